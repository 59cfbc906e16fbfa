//! Tubes around curves, as meshes.

use manylight::geometry::Mesh;
use manylight::math::{Vec2, Vec3, Vec4};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// How finely tubes are divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TubeDetail {
    /// Sides of the cross-section.
    pub(super) sides: usize,
    /// Pieces of a cubic segment.
    pub(super) pieces: usize,
}

impl TubeDetail {
    /// The coarsest detail: that of hair and fur.
    pub(super) const COARSE: TubeDetail = TubeDetail {
        sides: 4,
        pieces: 4,
    };

    /// The finest detail with which `segments` segments have at most about two million triangles;
    /// hair and fur are coarse, single ropes fine. `triangles` is the number of triangles of a
    /// segment.
    pub(super) fn for_segments(
        segments: usize,
        triangles: impl Fn(&TubeDetail) -> usize,
    ) -> TubeDetail {
        const MAX_TRIANGLES: usize = 1 << 21;
        const FINER: [TubeDetail; 3] = [
            TubeDetail {
                sides: 24,
                pieces: 12,
            },
            TubeDetail {
                sides: 12,
                pieces: 8,
            },
            TubeDetail {
                sides: 8,
                pieces: 4,
            },
        ];
        let fits = |detail: &TubeDetail| triangles(detail) * segments <= MAX_TRIANGLES;
        FINER.into_iter().find(fits).unwrap_or(Self::COARSE)
    }
}

/// A circle around a curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    pub(super) center: Vec3,
    pub(super) radius: f32,
    /// Unit vectors across the curve, at a quarter of a turn; their cross product is the direction
    /// of the curve.
    pub(super) axes: [Vec3; 2],
    /// Cosine and sine of the angle by which the surface normal leans towards the direction of the
    /// curve.
    pub(super) lean: [f32; 2],
    /// Place along the curve, the second argument of the texture coordinates.
    pub(super) along: f32,
}

/// Adds the surface through consecutive rings. Texture coordinates are a function of the turn
/// around the curve, from 0 to 1, and of [`Ring::along`].
pub(super) fn add_tube(mesh: &mut Mesh, rings: &[Ring], sides: usize, uv: fn(f32, f32) -> Vec2) {
    // The mean width of the shadow of a polygon is its perimeter over π, so its corners lie outside
    // of the circle by this factor.
    let widening = PI / (sides as f32 * (PI / sides as f32).sin());
    let first = mesh.positions.len();
    for ring in rings {
        let forward = ring.axes[0].cross(ring.axes[1]);
        for k in 0..=sides {
            let turn = k as f32 / sides as f32;
            let (sin, cos) = (TAU * turn).sin_cos();
            let outward = ring.axes[0] * cos + ring.axes[1] * sin;
            mesh.positions
                .push(ring.center + outward * (ring.radius * widening));
            mesh.normals
                .push((outward * ring.lean[0] + forward * ring.lean[1]).normalize());
            mesh.uvs.push(uv(turn, ring.along));
        }
    }
    let at = |i: usize, k: usize| (first + i * (sides + 1) + k) as u32;
    for i in 0..rings.len().saturating_sub(1) {
        for k in 0..sides {
            let [a, b] = [at(i, k), at(i, k + 1)];
            let [c, d] = [at(i + 1, k), at(i + 1, k + 1)];
            if rings[i].radius > 0.0 {
                mesh.triangles.push([a, b, d]);
            }
            if rings[i + 1].radius > 0.0 {
                mesh.triangles.push([a, d, c]);
            }
        }
    }
}

/// The rings around a straight segment between two spheres that touch its surface, with half of
/// each sphere. The fourth components are radii.
pub(super) fn capsule(
    ends: [Vec4; 2],
    axes: [Vec3; 2],
    along: [f32; 2],
    sides: usize,
) -> Vec<Ring> {
    let [a, b] = ends;
    let axis = axes[0].cross(axes[1]);
    let length = (b - a).truncate().length();
    // Where one sphere contains the other, half of each remains.
    let sin = ((a.w - b.w) / length.max(f32::MIN_POSITIVE)).clamp(-1.0, 1.0);
    let lean = sin.asin();
    let steps = cap_steps(sides);
    let ring = |end: usize, angle: f32| {
        let sphere = ends[end];
        let (sin, cos) = angle.sin_cos();
        let is_pole = angle.abs() >= FRAC_PI_2;
        Ring {
            center: sphere.truncate() + axis * (sphere.w * sin),
            radius: if is_pole { 0.0 } else { sphere.w * cos },
            axes,
            lean: [cos, sin],
            along: along[end],
        }
    };
    let part = |i: usize| i as f32 / steps as f32;
    let start = (0..=steps).map(|i| ring(0, -FRAC_PI_2 + (FRAC_PI_2 + lean) * part(i)));
    let end = (0..=steps).map(|i| ring(1, lean + (FRAC_PI_2 - lean) * part(i)));
    start.chain(end).collect()
}

