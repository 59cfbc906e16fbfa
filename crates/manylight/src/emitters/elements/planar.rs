//! Planar elements with constant radiance. The data for sampling one fits into two cache lines.

use super::visible_point::VisiblePoint;
use crate::color::Rgb;
use crate::emitters::unit_interval::split;
use crate::geometry::SurfacePoint;
use crate::math::{Vec2, Vec3};
use crate::sampling::warp;

/// A planar element, sampled by area.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanarElement {
    outline: PlanarOutline,
    /// Unit normal on the side of emission.
    n: Vec3,
    /// See [`SurfacePoint::offset`].
    offset: f32,
    area: f32,
}

#[derive(Clone, Copy, Debug)]
enum PlanarOutline {
    /// A corner, and the two edges from it.
    Triangle([Vec3; 3]),
    /// Two triangles, and the first one's share of the area.
    Triangles([[Vec3; 3]; 2], f32),
    /// The center, and two conjugate radii.
    Disk([Vec3; 3]),
}

impl PlanarElement {
    /// One or two triangles, given by the points at their corners. `None` if normals differ by more than rounding, and for
    /// triangles without area.
    pub(super) fn triangles(corners: &[[SurfacePoint; 3]]) -> Option<Self> {
        let n = corners.first()?[0].frame.n;
        let points = corners.iter().flatten();
        let is_flat = |x: &SurfacePoint| is_along(x.frame.n, n) && is_along(x.ng, n);
        if !points.clone().all(is_flat) {
            return None;
        }
        let edges = |[a, b, c]: &[SurfacePoint; 3]| [a.p, b.p - a.p, c.p - a.p];
        let area = |[_, ab, ac]: [Vec3; 3]| 0.5 * ab.cross(ac).length();
        let (outline, area) = match corners {
            [one] => (PlanarOutline::Triangle(edges(one)), area(edges(one))),
            [first, second] => {
                let both = [edges(first), edges(second)];
                let sum = area(both[0]) + area(both[1]);
                (PlanarOutline::Triangles(both, area(both[0]) / sum), sum)
            }
            _ => return None,
        };
        let offset = points.map(|x| x.offset).fold(0.0, f32::max);
        (area > 0.0).then_some(PlanarElement {
            outline,
            n,
            offset,
            area,
        })
    }

    /// A disk, given by its center, two points of its border a quarter turn apart, and its area.
    pub(super) fn disk([center, u, v]: [&SurfacePoint; 3], area: f32) -> Self {
        let radii = [u.p - center.p, v.p - center.p];
        // No coordinate of any point exceeds the sum of those of the center and of both radii.
        let reach = radii[0].abs().max_element() + radii[1].abs().max_element();
        let size = center.p.abs().max_element();
        PlanarElement {
            outline: PlanarOutline::Disk([center.p, radii[0], radii[1]]),
            n: center.frame.n,
            offset: center.offset.max(u.offset).max(v.offset) * (1.0 + reach / (size + reach)),
            area,
        }
    }

    /// A point as seen from `p`; `None` from behind.
    #[inline]
    pub(super) fn sample(&self, radiance: Rgb, p: Vec3, u: Vec2) -> Option<VisiblePoint> {
        let y = self.point(u);
        let d = y - p;
        let d2 = d.length_squared();
        let wi = d * d2.sqrt().recip();
        let cos = -self.n.dot(wi);
        let pdf = d2 / (self.area * cos);
        (cos > 0.0 && pdf > 0.0 && pdf.is_finite()).then(|| VisiblePoint {
            wi,
            target: y + self.n * self.offset,
            pdf,
            radiance,
        })
    }

    /// A point, uniform by area.
    #[inline]
    fn point(&self, u: Vec2) -> Vec3 {
        let ([origin, a, b], at) = match &self.outline {
            PlanarOutline::Triangle(triangle) => (triangle, warp::triangle(u)),
            PlanarOutline::Triangles(triangles, share) => {
                let (is_first, rest) = split(u.x, *share);
                let at = warp::triangle(Vec2::new(rest, u.y));
                (&triangles[usize::from(!is_first)], at)
            }
            PlanarOutline::Disk(disk) => (disk, warp::disc(u)),
        };
        *origin + *a * at.x + *b * at.y
    }
}

/// Whether two unit vectors are parallel or opposite, up to rounding.
fn is_along(a: Vec3, n: Vec3) -> bool {
    const ROUNDING: f32 = 4.0 * f32::EPSILON;
    a.abs_diff_eq(n, ROUNDING) || a.abs_diff_eq(-n, ROUNDING)
}
