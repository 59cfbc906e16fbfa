//! Values in lanes, by the functions of the models.

use super::{FixedWoLanes, LaneModel};
use crate::bsdf::material::Distribution;
use crate::bsdf::models::coat::interpolate_tables;
use crate::bsdf::models::fresnel::{self, ConductorFresnel};
use crate::bsdf::models::microfacet::Microfacets;
use crate::lanes::{Color, Float, LaneMask, Lanes3, Pair, Sixteen, Vector, lanes_of};
use crate::simd::Outlined;

/// Microfacets with the half vector as normal.
struct FacetLobe<W: Sixteen> {
    /// `D(m) G1(wi)`.
    density: Float<W>,
    /// Cosine between the half vector and `wo`.
    cos: Float<W>,
}

/// [`FixedWoLanes::f_cos_wi`] for all models but [`LaneModel::Any`]: a function that its many callers share.
struct Values<'a, 'b, 's, W> {
    functions: &'a FixedWoLanes<'b, 's>,
    s: W,
    wi: &'a Lanes3,
}

impl<W: Sixteen> Outlined for Values<'_, '_, '_, W> {
    type Output = Lanes3;

    #[inline(always)]
    fn run(self) -> Lanes3 {
        let Values { functions, s, wi } = self;
        let wi = wi.vectors(s);
        let values = match functions.model {
            LaneModel::Lambert | LaneModel::Any => functions.lambert(s, wi),
            LaneModel::Conductor(distribution) => functions.conductor(s, wi, distribution),
            LaneModel::Plastic => functions.plastic(s, wi),
            LaneModel::RoughPlastic(distribution) => functions.rough_plastic(s, wi, distribution),
            LaneModel::Principled => functions.principled(s, wi),
        };
        Lanes3::of_colors(values)
    }
}

impl FixedWoLanes<'_, '_> {
    /// [`FixedWo::f_cos_wi`](crate::bsdf::FixedWo::f_cos_wi) in each active lane, for unit directions `wi`; other lanes are unspecified.
    #[inline(always)]
    pub(crate) fn f_cos_wi<W: Sixteen>(&self, w: W, wi: &Lanes3, active: LaneMask) -> Lanes3 {
        match self.model {
            LaneModel::Lambert => Lanes3::of_colors(self.lambert(w, wi.vectors(w))),
            LaneModel::Any => {
                let mut out = Lanes3::ZERO;
                for i in lanes_of(active) {
                    if let Some(receiver) = &self.single[i] {
                        out.set(i, receiver.f_cos_wi(wi.vec(i)));
                    }
                }
                out
            }
            _ => w.outline(Values {
                functions: self,
                s: w,
                wi,
            }),
        }
    }

    /// Cosines of `wi` to the normals; 0 below the surface.
    #[inline(always)]
    fn cosines<W: Sixteen>(&self, s: W, wi: Vector<W>) -> Float<W> {
        self.frame[2].vectors(s).dot(wi).max(0.0)
    }

    #[inline(always)]
    fn lambert<W: Sixteen>(&self, s: W, wi: Vector<W>) -> Color<W> {
        self.base.colors(s) * self.cosines(s, wi)
    }

    #[inline(always)]
    fn plastic<W: Sixteen>(&self, s: W, wi: Vector<W>) -> Color<W> {
        let cos = self.cosines(s, wi);
        let enters = 1.0 - self.coat_reflectances(s, cos);
        self.base.colors(s) * (enters * cos)
    }

    #[inline(always)]
    fn conductor<W: Sixteen>(&self, s: W, wi: Vector<W>, distribution: Distribution) -> Color<W> {
        let lobe = self.facet_lobe(s, self.to_locals(s, wi), distribution);
        let [difference, product] = &self.conductor;
        let terms = [difference.colors(s), product.colors(s)];
        let f = ConductorFresnel::from_terms(terms).reflectance(lobe.cos);
        self.specular.colors(s) * f * lobe.density
    }

    #[inline(always)]
    fn rough_plastic<W: Sixteen>(
        &self,
        s: W,
        wi: Vector<W>,
        distribution: Distribution,
    ) -> Color<W> {
        let wi = self.to_locals(s, wi);
        let cos = wi.z.max(0.0);
        let base = interpolate_tables(&self.transmittance, cos) * cos;
        let lobe = self.facet_lobe(s, wi, distribution);
        let coat = self.coat_reflectances(s, lobe.cos) * lobe.density;
        self.base.colors(s) * base + self.specular.colors(s) * coat
    }

    #[inline(always)]
    fn principled<W: Sixteen>(&self, s: W, wi: Vector<W>) -> Color<W> {
        let wi = self.to_locals(s, wi);
        let (wo, seen) = (self.wo.vectors(s), Float::load(s, &self.specular.0[0]));
        let facets = self.facets_in_lanes(s, Distribution::Ggx);
        let front = self.principled.load(s);
        let values = if self.principled.has_extras {
            front.eval::<true>(&facets, wi, wo, seen)
        } else {
            front.eval::<false>(&facets, wi, wo, seen)
        };
        values.within(wi.z.gt(0.0))
    }

    /// The microfacets that reflect light from the local directions `wi` to `wo`.
    #[inline(always)]
    fn facet_lobe<W: Sixteen>(
        &self,
        s: W,
        wi: Vector<W>,
        distribution: Distribution,
    ) -> FacetLobe<W> {
        let half = wi + self.wo.vectors(s);
        let facets = self.facets_in_lanes(s, distribution);
        let density = facets.visible_density(wi, half);
        // For light from below, the half vector may be zero.
        let lit = wi.z.gt(0.0);
        FacetLobe {
            density: lit.select(density, 0.0),
            // |wi + wo| = 2 wo·m for unit vectors.
            cos: lit.select(0.5 * half.length(), 1.0),
        }
    }

    #[inline(always)]
    fn facets_in_lanes<W: Sixteen>(&self, s: W, distribution: Distribution) -> Microfacets<W> {
        let [alpha, inv_alpha] = &self.roughness;
        let pair = |[x, y]: &[_; 2]| Pair::new(Float::load(s, x), Float::load(s, y));
        Microfacets::from_roughness(distribution, pair(alpha), pair(inv_alpha))
    }

    /// Reflectance of the smooth coats from outside.
    #[inline(always)]
    fn coat_reflectances<W: Sixteen>(&self, s: W, cos: Float<W>) -> Float<W> {
        fresnel::coat_reflectance(
            cos,
            Float::load(s, &self.eta),
            Float::load(s, &self.inv_eta),
        )
    }

    /// World-space directions in the local frames.
    #[inline(always)]
    fn to_locals<W: Sixteen>(&self, s: W, w: Vector<W>) -> Vector<W> {
        let [x, y, z] = &self.frame;
        Vector::new(
            x.vectors(s).dot(w),
            y.vectors(s).dot(w),
            z.vectors(s).dot(w),
        )
    }
}
