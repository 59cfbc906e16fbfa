//! Cameras: rays for film positions, and importance for points.

#[cfg(test)]
mod tests;

use crate::film::FilmDesc;
use crate::geometry::Ray;
use crate::math::{Affine3A, UVec2, Vec2, Vec3};
use crate::sampling::warp;

/// How points are projected. The camera looks along +z of its own frame, +y is up, +x is to the left, as in Mitsuba.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole.
    Perspective {
        /// tan of half the horizontal field of view over the *uncropped* film.
        tan_half_fov_x: f32,
    },
    /// A lens of finite size.
    ThinLens {
        /// As for `Perspective`.
        tan_half_fov_x: f32,
        /// Radius of the lens in camera units.
        aperture_radius: f32,
        /// Distance of the plane in focus along z.
        focus_distance: f32,
    },
    /// Parallel rays along z; the full film is [-1, 1] wide in the camera frame, its height follows from its shape.
    Orthographic,
}

/// How the field of view follows the film's shape when the film is resized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FovAxis {
    /// Horizontal.
    X,
    /// Vertical.
    Y,
    /// Along the diagonal.
    Diagonal,
    /// Along the smaller edge.
    Smaller,
    /// Along the larger edge.
    Larger,
}

/// A sensor as a file describes it. Plain data; the loader fills it, `Sensor::new` resolves it.
#[derive(Clone, Debug)]
pub struct SensorDesc {
    /// Name or id in the file, may be empty.
    pub name: String,
    /// Camera frame to world; may contain a uniform scale and a reflection.
    pub world_from_camera: Affine3A,
    /// Kind and numbers.
    pub kind: SensorKind,
    /// Shift of the principal point as a fraction of the full film's size (Mitsuba's `principal_point_offset_x/y`):
    /// a film position shows what lies at that position plus the offset. Only Mitsuba's `perspective` knows it.
    pub principal_point_offset: Vec2,
    /// Nearest visible distance along the view axis; 0 for none.
    pub near_clip: f32,
    /// Farthest visible distance along the view axis.
    pub far_clip: f32,
    /// Size, crop, filter.
    pub film: FilmDesc,
}

/// Kinds of sensors in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorKind {
    /// A pinhole.
    Perspective {
        /// Degrees.
        fov: f32,
        /// Which extent `fov` spans.
        fov_axis: FovAxis,
    },
    /// A lens.
    ThinLens {
        /// Degrees.
        fov: f32,
        /// Which extent `fov` spans.
        fov_axis: FovAxis,
        /// Radius of the lens.
        aperture_radius: f32,
        /// Distance of the plane in focus.
        focus_distance: f32,
    },
    /// Parallel rays.
    Orthographic,
}

/// A resolved sensor.
#[derive(Clone, Debug)]
pub struct Sensor {
    desc: SensorDesc,
    projection: Projection,
    camera_from_world: Affine3A,
    /// Area of a pixel on the plane z = 1 of the camera frame; of orthographic sensors across the rays in the world.
    pixel_area: f32,
}

/// A camera ray and how much it counts.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// In world space; starts at the near plane and ends at the far plane.
    pub ray: Ray,
    /// Importance over density: 1 for all our sensors.
    pub weight: f32,
}

/// A point seen by the sensor, for light tracing.
#[derive(Clone, Copy, Debug)]
pub struct SensorConnection {
    /// Position on the film in pixels from the upper left of the *crop window*, x right, y down.
    pub film_position: Vec2,
    /// Unit direction from the point to the sensor.
    pub w: Vec3,
    /// Where the shadow ray ends.
    pub target: Vec3,
    /// `W_e cosθ_lens / (d² pdf_lens)` such that flux·f·|cos ng| times this, divided by the number of paths, is pixel radiance
    /// summed over that pixel's box.
    pub importance: f32,
}

impl Sensor {
    /// Resolves field of view and film shape. To resize the film, edit the description and resolve it again.
    pub fn new(desc: SensorDesc) -> Self {
        let projection = match desc.kind {
            SensorKind::Perspective { fov, fov_axis } => Projection::Perspective {
                tan_half_fov_x: tan_half_fov_x(fov, fov_axis, desc.film.size),
            },
            SensorKind::ThinLens {
                fov,
                fov_axis,
                aperture_radius,
                focus_distance,
            } => Projection::ThinLens {
                tan_half_fov_x: tan_half_fov_x(fov, fov_axis, desc.film.size),
                aperture_radius,
                focus_distance,
            },
            SensorKind::Orthographic => Projection::Orthographic,
        };
        let width = desc.film.size.x as f32;
        let pixel_area = match projection {
            Projection::Perspective { tan_half_fov_x }
            | Projection::ThinLens { tan_half_fov_x, .. } => (2.0 * tan_half_fov_x / width).powi(2),
            Projection::Orthographic => {
                let m = desc.world_from_camera.matrix3;
                let across = Vec3::from(m.x_axis).cross(Vec3::from(m.y_axis));
                across.dot(Vec3::from(m.z_axis).normalize_or_zero()).abs() * (2.0 / width).powi(2)
            }
        };
        let camera_from_world = desc.world_from_camera.inverse();
        Sensor {
            desc,
            projection,
            camera_from_world,
            pixel_area,
        }
    }

    /// The description.
    pub fn desc(&self) -> &SensorDesc {
        &self.desc
    }

