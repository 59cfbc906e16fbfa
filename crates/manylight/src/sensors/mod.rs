//! Cameras: rays for film positions, and importance for points.

use crate::geometry::Ray;
use crate::math::{Affine3A, Vec2, Vec3};
use crate::film::FilmDesc;

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
    /// Parallel rays over the square [-1, 1]² (width) of the camera frame.
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
    /// Shift of the principal point as a fraction of the film's size (Mitsuba's `principal_point_offset_x/y`).
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
    /// Resolves field of view and film shape.
    pub fn new(_desc: SensorDesc) -> Self {
        todo!()
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
    pub fn ray(&self, _film_position: Vec2, _u_lens: Vec2) -> CameraRay {
        todo!()
    }

    /// How the sensor sees the world point `p`; `None` if it does not.
    pub fn connect(&self, _p: Vec3, _u_lens: Vec2) -> Option<SensorConnection> {
        todo!()
    }
}
