//! Light from emitters that paths reflect, before visibility is known.

use crate::color::Rgb;
use crate::film::{Layer, TileSamples};
use crate::geometry::Segment;
use crate::scene::Scene;

/// The connections of a round.
#[derive(Clone, Debug, Default)]
pub(super) struct Connections(Vec<Connection>);

/// Light from an emitter that a path reflects, visibility not yet tested. Low-roughness lobes belong to another layer than
/// non-specular ones, so that there are two terms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Connection {
    /// Index of the pixel in the tile.
    pub(super) pixel: u32,
    /// The shadow ray.
    pub(super) segment: Segment,
    /// Transparent surfaces that the shadow ray may cross.
    pub(super) max_crossings: u32,
    pub(super) terms: [(Layer, Rgb); 2],
}

impl Connections {
    pub(super) fn push(&mut self, connection: Connection) {
        self.0.push(connection);
    }

    /// Adds the connections that nothing blocks, and empties the list. Returns the number of shadow rays.
    pub(super) fn add_all(&mut self, scene: &Scene, out: &mut TileSamples) -> u64 {
        let count = self.0.len() as u64;
        for connection in self.0.drain(..) {
            let (arriving, crossings) = scene.transmittance_and_crossings(&connection.segment);
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