    /// The resolved projection.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// The ray through `film_position` (pixels from the upper left of the crop window, x right, y down).
    pub fn ray(&self, film_position: Vec2, u_lens: Vec2) -> CameraRay {
        let q = self.plane_position(film_position);
        let ray = match self.projection {
            Projection::Perspective { tan_half_fov_x } => {
                self.ray_between(Vec3::ZERO, (q * tan_half_fov_x).extend(1.0))
            }
            Projection::ThinLens {
                tan_half_fov_x,
                aperture_radius,
                focus_distance,
            } => {
                let lens = (warp::disc(u_lens) * aperture_radius).extend(0.0);
                self.ray_between(lens, (q * tan_half_fov_x).extend(1.0) * focus_distance)
            }
            Projection::Orthographic => {
                let world_from_camera = &self.desc.world_from_camera;
                let o = world_from_camera.transform_point3(q.extend(self.desc.near_clip));
                let d = world_from_camera
                    .transform_vector3(Vec3::Z)
                    .normalize_or_zero();
                // As in Mitsuba, a scale along the axis moves the near plane but not the distance to the far plane.
                Ray {
                    o,
                    d,
                    t_max: self.desc.far_clip - self.desc.near_clip,
                }
            }
        };
        CameraRay { ray, weight: 1.0 }
    }

    /// How the sensor sees the world point `p`; `None` if it does not.
    pub fn connect(&self, p: Vec3, u_lens: Vec2) -> Option<SensorConnection> {
        let local = self.camera_from_world.transform_point3(p);
        let (film_position, lens) = match self.projection {
            Projection::Perspective { tan_half_fov_x } => (
                self.film_position(local.truncate() / (local.z * tan_half_fov_x)),
                Vec3::ZERO,
            ),
            Projection::ThinLens {
                tan_half_fov_x,
                aperture_radius,
                focus_distance,
            } => {
                let lens = (warp::disc(u_lens) * aperture_radius).extend(0.0);
                let in_focus = lens + (local - lens) * (focus_distance / local.z);
                (
                    self.film_position(in_focus.truncate() / (focus_distance * tan_half_fov_x)),
                    lens,
                )
            }
            Projection::Orthographic => (self.film_position(local.truncate()), local.with_z(0.0)),
        };
        let inside = film_position.cmpge(Vec2::ZERO)
            & film_position.cmplt(self.desc.film.crop_size.as_vec2());
        if !inside.all() {
            return None;
        }
        if self.projection == Projection::Orthographic {
            return self.connect_orthographic(p, film_position, local);
        }
        if local.z <= 0.0 || local.z < self.desc.near_clip || local.z > self.desc.far_clip {
            return None;
        }
        let ray = self.ray_between(lens, local);
        let from_lens = p - self.desc.world_from_camera.transform_point3(lens);
        let cos = local.z / (local - lens).length();
        // A pixel is the mean of radiance over its area and the lens. One pixel of the plane z = 1 spans the solid angle
        // pixel_area cos³ from a point of the lens, wherever the plane in focus is, and the density of the lens point cancels:
        //
        //     dω / d(pixel) = pixel_area cos³θ,    dω = cosθ_p dA / d²
        let importance = 1.0 / (self.pixel_area * cos.powi(3) * from_lens.length_squared());
        Some(SensorConnection {
            film_position,
            w: -ray.d,
            target: ray.o,
            importance,
        })
    }

    fn connect_orthographic(
        &self,
        p: Vec3,
        film_position: Vec2,
        local: Vec3,
    ) -> Option<SensorConnection> {
        let ray = self.ray(film_position, Vec2::ZERO).ray;
        let distance = (p - ray.o).dot(ray.d);
        if local.z < self.desc.near_clip || distance > ray.t_max {
            return None;
        }
        // The ray through the point itself, not through its rounded film position.
        let target = p - ray.d * distance;
        Some(SensorConnection {
            film_position,
            w: -ray.d,
            target,
            importance: 1.0 / self.pixel_area,
        })
    }

    /// The part between the clip planes of the ray from `lens` through `through`, both in the camera frame.
    fn ray_between(&self, lens: Vec3, through: Vec3) -> Ray {
        let d = (through - lens).normalize();
        let near = self.desc.near_clip / d.z;
        let world = self.desc.world_from_camera.transform_vector3(d);
        let scale = world.length();
        Ray {
            o: self
                .desc
                .world_from_camera
                .transform_point3(lens + d * near),
            d: world / scale,
            t_max: scale * (self.desc.far_clip / d.z - near),
        }
    }

    /// Film position to the plane on which the full film is [-1, 1] wide; x to the left, y up.
    fn plane_position(&self, film_position: Vec2) -> Vec2 {
        let film = &self.desc.film;
        let fraction = (film.crop_offset.as_vec2() + film_position) / film.size.as_vec2();
        (Vec2::ONE - (fraction + self.desc.principal_point_offset) * 2.0) * self.plane_extent()
    }

    /// The inverse of [`Sensor::plane_position`].
    fn film_position(&self, plane_position: Vec2) -> Vec2 {
        let film = &self.desc.film;
        let fraction = (Vec2::ONE - plane_position / self.plane_extent()) * 0.5
            - self.desc.principal_point_offset;
        fraction * film.size.as_vec2() - film.crop_offset.as_vec2()
    }

    /// Half the size of the full film on that plane.
    fn plane_extent(&self) -> Vec2 {
        let size = self.desc.film.size.as_vec2();
        Vec2::new(1.0, size.y / size.x)
    }
}

/// tan of half the horizontal field of view of a film of `size` pixels, when `fov` degrees span `axis`.
fn tan_half_fov_x(fov: f32, axis: FovAxis, size: UVec2) -> f32 {
    let tan = (fov.to_radians() * 0.5).tan();
    let aspect = size.x as f32 / size.y as f32;
    let along_y = tan * aspect;
    match axis {
        FovAxis::X => tan,
        FovAxis::Y => along_y,
        FovAxis::Diagonal => along_y / (1.0 + aspect * aspect).sqrt(),
        FovAxis::Smaller => tan * aspect.max(1.0),
        FovAxis::Larger => tan * aspect.min(1.0),
    }
}
