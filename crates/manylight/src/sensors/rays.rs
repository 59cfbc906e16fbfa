//! Camera rays, in lanes; single rays are those with one lane.

use super::{Projection, Sensor};
use crate::geometry::Ray;
use crate::lanes::{self, Float, One, Pair, Vector, Width, lane};
use crate::math::{Affine3A, Vec2, Vec3};

/// A camera ray per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraRays<S: Width> {
    /// Origins: on the near plane.
    o: Vector<S>,
    /// Unit directions.
    d: Vector<S>,
    /// Ends of the rays: on the far plane.
    t_max: Float<S>,
}

impl<S: Width> CameraRays<S> {
    /// The ray in each lane.
    #[inline(always)]
    pub(crate) fn store(self) -> S::Each<Ray> {
        let (o, d, t_max) = (self.o.store(), self.d.store(), self.t_max.store());
        self.t_max.width().each(|i| Ray {
            o: Vec3::from(lane(&o, i)),
            d: Vec3::from(lane(&d, i)),
            t_max: t_max.as_ref()[i],
        })
    }
}

impl Sensor {
    /// The ray through `film_position` (pixels from the upper left of the crop window, x right, y
    /// down), in world space, from the near plane to the far plane. Its importance over its
    /// probability density is 1 for all kinds of sensors.
    pub fn ray(&self, film_position: Vec2, u_lens: Vec2) -> Ray {
        let [ray] = self
            .rays::<One>(film_position.into(), u_lens.into())
            .store();
        ray
    }

    /// [`Sensor::ray`] in lanes.
    #[inline(always)]
    pub(crate) fn rays<S: Width>(&self, film_position: Pair<S>, u_lens: Pair<S>) -> CameraRays<S> {
        let q = self.plane_positions(film_position);
        let s = q.x.width();
        let zero = Float::splat(s, 0.0);
        match self.projection {
            Projection::Perspective { tan_half_fov_x } => {
                let q = q * tan_half_fov_x;
                let through = Vector::new(q.x, q.y, zero.same(1.0));
                self.ray_between(Vector::splat(s, Vec3::ZERO), through)
            }
            Projection::ThinLens {
                tan_half_fov_x,
                aperture_radius,
                focus_distance,
            } => {
                let lens = lanes::disc(u_lens) * aperture_radius;
                let q = q * tan_half_fov_x;
                let through = Vector::new(q.x, q.y, zero.same(1.0)) * focus_distance;
                self.ray_between(Vector::new(lens.x, lens.y, zero), through)
            }
            Projection::Orthographic => {
                let world_from_camera = &self.desc.world_from_camera;
                let near = zero.same(self.desc.near_clip);
                let d = world_from_camera.transform_vector3(Vec3::Z);
                // As in Mitsuba, a scale along the axis moves the near plane but not the distance
                // to the far plane.
                CameraRays {
                    o: point_in_world(world_from_camera, Vector::new(q.x, q.y, near)),
                    d: Vector::splat(s, d.normalize_or_zero()),
                    t_max: zero.same(self.desc.far_clip - self.desc.near_clip),
                }
            }
        }
    }

    /// The rays from `lens` through `through` (both in the camera frame), between the clip planes.
    #[inline(always)]
    pub(super) fn ray_between<S: Width>(
        &self,
        lens: Vector<S>,
        through: Vector<S>,
    ) -> CameraRays<S> {
        let world_from_camera = &self.desc.world_from_camera;
        let d = (through - lens).normalize();
        let per_depth = d.z.recip();
        let near = per_depth * self.desc.near_clip;
        let world = vector_in_world(world_from_camera, d);
        let scale = world.length();
        CameraRays {
            o: point_in_world(world_from_camera, lens + d * near),
            d: world * scale.recip(),
            t_max: scale * (per_depth * self.desc.far_clip - near),
        }
    }

    /// From film positions to the plane on which the width of the full film covers [-1, 1]; x to
    /// the left, y up.
    #[inline(always)]
    fn plane_positions<S: Width>(&self, film_position: Pair<S>) -> Pair<S> {
        let film = &self.desc.film;
        let s = film_position.x.width();
        let offset = film.crop_offset.as_vec2() / film.size.as_vec2();
        let start = Vec2::ONE - (offset + self.desc.principal_point_offset) * 2.0;
        let per_pixel = film.size.as_vec2().recip() * 2.0;
        let q = Pair::splat(s, start) - film_position * Pair::splat(s, per_pixel);
        q * Pair::splat(s, self.plane_extent())
    }
}

#[inline(always)]
fn vector_in_world<S: Width>(world_from_camera: &Affine3A, v: Vector<S>) -> Vector<S> {
    let axis = |axis| Vector::splat(v.x.width(), Vec3::from(axis));
    let matrix = &world_from_camera.matrix3;
    axis(matrix.x_axis) * v.x + axis(matrix.y_axis) * v.y + axis(matrix.z_axis) * v.z
}

#[inline(always)]
fn point_in_world<S: Width>(world_from_camera: &Affine3A, p: Vector<S>) -> Vector<S> {
    let origin = Vector::splat(p.x.width(), Vec3::from(world_from_camera.translation));
    vector_in_world(world_from_camera, p) + origin
}
