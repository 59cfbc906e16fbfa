//! Directions from a point in which its smooth lobes may see an emitter: drawn from the lobes, and from where photons of emitters
//! beyond the scene arrive.

use crate::bsdf::{BsdfNumbers, BsdfSample, Lobes};
use crate::maps::{IncidentGuide, IncidentMap, Neighbors};
use crate::math::Vec3;
use crate::transport::Vertex;

/// Share of the directions that look where light from afar comes from, if that is known.
const GUIDED: f32 = 0.5;

/// Where light from afar comes from at `v`, if anything is known.
pub(super) fn guide_at(
    incident: &IncidentMap,
    v: &Vertex,
    found: &mut Neighbors,
) -> Option<IncidentGuide> {
    // A surface that is lit from both sides would need two guides.
    v.bsdf.receiving_normal(v.w_prev)?;
    let n = v.x.normal_towards(v.w_prev);
    incident.around(v.x.p, n, found)
}

/// Density of [`draw_direction`] per solid angle.
pub(super) fn guided_pdf(v: &Vertex, guide: Option<&IncidentGuide>, lobes: Lobes, w: Vec3) -> f32 {
    let pdf = v.bsdf.pdf_wi(w, v.w_prev, lobes);
    guide.map_or(pdf, |guide| pdf + GUIDED * (guide.pdf(w) - pdf))
}

/// A direction in which `lobes`, all of them smooth, reflect: from the mixture of them and the guide, which of both by `u` in [0, 1).
pub(super) fn draw_direction(
    v: &Vertex,
    guide: Option<&IncidentGuide>,
    lobes: Lobes,
    numbers: BsdfNumbers,
    u: f32,
) -> Option<BsdfSample> {
    let Some(guide) = guide else {
        return v.bsdf.sample_wi(v.w_prev, numbers, lobes);
    };
    let (w, lobe, eta) = if u < GUIDED {
        let w = guide.sample(numbers.lobe, numbers.direction);
        (w, Lobes::DIFFUSE, 1.0)
    } else {
        let drawn = v.bsdf.sample_wi(v.w_prev, numbers, lobes)?;
        (drawn.w, drawn.lobe, drawn.eta)
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
