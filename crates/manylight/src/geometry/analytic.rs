//! Spheres, disks and cylinders: unit shapes under an affine transform.
//!
//! Computed in `f64`, so that radii and distances of a million units keep their precision for rays
//! in `f32`, and points restored from their parameters are exact up to the rounding of the result.
//! The parametrizations are Mitsuba's.

use super::Shape;
use crate::math::{Aabb, Affine3A, Frame, Vec2, Vec3};
use crate::sampling::warp;
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// A shape of unit size in its own space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum UnitShape {
    /// The unit sphere. Parameters (azimuth / 2π, polar angle / π).
    Sphere,
    /// The unit disk in the plane z = 0. Parameters (x, y).
    Disk,
    /// The cylinder of radius 1 around the z axis, z from 0 to 1. Parameters (azimuth / 2π, z).
    Cylinder,
}

/// A unit shape under an affine transform.
#[derive(Clone, Copy, Debug)]
pub(super) struct Analytic {
    pub(super) shape: UnitShape,
    world_from_unit: DAffine3,
    pub(super) unit_from_world: DAffine3,
}

/// A point on an analytic shape, in the world.
pub(super) struct AnalyticPoint {
    pub(super) p: Vec3,
    pub(super) ng: Vec3,
    pub(super) uv: Vec2,
    pub(super) dp_du: Vec3,
    pub(super) dp_dv: Vec3,
}

impl Analytic {
    /// `None` for meshes.
    pub(super) fn new(shape: &Shape, world_from_object: &Affine3A) -> Option<Self> {
        let (shape, object_from_unit) = match *shape {
            Shape::Mesh(_) => return None,
            Shape::Sphere { center, radius } => {
                let scale = DMat3::from_diagonal(DVec3::splat(radius.into()));
                (
                    UnitShape::Sphere,
                    DAffine3::from_mat3_translation(scale, center.as_dvec3()),
                )
            }
            Shape::Disk => (UnitShape::Disk, DAffine3::IDENTITY),
            Shape::Cylinder { p0, p1, radius } => {
                let axis = p1 - p0;
                let frame = Frame::from_normal(axis.normalize());
                let radius = f64::from(radius);
                let columns = DMat3::from_cols(
                    frame.s.as_dvec3() * radius,
                    frame.t.as_dvec3() * radius,
                    axis.as_dvec3(),
                );
                (
                    UnitShape::Cylinder,
                    DAffine3::from_mat3_translation(columns, p0.as_dvec3()),
                )
            }
        };
        let world_from_unit = affine_f64(world_from_object) * object_from_unit;
        Some(Analytic {
            shape,
            world_from_unit,
            unit_from_world: world_from_unit.inverse(),
        })
    }

    pub(super) fn bounds(&self) -> Aabb {
        let m = self.world_from_unit.matrix3;
        // The image of the unit ball under a linear map is an ellipsoid. Its half-extents are the
        // lengths of the rows of the map.
        let round = |x: DVec3, y: DVec3, z: DVec3| (x * x + y * y + z * z).map(f64::sqrt);
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        let center = self.world_from_unit.translation;
        let around = |c: DVec3, half: DVec3| {
            // Larger than the rounding to f32.
            let margin = (c.abs() + half) * f64::from(f32::EPSILON);
            Aabb {
                min: (c - half - margin).as_vec3(),
                max: (c + half + margin).as_vec3(),
            }
        };
        match self.shape {
            UnitShape::Sphere => around(center, round(x, y, z)),
            UnitShape::Disk => around(center, round(x, y, DVec3::ZERO)),
            UnitShape::Cylinder => {
                let half = round(x, y, DVec3::ZERO);
                around(center, half).union(around(center + z, half))
            }
        }
    }

