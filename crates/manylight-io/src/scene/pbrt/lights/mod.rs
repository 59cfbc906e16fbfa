//! Light sources.

mod area;
mod environment;
mod image_lights;

use super::Builder;
use super::entities::Entity;
use manylight::color::Rgb;
use manylight::emitters::{Emitter, SpotFalloff};
use manylight::ids::EmitterId;
use manylight::math::{Affine3A, Mat3, Vec3};
use std::f32::consts::{PI, TAU};

pub(super) const SUPPORTED: &[&str] = &[
    "diffuse",
    "distant",
    "goniometric",
    "infinite",
    "point",
    "projection",
    "spot",
];

/// Parameters of PBRT v3 about sampling, and shadow settings, which have no effect.
const SAMPLING_PARAMETERS: &[&str] = &["nsamples", "samples", "id"];

impl Builder<'_> {
    pub(super) fn add_emitter(&mut self, emitter: Emitter) -> EmitterId {
        self.desc.emitters.push(emitter);
        EmitterId::from(self.desc.emitters.len() - 1)
    }

    /// Adds a light that is not a surface.
    pub(super) fn light(&mut self, entity: &Entity) {
        let params = &entity.params;
        params.ignore(SAMPLING_PARAMETERS);
        match params.plugin.value.as_str() {
            "point" => self.point(entity),
            "spot" => self.spot(entity),
            "distant" => self.distant(entity),
            "infinite" | "exinfinite" => self.infinite(entity),
            "goniometric" => self.goniometric(entity),
            "projection" => self.projection(entity),
            _ => {
                let known = SUPPORTED.iter().copied().filter(|name| *name != "diffuse");
                self.unknown_plugin(entity, known);
                params.ignore_all();
            }
        }
        self.finish(entity);
    }

    /// The color `name` of a light, white by default, times its scale and that of the film.
    fn emission(&mut self, entity: &Entity, name: &'static str) -> Rgb {
        let color_use = self.emission_use();
        let color = self.color(entity, name, color_use).unwrap_or(Rgb::WHITE);
        color * self.emission_scale(entity)
    }

    /// The parameter `scale`, a number, or a color in PBRT v3, times the scale of the film.
    fn emission_scale(&mut self, entity: &Entity) -> Rgb {
        let scale = self.color_of_scale(entity);
        scale * self.film_scale
    }

    fn color_of_scale(&mut self, entity: &Entity) -> Rgb {
        let params = &entity.params;
        match params.get("scale").map(|param| param.ty) {
            None => Rgb::WHITE,
            Some(super::param_types::ParamType::Float) => {
                Rgb::splat(params.float(self.sink, "scale", 1.0))
            }
            Some(_) => {
                let color_use = self.emission_use();
                self.color(entity, "scale", color_use).unwrap_or(Rgb::WHITE)
            }
        }
    }

    /// The factor by which `power` scales a light that emits `unscaled` (a luminous quantity) without it.
    fn power_factor(&self, entity: &Entity, name: &'static str, unscaled: f32) -> f32 {
        match entity.params.maybe_float(self.sink, name) {
            Some(power) if power > 0.0 && unscaled > 0.0 => power / unscaled,
            _ => 1.0,
        }
    }

    fn point(&mut self, entity: &Entity) {
        let intensity = self.emission(entity, "I");
        let from = entity.params.point3(self.sink, "from", Vec3::ZERO);
        // The luminous power of an intensity of 1.
        let factor = self.power_factor(entity, "power", 4.0 * PI);
        let position = self.world_from(entity).transform_point3(from);
        self.add_emitter(Emitter::Point {
            position,
            intensity: intensity * factor,
        });
    }

    fn spot(&mut self, entity: &Entity) {
        let intensity = self.emission(entity, "I");
        let params = &entity.params;
        let from = params.point3(self.sink, "from", Vec3::ZERO);
        let to = params.point3(self.sink, "to", Vec3::Z);
        let inside = |angle| angle > 0.0 && angle <= 90.0;
        let cone = params.float_where(self.sink, "coneangle", 30.0, inside, "in (0, 90]");
        let delta = params.float_where(
            self.sink,
            "conedeltaangle",
            5.0f32.min(cone),
            |angle| angle >= 0.0,
            "at least 0",
        );
        let world = self.world_from(entity);
        let Some(direction) = world.transform_vector3(to - from).try_normalize() else {
            params.refuse_pair(self.sink, "from", "to");
            return;
        };
        let cutoff = cone.to_radians();
        let beam_width = (cone - delta).max(0.0).to_radians();
        // Solid angle of the beam, and half of that of the falloff.
        let solid_angle = TAU * (1.0 - 0.5 * (cutoff.cos() + beam_width.cos()));
        let factor = self.power_factor(entity, "power", solid_angle);
        self.add_emitter(Emitter::Spot {
            position: world.transform_point3(from),
            direction,
            intensity: intensity * factor,
            cutoff,
            beam_width,
            falloff: SpotFalloff::SmoothCosine,
            projector: None,
        });
    }

    fn distant(&mut self, entity: &Entity) {
        let irradiance = self.emission(entity, "L");
        let params = &entity.params;
        let from = params.point3(self.sink, "from", Vec3::ZERO);
        let to = params.point3(self.sink, "to", Vec3::Z);
        let factor = self.power_factor(entity, "illuminance", 1.0);
        let direction = self.world_from(entity).transform_vector3(to - from);
        let Some(direction) = direction.try_normalize() else {
            params.refuse_pair(self.sink, "from", "to");
            return;
        };
        self.add_emitter(Emitter::Directional {
            direction,
            irradiance: irradiance * factor,
        });
    }
}

/// The normalized axes of a transform.
fn rotation(transform: &Affine3A) -> Mat3 {
    let m = transform.matrix3;
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|axis| Vec3::from(axis).normalize_or_zero());
    Mat3::from_cols(x, y, z)
}
