//! The vertices of a packet: walks that hit one material.

use super::absorption::inside;
use super::{Arrivals, Generators, WalkRow, WalkState, Walks};
use crate::bsdf::{Bsdf, BsdfSamples, Lobes};
use crate::geometry::{Derivatives, Ray, SurfacePoints, SurfaceRef};
use crate::ids::MaterialId;
use crate::lanes::{Color, Float, Mask, Vector, Width, lane};
use crate::math::Vec3;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::simd::set_bits;
use crate::transport::walk::Previous;

/// Lanes of a packet, one bit each.
pub(crate) type Bits = u32;

/// The vertices of up to [`Width::LANES`] walks.
pub(crate) struct Vertices<'a, S: Width> {
    /// The walks; in unused lanes the first.
    pub(crate) index: S::Each<u32>,
    /// Lengths of the segments that end here, in m.
    pub(crate) distances: S::Each<f32>,
    pub(crate) x: SurfacePoints<S>,
    pub(crate) bsdf: Bsdf<'a, S>,
    /// Unit directions back along the rays.
    pub(crate) w_prev: Vector<S>,
    /// Segments up to here, by lane.
    pub(crate) segments: S::Each<u32>,
    /// The material of the vertices, if there is a medium behind it.
    around: Option<MaterialId>,
}

/// The end of a segment of one walk.
#[derive(Clone, Copy)]
pub(crate) struct SegmentEnd {
    pub(crate) at: SurfaceRef,
    /// See [`Vertices::distances`].
    pub(crate) distance: f32,
    /// Unit direction back along the segment.
    pub(crate) w_prev: Vec3,
    /// Segments up to here.
    pub(crate) segments: u32,
}

/// The next segments of walks that scatter, by lane.
pub(crate) struct NextSegments<'v, S: Width> {
    origin: [S::Each<f32>; 3],
    w: [S::Each<f32>; 3],
    p: [S::Each<f32>; 3],
    pdf: S::Each<f32>,
    lobe: S::Each<u32>,
    throughput: [S::Each<f32>; 3],
    eta_squared: S::Each<f32>,
    segments: &'v S::Each<u32>,
    /// The material around a medium into which the walks of the lanes `enters` go.
    around: Option<MaterialId>,
    enters: Bits,
    /// For walks that may meet emitters.
    normals: Option<ReceivingNormals<S>>,
}

impl<S: Width> NextSegments<'_, S> {
    /// The class of the sampled lobe in lane `i`.
    #[inline(always)]
    pub(crate) fn event(&self, i: usize) -> Lobes {
        Lobes(self.lobe.as_ref()[i] as u8)
    }

    /// The walk in lane `i`.
    #[inline(always)]
    pub(crate) fn row<T>(&self, i: usize, sampler: Sampler, payload: T) -> WalkRow<T> {
        let [o, d] = [&self.origin, &self.w].map(|v| Vec3::from(lane(v, i)));
        let previous = Previous {
            p: Vec3::from(lane(&self.p, i)),
            n: self.normals.as_ref().and_then(|normals| normals.get(i)),
            event: self.event(i),
            pdf: self.pdf.as_ref()[i],
            inside: self.around.filter(|_| self.enters >> i & 1 != 0),
        };
        WalkRow {
            ray: Ray::new(o, d),
            state: WalkState {
                throughput: lane(&self.throughput, i),
                eta_squared: self.eta_squared.as_ref()[i],
                segments: self.segments.as_ref()[i],
                previous,
                sampler,
                payload,
            },
        }
    }
}

/// Normals as in [`Previous::n`], by lane.
struct ReceivingNormals<S: Width> {
    n: [S::Each<f32>; 3],
    has_normal: Bits,
}

impl<S: Width> ReceivingNormals<S> {
    #[inline(always)]
    fn get(&self, i: usize) -> Option<Vec3> {
        (self.has_normal >> i & 1 != 0).then(|| Vec3::from(lane(&self.n, i)))
    }
}

/// The lanes of a packet of `count` walks.
#[inline(always)]
pub(crate) fn used(count: usize) -> Bits {
    u32::MAX >> (32 - count)
}

