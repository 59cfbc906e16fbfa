//! The data by which elements are sampled from receivers.

use crate::color::Rgb;
use crate::emitters::Emitter;
use crate::geometry::SurfacePoint;
use crate::ids::EmitterId;
use crate::math::Vec3;

/// The data for sampling an element from a receiver.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) enum ElementSampling {
    /// A planar element with constant radiance.
    Planar(PlanarElement),
    /// A sphere with constant radiance, sampled by its visible cap.
    Sphere(SphereElement),
    /// A point or a spot.
    Point(PointElement),
    /// Any other surface, by [`EmitterElement`](super::element::EmitterElement).
    Surface,
}

/// A planar element, sampled by area. Its data fit into two cache lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanarElement {
    /// Of one or two triangles a corner, and the two edges from it; of a disk the center, and two
    /// conjugate radii.
    pub(super) outlines: [[Vec3; 3]; 2],
    /// The first outline's share of the area.
    pub(super) share: f32,
    pub(super) is_disk: bool,
    /// Unit normal on the side of emission.
    pub(super) n: Vec3,
    /// See [`SurfacePoint::offset`].
    pub(super) offset: f32,
    pub(super) area: f32,
    /// In W/(m² sr).
    pub(super) radiance: Rgb,
}

impl PlanarElement {
    /// One or two triangles, given by the points at their corners. `None` if normals differ by more
    /// than rounding, and for triangles without area.
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

/// A sphere with constant radiance.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphereElement {
    pub(super) center: Vec3,
    pub(super) radius: f32,
    /// Distance by which points are moved off the sphere, in m.
    pub(super) offset: f32,
    /// In W/(m² sr).
    pub(super) radiance: Rgb,
}

/// A point or a spot.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointElement {
    pub(super) position: Vec3,
    pub(super) emitter: EmitterId,
    /// In W/sr; `None` if it depends on the direction.
    pub(super) intensity: Option<Rgb>,
}

impl PointElement {
    pub(super) fn new(id: EmitterId, emitter: &Emitter, position: Vec3) -> Self {
        PointElement {
            position,
            emitter: id,
            intensity: match emitter {
                Emitter::Point { intensity, .. } => Some(*intensity),
                _ => None,
            },
        }
    }
}

/// Whether two unit vectors are parallel or opposite, up to rounding.
fn is_along(a: Vec3, n: Vec3) -> bool {
    const ROUNDING: f32 = 4.0 * f32::EPSILON;
    a.abs_diff_eq(n, ROUNDING) || a.abs_diff_eq(-n, ROUNDING)
}
