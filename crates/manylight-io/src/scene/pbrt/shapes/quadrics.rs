//! Spheres, disks, cylinders and the quadrics of PBRT v3. Whole ones are analytic where the core
//! has the form, parts are tessellated.

use super::super::super::description::{Additions, add};
use super::super::super::parameters::{Numbers, Parameters};
use super::super::builder::Builder;
use super::super::elements::Elements;
use super::super::entities::{MaterialRef, ShapeEntity};
use super::super::param_types::ParamType;
use super::super::transforms::mirrors;
use super::tessellation::{Geometry, grid};
use manylight::geometry::{Mesh, Shape};
use manylight::math::{Affine3A, Vec3};
use std::f32::consts::TAU;

/// Cells of a tessellated quadric around the whole axis.
const AROUND: usize = 128;
/// Cells along the axis: of round profiles, and of straight ones, which need them at the apex of a
/// cone alone.
const ALONG: usize = 64;
const ALONG_STRAIGHT: usize = 8;

impl Builder<'_> {
    /// The angle `phimax` in radians.
    fn phi_max(&self, shape: &ShapeEntity<'_>) -> f32 {
        let inside = |angle| angle > 0.0 && angle <= 360.0;
        let params = &shape.entity.params;
        params
            .float_where("phimax", 360.0, inside, "in (0, 360]")
            .to_radians()
    }

    fn radius(&self, shape: &ShapeEntity<'_>) -> f32 {
        let params = &shape.entity.params;
        params.float_where("radius", 1.0, |radius| radius > 0.0, "positive")
    }

    pub(super) fn sphere(&mut self, shape: &ShapeEntity<'_>) -> Option<Geometry> {
        let params = &shape.entity.params;
        let radius = self.radius(shape);
        let clamped = |z: f32| z.clamp(-radius, radius);
        let a = clamped(params.float("zmin", -radius));
        let b = clamped(params.float("zmax", radius));
        let (low, high) = (a.min(b), a.max(b));
        let phi_max = self.phi_max(shape);
        if low == -radius && high == radius && phi_max == TAU {
            let world = self.world_of_shape(shape)?;
            let center = Vec3::ZERO;
            // A reflection of z, so that v grows with z as in PBRT.
            let upward = Affine3A::from_scale(Vec3::new(1.0, 1.0, -1.0));
            return Some(Geometry {
                shape: self.desc.add(Shape::Sphere { center, radius }),
                world_from_object: world * upward,
                // The normals of mirrored spheres point inwards.
                is_reversed: !mirrors(shape.entity.transform),
                elements: Elements::Whole,
            });
        }
        let (theta_low, theta_high) = ((low / radius).acos(), (high / radius).acos());
        let mesh = grid([around(phi_max), ALONG], |u, v| {
            let theta = theta_low + v * (theta_high - theta_low);
            let (sin_phi, cos_phi) = (u * phi_max).sin_cos();
            let n = Vec3::new(theta.sin() * cos_phi, theta.sin() * sin_phi, theta.cos());
            (n * radius, n)
        });
        self.add_tessellated(shape, mesh, Elements::Whole)
    }

    pub(super) fn disk(&mut self, shape: &ShapeEntity<'_>) -> Option<Geometry> {
        let params = &shape.entity.params;
        let radius = self.radius(shape);
        let height = params.float("height", 0.0);
        let inner = params.float_where(
            "innerradius",
            0.0,
            |inner| inner >= 0.0 && inner < radius,
            "at least 0 and less than `radius`",
        );
        let phi_max = self.phi_max(shape);
        let is_whole = inner == 0.0 && phi_max == TAU;
        if is_whole && !self.is_textured(shape) {
            let world = self.world_of_shape(shape)?;
            let shapes = &mut self.desc.shapes;
            let disk = self
                .made
                .disk
                .get_or_insert_with(|| add(shapes, Shape::Disk));
            let placed = Affine3A::from_translation(Vec3::new(0.0, 0.0, height))
                * Affine3A::from_scale(Vec3::new(radius, radius, radius));
            return Some(Geometry {
                shape: *disk,
                world_from_object: world * placed,
                is_reversed: false,
                elements: Elements::Whole,
            });
        }
        let mesh = grid([around(phi_max), ALONG_STRAIGHT], |u, v| {
            let r = radius + v * (inner - radius);
            let (sin, cos) = (u * phi_max).sin_cos();
            (Vec3::new(r * cos, r * sin, height), Vec3::Z)
        });
        self.add_tessellated(shape, mesh, Elements::Whole)
    }

    /// Whether the shape has an emission, an opacity or a material of which parts may be textures.
    fn is_textured(&self, shape: &ShapeEntity<'_>) -> bool {
        let light = shape.area_light.as_deref();
        let alpha = shape.entity.params.get("alpha");
        light.is_some_and(|light| light.params.has("filename"))
            || alpha.is_some_and(|alpha| alpha.ty == ParamType::Texture)
            || !self.desc.textures.is_empty()
                && light.is_none()
                && !matches!(shape.material, MaterialRef::Default)
    }

    pub(super) fn cylinder(&mut self, shape: &ShapeEntity<'_>) -> Option<Geometry> {
        let params = &shape.entity.params;
        let radius = self.radius(shape);
        let a = params.float("zmin", -1.0);
        let b = params.float("zmax", 1.0);
        let (low, high) = (a.min(b), a.max(b));
        if low == high {
            params.refuse_pair("zmin", "zmax");
            return None;
        }
        let phi_max = self.phi_max(shape);
        if phi_max == TAU {
            let world_from_object = self.world_of_shape(shape)?;
            let shape = Shape::Cylinder {
                p0: Vec3::Z * low,
                p1: Vec3::Z * high,
                radius,
            };
            return Some(Geometry {
                shape: self.desc.add(shape),
                world_from_object,
                is_reversed: false,
                elements: Elements::Whole,
            });
        }
        let mesh = revolved(phi_max, ALONG_STRAIGHT, |v| {
            let z = low + v * (high - low);
            ([radius, z], [1.0, 0.0])
        });
        self.add_tessellated(shape, mesh, Elements::Whole)
    }

    /// Cones, paraboloids and hyperboloids.
    pub(super) fn old_quadric(&mut self, shape: &ShapeEntity<'_>) -> Option<Geometry> {
        let params = &shape.entity.params;
        let phi_max = self.phi_max(shape);
        let mesh = match params.plugin.value.as_str() {
            "cone" => {
                let radius = self.radius(shape);
                let height = params.float_where("height", 1.0, |h| h > 0.0, "positive");
                revolved(phi_max, ALONG_STRAIGHT, |v| {
                    ([radius * (1.0 - v), height * v], [height, radius])
                })
            }
            "paraboloid" => {
                let radius = self.radius(shape);
                let a = params.float("zmin", 0.0);
                let b = params.float("zmax", 1.0);
                let (low, high) = (a.min(b).max(0.0), a.max(b));
                if high <= low {
                    params.refuse_pair("zmin", "zmax");
                    return None;
                }
                revolved(phi_max, ALONG, |v| {
                    let z = low + v * (high - low);
                    let r = radius * (z / high).sqrt();
                    ([r, z], [2.0 * high * r, -radius * radius])
                })
            }
            _ => {
                let p1 = params.point3("p1", Vec3::ZERO);
                let p2 = params.point3("p2", Vec3::ONE);
                // A line segment that turns around z. The normal is that of the cross product of
                // the two tangents.
                grid([around(phi_max), ALONG], |u, v| {
                    let p = p1.lerp(p2, v);
                    let turn = manylight::math::Mat3::from_rotation_z(u * phi_max);
                    let around = Vec3::new(-p.y, p.x, 0.0);
                    (turn * p, turn * around.cross(p2 - p1))
                })
            }
        };
        self.add_tessellated(shape, mesh, Elements::Whole)
    }
}

/// Cells in proportion to the angle around the axis.
fn around(phi_max: f32) -> usize {
    ((AROUND as f32 * phi_max / TAU).ceil() as usize).max(4)
}

/// The surface of a profile that turns around z. The profile gives [radius, z] and the direction of
/// the normal in this plane, and has `along` cells.
fn revolved(phi_max: f32, along: usize, profile: impl Fn(f32) -> ([f32; 2], [f32; 2])) -> Mesh {
    grid([around(phi_max), along], |u, v| {
        let ([r, z], [normal_r, normal_z]) = profile(v);
        let (sin, cos) = (u * phi_max).sin_cos();
        (
            Vec3::new(r * cos, r * sin, z),
            Vec3::new(normal_r * cos, normal_r * sin, normal_z),
        )
    })
}
