//! Values in lanes.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over lanes read like the vector instructions that they become"
)]

use super::{FixedWoLanes, LaneModel};
use crate::bsdf::material::Distribution;
use crate::bsdf::models::coat::interpolate_lanes;
use crate::bsdf::models::fresnel::ConductorFresnel;
use crate::color::Rgb;
use crate::lanes::vectors::{dot, scale3};
use crate::lanes::{LANES, LaneMask, Lanes3, lanes_of};
use crate::math::Vec3;
use crate::simd::Wide;

/// Microfacets with the half vector as normal.
struct FacetLobe {
    /// `D(m) G1(wi)`.
    density: f32,
    /// Cosine between the half vector and `wo`.
    cos: f32,
}

impl FixedWoLanes<'_, '_> {
    /// [`FixedWo::f_cos_wi`] in each active lane, for unit directions `wi`; other lanes are unspecified.
    #[inline(always)]
    pub(crate) fn f_cos_wi<W: Wide>(&self, w: W, wi: &Lanes3, active: LaneMask) -> Lanes3 {
        match self.model {
            LaneModel::Lambert => self.lambert(w, wi),
            LaneModel::Conductor(Distribution::Ggx) => self.conductor(wi, Distribution::Ggx),
            LaneModel::Conductor(Distribution::Beckmann) => {
                self.conductor(wi, Distribution::Beckmann)
            }
            LaneModel::Plastic => self.plastic(w, wi),
            LaneModel::RoughPlastic(Distribution::Ggx) => {
                self.rough_plastic(w, wi, Distribution::Ggx)
            }
            LaneModel::RoughPlastic(Distribution::Beckmann) => {
                self.rough_plastic(w, wi, Distribution::Beckmann)
            }
            LaneModel::Principled if self.principled.has_extras => self.principled::<true>(wi),
            LaneModel::Principled => self.principled::<false>(wi),
            LaneModel::Any => {
                let mut out = Lanes3::ZERO;
                for i in lanes_of(active) {
                    if let Some(receiver) = &self.single[i] {
                        out.set(i, receiver.f_cos_wi(wi.vec(i)));
                    }
                }
                out
            }
        }
    }

    /// Cosines of `wi` to the normals; 0 below the surface.
    #[inline(always)]
    fn cosines<W: Wide>(&self, w: W, wi: &Lanes3) -> W::F {
        let cos = dot(w, self.frame[2].load(w), wi.load(w));
        w.max(cos, w.splat(0.0))
    }

    #[inline(always)]
    fn lambert<W: Wide>(&self, w: W, wi: &Lanes3) -> Lanes3 {
        let cos = self.cosines(w, wi);
        Lanes3::store(w, scale3(w, self.base.load(w), cos))
    }

    #[inline(always)]
    fn plastic<W: Wide>(&self, w: W, wi: &Lanes3) -> Lanes3 {
        let cos = self.cosines(w, wi);
        let mut enters = w.store(cos);
        for i in 0..LANES {
            enters[i] = 1.0 - self.coat_reflectance(i, enters[i]);
        }
        let share = w.mul(w.load(&enters), cos);
        Lanes3::store(w, scale3(w, self.base.load(w), share))
    }

    #[inline(always)]
    fn conductor(&self, wi: &Lanes3, distribution: Distribution) -> Lanes3 {
        let mut out = Lanes3::ZERO;
        for i in 0..LANES {
            let lobe = self.facet_lobe(i, self.to_local(i, wi.vec(i)), distribution);
            let terms = [self.conductor[0].rgb(i), self.conductor[1].rgb(i)];
            let f = ConductorFresnel::from_terms(terms).reflectance(lobe.cos.into());
            out.set(i, self.specular.rgb(i) * Rgb::from(f) * lobe.density);
        }
        out
    }

    #[inline(always)]
    fn rough_plastic<W: Wide>(&self, w: W, wi: &Lanes3, distribution: Distribution) -> Lanes3 {
        let cos = self.cosines(w, wi);
        // A rounded cosine may be above 1.
        let enters = interpolate_lanes(&self.transmittance, &w.store(w.min(cos, w.splat(1.0))));
        let base = scale3(w, self.base.load(w), w.mul(w.load(&enters), cos));
        let mut out = Lanes3::store(w, base);
        for i in 0..LANES {
            let lobe = self.facet_lobe(i, self.to_local(i, wi.vec(i)), distribution);
            let f = self.coat_reflectance(i, lobe.cos);
            let coat = self.specular.rgb(i) * (f * lobe.density);
            out.set(i, out.rgb(i) + coat);
        }
        out
    }

    #[inline(always)]
    fn principled<const EXTRAS: bool>(&self, wi: &Lanes3) -> Lanes3 {
        let mut out = Lanes3::ZERO;
        for i in 0..LANES {
            let wi = self.to_local(i, wi.vec(i));
            let facets = self.facets(i, Distribution::Ggx);
            let value = self.principled.lane(i).eval::<EXTRAS>(
                &facets,
                wi.into(),
                self.wo.vec(i).into(),
                self.specular.0[0][i].into(),
            );
            let lit = wi.z > 0.0;
            out.set(i, if lit { value.into() } else { Rgb::BLACK });
        }
        out
    }

    /// The microfacets of lane `i` that reflect light from the local direction `wi` to `wo`.
    #[inline(always)]
    fn facet_lobe(&self, i: usize, wi: Vec3, distribution: Distribution) -> FacetLobe {
        let wo = self.wo.vec(i);
        let half = wi + wo;
        let density = self
            .facets(i, distribution)
            .visible_density(wi.into(), half.into())
            .get();
        // For light from below, the half vector may be zero.
        let lit = wi.z > 0.0;
        FacetLobe {
            density: if lit { density } else { 0.0 },
            // |wi + wo| = 2 wo·m for unit vectors.
            cos: if lit {
                0.5 * half.length_squared().sqrt()
            } else {
                1.0
            },
        }
    }
}