/// Rings between pole and equator of the sphere at the end of a straight segment.
fn cap_steps(sides: usize) -> usize {
    (sides / 4).max(1)
}

/// Number of triangles of [`capsule`].
pub(super) fn capsule_triangles(sides: usize) -> usize {
    2 * sides * (2 * cap_steps(sides) + 1)
}

/// A point of a uniform B-spline segment of degree 2 or 3, and its derivative.
pub(super) fn spline(control: &[Vec4], t: f32) -> [Vec4; 2] {
    let s = 1.0 - t;
    match *control {
        [a, b, c] => [
            (a * (s * s) + b * (1.0 + 2.0 * t * s) + c * (t * t)) * 0.5,
            (b - a) * s + (c - b) * t,
        ],
        [a, b, c, d] => {
            let weights = [
                s * s * s,
                3.0 * t * t * t - 6.0 * t * t + 4.0,
                -3.0 * t * t * t + 3.0 * t * t + 3.0 * t + 1.0,
                t * t * t,
            ];
            let point = (a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3]) / 6.0;
            let slope = (b - a) * (0.5 * s * s)
                + (c - b) * (0.5 * (1.0 + 2.0 * t * s))
                + (d - c) * (0.5 * t * t);
            [point, slope]
        }
        _ => [control.first().copied().unwrap_or(Vec4::ZERO), Vec4::ZERO],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(count: usize) -> Vec<Vec4> {
        (0..count)
            .map(|i| Vec4::new(i as f32, 0.0, 0.0, 0.1))
            .collect()
    }

    #[test]
    fn splines_of_equidistant_points_are_straight_and_steady() {
        for (control, start) in [(line(3), 0.5), (line(4), 1.0)] {
            for t in [0.0, 0.25, 1.0] {
                let [p, d] = spline(&control, t);
                assert!(
                    p.abs_diff_eq(Vec4::new(start + t, 0.0, 0.0, 0.1), 1e-6),
                    "{p}"
                );
                assert!(d.abs_diff_eq(Vec4::X, 1e-6), "{d}");
            }
        }
        let bent = [Vec4::ZERO, Vec4::Y, Vec4::new(2.0, 0.5, 0.0, 0.3), Vec4::Z];
        let step = 1e-3;
        let difference =
            (spline(&bent, 0.4 + step)[0] - spline(&bent, 0.4 - step)[0]) / (2.0 * step);
        assert!(difference.abs_diff_eq(spline(&bent, 0.4)[1], 1e-3));
    }

    #[test]
    fn a_capsule_touches_its_spheres_and_faces_outwards() {
        let ends = [
            Vec4::new(0.0, 0.0, -1.0, 0.2),
            Vec4::new(0.0, 0.0, 1.0, 0.4),
        ];
        let rings = capsule(ends, [Vec3::X, Vec3::Y], [0.0, 1.0], 64);
        let mut mesh = Mesh::default();
        add_tube(&mut mesh, &rings, 64, Vec2::new);
        let top = mesh.positions.iter().map(|p| p.z).fold(f32::MIN, f32::max);
        let bottom = mesh.positions.iter().map(|p| p.z).fold(f32::MAX, f32::min);
        assert!((top - 1.4).abs() < 1e-5 && (bottom + 1.2).abs() < 1e-5);
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let n = (b - a).cross(c - a);
            assert!(n.length() > 0.0, "{triangle:?} is degenerate");
            for i in triangle {
                assert!(n.normalize().dot(mesh.normals[*i as usize]) > 0.9);
            }
        }
        // The cone touches the spheres where its normal leans by asin((r1 - r0) / length).
        let cone = mesh.normals.iter().filter(|n| (n.z + 0.1).abs() < 1e-4);
        assert_eq!(cone.count(), 2 * 65);
    }

    #[test]
    fn a_tube_casts_a_shadow_of_its_width() {
        let ring = |z: f32| Ring {
            center: Vec3::Z * z,
            radius: 0.5,
            axes: [Vec3::X, Vec3::Y],
            lean: [1.0, 0.0],
            along: z,
        };
        let mut mesh = Mesh::default();
        add_tube(&mut mesh, &[ring(0.0), ring(1.0)], 4, Vec2::new);
        let width = |angle: f32| {
            let across = Vec3::new(angle.cos(), angle.sin(), 0.0);
            let places = mesh.positions.iter().map(|p| p.dot(across));
            let (low, high) = places.fold((f32::MAX, f32::MIN), |(l, h), x| (l.min(x), h.max(x)));
            high - low
        };
        let mean = (0..180).map(|i| width(PI * i as f32 / 180.0)).sum::<f32>() / 180.0;
        assert!((mean - 1.0).abs() < 1e-3, "{mean}");
    }
}
