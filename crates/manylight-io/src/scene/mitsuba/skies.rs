//! The emitter plugins of sun and sky, baked into environment maps. Version 3 has z up; in 0.x, y
//! is up, x east and z south.

use super::super::description::Additions;
use super::super::parameters::{Numbers, Parameters};
use super::super::sink::Problem;
use super::builder::DescBuilder;
use super::colors::ColorUse;
use super::props::Props;
use super::transforms::rotation;
use crate::sky::{PlaceAndTime, SunDisc, SunSky, bake_sunsky, sky_from_environment};
use glam::{DMat4, DVec3};
use manylight::emitters::{Emitter, Environment};
use manylight::math::Vec3;

/// Width of the map in texels. The disc of the sun is three texels wide.
const MAP_WIDTH: usize = 2048;

/// Parameters of place and time, which determine the direction to the sun.
const TIME: [&str; 9] = [
    "latitude",
    "longitude",
    "timezone",
    "year",
    "month",
    "day",
    "hour",
    "minute",
    "second",
];

/// The parts of the model that emit light.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum SkyParts {
    Both,
    Sky,
    Sun,
}

impl DescBuilder<'_> {
    /// Adds an emitter of sun and sky.
    pub(super) fn sun_and_sky(&mut self, props: &Props<'_>, parts: SkyParts) {
        let defaults = SunSky::default();
        let to_world = props.to_world();
        self.check_unscaled(props, to_world);
        let z_up = DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2);
        let (frame, scale) = if has_y_up(props) {
            (to_world * z_up, props.float("scale", 1.0))
        } else {
            (to_world, 1.0)
        };
        let at_least_zero = |name| props.float_where(name, 1.0, |scale| scale >= 0.0, "at least 0");
        let (sun_scale, sky_scale) = (
            at_least_zero("sun_scale") * scale,
            at_least_zero("sky_scale") * scale,
        );
        let parameters = SunSky {
            sun_direction: self.sun_direction(props, to_world, frame),
            turbidity: props.float_where(
                "turbidity",
                3.0,
                |t| (1.0..=10.0).contains(&t),
                "in [1, 10]",
            ),
            albedo: self.color(props, "albedo", defaults.albedo.r, ColorUse::Reflectance),
            sun_scale: if parts == SkyParts::Sky {
                0.0
            } else {
                sun_scale
            },
            sky_scale: if parts == SkyParts::Sun {
                0.0
            } else {
                sky_scale
            },
            sun_aperture: self.sun_aperture(props, defaults.sun_aperture),
            sun_disc: match props.boolean("complex_sun", false) {
                true => SunDisc::Darkened,
                false => SunDisc::Uniform,
            },
        };
        if props.is_v0() {
            self.warn_feature(props, "stretch", "is not supported; it is ignored");
            props.ignore(&["resolution", "extend", "sun_samples"]);
        }
        if parameters.sun_direction.z <= 0.0 {
            let message = format!(
                "the sun of {} is below the horizon: it emits nothing",
                props.describe()
            );
            let problem = Problem::new("scene::suspicious", props.span(), message);
            self.sink.warn_once("sun below the horizon", problem);
        }
        let image = bake_sunsky(&parameters, MAP_WIDTH);
        let world_from_emitter = rotation(frame) * sky_from_environment();
        self.desc.add(Emitter::Environment(Environment {
            image,
            scale: 1.0,
            world_from_emitter,
        }));
    }

    /// Angular diameter of the sun in degrees. Mitsuba 3 knows its new name in old files too.
    fn sun_aperture(&self, props: &Props<'_>, default: f32) -> f32 {
        if props.is_v0() && !props.has("sun_aperture") {
            default * props.float_where("sun_radius_scale", 1.0, |scale| scale >= 0.0, "at least 0")
        } else {
            props.float_where(
                "sun_aperture",
                default,
                |angle| angle > 0.0 && angle < 180.0,
                "in (0, 180)",
            )
        }
    }

    /// Unit vector to the sun in the frame of the sky. The parameter `sun_direction` is in world
    /// space; place and time determine a direction in the frame of the emitter.
    fn sun_direction(&self, props: &Props<'_>, to_world: DMat4, frame: DMat4) -> Vec3 {
        let into_frame = |world: DVec3| {
            frame
                .inverse()
                .transform_vector3(world)
                .normalize_or_zero()
                .as_vec3()
        };
        if let Some(direction) = props.vector("sun_direction") {
            if let Some(time) = TIME.iter().find(|name| props.has(name)) {
                props.refuse_named("sun_direction", &format!("absent if `{time}` is given"));
            }
            props.ignore(&TIME);
            return into_frame(direction);
        }
        let local = place_and_time(props).sun_direction();
        if has_y_up(props) {
            let east_up_south = Vec3::new(-local.y, local.z, local.x).as_dvec3();
            return into_frame(to_world.transform_vector3(east_up_south));
        }
        local
    }
}

/// Whether the frame is that of 0.x. A file of 0.x with a parameter that only version 3 has is read
/// by version 3.
fn has_y_up(props: &Props<'_>) -> bool {
    props.is_v0() && !props.has("sun_aperture")
}

fn place_and_time(props: &Props<'_>) -> PlaceAndTime {
    let default = PlaceAndTime::default();
    let integer = |name, default: i32, least| props.integer(name, i64::from(default), least) as i32;
    PlaceAndTime {
        latitude: props.float("latitude", default.latitude),
        longitude: props.float("longitude", default.longitude),
        timezone: props.float("timezone", default.timezone),
        year: integer("year", default.year, 0),
        month: integer("month", default.month, 1),
        day: integer("day", default.day, 1),
        hour: props.float("hour", default.hour),
        minute: props.float("minute", default.minute),
        second: props.float("second", default.second),
    }
}
