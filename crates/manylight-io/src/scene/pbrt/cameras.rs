//! Cameras.

use super::super::motion::frames;
use super::super::parameters::{Numbers, Parameters};
use super::super::sink::Problem;
use super::builder::Builder;
use super::entities::Entity;
use glam::{DMat4, DVec3};
use manylight::film::FilmDesc;
use manylight::math::{Affine3A, Vec2};
use manylight::sensors::{FovAxis, SensorDesc, SensorKind};

pub(super) const SUPPORTED: &[&str] = &["orthographic", "perspective"];

/// Plugins that are replaced by `perspective`: their names and the field of view of the shorter
/// edge in degrees.
const SUBSTITUTES: [(&str, f32); 3] = [
    ("environment", 90.0),
    ("realistic", 40.0),
    ("spherical", 90.0),
];

/// The part of the screen that the film covers, in units of half its shorter edge.
#[derive(Clone, Copy, Debug)]
struct Screen {
    x: [f32; 2],
    y: [f32; 2],
    /// Whether the film determines the window.
    is_default: bool,
}

impl Builder<'_> {
    /// Adds the camera. `motion` is the transform from the world to it at the end of its motion, with
    /// the times of its start and end in s.
    pub(super) fn camera(
        &mut self,
        entity: &Entity<'_>,
        motion: Option<(DMat4, [f64; 2])>,
        film: FilmDesc,
    ) {
        let params = &entity.params;
        let screen = self.screen(entity, &film);
        // PBRT's x points to the right, ours to the left.
        let mut from_camera = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let kind = match params.plugin.value.as_str() {
            "orthographic" => {
                let half_width = 0.5 * f64::from(screen.x[1] - screen.x[0]);
                from_camera *= DMat4::from_scale(DVec3::splat(half_width));
                self.warn_orthographic_lens(entity);
                SensorKind::Orthographic
            }
            _ => self.perspective(entity, &screen),
        };
        let frame = |camera_from_world: DMat4| camera_from_world.inverse() * from_camera;
        let motion = motion.map_or_else(Vec::new, |(at_end, [start, end])| {
            let keys = [(start, frame(entity.transform)), (end, frame(at_end))];
            frames(&keys, self.fps).unwrap_or_else(|fault| {
                let message = format!("this camera cannot move: {fault}");
                let help = "`TransformTimes` has the times of the start and the end, in seconds";
                let problem = Problem::new("scene::bad_value", params.plugin.span, message);
                self.sink.error(problem.help(help));
                Vec::new()
            })
        });
        params.ignore(&["shutteropen", "shutterclose"]);
        entity.params.finish(self.is_v3);
        let extent = [screen.x[1] - screen.x[0], screen.y[1] - screen.y[0]];
        let center = [screen.x[0] + screen.x[1], screen.y[0] + screen.y[1]];
        self.desc.sensors.push(SensorDesc {
            name: String::new(),
            world_from_camera: Affine3A::from_mat4(frame(entity.transform).as_mat4()),
            motion,
            kind,
            principal_point_offset: Vec2::new(
                0.5 * center[0] / extent[0],
                -0.5 * center[1] / extent[1],
            ),
            near_clip: 0.0,
            far_clip: f32::INFINITY,
            film,
        });
    }

    /// The factor of the sensor: exposure time times ISO over 100.
    pub(super) fn imaging_ratio(&self, camera: &Entity<'_>, film: Option<&Entity<'_>>) -> f32 {
        let time = |name, default| camera.params.float(name, default);
        let exposure = (time("shutterclose", 1.0) - time("shutteropen", 0.0)).abs();
        let iso = film.map_or(100.0, |film| film.params.float("iso", 100.0));
        // In PBRT v3 the shutter has no effect on brightness.
        if self.is_v3 {
            1.0
        } else {
            exposure * iso / 100.0
        }
    }

    fn perspective(&mut self, entity: &Entity<'_>, screen: &Screen) -> SensorKind {
        let params = &entity.params;
        let sink = self.sink;
        let plugin = params.plugin.value.as_str();
        let substitute = SUBSTITUTES.iter().find(|(name, _)| *name == plugin);
        if let Some((name, degrees)) = substitute {
            let message = format!(
                "camera `{name}` is not supported; it is replaced by `perspective` with a field of view of {degrees} degrees"
            );
            let span = params.plugin.span;
            sink.warn_once("camera", Problem::new("scene::unsupported", span, message));
            params.ignore_all();
            return SensorKind::Perspective {
                fov: *degrees,
                fov_axis: FovAxis::Smaller,
            };
        }
        if plugin != "perspective" {
            let others = SUBSTITUTES.iter().map(|(name, _)| *name);
            self.unknown_plugin(entity, SUPPORTED.iter().copied().chain(others));
            params.ignore_all();
        }
        let inside = |fov| fov > 0.0 && fov < 180.0;
        let half_fov = params.maybe_float("halffov").map(|half| 2.0 * half);
        let shorter = params.float_where("fov", half_fov.unwrap_or(90.0), inside, "in (0, 180)");
        let (fov, fov_axis) = if screen.is_default {
            (shorter, FovAxis::Smaller)
        } else {
            let half_width = 0.5 * (screen.x[1] - screen.x[0]);
            let tan = (0.5 * shorter.to_radians()).tan() * half_width;
            (2.0 * tan.atan().to_degrees(), FovAxis::X)
        };
        let at_least_zero = |radius| radius >= 0.0;
        let aperture_radius = params.float_where("lensradius", 0.0, at_least_zero, "at least 0");
        let focus_distance =
            params.float_where("focaldistance", 1e6, |distance| distance > 0.0, "positive");
        if aperture_radius == 0.0 {
            return SensorKind::Perspective { fov, fov_axis };
        }
        SensorKind::ThinLens {
            fov,
            fov_axis,
            aperture_radius,
            focus_distance,
        }
    }

    fn warn_orthographic_lens(&self, entity: &Entity<'_>) {
        let params = &entity.params;
        params.ignore(&["focaldistance"]);
        if params.float("lensradius", 0.0) > 0.0
            && let Some(param) = params.get("lensradius")
        {
            let message = "the lens of an orthographic camera is not supported; it is a pinhole";
            self.sink
                .unsupported("orthographic lens", param.name.span, message);
        }
    }

    /// The window from `screenwindow` or `frameaspectratio`. Pixels that are not square are
    /// reported.
    fn screen(&self, entity: &Entity<'_>, film: &FilmDesc) -> Screen {
        let params = &entity.params;
        let film_aspect = film.size.x as f32 / film.size.y as f32;
        let of_aspect = |aspect: f32| {
            let [x, y] = [aspect.max(1.0), (1.0 / aspect).max(1.0)];
            [[-x, x], [-y, y]]
        };
        let aspect = params.float_where(
            "frameaspectratio",
            film_aspect,
            |aspect| aspect > 0.0,
            "positive",
        );
        let [mut x, mut y] = of_aspect(aspect);
        if let Some(window) = params.floats("screenwindow") {
            match *window {
                [x0, x1, y0, y1] if x0 < x1 && y0 < y1 => [x, y] = [[x0, x1], [y0, y1]],
                _ => {
                    let required = "four numbers x0 < x1, y0 < y1";
                    params.refuse_named("screenwindow", required);
                }
            }
        }
        let is_default = [x, y] == of_aspect(film_aspect);
        let stretch = (x[1] - x[0]) / (y[1] - y[0]) / film_aspect;
        // Files round the numbers of the window.
        if (stretch - 1.0).abs() > 1e-2 {
            let message =
                "the window has another aspect ratio than the film; pixels are square here";
            let param = params.get("screenwindow");
            let span = param
                .or_else(|| params.get("frameaspectratio"))
                .map_or(params.plugin.span, |param| param.span);
            self.sink.unsupported("square pixels", span, message);
        }
        Screen { x, y, is_default }
    }
}
