//! Directions from a surface point towards emitters: sampled from a mixture of the scattering function and of the directions
//! from which photons of the environment arrive nearby.

use crate::bsdf::{BsdfNumbers, BsdfSample, Lobes};
use crate::emitters::EnvironmentLobes;
use crate::maps::{IncidentMap, Neighbors};
use crate::math::Vec3;
use crate::transport::Vertex;

/// Fraction of directions sampled from the guide where there is one; the others come from the scattering function.
/// Unmeasured: equal parts bound the loss where either alone would be right by a factor of two.
const GUIDED_FRACTION: f32 = 0.5;

/// The guide at `v`; `None` where too few photons of the environment arrive, or where light arrives on both sides, which
/// would need two guides.
pub(super) fn environment_guide(
    incident: &IncidentMap,
    v: &Vertex,
    found: &mut Neighbors,
) -> Option<EnvironmentLobes> {
    v.bsdf.receiving_normal(v.w_prev)?;
    let n = v.x.normal_towards(v.w_prev);
    incident.around(v.x.p, n, found)
}

/// Density of [`sample_direction`] per solid angle, in 1/sr.
pub(super) fn guided_pdf(
    v: &Vertex,
    guide: Option<&EnvironmentLobes>,
    lobes: Lobes,
    w: Vec3,
) -> f32 {
    let pdf = v.bsdf.pdf_wi(w, v.w_prev, lobes);
    guide.map_or(pdf, |guide| pdf + GUIDED_FRACTION * (guide.pdf(w) - pdf))
}

/// Samples a direction `wi` at `v` for `lobes`, all of them non-specular. `u` in [0, 1) chooses between the guide and the
/// scattering function.
pub(super) fn sample_direction(
    v: &Vertex,
    guide: Option<&EnvironmentLobes>,
    lobes: Lobes,
    numbers: BsdfNumbers,
    u: f32,
) -> Option<BsdfSample> {
    let Some(guide) = guide else {
        return v.bsdf.sample_wi(v.w_prev, numbers, lobes);
    };
    let (w, lobe, eta) = if u < GUIDED_FRACTION {
        let w = guide.sample(numbers.lobe, numbers.direction);
        (w, Lobes::DIFFUSE, 1.0)
    } else {
        let sample = v.bsdf.sample_wi(v.w_prev, numbers, lobes)?;
        (sample.w, sample.lobe, sample.eta)
    };
    let pdf = guided_pdf(v, Some(guide), lobes, w);
    Some(BsdfSample {
        w,
        weight: v.bsdf.f_cos_wi(w, v.w_prev, lobes) / pdf,
        pdf,
        lobe,
        eta,
    })
}
