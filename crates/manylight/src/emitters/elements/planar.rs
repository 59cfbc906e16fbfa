//! Points of planar elements, by area.

use super::sampling::ElementSampling;
use super::visible_point::VisiblePoints;
use crate::lanes::{Color, Float, Mask, Pair, Vector, Width, Word, disc, split, triangle};
use crate::math::Vec3;

/// Points of planar elements as seen from `p`, with the uniform numbers `u`: in the lanes of
/// `lanes`, by the indices `element`.
#[inline(always)]
pub(super) fn sample<S: Width>(
    sampling: &[ElementSampling],
    element: Word<S>,
    lanes: Mask<S>,
    p: Vector<S>,
    u: Pair<S>,
) -> VisiblePoints<S> {
    let of = PlanarElements::load(sampling, element, lanes, u.x);
    let (_, rest) = split(u.x, of.share);
    let u = Pair::new(rest, u.y);
    let mut at = triangle(u);
    if of.is_disk.any() {
        let round = disc(u);
        at = Pair::new(
            of.is_disk.select(round.x, at.x),
            of.is_disk.select(round.y, at.y),
        );
    }
    let [origin, a, b] = of.outline;
    let y = origin + a * at.x + b * at.y;
    let d = y - p;
    let d2 = d.length_squared();
    let wi = d * d2.sqrt().recip();
    let cos = -of.n.dot(wi);
    let pdf = d2 / (of.area * cos);
    VisiblePoints {
        wi,
        target: y + of.n * of.offset,
        pdf,
        radiance: of.radiance,
        valid: lanes & cos.gt(0.0) & pdf.gt(0.0) & pdf.is_finite(),
    }
}

/// A planar element per lane, with the outline that is sampled.
struct PlanarElements<S: Width> {
    outline: [Vector<S>; 3],
    share: Float<S>,
    is_disk: Mask<S>,
    n: Vector<S>,
    offset: Float<S>,
    area: Float<S>,
    radiance: Color<S>,
}

impl<S: Width> PlanarElements<S> {
    /// The elements in the lanes of `lanes`. `u` chooses between outlines.
    #[inline(always)]
    fn load(sampling: &[ElementSampling], element: Word<S>, lanes: Mask<S>, u: Float<S>) -> Self {
        let s = u.width();
        let (zero, none) = (Vector::splat(s, Vec3::ZERO), Mask::splat(s, false));
        let mut all = PlanarElements {
            outline: [zero; 3],
            share: u.same(1.0),
            is_disk: none,
            n: zero,
            offset: u.same(0.0),
            area: u.same(1.0),
            radiance: Color::black(s),
        };
        for (i, lanes) in element.groups(lanes) {
            let ElementSampling::Planar(of) = &sampling[i as usize] else {
                continue;
            };
            let is_first = u.lt(of.share) & lanes;
            for (outline, m) in of.outlines.iter().zip([is_first, lanes & !is_first]) {
                if m.any() {
                    for (all, v) in all.outline.iter_mut().zip(outline) {
                        *all = Vector::select(m, Vector::splat(s, *v), *all);
                    }
                }
            }
            all.share = lanes.select(of.share, all.share);
            if of.is_disk {
                all.is_disk |= lanes;
            }
            all.n = Vector::select(lanes, Vector::splat(s, of.n), all.n);
            all.offset = lanes.select(of.offset, all.offset);
            all.area = lanes.select(of.area, all.area);
            let radiance = Color::splat(s, of.radiance);
            all.radiance = Color::select(lanes, radiance, all.radiance);
        }
        all
    }
}
