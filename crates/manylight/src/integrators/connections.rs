//! Shadow rays in streams, and next-event estimation at the vertices of camera paths: the only one,
//! whatever the method.

use super::light_groups::each_group;
use super::partition::PathStage;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::LobesOfLanes;
use crate::film::{Layer, TileSamples};
use crate::geometry::Segment;
use crate::ids::LightGroup;
use crate::lanes::{Color, Float, Mask, Pair, Width, lane};
use crate::math::Vec3;
use crate::scene::{LimitedScene, Scene};
use crate::simd::set_bits;
use crate::transport::direct::EmitterSamples;
use crate::transport::stream::Vertices;

/// Shadow rays that wait for their test, with the light that each carries.
#[derive(Clone, Debug)]
pub(super) struct ShadowRays<T> {
    segments: Vec<Segment>,
    /// The light, and the number of transparent surfaces that the ray may cross. Each is a vertex
    /// of the path.
    light: Vec<(T, u32)>,
    /// By ray: whether an opaque surface blocks it.
    occluded: Vec<bool>,
}

impl<T> Default for ShadowRays<T> {
    fn default() -> Self {
        ShadowRays {
            segments: Vec::new(),
            light: Vec::new(),
            occluded: Vec::new(),
        }
    }
}

impl<T> ShadowRays<T> {
    /// Adds a ray that may cross `max_crossings` transparent surfaces.
    #[inline(always)]
    pub(super) fn push(&mut self, segment: Segment, max_crossings: u32, light: T) {
        self.segments.push(segment);
        self.light.push((light, max_crossings));
    }

    /// Tests the rays, calls `arrive` with the light of those that nothing blocks and their
    /// transmittance, and empties the list. Returns the number of rays.
    pub(super) fn trace(&mut self, scene: &Scene, mut arrive: impl FnMut(T, Rgb)) -> u64 {
        let count = self.segments.len() as u64;
        (scene.geometry).occluded_stream(&self.segments, &mut self.occluded);
        let rays = self.segments.drain(..).zip(&self.occluded);
        for ((light, max_crossings), (segment, &is_occluded)) in self.light.drain(..).zip(rays) {
            if is_occluded {
                continue;
            }
            let (transmittance, crossings) = scene.cross_transparent(&segment);
            if !transmittance.is_black() && crossings <= max_crossings {
                arrive(light, transmittance);
            }
        }
        count
    }
}

/// Light of an emitter that a camera path reflects.
#[derive(Clone, Copy, Debug)]
pub(super) struct Connection {
    pixel: u32,
    group: LightGroup,
    terms: [(Layer, Rgb); 2],
}

/// A camera path that reflects light of emitters.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReflectingPath {
    /// Index of the pixel in the tile.
    pub(super) pixel: u32,
    /// Layers of the two terms of [`EmitterReflection::reflect`].
    pub(super) layers: [Layer; 2],
}

impl ReflectingPath {
    /// A path before the event that reflects: by non-specular lobes, and by near-delta lobes.
    #[inline(always)]
    pub(super) fn before_event(pixel: u32, stage: PathStage) -> Self {
        ReflectingPath {
            pixel,
            layers: [Lobes::DIFFUSE, Lobes::NEAR_DELTA].map(|event| stage.after(event).layer()),
        }
    }
}

/// How the vertices of a packet reflect light of emitters: all that differs between the methods.
/// The functions must be `inline(always)`.
pub(super) trait EmitterReflection<S: Width> {
    /// The light that the paths carry from the samples to their pixels, weighted by MIS: the terms
    /// of two layers. Unspecified in lanes without a sample.
    fn reflect(&self, lights: &EmitterSamples<S>) -> [Color<S>; 2];

    /// The path in lane `i`.
    fn path(&self, i: usize) -> ReflectingPath;

    /// Factor of that path on light of `group`.
    #[inline(always)]
    fn group_weight(&self, _i: usize, _group: LightGroup) -> f32 {
        1.0
    }
}

