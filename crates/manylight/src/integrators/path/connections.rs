//! Light from emitters that paths reflect, before visibility is known.

use crate::color::Rgb;
use crate::film::{Layer, TileSamples};
use crate::geometry::Segment;
use crate::scene::Scene;

/// The connections of a round.
#[derive(Clone, Debug, Default)]
pub(super) struct Connections {
    /// The shadow rays.
    segments: Vec<Segment>,
    connections: Vec<Connection>,
    /// By shadow ray: whether an opaque surface blocks it.
    occluded: Vec<bool>,
}

/// Light from an emitter that a path reflects, visibility not yet tested. Low-roughness lobes belong to another layer than
/// non-specular ones, so that there are two terms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Connection {
    /// Index of the pixel in the tile.
    pub(super) pixel: u32,
    /// Transparent surfaces that the shadow ray may cross.
    pub(super) max_crossings: u32,
    pub(super) terms: [(Layer, Rgb); 2],
}

impl Connections {
    /// Adds a connection with the shadow ray `segment`.
    pub(super) fn push(&mut self, segment: Segment, connection: Connection) {
        self.segments.push(segment);
        self.connections.push(connection);
    }

    /// Adds the connections that nothing blocks, and empties the list. Returns the number of shadow rays.
    pub(super) fn add_all(&mut self, scene: &Scene, out: &mut TileSamples) -> u64 {
        let count = self.segments.len() as u64;
        scene
            .geometry
            .occluded_stream(&self.segments, &mut self.occluded);
        let shadow_rays = self.segments.drain(..).zip(&self.occluded);
        for (connection, (segment, &is_occluded)) in self.connections.drain(..).zip(shadow_rays) {
            if is_occluded {
                continue;
            }
            let (arriving, crossings) = scene.cross_transparent(&segment);
            if arriving.is_black() || crossings > connection.max_crossings {
                continue;
            }
            for (layer, value) in connection.terms {
                if !value.is_black() {
                    out.add(connection.pixel as usize, layer, arriving * value);
                }
            }
        }
        count
    }
}
