//! Cameras, and one for files without any.

use super::super::description::film_of_size;
use super::super::parameters::Numbers;
use super::json::Json;
use glam::{DMat3, DMat4, DVec3};
use manylight::film::{FilmDesc, Filter};
use manylight::math::{Aabb, Affine3A, Mat3, UVec2, Vec2, Vec3};
use manylight::sensors::{FovAxis, SensorDesc, SensorKind};
use std::f64::consts::PI;

/// Longer edge of the film in pixels; the aspect ratio of the camera gives the other one. Files do
/// not say how large images are.
const LONGER_EDGE: f64 = 1280.0;
/// Aspect ratio of the film if the camera has none.
const DEFAULT_ASPECT: f64 = 16.0 / 9.0;
/// Farthest distance of a camera without `zfar`, in units of the scene. A finite number, because
/// rays end there.
const FAR: f32 = 1e30;
/// Vertical field of view in degrees of the camera for files without one.
const FRAMING_FOV: f32 = 40.0;
/// Direction from the scene to this camera: the front of a model is +z, seen from a little above
/// and to the right.
const FRAMING_DIRECTION: Vec3 = Vec3::new(0.35, 0.25, 1.0);
/// Part of the film that the scene fills at most in such a picture.
const FRAMING_MARGIN: f32 = 0.9;

/// The camera of a node.
pub(super) fn sensor(json: &Json<'_>, name: &str, world_from_node: &DMat4) -> Option<SensorDesc> {
    let kind = json.string("type");
    let (Some(kind @ ("perspective" | "orthographic")), Some(lens)) =
        (kind, kind.and_then(|kind| json.member(kind)))
    else {
        json.error(
            "expected the `type` `perspective` or `orthographic`, and an object of this name",
        );
        return None;
    };
    let near = lens.float_where("znear", 0.0, |v| v >= 0.0, "at least 0");
    let far = lens.float_where("zfar", FAR, |v| v > near, "more than `znear`");
    let mut sensor = SensorDesc {
        name: name.to_owned(),
        world_from_camera: camera_frame(world_from_node),
        motion: Vec::new(),
        kind: SensorKind::Orthographic,
        principal_point_offset: Vec2::ZERO,
        near_clip: near,
        far_clip: far,
        film: film(DEFAULT_ASPECT),
    };
    if kind == "perspective" {
        let is_inside = |fov: &f64| *fov > 0.0 && *fov < PI;
        let Some(yfov) = lens.number("yfov").filter(is_inside) else {
            lens.error("expected a `yfov` from 0 to π");
            return None;
        };
        let aspect = lens.number("aspectRatio").unwrap_or(DEFAULT_ASPECT);
        if aspect <= 0.0 {
            lens.unexpected("aspectRatio", aspect, "more than 0");
            return None;
        }
        sensor.film = film(aspect);
        sensor.kind = SensorKind::Perspective {
            fov: yfov.to_degrees() as f32,
            fov_axis: FovAxis::Y,
        };
        return Some(sensor);
    }
    let extent = |name: &str| lens.number(name).map(f64::abs).filter(|v| *v > 0.0);
    let (Some(x), Some(y)) = (extent("xmag"), extent("ymag")) else {
        lens.error("expected `xmag` and `ymag` different from 0");
        return None;
    };
    sensor.film = film(x / y);
    // The film covers [-1, 1] of the camera frame. So a unit of this frame is `xmag`, half the
    // width.
    sensor.world_from_camera *= Affine3A::from_scale(Vec3::splat(x as f32));
    sensor.near_clip = near / x as f32;
    // Rays start at the near plane, and end at this distance minus that of the near plane in the
    // camera frame.
    sensor.far_clip = far - near + near / x as f32;
    Some(sensor)
}

/// A film of this aspect ratio.
fn film(aspect: f64) -> FilmDesc {
    let shorter = |ratio: f64| (LONGER_EDGE * ratio).round().max(1.0) as u32;
    let size = if aspect >= 1.0 {
        UVec2::new(LONGER_EDGE as u32, shorter(aspect.recip()))
    } else {
        UVec2::new(shorter(aspect), LONGER_EDGE as u32)
    };
    film_of_size(size, Filter::Gaussian { stddev: 0.5 })
}

/// The frame of a camera at a node, without the scale of the node. glTF's cameras look along -z
/// with +x to the right, those of the renderer along +z with +x to the left.
fn camera_frame(world_from_node: &DMat4) -> Affine3A {
    let m = DMat3::from_mat4(*world_from_node);
    let z = m.z_axis.normalize_or(DVec3::Z);
    let x = (m.x_axis - z * z.dot(m.x_axis)).normalize_or(z.any_orthonormal_vector());
    let y = z.cross(x);
    let y = if y.dot(m.y_axis) < 0.0 { -y } else { y };
    let axes = DMat3::from_cols(-x, y, -z);
    Affine3A::from_mat3_translation(
        Mat3::from_cols(
            axes.x_axis.as_vec3(),
            axes.y_axis.as_vec3(),
            axes.z_axis.as_vec3(),
        ),
        world_from_node.w_axis.truncate().as_vec3(),
    )
}

/// A camera that shows all of `bounds`.
pub(super) fn framing(bounds: Aabb) -> SensorDesc {
    let (bounds, center) = if bounds.is_empty() {
        (
            Aabb {
                min: -Vec3::ONE,
                max: Vec3::ONE,
            },
            Vec3::ZERO,
        )
    } else {
        (bounds, 0.5 * (bounds.min + bounds.max))
    };
    let back = FRAMING_DIRECTION.normalize();
    let right = Vec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let film = film(DEFAULT_ASPECT);
    let tan_y = (0.5 * FRAMING_FOV).to_radians().tan() * FRAMING_MARGIN;
    let tan_x = tan_y * DEFAULT_ASPECT as f32;
    // Each corner of the box limits the distance: it must lie within the field of view.
    let corners = (0..8).map(|i| {
        let pick = |axis: usize| {
            if i >> axis & 1 == 0 {
                bounds.min
            } else {
                bounds.max
            }
        };
        Vec3::new(pick(0).x, pick(1).y, pick(2).z) - center
    });
    let distance = corners
        .map(|c| c.dot(back) + (c.dot(right).abs() / tan_x).max(c.dot(up).abs() / tan_y))
        .fold(0.0, f32::max);
    let distance = if distance > 0.0 { distance } else { 1.0 };
    SensorDesc {
        name: String::new(),
        world_from_camera: Affine3A::from_mat3_translation(
            Mat3::from_cols(-right, up, -back),
            center + back * distance,
        ),
        motion: Vec::new(),
        kind: SensorKind::Perspective {
            fov: FRAMING_FOV,
            fov_axis: FovAxis::Y,
        },
        principal_point_offset: Vec2::ZERO,
        near_clip: 0.0,
        far_clip: FAR,
        film,
    }
}
