//! What all methods do at the ends of the segments of camera paths: emitted radiance,
//! straight-through transmission, and the layers of first surfaces and events.
//!
//! Albedo is the reflectance towards the viewer, estimated by the weight of one sampled direction.
//! Its mean over passes is right, and exact after one pass on a Lambertian surface.

use super::first_event::{FirstEvent, SampleShare, add_first_event};
use super::light_groups::each_group;
use crate::bsdf::{BsdfSamples, Lobes};
use crate::color::Rgb;
use crate::emitters::{EmissionSource, EnvironmentLobes};
use crate::film::{Layer, TileSamples};
use crate::geometry::SurfacePoint;
use crate::ids::{EmitterId, LightGroup, MaterialId, PrimitiveId};
use crate::lanes::{Color, Float, Width, lane};
use crate::math::Vec3;
use crate::scene::{PathLimits, Scene};
use crate::simd::set_bits;
use crate::transport::Vertex;
use crate::transport::direct::emitted_with_mis;
use crate::transport::stream::{
    Arrivals, Bits, Generators, Vertices, WalkStream, Walks, follow_all, lanes_where,
    see_environment, used,
};

/// What a camera path carries for a method.
pub(super) trait CameraPath: Copy {
    /// What the layers of first surfaces and events need to know; `None` if the path is not in
    /// them.
    fn first(&self) -> Option<FirstPart>;

    /// After a segment of this length, in m.
    #[inline(always)]
    fn after_segment(self, _distance: f32) -> Self {
        self
    }
}

/// A camera path before its first event.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstPart {
    /// Index of the pixel in the tile.
    pub(super) pixel: u32,
    /// Length of the ray's part before its origin, which the camera must not see; in m.
    pub(super) hidden: f32,
    /// The path in the layers of first events.
    pub(super) event: SampleShare,
    /// Inverse of the number of paths of the pixel in the layers that describe first surfaces; 0 if
    /// this one is not in them.
    pub(super) surface_share: f32,
}

/// Emission that a camera path sees at its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenEmission {
    /// Throughput of the path.
    pub(super) throughput: Rgb,
    /// Emitted radiance times its MIS weight, in W/(m² sr).
    pub(super) radiance: Rgb,
    /// Whose surface it is; `None` for the environment.
    pub(super) emitter: Option<EmitterId>,
    /// The surface; `None` for the environment.
    surface: Option<PrimitiveId>,
    /// Unit direction of the last segment of the path.
    w: Vec3,
}

impl SeenEmission {
    /// The radiance at the camera, in W/(m² sr).
    pub(super) fn at_camera(&self) -> Rgb {
        self.throughput * self.radiance
    }

    /// Adds the radiance `value` of this emission to a layer of a pixel. Light of each group has the
    /// factor `weight`.
    #[inline]
    pub(super) fn add_to(
        &self,
        scene: &Scene,
        (pixel, layer): (u32, Layer),
        value: Rgb,
        weight: impl Fn(LightGroup) -> f32,
        out: &mut TileSamples,
    ) {
        let pixel = pixel as usize;
        if out.light_groups() == 0 {
            return out.add(pixel, layer, value);
        }
        let source = self.surface.map(EmissionSource::Surface);
        each_group(scene, source, self.w, |group, share| {
            out.add_light(pixel, layer, group, value * share * weight(group));
        });
    }
}

/// Paths that carry nothing else.
impl CameraPath for FirstPart {
    #[inline(always)]
    fn first(&self) -> Option<FirstPart> {
        Some(*self)
    }
}

/// Follows camera paths to their ends. `shade` does what happens at the ends of the segments of a
/// round, and appends the paths that go on to its last argument.
pub(super) fn follow_paths<'s, T: CameraPath>(
    scene: &'s Scene,
    limits: PathLimits,
    stream: &mut WalkStream<T>,
    mut shade: impl FnMut(CameraRound<'_, 's, T>, &mut Walks<T>),
) {
    follow_all(scene, stream, |walks, arrivals, next| {
        let round = CameraRound {
            scene,
            limits,
            walks,
            arrivals,
        };
        shade(round, next);
    });
}

