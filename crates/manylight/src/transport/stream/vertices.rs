//! The vertices of a packet: walks that hit one material.

use super::{Arrivals, Generators, WalkRow, Walks};
use crate::bsdf::{Bsdf, BsdfSamples, Lobes};
use crate::geometry::{Derivatives, Hit, Ray, SurfacePoints};
use crate::ids::MaterialId;
use crate::lanes::{Color, Float, Mask, Vector, Width, lane};
use crate::math::Vec3;
use crate::scene::Scene;
use crate::simd::set_bits;
use crate::transport::walk::Previous;

/// Lanes of a packet, one bit each.
pub(crate) type Bits = u32;

/// The vertices of up to [`Width::LANES`] walks.
pub(crate) struct Vertices<'a, S: Width> {
    /// The walks; in unused lanes the first.
    pub(crate) index: S::Each<u32>,
    pub(crate) hits: S::Each<Hit>,
    pub(crate) x: SurfacePoints<S>,
    pub(crate) bsdf: Bsdf<'a, S>,
    /// Unit directions back along the rays.
    pub(crate) w_prev: Vector<S>,
    /// Segments up to here, by lane.
    pub(crate) segments: S::Each<u32>,
}

/// The next segments of walks that scatter, by lane.
pub(crate) struct Scattered<S: Width> {
    origin: [S::Each<f32>; 3],
    w: [S::Each<f32>; 3],
    p: [S::Each<f32>; 3],
    pdf: S::Each<f32>,
    lobe: S::Each<u32>,
}

impl<S: Width> Scattered<S> {
    /// The ray in lane `i`.
    #[inline(always)]
    pub(crate) fn ray(&self, i: usize) -> Ray {
        Ray::new(
            Vec3::from(lane(&self.origin, i)),
            Vec3::from(lane(&self.w, i)),
        )
    }

    /// The class of the sampled lobe in lane `i`.
    #[inline(always)]
    pub(crate) fn event(&self, i: usize) -> Lobes {
        Lobes(self.lobe.as_ref()[i] as u8)
    }

    /// The scattering event in lane `i`, with a normal as in [`Previous::n`].
    #[inline(always)]
    pub(crate) fn previous(&self, i: usize, n: Option<Vec3>) -> Previous {
        Previous {
            p: Vec3::from(lane(&self.p, i)),
            n,
            event: self.event(i),
            pdf: self.pdf.as_ref()[i],
        }
    }
}

/// Normals as in [`Previous::n`], by lane.
pub(crate) struct ReceivingNormals<S: Width> {
    n: [S::Each<f32>; 3],
    has_normal: Bits,
}