    /// Ray parameter and surface parameters of the nearest hit with `0 < t < t_max`.
    pub(super) fn intersect(&self, o: Vec3, d: Vec3, t_max: f32) -> Option<(f32, Vec2)> {
        let o = self.unit_from_world.transform_point3(o.as_dvec3());
        let d = self.unit_from_world.transform_vector3(d.as_dvec3());
        let hits = self.shape.meets(o, d);
        let first = hits
            .into_iter()
            .find(|&t| self.shape.is_hit(o, d, t, t_max))?;
        let t = (first as f32).max(f32::MIN_POSITIVE);
        Some((t, self.parameters(o + d * first)))
    }

    fn parameters(&self, q: DVec3) -> Vec2 {
        let azimuth = q.y.atan2(q.x) / TAU;
        let turn = if azimuth < 0.0 {
            azimuth + 1.0
        } else {
            azimuth
        };
        match self.shape {
            UnitShape::Sphere => DVec2::new(turn, q.truncate().length().atan2(q.z) / PI),
            UnitShape::Disk => q.truncate(),
            UnitShape::Cylinder => DVec2::new(turn, q.z),
        }
        .as_vec2()
    }

    /// The point with these parameters, with the outer normal.
    pub(super) fn point(&self, parameters: Vec2) -> AnalyticPoint {
        let a = parameters.as_dvec2();
        let (sin, cos) = (a.x * TAU).sin_cos();
        let (q, n, uv, dq_du, dq_dv) = match self.shape {
            UnitShape::Sphere => {
                let (sin_theta, cos_theta) = (a.y * PI).sin_cos();
                let q = DVec3::new(cos * sin_theta, sin * sin_theta, cos_theta);
                let dq_dv = DVec3::new(cos * cos_theta, sin * cos_theta, -sin_theta) * PI;
                (q, q, parameters, DVec3::new(-q.y, q.x, 0.0) * TAU, dq_dv)
            }
            UnitShape::Disk => {
                let r = a.length();
                let radial = if r > 0.0 { a / r } else { DVec2::X };
                let turn = a.y.atan2(a.x) / TAU;
                let uv = DVec2::new(r, if turn < 0.0 { turn + 1.0 } else { turn }).as_vec2();
                (
                    a.extend(0.0),
                    DVec3::Z,
                    uv,
                    radial.extend(0.0),
                    DVec3::new(-a.y, a.x, 0.0) * TAU,
                )
            }
            UnitShape::Cylinder => {
                let n = DVec3::new(cos, sin, 0.0);
                (
                    n + DVec3::Z * a.y,
                    n,
                    parameters,
                    DVec3::new(-sin, cos, 0.0) * TAU,
                    DVec3::Z,
                )
            }
        };
        let m = &self.world_from_unit.matrix3;
        // As in Mitsuba: under a reflection the normal of a sphere points inwards, those of other
        // shapes do not.
        let side = if self.shape == UnitShape::Sphere && m.determinant() < 0.0 {
            -1.0
        } else {
            1.0
        };
        AnalyticPoint {
            p: self.world_from_unit.transform_point3(q).as_vec3(),
            ng: (self.unit_from_world.matrix3.transpose() * n * side)
                .normalize()
                .as_vec3(),
            uv,
            dp_du: (*m * dq_du).as_vec3(),
            dp_dv: (*m * dq_dv).as_vec3(),
        }
    }

    /// Size of the shape: the largest half-extent of its box.
    pub(super) fn scale(&self) -> f32 {
        self.bounds().extent().max_element() * 0.5
    }

    /// Area in the world. Exact if the stretch of area is constant over the surface, else by
    /// quadrature.
    pub(super) fn area(&self) -> f32 {
        /// Quadrature points per parameter. The error is below 1e-3 for a spheroid with axes 1 : 1
        /// : 2 (tested).
        const CELLS: u32 = 32;
        let center = |i: u32| (f64::from(i) + 0.5) / f64::from(CELLS);
        let cells = (0..CELLS * CELLS).map(|i| DVec2::new(center(i % CELLS), center(i / CELLS)));
        let mean = cells
            .map(|u| self.stretch(self.parameters_by_area(u)))
            .sum::<f64>()
            / f64::from(CELLS * CELLS);
        (mean * self.unit_area()) as f32
    }