/// The lanes of `of` for which `test` holds.
#[inline(always)]
pub(crate) fn lanes_where(of: Bits, test: impl Fn(usize) -> bool) -> Bits {
    let mut bits = 0;
    for i in set_bits(of) {
        bits |= u32::from(test(i)) << i;
    }
    bits
}

/// The elements `packet`, one per lane; in unused lanes the first.
#[inline(always)]
pub(crate) fn by_lane<S: Width>(s: S, packet: &[u32]) -> S::Each<u32> {
    s.each(|i| packet[if i < packet.len() { i } else { 0 }])
}

impl<'a, S: Width> Vertices<'a, S> {
    /// The vertices of the walks `packet`, all of which hit `material`, before
    /// [`Vertices::add_leaves`].
    #[inline(always)]
    pub(crate) fn new<T>(
        s: S,
        scene: &'a Scene,
        walks: &Walks<T>,
        arrivals: &Arrivals,
        material: MaterialId,
        packet: &[u32],
    ) -> Self {
        let index = by_lane(s, packet);
        let ends = s.each(|i| {
            let walk = index.as_ref()[i] as usize;
            let hit = arrivals.hits[walk].expect("invariant: walks of runs hit");
            SegmentEnd {
                at: hit.at,
                distance: hit.t,
                w_prev: -walks.rays[walk].d,
                segments: walks.states[walk].segments + 1,
            }
        });
        Vertices::at_ends(s, scene, material, index, &ends)
    }

    /// The vertices at the ends of the segments of the walks `index`, on `material`, before
    /// [`Vertices::add_leaves`].
    #[inline(always)]
    pub(crate) fn at_ends(
        s: S,
        scene: &'a Scene,
        material: MaterialId,
        index: S::Each<u32>,
        ends: &S::Each<SegmentEnd>,
    ) -> Self {
        let end = |i: usize| &ends.as_ref()[i];
        let derivatives = match scene.materials.has_tilts(material) {
            true => Derivatives::OfPosition,
            false => Derivatives::Unspecified,
        };
        let at = s.each(|i| end(i).at);
        let x = scene.geometry.surface_points(s, &at, derivatives);
        Vertices {
            bsdf: Bsdf::without_leaves(&x),
            w_prev: Vector::from_fn(s, |i| end(i).w_prev),
            segments: s.each(|i| end(i).segments),
            distances: s.each(|i| end(i).distance),
            around: inside(scene, material),
            index,
            x,
        }
    }

    /// Completes the scattering functions, by `material`. The second step of every packet: a
    /// function that returned complete vertices would copy 13 kB of them.
    #[inline(always)]
    pub(crate) fn add_leaves(&mut self, scene: &'a Scene, material: MaterialId) {
        let Vertices { x, bsdf, .. } = self;
        (scene.materials).add_leaves(material, x, &scene.textures, bsdf);
    }

    /// Appends to `next` the walks of the lanes `goes_on` that continue straight through, with the
    /// probability of the straight-through transmittance, by the random numbers `u`; `payload(i)`
    /// is what they carry. Returns the lanes in which walks scatter. The throughput of all walks is
    /// multiplied by the factor of those that pass, or of those that do not.
    #[inline(always)]
    pub(crate) fn pass_through<T: Copy>(
        &self,
        walks: &Walks<T>,
        next: &mut Walks<T>,
        (throughput, generators, u): (&mut Color<S>, &Generators<S>, Float<S>),
        goes_on: Bits,
        payload: impl Fn(usize) -> T,
    ) -> Bits {
        let Some(transmittance) = self.bsdf.transmittances(self.w_prev) else {
            return goes_on;
        };
        let p = transmittance.max_channel().min(1.0);
        let is_open = p.gt(0.0);
        let through = is_open & u.lt(p);
        let factor = Color::select(through, transmittance / p, Color::grey((1.0 - p).recip()));
        let factor = Color::select(is_open, factor, Color::grey(p.same(1.0)));
        *throughput = *throughput * factor;
        let passes = through.bits() & goes_on;
        let weights = throughput.store();
        let origin = self.x.offset_towards(-self.w_prev).store();
        for i in set_bits(passes) {
            let walk = self.index.as_ref()[i] as usize;
            let (ray, before) = (&walks.rays[walk], &walks.states[walk]);
            next.push(WalkRow {
                ray: Ray {
                    o: Vec3::from(lane(&origin, i)),
                    d: ray.d,
                    t_max: ray.t_max - self.distances.as_ref()[i],
                },
                state: WalkState {
                    throughput: lane(&weights, i),
                    segments: self.segments.as_ref()[i],
                    previous: self.passed(before.previous, ray.d, i),
                    sampler: generators.get(i),
                    payload: payload(i),
                    ..*before
                },
            });
        }
        goes_on & !passes
    }

