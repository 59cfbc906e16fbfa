//! Upper bounds of a scattering function over a cone of directions, for cuts through a tree of
//! lights. Each model has an upper bound next to its value.

use super::incident_cone::IncidentCone;
use super::{Bsdf, Lobes};
use crate::math::{Cone, Spread, Vec3};

impl Bsdf<'_> {
    /// Upper bound of all channels of [`Bsdf::f_cos_wi`] over the directions `wi` in `cone`.
    /// Infinite for rough dielectrics of index 1.
    pub fn bound_f_cos_wi(&self, cone: &Cone, wo: Vec3, lobes: Lobes) -> f32 {
        let incident = IncidentCone {
            axis: self.frame.to_local(cone.axis.into()).into(),
            spread: Spread::new(cone.half_angle),
            projected: None,
        };
        self.bound_local(&incident, self.frame.to_local(wo.into()).into(), lobes)
    }

    /// [`Bsdf::bound_f_cos_wi`] for directions in the shading frame.
    pub(super) fn bound_local(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        self.leaves()
            .map(|leaf| leaf.bound(incident, wo, lobes))
            .sum()
    }

    /// Upper bound of all channels of [`Bsdf::f_cos_wo`] of the `NON_SPECULAR` lobes over the
    /// directions `wo` in `cone`. It is found from the reciprocity of the models, with the cosine
    /// of `wo` to the geometric normal. Infinite for surfaces that transmit.
    pub fn bound_f_cos_wo(&self, wi: Vec3, cone: &Cone) -> f32 {
        if self.transmits() {
            return f32::INFINITY;
        }
        let spread = Spread::new(cone.half_angle);
        let (ng, ns) = (Vec3::from(self.ng), Vec3::from(self.frame.n));
        let [lowest, highest] = spread.cosines(cone.axis.dot(ng));
        let is_untilted = ns == ng || ns == -ng;
        let leaving = IncidentCone {
            axis: self.frame.to_local(cone.axis.into()).into(),
            spread,
            projected: (!is_untilted).then_some(highest.max(-lowest)),
        };
        let local = Vec3::from(self.frame.to_local(wi.into()));
        let sum: f32 = self
            .leaves()
            .map(|leaf| leaf.bound_leaving(local, &leaving, Lobes::NON_SPECULAR))
            .sum();
        sum / wi.dot(ng).abs()
    }
}