    /// Parameters of a point drawn uniformly over the unit shape, and the density of the point by
    /// area in the world.
    pub(super) fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let parameters = self.parameters_by_area(u.as_dvec2());
        (
            parameters.as_vec2(),
            (1.0 / (self.unit_area() * self.stretch(parameters))) as f32,
        )
    }

    fn unit_area(&self) -> f64 {
        match self.shape {
            UnitShape::Sphere => 2.0 * TAU,
            UnitShape::Disk => PI,
            UnitShape::Cylinder => TAU,
        }
    }

    /// Maps the unit square to parameters such that area on the unit shape is preserved up to a
    /// constant.
    fn parameters_by_area(&self, u: DVec2) -> DVec2 {
        match self.shape {
            UnitShape::Sphere => DVec2::new(u.x, (1.0 - 2.0 * u.y).acos() / PI),
            UnitShape::Disk => warp::disc(u.as_vec2()).as_dvec2(),
            UnitShape::Cylinder => u,
        }
    }

    /// Ratio of world area to unit area at a point: |det M| |M⁻ᵀ n|.
    fn stretch(&self, parameters: DVec2) -> f64 {
        let (sin, cos) = (parameters.x * TAU).sin_cos();
        let n = match self.shape {
            UnitShape::Sphere => {
                let (sin_theta, cos_theta) = (parameters.y * PI).sin_cos();
                DVec3::new(cos * sin_theta, sin * sin_theta, cos_theta)
            }
            UnitShape::Disk => DVec3::Z,
            UnitShape::Cylinder => DVec3::new(cos, sin, 0.0),
        };
        let normal = self.unit_from_world.matrix3.transpose() * n;
        self.world_from_unit.matrix3.determinant().abs() * normal.length()
    }
}

/// The same transform in `f64`.
pub(super) fn affine_f64(m: &Affine3A) -> DAffine3 {
    DAffine3 {
        matrix3: DMat3::from_cols(
            m.x_axis.as_dvec3(),
            m.y_axis.as_dvec3(),
            m.z_axis.as_dvec3(),
        ),
        translation: m.translation.as_dvec3(),
    }
}

impl UnitShape {
    /// Parameters at which a line meets the plane, sphere or infinite cylinder of the shape; NaN
    /// for none.
    #[inline(always)]
    pub(super) fn meets(self, o: DVec3, d: DVec3) -> [f64; 2] {
        match self {
            UnitShape::Disk => [-o.z / d.z; 2],
            UnitShape::Sphere => line_and_unit_sphere(o, d),
            UnitShape::Cylinder => {
                line_and_unit_sphere(DVec3 { z: 0.0, ..o }, DVec3 { z: 0.0, ..d })
            }
        }
    }

    /// Whether the point at `t`, one of [`UnitShape::meets`], is on the shape, and `0 < t < t_max`.
    #[inline(always)]
    pub(super) fn is_hit(self, o: DVec3, d: DVec3, t: f64, t_max: f32) -> bool {
        let q = o + d * t;
        let inside = match self {
            UnitShape::Sphere => true,
            UnitShape::Disk => q.x * q.x + q.y * q.y <= 1.0,
            UnitShape::Cylinder => (q.z >= 0.0) & (q.z <= 1.0),
        };
        // Without branches, so that loops vectorize.
        (t > 0.0) & ((t as f32) < t_max) & inside
    }
}

/// Parameters at which a line enters and leaves the unit sphere; NaN for a miss or a zero
/// direction. Relative to the point of the line nearest to the center, so that a distant origin
/// does not lose precision.
#[inline(always)]
fn line_and_unit_sphere(o: DVec3, d: DVec3) -> [f64; 2] {
    let d2 = d.length_squared();
    let middle = -o.dot(d) / d2;
    let rest = 1.0 - (o + d * middle).length_squared();
    let half = (rest / d2).sqrt();
    [middle - half, middle + half]
}