impl<S: Width> ReceivingNormals<S> {
    /// The normal in lane `i`.
    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Option<Vec3> {
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

impl<'a, S: Width> Vertices<'a, S> {
    /// The vertices of the walks `packet`, all of which hit `material`.
    #[inline(always)]
    pub(crate) fn new<T>(
        s: S,
        scene: &'a Scene,
        walks: &Walks<T>,
        arrivals: &Arrivals,
        material: MaterialId,
        packet: &[u32],
    ) -> Self {
        let index = s.each(|i| packet[if i < packet.len() { i } else { 0 }]);
        let walk = |i: usize| index.as_ref()[i] as usize;
        let hits = s.each(|i| arrivals.hits[walk(i)].expect("invariant: walks of runs hit"));
        let derivatives = match scene.materials.has_tilts(material) {
            true => Derivatives::OfPosition,
            false => Derivatives::Unspecified,
        };
        let at = s.each(|i| hits.as_ref()[i].at);
        let x = scene.geometry.surface_points(s, &at, derivatives);
        Vertices {
            bsdf: scene.materials.bsdfs(material, &x, &scene.textures),
            w_prev: Vector::from_fn(s, |i| -walks.rays[walk(i)].d),
            segments: s.each(|i| walks.segments[walk(i)] + 1),
            index,
            hits,
            x,
        }
    }

    /// The lanes of `goes_on` in which walks continue straight through, with the probability of the straight-through transmittance,
    /// and the factor on the throughput of all walks: that of those that pass, or of those that do not. `None` where nothing is
    /// transparent.
    #[inline(always)]
    pub(crate) fn passes(&self, u: Float<S>, goes_on: Bits) -> Option<(Bits, Color<S>)> {
        let transmittance = self.bsdf.transmittances(self.w_prev)?;
        let p = transmittance.max_channel().min(1.0);
        let is_open = p.gt(0.0);
        let through = is_open & u.lt(p);
        let factor = Color::select(through, transmittance / p, Color::grey((1.0 - p).recip()));
        let factor = Color::select(is_open, factor, Color::grey(p.same(1.0)));
        Some((through.bits() & goes_on, factor))
    }

    /// Appends to `next` the walks that continue straight through, in the lanes `passes`, for which the method keeps `kept(i)`.
    #[inline(always)]
    pub(crate) fn pass_through<T: Copy>(
        &self,
        walks: &Walks<T>,
        next: &mut Walks<T>,
        throughput: Color<S>,
        generators: &Generators<S>,
        (passes, kept): (Bits, impl Fn(usize) -> T),
    ) {
        let throughput = throughput.store();
        let origin = self.x.offset_towards(-self.w_prev).store();
        for i in set_bits(passes) {
            let walk = self.index.as_ref()[i] as usize;
            let ray = &walks.rays[walk];
            next.push(WalkRow {
                ray: Ray {
                    o: Vec3::from(lane(&origin, i)),
                    d: ray.d,
                    t_max: ray.t_max - self.hits.as_ref()[i].t,
                },
                throughput: lane(&throughput, i),
                eta_squared: walks.eta_squared[walk],
                segments: self.segments.as_ref()[i],
                previous: walks.previous[walk],
                sampler: generators.get(i),
                kept: kept(i),
            });
        }
    }

    /// What the method keeps for the walk in lane `i`.
    #[inline(always)]
    pub(crate) fn kept<T: Copy>(&self, walks: &Walks<T>, i: usize) -> T {
        walks.kept[self.index.as_ref()[i] as usize]
    }

    /// Products of squared relative indices of refraction, as in [`Walks::eta_squared`].
    #[inline(always)]
    pub(crate) fn eta_squared<T>(&self, s: S, walks: &Walks<T>) -> Float<S> {
        Float::from_fn(s, |i| walks.eta_squared[self.index.as_ref()[i] as usize])
    }

    /// Fraction of light that does not pass straight through in lane `i`: one minus the largest channel of the transmittance.
    #[inline(always)]
    pub(crate) fn opacity(&self, i: usize) -> f32 {
        let transmittance = self.bsdf.transmittances(self.w_prev);
        1.0 - transmittance.map_or(0.0, |t| t.max_channel().min(1.0).store().as_ref()[i])
    }

    /// The normals by which next-event estimation chooses emitters at the vertices.
    #[inline(always)]
    pub(crate) fn normals(&self) -> ReceivingNormals<S> {
        let (n, has_normal) = self.bsdf.receiving_normals(self.w_prev);
        ReceivingNormals {
            n: n.store(),
            has_normal: has_normal.bits(),
        }
    }

    /// The next segments of the walks along sampled directions.
    #[inline(always)]
    pub(crate) fn scattered(&self, sample: &BsdfSamples<S>) -> Scattered<S> {
        Scattered {
            origin: self.x.offset_towards(sample.w).store(),
            w: sample.w.store(),
            p: self.x.p.store(),
            pdf: sample.pdf.store(),
            lobe: sample.lobe.store(),
        }
    }

    /// The sampler of each walk.
    #[inline(always)]
    pub(crate) fn generators<T>(&self, s: S, walks: &Walks<T>) -> Generators<S> {
        Generators::from_fn(s, |i| &walks.samplers[self.index.as_ref()[i] as usize])
    }

    /// The lanes `bits` as a mask.
    #[inline(always)]
    pub(crate) fn mask(&self, bits: Bits) -> Mask<S> {
        Mask::from_bits(self.w_prev.x.width(), bits)
    }
}