    /// The last event of a walk that goes on straight through along `d` in lane `i`.
    #[inline(always)]
    fn passed(&self, previous: Previous, d: Vec3, i: usize) -> Previous {
        match self.around {
            None => previous,
            around => {
                let ng = Vec3::from(lane(&self.x.ng.store(), i));
                Previous {
                    inside: around.filter(|_| ng.dot(d) < 0.0),
                    ..previous
                }
            }
        }
    }

    /// What the walk in lane `i` carries for the method.
    #[inline(always)]
    pub(crate) fn payload<T: Copy>(&self, walks: &Walks<T>, i: usize) -> T {
        walks.state(self.index.as_ref()[i]).payload
    }

    /// Products of squared relative indices of refraction, as in [`WalkState::eta_squared`].
    #[inline(always)]
    pub(crate) fn eta_squared<T>(&self, s: S, walks: &Walks<T>) -> Float<S> {
        Float::from_fn(s, |i| walks.state(self.index.as_ref()[i]).eta_squared)
    }

    /// Fraction of light that does not pass straight through in lane `i`: one minus the largest
    /// channel of the transmittance.
    #[inline(always)]
    pub(crate) fn opacity(&self, i: usize) -> f32 {
        let transmittance = self.bsdf.transmittances(self.w_prev);
        1.0 - transmittance.map_or(0.0, |t| t.max_channel().min(1.0).store().as_ref()[i])
    }

    /// The next segments along sampled directions, of walks that meet no emitters: photons and
    /// importons.
    #[inline(always)]
    pub(crate) fn next_segments(
        &self,
        sample: &BsdfSamples<S>,
        throughput: Color<S>,
        eta_squared: Float<S>,
    ) -> NextSegments<'_, S> {
        NextSegments {
            origin: self.x.offset_towards(sample.w).store(),
            w: sample.w.store(),
            p: self.x.p.store(),
            pdf: sample.pdf.store(),
            lobe: sample.lobe.store(),
            throughput: throughput.store(),
            eta_squared: eta_squared.store(),
            segments: &self.segments,
            around: self.around,
            enters: match self.around {
                Some(_) => sample.w.dot(self.x.ng).lt(0.0).bits(),
                None => 0,
            },
            normals: None,
        }
    }

    /// The next segments along sampled directions, of walks that may meet emitters: camera paths.
    #[inline(always)]
    pub(crate) fn next_camera_segments(
        &self,
        sample: &BsdfSamples<S>,
        throughput: Color<S>,
        eta_squared: Float<S>,
    ) -> NextSegments<'_, S> {
        let (n, has_normal) = self.bsdf.receiving_normals(self.w_prev);
        NextSegments {
            normals: Some(ReceivingNormals {
                n: n.store(),
                has_normal: has_normal.bits(),
            }),
            ..self.next_segments(sample, throughput, eta_squared)
        }
    }

    /// The sampler of each walk.
    #[inline(always)]
    pub(crate) fn generators<T>(&self, s: S, walks: &Walks<T>) -> Generators<S> {
        Generators::from_fn(s, |i| &walks.state(self.index.as_ref()[i]).sampler)
    }

    /// The lanes `bits` as a mask.
    #[inline(always)]
    pub(crate) fn mask(&self, bits: Bits) -> Mask<S> {
        Mask::from_bits(self.w_prev.x.width(), bits)
    }
}
