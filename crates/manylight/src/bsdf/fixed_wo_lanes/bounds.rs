//! Upper bounds in lanes.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over lanes read like the vector instructions that they become"
)]

use super::{FixedWoLanes, LaneModel};
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::material::Distribution;
use crate::bsdf::models::fresnel::ConductorFresnel;
use crate::lanes::{Color, LANES, LaneMask, Lanes, Lanes3, lanes_of};
use crate::math::Spread;
use crate::simd::{Outlined, Sixteen};

/// Bounds on the microfacets that reflect light from a cone to `wo`.
struct FacetBound {
    /// Upper bound of `D(m) G1(wi)`.
    density: f32,
    /// Smallest and largest cosine between the half vector and `wo`.
    cosines: [f32; 2],
}

/// [`FixedWoLanes::bounds`]: a function that its callers share.
struct Bounds<'a, 'b, 's> {
    functions: &'a FixedWoLanes<'b, 's>,
    axes: &'a Lanes3,
    spreads: &'a [Spread; LANES],
    active: LaneMask,
}

impl Outlined for Bounds<'_, '_, '_> {
    type Output = Lanes;

    #[inline(always)]
    fn run(self) -> Lanes {
        self.functions
            .bounds_inlined(self.axes, self.spreads, self.active)
    }
}

impl FixedWoLanes<'_, '_> {
    /// Upper bounds of all channels of [`FixedWoLanes::f_cos_wi`] over the cones with unit axes `axes` and half-angles `spreads`, in each
    /// active lane; other lanes are unspecified.
    #[inline(always)]
    pub(crate) fn bounds<W: Sixteen>(
        &self,
        w: W,
        axes: &Lanes3,
        spreads: &[Spread; LANES],
        active: LaneMask,
    ) -> Lanes {
        w.outline(Bounds {
            functions: self,
            axes,
            spreads,
            active,
        })
    }

    #[inline(always)]
    fn bounds_inlined(&self, axes: &Lanes3, spreads: &[Spread; LANES], active: LaneMask) -> Lanes {
        let mut out = [0.0; LANES];
        match self.model {
            LaneModel::Lambert => {
                for i in 0..LANES {
                    out[i] = self.bound_lambert(i, &self.incident(i, axes, spreads));
                }
            }
            LaneModel::Plastic => {
                for i in 0..LANES {
                    out[i] = self.bound_plastic(i, &self.incident(i, axes, spreads));
                }
            }
            LaneModel::Conductor(distribution) => {
                for i in 0..LANES {
                    let incident = self.incident(i, axes, spreads);
                    out[i] = self.bound_conductor(i, &incident, distribution);
                }
            }
            LaneModel::RoughPlastic(distribution) => {
                for i in 0..LANES {
                    let incident = self.incident(i, axes, spreads);
                    out[i] = self.bound_rough_plastic(i, &incident, distribution);
                }
            }
            LaneModel::Principled => {
                for i in 0..LANES {
                    out[i] = self.bound_principled(i, &self.incident(i, axes, spreads));
                }
            }
            LaneModel::Any => {
                for i in lanes_of(active) {
                    if let Some(function) = &self.single[i] {
                        out[i] = function.bound(axes.vec(i), spreads[i]);
                    }
                }
            }
        }
        out
    }

    #[inline(always)]
    fn bound_lambert(&self, i: usize, incident: &IncidentCone) -> f32 {
        let [_, cos] = incident.cosines();
        self.base.rgb(i).max_channel() * cos.max(0.0)
    }

    #[inline(always)]
    fn bound_plastic(&self, i: usize, incident: &IncidentCone) -> f32 {
        let [_, cos] = incident.cosines();
        let cos = cos.max(0.0);
        let enters = 1.0 - self.coat_reflectance(i, cos);
        self.base.rgb(i).max_channel() * (enters * cos)
    }

    #[inline(always)]
    fn bound_conductor(
        &self,
        i: usize,
        incident: &IncidentCone,
        distribution: Distribution,
    ) -> f32 {
        let terms = [self.conductor[0].rgb(i), self.conductor[1].rgb(i)];
        let lobe = self.facet_bound(i, incident, distribution);
        let f = ConductorFresnel::from_terms(terms.map(Color::from)).bound(lobe.cosines);
        (self.specular.rgb(i) * f).max_channel() * lobe.density
    }

    #[inline(always)]
    fn bound_rough_plastic(
        &self,
        i: usize,
        incident: &IncidentCone,
        distribution: Distribution,
    ) -> f32 {
        let [_, cos] = incident.cosines();
        let base = self.base.rgb(i).max_channel() * self.max_transmittance[i];
        let lobe = self.facet_bound(i, incident, distribution);
        let f = self.coat_reflectance(i, lobe.cosines[0]);
        let coat = self.specular.rgb(i).max_channel() * (f * lobe.density);
        base * cos.max(0.0) + coat
    }

    #[inline(always)]
    fn bound_principled(&self, i: usize, incident: &IncidentCone) -> f32 {
        let facets = self.facets(i, Distribution::Ggx);
        let (wo, seen) = (self.wo.vec(i), self.specular.0[0][i]);
        self.principled.lane(i).bound(&facets, incident, wo, seen)
    }

    /// The cone of lane `i` in the local frame.
    #[inline(always)]
    fn incident(&self, i: usize, axes: &Lanes3, spreads: &[Spread; LANES]) -> IncidentCone {
        IncidentCone {
            axis: self.to_local(i, axes.vec(i)),
            spread: spreads[i],
            projected: None,
        }
    }

    /// Bounds on the microfacets of lane `i` that reflect light from a cone to `wo`.
    #[inline(always)]
    fn facet_bound(
        &self,
        i: usize,
        incident: &IncidentCone,
        distribution: Distribution,
    ) -> FacetBound {
        let halves = incident.halves(self.wo.vec(i));
        let [_, cos] = incident.cosines();
        let facets = self.facets(i, distribution);
        FacetBound {
            density: facets.visible_bound(halves.highest, cos),
            cosines: halves.cosines,
        }
    }
}
