//! Light from emitters that paths reflect, before visibility is known.

use crate::color::Rgb;
use crate::film::{Layer, TileSamples};
use crate::geometry::Segment;
use crate::lanes::{Width, lane};
use crate::math::Vec3;
use crate::scene::Scene;
use crate::simd::set_bits;
use crate::transport::direct::EmitterSamples;
use crate::transport::stream::Bits;

/// The connections of a round.
#[derive(Clone, Debug, Default)]
pub(super) struct Connections {
    /// The shadow rays.
    segments: Vec<Segment>,
    connections: Vec<Connection>,
    /// By shadow ray: whether an opaque surface blocks it.
    occluded: Vec<bool>,
}

/// Light from an emitter that a path reflects, visibility not yet tested.
#[derive(Clone, Copy, Debug)]
pub(super) struct Connection {
    /// Index of the pixel in the tile.
    pub(super) pixel: u32,
    /// Transparent surfaces that the shadow ray may cross.
    pub(super) max_crossings: u32,
    /// Low-roughness lobes belong to another layer than non-specular ones, so that there may be two terms.
    pub(super) terms: [(Layer, Rgb); 2],
}

impl Connections {
    /// Adds `connection(i)` with the shadow ray to the emitter in each lane `i` of `lanes`.
    #[inline(always)]
    pub(super) fn push_lanes<S: Width>(
        &mut self,
        lights: &EmitterSamples<S>,
        lanes: Bits,
        connection: impl Fn(usize) -> Connection,
    ) {
        let (from, to) = (lights.from.store(), lights.to.store());
        for i in set_bits(lanes) {
            self.segments.push(Segment {
                from: Vec3::from(lane(&from, i)),
                to: Vec3::from(lane(&to, i)),
            });
            self.connections.push(connection(i));
        }
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