/// Samples of emitters to draw.
pub(super) struct EmitterQuery<'g, S: Width> {
    /// Random numbers of the choice of an emitter, and of a point on it.
    pub(super) numbers: (Float<S>, Pair<S>),
    /// Densities of directions to the environment.
    pub(super) guides: LobesOfLanes<'g, S>,
    pub(super) lanes: Mask<S>,
}

/// The connections of a round.
#[derive(Clone, Debug)]
pub(super) struct Connections {
    rays: ShadowRays<Connection>,
    /// Whether light groups are told apart.
    by_group: bool,
}

impl Connections {
    /// No connections, for `out`.
    pub(super) fn of(out: &TileSamples) -> Self {
        Connections {
            rays: ShadowRays::default(),
            by_group: out.light_groups() > 0,
        }
    }

    /// Takes connections for `out` from now on. The list must be empty.
    pub(super) fn begin(&mut self, out: &TileSamples) {
        debug_assert!(self.rays.segments.is_empty());
        self.by_group = out.light_groups() > 0;
    }

    /// Next-event estimation: connects each of the vertices in the lanes of `query` with a point of
    /// an emitter. The light counts if nothing blocks it: see [`Connections::add_all`].
    #[inline(always)]
    pub(super) fn connect_emitters<'a, S: Width>(
        &mut self,
        LimitedScene { scene, limits }: LimitedScene<'a>,
        v: &Vertices<S>,
        query: EmitterQuery<'a, S>,
        reflection: &impl EmitterReflection<S>,
    ) {
        let EmitterQuery {
            numbers,
            guides,
            lanes,
        } = query;
        let normals = v.bsdf.receiving_normals(v.w_prev);
        let lights = EmitterSamples::new(scene, &v.x, normals, numbers, guides, lanes);
        if lights.valid.none() {
            return;
        }
        let terms = reflection.reflect(&lights);
        let is_lit = lights.valid & !(terms[0].is_black() & terms[1].is_black());
        let [first, second] = [terms[0].store(), terms[1].store()];
        let (from, to) = (lights.from.store(), lights.to.store());
        for i in set_bits(is_lit.bits()) {
            let segment = Segment {
                from: Vec3::from(lane(&from, i)),
                to: Vec3::from(lane(&to, i)),
            };
            let ReflectingPath { pixel, layers } = reflection.path(i);
            let connection = Connection {
                pixel,
                group: LightGroup::default(),
                terms: [
                    (layers[0], Rgb::from(lane(&first, i))),
                    (layers[1], Rgb::from(lane(&second, i))),
                ],
            };
            let max_crossings = limits.left_after(v.segments.as_ref()[i] + 1);
            if self.by_group {
                let source = lights.source.store().as_ref()[i];
                let weight = |group| reflection.group_weight(i, group);
                self.push_by_group(scene, source, (segment, max_crossings), connection, &weight);
            } else {
                self.rays.push(segment, max_crossings, connection);
            }
        }
    }

    /// Adds a connection for each light group of the source with this index.
    #[inline(never)]
    fn push_by_group(
        &mut self,
        scene: &Scene,
        source: u32,
        (segment, max_crossings): (Segment, u32),
        connection: Connection,
        weight: &dyn Fn(LightGroup) -> f32,
    ) {
        let source = scene.emitters.source(source);
        let wi = (segment.to - segment.from).normalize_or_zero();
        each_group(scene, source, wi, |group, share| {
            let scale = share * weight(group);
            if !scale.is_black() {
                let terms = connection
                    .terms
                    .map(|(layer, value)| (layer, value * scale));
                let connection = Connection {
                    group,
                    terms,
                    ..connection
                };
                self.rays.push(segment, max_crossings, connection);
            }
        });
    }

    /// Adds the connections that nothing blocks to the pixels, and empties the list. Returns the
    /// number of shadow rays.
    pub(super) fn add_all(&mut self, scene: &Scene, out: &mut TileSamples) -> u64 {
        self.rays.trace(scene, |connection, transmittance| {
            for (layer, value) in connection.terms {
                if !value.is_black() {
                    let pixel = connection.pixel as usize;
                    out.add_light(pixel, layer, connection.group, transmittance * value);
                }
            }
        })
    }
}
