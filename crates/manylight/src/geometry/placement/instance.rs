//! Groups under the transforms of their instances.

use crate::geometry::analytic::affine_f64;
use crate::geometry::surface_point::OFFSET_ROUNDINGS;
use crate::geometry::{Ray, Segment, SurfacePoint};
use crate::math::{Aabb, Affine3A, Frame, Vec3};
use glam::DAffine3;

/// Margin of the bounds of instances for the rounding of rays that enter, relative to the terms of
/// the transform.
const ENTRY_ROUNDING: f32 = 4.0 * f32::EPSILON;

/// An instance: a group under a transform.
#[derive(Debug)]
pub(in crate::geometry) struct PlacedInstance {
    group: usize,
    world_from_group: DAffine3,
    group_from_world: DAffine3,
}

impl PlacedInstance {
    pub(in crate::geometry) fn new(group: u32, world_from_group: &Affine3A) -> Self {
        let world_from_group = affine_f64(world_from_group);
        PlacedInstance {
            group: group as usize,
            world_from_group,
            group_from_world: world_from_group.inverse(),
        }
    }

    /// Index of the group.
    pub(in crate::geometry) fn group(&self) -> usize {
        self.group
    }

    /// The box in the world around the transformed box `group`.
    pub(in crate::geometry) fn bounds(&self, group: Aabb) -> Aabb {
        if group.is_empty() {
            return group;
        }
        let b = Aabb::from_points(group.corners().map(|c| {
            self.world_from_group
                .transform_point3(c.as_dvec3())
                .as_vec3()
        }));
        // Rays are rounded on entering the group, so that hits may lie a little outside of the
        // exact box.
        let margin = ENTRY_ROUNDING * self.magnitude(group.min.abs().max(group.max.abs()));
        Aabb {
            min: b.min - margin,
            max: b.max + margin,
        }
    }

    /// The ray in the space of the group; ray parameters keep their values.
    pub(in crate::geometry) fn ray_in_group(&self, ray: &Ray) -> Ray {
        Ray {
            o: self.point_in_group(ray.o),
            d: self
                .group_from_world
                .transform_vector3(ray.d.as_dvec3())
                .as_vec3(),
            t_max: ray.t_max,
        }
    }

    pub(in crate::geometry) fn segment_in_group(&self, segment: &Segment) -> Segment {
        Segment {
            from: self.point_in_group(segment.from),
            to: self.point_in_group(segment.to),
        }
    }

    pub(in crate::geometry) fn point_in_group(&self, p: Vec3) -> Vec3 {
        self.group_from_world
            .transform_point3(p.as_dvec3())
            .as_vec3()
    }

    /// The world-space point of a point in the space of the group.
    pub(in crate::geometry) fn surface_in_world(&self, surface: &SurfacePoint) -> SurfacePoint {
        let vector = |v: Vec3| {
            self.world_from_group
                .transform_vector3(v.as_dvec3())
                .as_vec3()
        };
        let normals = self.group_from_world.matrix3.transpose();
        let normal = |n: Vec3| (normals * n.as_dvec3()).normalize_or_zero().as_vec3();
        let dp_du = vector(surface.dp_du);
        SurfacePoint {
            p: self
                .world_from_group
                .transform_point3(surface.p.as_dvec3())
                .as_vec3(),
            ng: normal(surface.ng),
            frame: Frame::from_normal_and_tangent(normal(surface.frame.n), dp_du),
            uv: surface.uv,
            dp_du,
            dp_dv: vector(surface.dp_dv),
            at: surface.at,
            // A ray from this point is rounded again on entering the group: add one offset for each
            // space.
            offset: self.stretch() * surface.offset
                + OFFSET_ROUNDINGS * 0.5 * f32::EPSILON * self.magnitude(surface.p.abs()),
        }
    }

    /// Upper bound of the factor by which the transform lengthens a vector.
    fn stretch(&self) -> f32 {
        let m = &self.world_from_group.matrix3;
        (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
            as f32
    }

    /// Upper bound of the terms in the transform of a point to the world; `p` has the absolute
    /// coordinates.
    fn magnitude(&self, p: Vec3) -> f32 {
        self.stretch() * p.max_element()
            + self.world_from_group.translation.abs().max_element() as f32
    }
}