/// The paths of a round, at the ends of their segments.
#[derive(Clone, Copy)]
pub(super) struct CameraRound<'a, 's, T> {
    pub(super) scene: &'s Scene,
    pub(super) limits: PathLimits,
    pub(super) walks: &'a Walks<T>,
    pub(super) arrivals: &'a Arrivals,
}

/// The vertices of a packet, with the paths that arrive there.
pub(super) struct Arrived<'v, 's, S: Width, T: Copy> {
    pub(super) v: &'v Vertices<'s, S>,
    pub(super) material: MaterialId,
    /// After the segment.
    pub(super) paths: S::Each<T>,
    pub(super) throughput: Color<S>,
    pub(super) eta_squared: Float<S>,
    pub(super) generators: Generators<S>,
}

/// The scalar values of [`Arrived`].
pub(super) struct ArrivedValues<S: Width> {
    x: S::Each<SurfacePoint>,
    w_prev: [S::Each<f32>; 3],
    throughput: [S::Each<f32>; 3],
    eta_squared: S::Each<f32>,
}

impl<'s, S: Width, T: Copy> Arrived<'_, 's, S, T> {
    /// The values of all lanes, for steps that are taken one path at a time.
    #[inline(always)]
    pub(super) fn values(&self) -> ArrivedValues<S> {
        ArrivedValues {
            x: self.v.x.store(),
            w_prev: self.v.w_prev.store(),
            throughput: self.throughput.store(),
            eta_squared: self.eta_squared.store(),
        }
    }

    /// The vertex of lane `i`.
    #[inline(always)]
    pub(super) fn vertex(
        &self,
        scene: &'s Scene,
        values: &ArrivedValues<S>,
        i: usize,
    ) -> Vertex<'s> {
        let x = values.x(i);
        Vertex {
            bsdf: scene.materials.bsdf(self.material, x, &scene.textures),
            x: *x,
            w_prev: values.w_prev(i),
            segments: self.v.segments.as_ref()[i],
        }
    }
}

impl<S: Width> ArrivedValues<S> {
    #[inline(always)]
    pub(super) fn x(&self, i: usize) -> &SurfacePoint {
        &self.x.as_ref()[i]
    }

    #[inline(always)]
    pub(super) fn w_prev(&self, i: usize) -> Vec3 {
        Vec3::from(lane(&self.w_prev, i))
    }

    #[inline(always)]
    pub(super) fn throughput(&self, i: usize) -> Rgb {
        Rgb::from(lane(&self.throughput, i))
    }

    #[inline(always)]
    pub(super) fn eta_squared(&self, i: usize) -> f32 {
        self.eta_squared.as_ref()[i]
    }
}

/// Lanes of a packet.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathLanes {
    pub(super) active: Bits,
    /// The surface belongs to an emitter.
    pub(super) emits: Bits,
    /// The path has met nothing yet, and is in the layers of first events.
    pub(super) firsts: Bits,
    /// No longer path is within the limits.
    pub(super) ends: Bits,
}

impl PathLanes {
    /// Whether nothing happens at the vertices: no path meets an emitter, fills a layer of first
    /// surfaces or goes on.
    #[inline(always)]
    pub(super) fn are_done(self) -> bool {
        self.emits | self.firsts | (self.active & !self.ends) == 0
    }
}

impl<'a, 's, T: CameraPath> CameraRound<'a, 's, T> {
    /// The lanes of `packet`.
    #[inline(always)]
    pub(super) fn lanes(&self, packet: &[u32]) -> PathLanes {
        let (walks, active) = (self.walks, used(packet.len()));
        let primitives = self.scene.geometry.primitives();
        PathLanes {
            active,
            emits: lanes_where(active, |i| {
                let hit = self.arrivals.hits[packet[i] as usize];
                hit.is_some_and(|hit| primitives[hit.at.primitive.index()].emitter.is_some())
            }),
            firsts: lanes_where(active, |i| self.is_first(packet[i])),
            ends: lanes_where(active, |i| {
                !self.limits.allow(walks.state(packet[i]).segments + 2)
            }),
        }
    }

