//! Directions from a surface point towards emitters: sampled from a mixture of the scattering
//! function and of the directions from which photons of the environment arrive nearby.

use crate::bsdf::{BsdfSamples, Lobes, Numbers};
use crate::emitters::{EnvironmentLobes, LobesOfLanes};
use crate::lanes::{Color, Float, Mask, Vector, Width, Word, lane};
use crate::maps::{IncidentMap, Neighbors};
use crate::math::{Vec2, Vec3};
use crate::simd::set_bits;
use crate::transport::Vertex;
use crate::transport::stream::{Vertices, lanes_where};

/// Fraction of directions sampled from the guide where there is one; the others come from the
/// scattering function. With a fraction `a` the second moment of a sample is at most `1/a` times
/// that of the guide alone and `1/(1 - a)` times that of the scattering function alone: equal parts
/// make the larger of the two bounds least, 2; at a quarter or three quarters it is 4.
const GUIDED_DIRECTIONS: f32 = 0.5;

/// The guide at `v`; `None` where too few photons of the environment arrive, or where light arrives
/// on both sides, which would need two guides.
pub(super) fn environment_guide(
    incident: &IncidentMap,
    v: &Vertex,
    found: &mut Neighbors,
) -> Option<EnvironmentLobes> {
    v.bsdf.receiving_normal(v.w_prev)?;
    let n = v.x.normal_towards(v.w_prev);
    incident.around(v.x.p, n, found)
}

/// Densities of [`sample_directions`] along the unit directions `w` per solid angle, in 1/sr; `pdf`
/// are those of the scattering functions.
#[inline(always)]
pub(super) fn guided_pdfs<S: Width>(
    pdf: Float<S>,
    guides: LobesOfLanes<S>,
    w: Vector<S>,
) -> Float<S> {
    let Some(guides) = guides else {
        return pdf;
    };
    let (w, by_bsdf) = (w.store(), pdf.store());
    Float::from_fn(pdf.width(), |i| {
        let by_bsdf = by_bsdf.as_ref()[i];
        guides.as_ref()[i].map_or(by_bsdf, |guide| {
            by_bsdf + GUIDED_DIRECTIONS * (guide.pdf(Vec3::from(lane(&w, i))) - by_bsdf)
        })
    })
}

/// Samples directions `wi` at the vertices for `lobes`, all of them non-specular. `u` in [0, 1)
/// chooses between the guide of a lane and the scattering function.
#[inline(always)]
pub(super) fn sample_directions<S: Width>(
    v: &Vertices<S>,
    guides: LobesOfLanes<S>,
    lobes: Lobes,
    numbers: Numbers<S>,
    u: Float<S>,
) -> BsdfSamples<S> {
    let mut samples = v.bsdf.sample_each_wi(v.w_prev, numbers, lobes);
    let Some(guides) = guides else {
        return samples;
    };
    let s = u.width();
    let guide = |i: usize| guides.as_ref()[i];
    let all = u32::MAX >> (32 - S::LANES);
    let has_guide = lanes_where(all, |i| guide(i).is_some());
    let guided = has_guide & u.lt(GUIDED_DIRECTIONS).bits();
    let (lobe, x, y) = (
        numbers.lobe.store(),
        numbers.direction.x.store(),
        numbers.direction.y.store(),
    );
    let mut w = samples.w.store();
    for i in set_bits(guided) {
        if let Some(guide) = guide(i) {
            let u = Vec2::new(x.as_ref()[i], y.as_ref()[i]);
            let sampled = guide.sample(lobe.as_ref()[i], u).to_array();
            for (axis, value) in w.iter_mut().zip(sampled) {
                axis.as_mut()[i] = value;
            }
        }
    }
    let (has_guide, guided) = (Mask::from_bits(s, has_guide), Mask::from_bits(s, guided));
    samples.w = Vector::load(s, &w);
    let (f_cos, pdf) = v.bsdf.responses(samples.w, v.w_prev, lobes);
    let pdf = guided_pdfs(pdf, Some(guides), samples.w);
    samples.weight = Color::select(has_guide, f_cos / pdf, samples.weight);
    samples.pdf = has_guide.select(pdf, samples.pdf);
    samples.valid |= guided;
    samples.eta = guided.select(1.0, samples.eta);
    let diffuse = Word::splat(s, u32::from(Lobes::DIFFUSE.0));
    samples.lobe = guided.select_words(diffuse, samples.lobe);
    samples
}
