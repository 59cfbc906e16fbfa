//! Next-event estimation on the camera paths of the many-light methods.

use super::compensation_photons::direction_fraction;
use super::gather_points::PixelGather;
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::math::Vec3;
use crate::transport::Vertex;
use crate::transport::direct::EmitterSample;

/// The light of emitters that is estimated at a vertex.
#[derive(Clone, Copy)]
pub(super) struct EmitterLight {
    /// Lobes that reflect it.
    pub(super) lobes: Lobes,
    /// If given, only light that arrives on the side of this normal counts.
    pub(super) lit_from: Option<Vec3>,
    /// See [`direction_limit`](super::compensation_photons::direction_limit).
    pub(super) direction_limit: f32,
}

impl PixelGather<'_, '_, '_, '_> {
    /// Radiance from the sampled emitter that `v` reflects towards the camera path, in W/(m² sr), with the MIS weight against
    /// directions sampled with density `pdf_walk`, in 1/sr.
    pub(super) fn next_event(
        &mut self,
        v: &Vertex,
        light: EmitterLight,
        sample: EmitterSample,
        pdf_walk: impl FnOnce(Vec3) -> f32,
    ) -> Option<Rgb> {
        let (scene, wo) = (self.prepared.scene, v.w_prev);
        let f_cos = v.bsdf.f_cos_wi(sample.wi, wo, light.lobes);
        if f_cos.is_black() || light.lit_from.is_some_and(|n| sample.wi.dot(n) <= 0.0) {
            return None;
        }
        let fraction = direction_fraction(light.direction_limit, f_cos);
        self.tile.shadow_rays += 1;
        let crossings = self.prepared.limits.left_after(v.segments + 1);
        let arriving = sample.weight * sample.transmittance(scene, crossings);
        Some(arriving * f_cos * (fraction * sample.mis_weight(pdf_walk(sample.wi))))
    }
}
