//! The transforms of a sensor as matrices, by the conventions of OpenEXR.

use super::{Projection, Sensor};
use crate::math::{Mat4, Vec2, Vec3, Vec4};

impl Sensor {
    /// From world space to the camera's, in the world's unit: x to the right of the picture, y up,
    /// z in the direction of view.
    pub fn camera_from_world(&self) -> Mat4 {
        let frame = self.desc.world_from_camera;
        let [x, y, z] = [frame.x_axis, frame.y_axis, frame.z_axis].map(Vec3::from);
        // The sensor's own frame has x to the left, and a scale.
        let axes = [-x, y, z].map(Vec3::normalize_or_zero);
        let row = |axis: Vec3| axis.extend(-axis.dot(frame.translation.into()));
        Mat4::from_cols(row(axes[0]), row(axes[1]), row(axes[2]), Vec4::W).transpose()
    }

    /// From world space to the full film in homogeneous coordinates: (0, 0) is its upper left
    /// corner, (1, 1) its lower right; z grows with the distance.
    pub fn film_from_world(&self) -> Mat4 {
        let frame = Mat4::from(self.camera_from_world);
        let extent = self.plane_extent();
        let offset = self.desc.principal_point_offset;
        let near = self.desc.near_clip;
        // Rows of the map from the sensor's frame. A film coordinate is (1 - q / extent) / 2 -
        // offset, with q on the plane of `Sensor::plane_position`.
        let rows = match self.projection {
            Projection::Perspective { tan_half_fov_x }
            | Projection::ThinLens { tan_half_fov_x, .. } => {
                let slope = Vec2::splat(0.5) / (extent * tan_half_fov_x);
                let center = Vec2::splat(0.5) - offset;
                // Depth is 1 - near / z. Without a near plane, any other distance will do.
                let near = if near > 0.0 { near } else { 1.0 };
                [
                    Vec4::new(-slope.x, 0.0, center.x, 0.0),
                    Vec4::new(0.0, -slope.y, center.y, 0.0),
                    Vec4::new(0.0, 0.0, 1.0, -near),
                    Vec4::Z,
                ]
            }
            Projection::Orthographic => {
                let slope = Vec2::splat(0.5) / extent;
                let center = Vec2::splat(0.5) - offset;
                [
                    Vec4::new(-slope.x, 0.0, 0.0, center.x),
                    Vec4::new(0.0, -slope.y, 0.0, center.y),
                    Vec4::new(0.0, 0.0, 1.0, -near),
                    Vec4::W,
                ]
            }
        };
        Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose() * frame
    }

    /// Center and width of the full film on the plane z = 1 of [`Sensor::camera_from_world`];
    /// `None` for parallel rays.
    pub fn screen_window(&self) -> Option<(Vec2, f32)> {
        match self.projection {
            Projection::Perspective { tan_half_fov_x }
            | Projection::ThinLens { tan_half_fov_x, .. } => {
                let middle = self.plane_extent() * self.desc.principal_point_offset * 2.0;
                let center = Vec2::new(middle.x, -middle.y) * tan_half_fov_x;
                Some((center, 2.0 * tan_half_fov_x))
            }
            Projection::Orthographic => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{FilmDesc, Filter};
    use crate::math::{Affine3A, UVec2};
    use crate::sensors::{FovAxis, SensorDesc, SensorKind};

    fn sensor(kind: SensorKind, scale: Vec3) -> Sensor {
        let placed = Affine3A::from_translation(Vec3::new(3.0, -1.0, 2.0))
            * Affine3A::from_rotation_y(0.7)
            * Affine3A::from_rotation_x(-0.3);
        Sensor::new(SensorDesc {
            name: String::new(),
            world_from_camera: placed * Affine3A::from_scale(scale),
            motion: Vec::new(),
            kind,
            principal_point_offset: Vec2::new(0.1, -0.05),
            near_clip: 0.01,
            far_clip: 100.0,
            film: FilmDesc {
                size: UVec2::new(200, 120),
                crop_offset: UVec2::new(30, 40),
                crop_size: UVec2::new(100, 50),
                filter: Filter::Box,
            },
        })
    }

    #[test]
    fn matrices_lead_back_along_camera_rays() {
        let fov_axis = FovAxis::X;
        let kinds = [
            SensorKind::Perspective {
                fov: 50.0,
                fov_axis,
            },
            SensorKind::ThinLens {
                fov: 50.0,
                fov_axis,
                aperture_radius: 0.1,
                focus_distance: 2.0,
            },
            SensorKind::Orthographic,
        ];
        let scales = [Vec3::ONE, Vec3::splat(2.5), Vec3::new(-1.0, 1.0, 1.0)];
        for (kind, scale) in kinds
            .into_iter()
            .flat_map(|kind| scales.map(|scale| (kind, scale)))
        {
            let sensor = sensor(kind, scale);
            for at in [
                Vec2::new(10.0, 20.0),
                Vec2::new(99.0, 1.0),
                Vec2::new(50.0, 25.0),
            ] {
                // The center of the lens.
                let ray = sensor.ray(at, Vec2::splat(0.5));
                let fraction = (at + Vec2::new(30.0, 40.0)) / Vec2::new(200.0, 120.0);
                let mut depths = Vec::new();
                for distance in [1.0, 4.0] {
                    let p = ray.o + ray.d * distance;
                    let film = sensor.film_from_world().project_point3(p);
                    let error = (film.truncate() - fraction).abs().max_element();
                    assert!(
                        error < 1e-5,
                        "{kind:?} {scale}: {film}, expected {fraction}"
                    );
                    depths.push(film.z);
                    let local = sensor.camera_from_world().transform_point3(p);
                    assert!(local.z > 0.0, "{local}");
                    let length =
                        (local - sensor.camera_from_world().transform_point3(ray.o)).length();
                    assert!((length - distance).abs() < 1e-4, "{kind:?}: {length}");
                    if let Some((center, width)) = sensor.screen_window() {
                        let window = Vec2::new(width, width * 0.6);
                        let flipped = (fraction - 0.5) * Vec2::new(1.0, -1.0);
                        let expected = center + flipped * window;
                        let found = local.truncate() / local.z;
                        assert!(
                            (found - expected).abs().max_element() < 1e-5,
                            "{found} {expected}"
                        );
                    }
                }
                assert!(depths[0] < depths[1], "{kind:?}: {depths:?}");
            }
        }
    }
}
