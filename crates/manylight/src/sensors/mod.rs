//! Sensors: camera rays for film positions, and importance at points.

mod matrices;
mod rays;
#[cfg(test)]
mod tests;

use crate::film::FilmDesc;
use crate::lanes::One;
use crate::math::{Affine3A, UVec2, Vec2, Vec3};
use crate::sampling::warp;

/// The projection of a sensor. As in Mitsuba, the camera looks along +z of the camera frame, with
/// +y up and +x to the left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole.
    Perspective {
        /// tan of half the horizontal field of view over the *uncropped* film.
        tan_half_fov_x: f32,
    },
    /// A thin lens of finite size.
    ThinLens {
        /// As for `Perspective`.
        tan_half_fov_x: f32,
        /// Radius of the lens in units of the camera frame.
        aperture_radius: f32,
        /// Distance of the plane in focus along z.
        focus_distance: f32,
    },
    /// Parallel rays along z. The width of the full film covers [-1, 1] in the camera frame.
    Orthographic,
}

/// The extent of the film that the field of view spans.
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

/// A sensor as a scene file describes it. Plain data; [`Sensor::new`] resolves it.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorDesc {
    /// Name or id in the file; may be empty.
    pub name: String,
    /// Camera frame to world; may contain a uniform scale and a reflection.
    pub world_from_camera: Affine3A,
    /// The same, frame by frame, of a camera that moves; empty if it stands still. Pictures are
    /// made by [`Scene::set_frames`](crate::scene::Scene::set_frames).
    pub motion: Vec<Affine3A>,
    /// Kind and its parameters.
    pub kind: SensorKind,
    /// Shift of the principal point as a fraction of the full film's size (Mitsuba's
    /// `principal_point_offset_x/y`): the ray of a film position is that of this position plus the
    /// offset without a shift. In Mitsuba only `perspective` has it.
    pub principal_point_offset: Vec2,
    /// Nearest visible distance along the view axis; 0: no near plane.
    pub near_clip: f32,
    /// Farthest visible distance along the view axis.
    pub far_clip: f32,
    /// Size, crop and filter of the film.
    pub film: FilmDesc,
}

/// Kinds of sensors in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorKind {
    /// A pinhole.
    Perspective {
        /// Field of view in degrees.
        fov: f32,
        /// The extent that `fov` spans.
        fov_axis: FovAxis,
    },
    /// A thin lens.
    ThinLens {
        /// Field of view in degrees.
        fov: f32,
        /// The extent that `fov` spans.
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
    /// Area of a pixel on the plane z = 1 of the camera frame; for orthographic sensors
    /// perpendicular to the rays in world space.
    pixel_area: f32,
}

/// A connection of a point to the sensor, for light tracing.
#[derive(Clone, Copy, Debug)]
pub struct SensorConnection {
    /// Position on the film in pixels from the upper left of the *crop window*, x right, y down.
    pub film_position: Vec2,
    /// Unit direction from the point to the sensor.
    pub w: Vec3,
    /// End of the shadow ray.
    pub target: Vec3,
    /// `W_e cosθ_lens / (d² pdf_lens)`. Flux · f · |cos ng| times this, over the number of paths,
    /// is the contribution to the radiance of the pixel, averaged over its area.
    pub importance: f32,
}

impl Sensor {
    /// Resolves the field of view for the size of the film. For another size, change the
    /// description and call this again.
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

    /// Connects the world-space point `p` to the sensor; `None` if it is outside of the film or of
    /// the clip planes.
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
        let [ray] = self.ray_between::<One>(lens.into(), local.into()).store();
        let from_lens = p - self.desc.world_from_camera.transform_point3(lens);
        let cos = local.z / (local - lens).length();
        // The value of a pixel is the mean of radiance over its area and the lens. From a point of
        // the lens, a pixel on the plane z = 1 spans the solid angle pixel_area cos³, for any plane
        // in focus. The density of the lens point cancels.
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
        let ray = self.ray(film_position, Vec2::ZERO);
        let distance = (p - ray.o).dot(ray.d);
        if local.z < self.desc.near_clip || distance > ray.t_max {
            return None;
        }
        // Exactly through the point, not through its rounded film position.
        let target = p - ray.d * distance;
        Some(SensorConnection {
            film_position,
            w: -ray.d,
            target,
            importance: 1.0 / self.pixel_area,
        })
    }

    /// The inverse of `plane_positions`.
    fn film_position(&self, plane_position: Vec2) -> Vec2 {
        let film = &self.desc.film;
        let fraction = (Vec2::ONE - plane_position / self.plane_extent()) * 0.5
            - self.desc.principal_point_offset;
        fraction * film.size.as_vec2() - film.crop_offset.as_vec2()
    }

    /// Half the size of the full film on the plane of [`Sensor::plane_position`].
    fn plane_extent(&self) -> Vec2 {
        let size = self.desc.film.size.as_vec2();
        Vec2::new(1.0, size.y / size.x)
    }
}

/// tan of half the horizontal field of view of a film of `size` pixels. `fov` in degrees spans
/// `axis`.
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
