//! Planar elements with constant radiance. The data for sampling one fits into two cache lines.

use super::sampling::ElementSampling;
use super::visible_point::VisiblePoints;
use crate::color::Rgb;
use crate::geometry::SurfacePoint;
use crate::lanes::{Color, Float, Mask, Pair, Vector, Width, Word, disc, split, triangle};
use crate::math::Vec3;

/// A planar element, sampled by area.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanarElement {
    /// Of one or two triangles a corner, and the two edges from it; of a disk the center, and two conjugate radii.
    outlines: [[Vec3; 3]; 2],
    /// The first outline's share of the area.
    share: f32,
    is_disk: bool,
    /// Unit normal on the side of emission.
    n: Vec3,
    /// See [`SurfacePoint::offset`].
    offset: f32,
    area: f32,
    /// In W/(m² sr).
    radiance: Rgb,
}

impl PlanarElement {
    /// One or two triangles, given by the points at their corners. `None` if normals differ by more than rounding, and for
    /// triangles without area.
    pub(super) fn triangles(corners: &[[SurfacePoint; 3]], radiance: Rgb) -> Option<Self> {
        let n = corners.first()?[0].frame.n;
        let points = corners.iter().flatten();
        let is_flat = |x: &SurfacePoint| is_along(x.frame.n, n) && is_along(x.ng, n);
        if !points.clone().all(is_flat) {
            return None;
        }
        let edges = |[a, b, c]: &[SurfacePoint; 3]| [a.p, b.p - a.p, c.p - a.p];
        let area = |[_, ab, ac]: [Vec3; 3]| 0.5 * ab.cross(ac).length();
        let (outlines, share, area) = match corners {
            [one] => ([edges(one); 2], 1.0, area(edges(one))),
            [first, second] => {
                let both = [edges(first), edges(second)];
                let sum = area(both[0]) + area(both[1]);
                (both, area(both[0]) / sum, sum)
            }
            _ => return None,
        };
        let offset = points.map(|x| x.offset).fold(0.0, f32::max);
        (area > 0.0).then_some(PlanarElement {
            outlines,
            share,
            is_disk: false,
            n,
            offset,
            area,
            radiance,
        })
    }

    /// A disk, given by its center, two points of its border a quarter turn apart, and its area.
    pub(super) fn disk([center, u, v]: [&SurfacePoint; 3], area: f32, radiance: Rgb) -> Self {
        let radii = [u.p - center.p, v.p - center.p];
        // No coordinate of any point exceeds the sum of those of the center and of both radii.
        let reach = radii[0].abs().max_element() + radii[1].abs().max_element();
        let size = center.p.abs().max_element();
        PlanarElement {
            outlines: [[center.p, radii[0], radii[1]]; 2],
            share: 1.0,
            is_disk: true,
            n: center.frame.n,
            offset: center.offset.max(u.offset).max(v.offset) * (1.0 + reach / (size + reach)),
            area,
            radiance,
        }
    }
}

/// Points of planar elements as seen from `p`, with the uniform numbers `u`: in the lanes of `lanes`, by the indices `element`.
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

/// Whether two unit vectors are parallel or opposite, up to rounding.
fn is_along(a: Vec3, n: Vec3) -> bool {
    const ROUNDING: f32 = 4.0 * f32::EPSILON;
    a.abs_diff_eq(n, ROUNDING) || a.abs_diff_eq(-n, ROUNDING)
}