    /// The vertices of `packet`, paths that hit `material`, before [`Vertices::add_leaves`].
    #[inline(always)]
    pub(super) fn vertices<S: Width>(
        &self,
        s: S,
        material: MaterialId,
        packet: &[u32],
    ) -> Vertices<'s, S> {
        Vertices::new(s, self.scene, self.walks, self.arrivals, material, packet)
    }

    /// The paths that arrive at the vertices `v`, on `material`. They are a reference: moving them
    /// costs more than shading them.
    #[inline(always)]
    pub(super) fn arrive<'v, S: Width>(
        &self,
        s: S,
        v: &'v Vertices<'s, S>,
        material: MaterialId,
    ) -> Arrived<'v, 's, S, T> {
        let walks = self.walks;
        Arrived {
            paths: s.each(|i| v.payload(walks, i).after_segment(v.distances.as_ref()[i])),
            throughput: walks.throughput(s, &v.index),
            eta_squared: v.eta_squared(s, walks),
            generators: v.generators(s, walks),
            v,
            material,
        }
    }

    #[inline(always)]
    fn is_first(&self, i: u32) -> bool {
        self.walks.event(i) == Lobes::NONE && self.walks.state(i).payload.first().is_some()
    }

    /// Calls `visit` with each path that leaves the scene, and what it sees of the environment.
    /// `guide` as in [`see_environment`]. Adds the first events of these paths.
    pub(super) fn leave<'g>(
        &self,
        guide: impl Fn(u32) -> Option<&'g EnvironmentLobes>,
        mut visit: impl FnMut(&T, SeenEmission, &mut TileSamples),
        out: &mut TileSamples,
    ) {
        let (walks, escaped) = (self.walks, &self.arrivals.escaped);
        see_environment(
            self.scene,
            self.limits,
            walks,
            escaped,
            guide,
            |i, radiance| {
                if !radiance.is_black() {
                    let seen = SeenEmission {
                        throughput: walks.throughput_of(i),
                        radiance,
                        emitter: None,
                        surface: None,
                        w: walks.rays[i as usize].d,
                    };
                    visit(&walks.state(i).payload, seen, out);
                }
            },
        );
        for &i in escaped {
            if self.is_first(i) {
                let event = FirstEvent::escape(self.scene, self.limits);
                self.add_first_event(&walks.state(i).payload, event, out);
            }
        }
    }

    /// Calls `visit` with the paths in the lanes `emits`, and what they see of the surfaces.
    #[inline(always)]
    pub(super) fn see_emitters<S: Width>(
        &self,
        v: &Vertices<S>,
        emits: Bits,
        mut visit: impl FnMut(&T, SeenEmission),
    ) {
        if emits == 0 {
            return;
        }
        let walks = self.walks;
        let previous = walks.previous_events(v.w_prev.x.width(), &v.index);
        let emits = v.mask(emits);
        let radiance = emitted_with_mis(self.scene, &previous, &v.x, v.w_prev, emits);
        let lit = (emits & !radiance.is_black()).bits();
        let radiance = radiance.store();
        for i in set_bits(lit) {
            let walk = v.index.as_ref()[i];
            let hit = self.arrivals.hits[walk as usize];
            let primitives = self.scene.geometry.primitives();
            let seen = SeenEmission {
                throughput: walks.throughput_of(walk),
                radiance: Rgb::from(lane(&radiance, i)),
                emitter: hit.and_then(|hit| primitives[hit.at.primitive.index()].emitter),
                surface: hit.map(|hit| hit.at.primitive),
                w: walks.rays[walk as usize].d,
            };
            visit(&walks.state(walk).payload, seen);
        }
    }

    /// Adds the layers that describe the first surfaces of the paths in the lanes `firsts`;
    /// `samples` draws directions from all lobes.
    #[inline(always)]
    pub(super) fn describe<S: Width>(
        &self,
        v: &Vertices<S>,
        samples: impl FnOnce() -> BsdfSamples<S>,
        firsts: Bits,
        out: &mut TileSamples,
    ) {
        let first = |i: usize| v.payload(self.walks, i).first();
        let lanes = lanes_where(firsts, |i| {
            v.segments.as_ref()[i] == 1 && first(i).is_some_and(|first| first.surface_share > 0.0)
        });
        if lanes == 0 {
            return;
        }
        let samples = samples();
        let albedo = samples.weight.within(samples.valid).store();
        let normal = v.x.frame.n.store();
        for i in set_bits(lanes) {
            let Some(first) = first(i) else {
                continue;
            };
            let depth = first.hidden + v.distances.as_ref()[i];
            let mut add = |layer, value: Rgb| {
                out.add(first.pixel as usize, layer, value * first.surface_share);
            };
            add(Layer::Normal, Rgb::from(lane(&normal, i)));
            add(Layer::Depth, Rgb::splat(depth));
            add(Layer::Albedo, Rgb::from(lane(&albedo, i)));
        }
    }

    /// The first steps of paths at their vertices: layers of first surfaces, with directions drawn
    /// for them, then [`CameraRound::pass_through`].
    #[inline(always)]
    pub(super) fn describe_and_pass_through<S: Width>(
        &self,
        at: &mut Arrived<S, T>,
        lanes: PathLanes,
        next: &mut Walks<T>,
        out: &mut TileSamples,
    ) -> Bits {
        let (v, generators) = (at.v, &mut at.generators);
        let samples = || {
            let numbers = generators.next_bsdf();
            v.bsdf.sample_each_wi(v.w_prev, numbers, Lobes::ALL)
        };
        self.describe(v, samples, lanes.firsts, out);
        let u = at.generators.next();
        self.pass_through((at, u), lanes, next, out)
    }

    /// Appends to `next` the paths that continue straight through, by the random numbers `u`, and
    /// adds the first events of the others: where a path ends by the limits, whether it scatters
    /// stays open. Returns the lanes in which paths scatter.
    #[inline(always)]
    pub(super) fn pass_through<S: Width>(
        &self,
        (at, u): (&mut Arrived<S, T>, Float<S>),
        lanes: PathLanes,
        next: &mut Walks<T>,
        out: &mut TileSamples,
    ) -> Bits {
        for i in set_bits(lanes.firsts & lanes.ends) {
            self.add_surface(at.v, i, at.v.opacity(i), out);
        }
        let goes_on = lanes.active & !lanes.ends;
        let state = (&mut at.throughput, &at.generators, u);
        let paths = &at.paths;
        let path = |i: usize| paths.as_ref()[i];
        let scatters = (at.v).pass_through(self.walks, next, state, goes_on, path);
        for i in set_bits(lanes.firsts & scatters) {
            self.add_surface(at.v, i, 1.0, out);
        }
        scatters
    }

    #[inline(always)]
    fn add_surface<S: Width>(
        &self,
        v: &Vertices<S>,
        i: usize,
        opacity: f32,
        out: &mut TileSamples,
    ) {
        let event = FirstEvent::Surface {
            at: v.x.at.as_ref()[i],
            p: Vec3::from(lane(&v.x.p.store(), i)),
            opacity,
        };
        self.add_first_event(&v.payload(self.walks, i), event, out);
    }

    fn add_first_event(&self, path: &T, event: FirstEvent, out: &mut TileSamples) {
        if let Some(first) = path.first() {
            add_first_event(self.scene, event, first.event, first.pixel as usize, out);
        }
    }
}
