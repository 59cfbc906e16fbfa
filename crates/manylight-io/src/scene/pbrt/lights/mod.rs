//! Light sources.

mod area;
mod environment;
mod image_lights;
mod power;

use super::super::description::Additions;
use super::super::names::name_light_group;
use super::super::parameters::{Numbers, Parameters};
use super::builder::Builder;
use super::entities::Entity;
use super::param_types::ParamType;
pub(super) use area::AreaLight;
use manylight::color::Rgb;
use manylight::emitters::{Emitter, SpotFalloff};
use manylight::math::Vec3;
pub(super) use power::EmittingSurface;
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

/// Name of the light group of a light. An extension of this renderer: PBRT has no such groups.
const LIGHT_GROUP: &str = "lightgroup";

impl Builder<'_> {
    /// Adds a light that is not a surface.
    pub(super) fn light(&mut self, entity: &Entity<'_>) {
        let params = &entity.params;
        params.ignore(SAMPLING_PARAMETERS);
        let group = params.string(LIGHT_GROUP).map(|name| name.value.as_str());
        let first = self.desc.emitters.len();
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
        name_light_group(&mut self.desc, first, group);
        entity.params.finish(self.is_v3);
    }

    /// The color `name` of a light, white by default, times its scale and that of the film.
    fn emission(&mut self, entity: &Entity<'_>, name: &'static str) -> Rgb {
        let color = entity.color(name, self.emission_use());
        color.unwrap_or(Rgb::WHITE) * self.emission_scale(entity)
    }

    /// The parameter `scale`, a number, or a color in PBRT v3, times the scale of the film.
    fn emission_scale(&mut self, entity: &Entity<'_>) -> Rgb {
        let params = &entity.params;
        let scale = match params.get("scale").map(|param| param.ty) {
            None => Rgb::WHITE,
            Some(ParamType::Float) => Rgb::splat(params.float("scale", 1.0)),
            Some(_) => {
                let color = entity.color("scale", self.emission_use());
                color.unwrap_or(Rgb::WHITE)
            }
        };
        scale * self.film_scale
    }

    /// The factor by which `power` scales a light that emits `unscaled` (a luminous quantity)
    /// without it.
    fn power_factor(&self, entity: &Entity<'_>, name: &'static str, unscaled: f32) -> f32 {
        match entity.params.maybe_float(name) {
            Some(power) if power > 0.0 && unscaled > 0.0 => power / unscaled,
            _ => 1.0,
        }
    }

    /// The name of the image of a light, which is `mapname` in PBRT v3.
    fn map_parameter(entity: &Entity<'_>) -> &'static str {
        if entity.params.has("mapname") {
            "mapname"
        } else {
            "filename"
        }
    }

    fn point(&mut self, entity: &Entity<'_>) {
        let intensity = self.emission(entity, "I");
        let from = entity.params.point3("from", Vec3::ZERO);
        // The luminous power of an intensity of 1.
        let factor = self.power_factor(entity, "power", 4.0 * PI);
        let position = self.world_from(entity).transform_point3(from);
        self.desc.add(Emitter::Point {
            position,
            intensity: intensity * factor,
        });
    }

    fn spot(&mut self, entity: &Entity<'_>) {
        let intensity = self.emission(entity, "I");
        let params = &entity.params;
        let from = params.point3("from", Vec3::ZERO);
        let to = params.point3("to", Vec3::Z);
        let inside = |angle| angle > 0.0 && angle <= 90.0;
        let cone = params.float_where("coneangle", 30.0, inside, "in (0, 90]");
        let delta = params.float_where(
            "conedeltaangle",
            5.0f32.min(cone),
            |angle| angle >= 0.0,
            "at least 0",
        );
        let world = self.world_from(entity);
        let Some(direction) = world.transform_vector3(to - from).try_normalize() else {
            params.refuse_pair("from", "to");
            return;
        };
        let cutoff = cone.to_radians();
        let beam_width = (cone - delta).max(0.0).to_radians();
        // Solid angle of the beam, and half of that of the falloff.
        let solid_angle = TAU * (1.0 - 0.5 * (cutoff.cos() + beam_width.cos()));
        let factor = self.power_factor(entity, "power", solid_angle);
        self.desc.add(Emitter::Spot {
            position: world.transform_point3(from),
            direction,
            intensity: intensity * factor,
            cutoff,
            beam_width,
            falloff: match self.is_v3 {
                true => SpotFalloff::QuarticCosine,
                false => SpotFalloff::SmoothCosine,
            },
            projector: None,
        });
    }

    fn distant(&mut self, entity: &Entity<'_>) {
        let irradiance = self.emission(entity, "L");
        let params = &entity.params;
        let from = params.point3("from", Vec3::ZERO);
        let to = params.point3("to", Vec3::Z);
        let factor = self.power_factor(entity, "illuminance", 1.0);
        let direction = self.world_from(entity).transform_vector3(to - from);
        let Some(direction) = direction.try_normalize() else {
            params.refuse_pair("from", "to");
            return;
        };
        self.desc.add(Emitter::Directional {
            direction,
            irradiance: irradiance * factor,
        });
    }
}
