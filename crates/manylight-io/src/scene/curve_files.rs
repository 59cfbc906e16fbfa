//! Files of curves as meshes of tubes.

use super::tubes::{Ring, TubeDetail, add_tube, capsule, capsule_triangles, spline};
use crate::file_error::FileError;
use crate::mesh::read_curves;
use manylight::geometry::Mesh;
use manylight::math::{Affine3A, Vec2, Vec3, Vec4};
use std::path::Path;

/// How the control points of a curve determine it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CurveBasis {
    /// Straight segments with spheres at their ends.
    Linear,
    /// Uniform cubic B-splines with open ends.
    BSpline,
}

/// How to read a file of curves.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CurveFile {
    pub(super) basis: CurveBasis,
    /// Applies to positions, but not to radii, as in Mitsuba.
    pub(super) world_from_object: Affine3A,
}

impl CurveFile {
    /// The mesh of the curves in the file, in world space. The first texture coordinate turns
    /// around the curves, the second one is the place along all segments of the file.
    pub(super) fn read(&self, path: &Path) -> Result<Mesh, FileError> {
        let least = self.points_of_segment();
        let mut curves = read_curves(path, least)?;
        for point in curves.iter_mut().flatten() {
            let p = self.world_from_object.transform_point3(point.truncate());
            *point = p.extend(point.w);
        }
        let count = curves.iter().map(|curve| curve.len() - least + 1).sum();
        let mut tubes = Tubes {
            mesh: Mesh::default(),
            detail: TubeDetail::for_segments(count, |detail| match self.basis {
                CurveBasis::Linear => capsule_triangles(detail.sides),
                CurveBasis::BSpline => 2 * detail.sides * detail.pieces,
            }),
            count: count as f32,
        };
        let mut first = 0;
        for curve in &curves {
            match self.basis {
                CurveBasis::Linear => tubes.linear(curve, first),
                CurveBasis::BSpline => tubes.spline(curve, first),
            }
            first += curve.len() - least + 1;
        }
        Ok(tubes.mesh)
    }

    /// Control points of one segment.
    fn points_of_segment(&self) -> usize {
        match self.basis {
            CurveBasis::Linear => 2,
            CurveBasis::BSpline => 4,
        }
    }
}

/// The tubes of a file.
struct Tubes {
    mesh: Mesh,
    detail: TubeDetail,
    /// Number of segments in the file.
    count: f32,
}

impl Tubes {
    /// Adds a polyline. Its first segment has the index `first`.
    fn linear(&mut self, points: &[Vec4], first: usize) {
        let sides = self.detail.sides;
        for (i, pair) in points.windows(2).enumerate() {
            let axis = (pair[1] - pair[0]).truncate().normalize_or(Vec3::Z);
            let along = [first + i, first + i + 1].map(|i| i as f32 / self.count);
            let rings = capsule([pair[0], pair[1]], axes(axis), along, sides);
            add_tube(&mut self.mesh, &rings, sides, Vec2::new);
        }
    }

    /// Adds a B-spline. Its first segment has the index `first`.
    fn spline(&mut self, points: &[Vec4], first: usize) {
        let pieces = self.detail.pieces;
        let segments = points.len() - 3;
        let rings: Vec<Ring> = (0..=segments * pieces)
            .map(|i| {
                let segment = (i / pieces).min(segments - 1);
                let t = (i - segment * pieces) as f32 / pieces as f32;
                let [at, slope] = spline(&points[segment..segment + 4], t);
                let speed = slope.truncate().length().max(f32::MIN_POSITIVE);
                let lean = -(slope.w / speed).atan();
                Ring {
                    center: at.truncate(),
                    radius: at.w,
                    axes: axes(slope.truncate().normalize_or(Vec3::Z)),
                    lean: [lean.cos(), lean.sin()],
                    along: (first as f32 + i as f32 / pieces as f32) / self.count,
                }
            })
            .collect();
        add_tube(&mut self.mesh, &rings, self.detail.sides, Vec2::new);
    }
}

/// The axes across a curve with this direction, as in Mitsuba: the second one near z.
fn axes(direction: Vec3) -> [Vec3; 2] {
    let up = (Vec3::Z - direction * direction.z).normalize_or_zero();
    let up = if up == Vec3::ZERO { Vec3::Y } else { up };
    [up.cross(direction), up]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(basis: CurveBasis, text: &str) -> Mesh {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        let curves = CurveFile {
            basis,
            world_from_object: Affine3A::from_scale(Vec3::splat(2.0)),
        };
        curves.read(file.path()).unwrap()
    }

    #[test]
    fn transforms_move_points_and_keep_radii() {
        let rod = mesh(CurveBasis::Linear, "0 0 0 0.1\n0 0 1 0.1");
        let length = rod.positions.iter().map(|p| p.z).fold(0.0, f32::max);
        assert!((length - 2.1).abs() < 1e-5, "{length}");
        let widest = rod.positions.iter().map(|p| p.x).fold(0.0, f32::max);
        assert!((widest - 0.1).abs() < 1e-3, "{widest}");
    }

    #[test]
    fn texture_coordinates_are_those_of_mitsuba() {
        let text = "-2 0 0 .2\n-1 0 0 .2\n0 .5 0 .3\n1 0 0 .2\n2 0 0 .2\n\n-2 2 0 .2\n-1 2 0 .2\n0 2 0 .3\n1 2 0 .2\n";
        let ropes = mesh(CurveBasis::BSpline, text);
        // Of the second curve, in the middle of its segment, on top: found by Mitsuba 3.9.1 at x =
        // -0.5 before the transform.
        let top = (ropes.positions.iter().zip(&ropes.uvs))
            .find(|(p, uv)| (p.x + 1.0).abs() < 0.01 && p.y > 3.0 && (uv.x - 0.25).abs() < 1e-6);
        let (p, uv) = top.unwrap();
        assert!((uv.y - 0.8333).abs() < 1e-3, "{uv}");
        assert!((p.z - 0.2479).abs() < 2e-3, "{p}");
    }
}
