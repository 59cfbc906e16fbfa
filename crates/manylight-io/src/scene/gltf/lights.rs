//! Lights of the extension KHR_lights_punctual.

use super::super::options::LightUnits;
use super::super::parameters::Numbers;
use super::json::Json;
use super::origin::{LUMENS_PER_WATT, Origin};
use glam::{DMat4, DVec3};
use manylight::color::Rgb;
use manylight::emitters::{Emitter, SpotFalloff};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// How the writer of a file means its numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dialect {
    units: LightUnits,
    /// Whether the inner cone is the `blend` of a Blender lamp.
    is_blender: bool,
    /// Whether neither the file nor the options say the units.
    is_open: bool,
}

impl Dialect {
    /// Blender's exporter writes photometric units while emission stays radiometric; others write
    /// both in one unit. `units` overrides it.
    pub(super) fn new(origin: Origin, units: Option<LightUnits>) -> Self {
        let is_blender = origin == Origin::Blender;
        let usual = if is_blender {
            LightUnits::Lumen
        } else {
            LightUnits::Watt
        };
        Dialect {
            units: units.unwrap_or(usual),
            is_blender,
            is_open: origin == Origin::Replaced && units.is_none(),
        }
    }

    /// Warns if the units of a light are not known.
    pub(super) fn warn_of_units(self, light: &Json<'_>) {
        if self.is_open {
            light.warn_once(
                "units",
                "the program that rewrote this file has removed the name of its exporter, so that the units of its lights are not known; they count as W/sr and W/m² (`--light-units W` says so). If the scene is from Blender, `--light-units lm` makes them 683 times darker",
            );
        }
    }
}

/// The emitter of a light at a node.
pub(super) fn emitter(
    light: &Json<'_>,
    world_from_node: &DMat4,
    dialect: Dialect,
) -> Option<Emitter> {
    let color = light.floats("color", [1.0; 3]);
    if color.iter().any(|v| *v < 0.0) {
        light.error_at("color", "found a negative number, expected at least 0");
        return None;
    }
    let strength = light.float_where("intensity", 1.0, |v| v >= 0.0, "at least 0");
    let kind = light.string("type");
    let factor = match (dialect.units, kind) {
        (LightUnits::Lumen, _) => LUMENS_PER_WATT.recip(),
        // Watts of a point or spot as Blender counts them: as if it emitted into all directions.
        (LightUnits::Raw, Some("point" | "spot")) => 1.0 / (4.0 * PI),
        _ => 1.0,
    };
    let strength = Rgb::from(color) * (strength * factor);
    let position = world_from_node.transform_point3(DVec3::ZERO).as_vec3();
    let axis = world_from_node.transform_vector3(DVec3::NEG_Z);
    let direction = axis.normalize_or(DVec3::NEG_Z).as_vec3();
    match kind {
        Some("point") => Some(Emitter::Point {
            position,
            intensity: strength,
        }),
        Some("directional") => Some(Emitter::Directional {
            direction,
            irradiance: strength,
        }),
        Some("spot") => {
            let (inner, outer) = cone(light, dialect)?;
            Some(Emitter::Spot {
                position,
                direction,
                intensity: strength,
                cutoff: outer,
                beam_width: inner,
                falloff: SpotFalloff::SmoothCosine,
                projector: None,
            })
        }
        other => {
            let found = other.map_or("nothing".into(), |kind| format!("`{kind}`"));
            light.unexpected("type", found, "`directional`, `point` or `spot`");
            None
        }
    }
}

/// Half-angles of the inner and the outer cone of a spot in radians.
fn cone(light: &Json<'_>, dialect: Dialect) -> Option<(f32, f32)> {
    let spot = light.required_member("spot")?;
    let outer = spot.float("outerConeAngle", FRAC_PI_4);
    let inner = spot.float("innerConeAngle", 0.0);
    // Exporters write the limits with rounding.
    const ROUNDING: f32 = 1e-4;
    if !(outer > 0.0 && outer <= FRAC_PI_2 + ROUNDING) {
        spot.unexpected("outerConeAngle", outer, "an angle from 0 to π/2");
        return None;
    }
    if !(0.0..=outer + ROUNDING).contains(&inner) {
        let expected = format!("an angle from 0 to {outer}");
        spot.unexpected("innerConeAngle", inner, &expected);
        return None;
    }
    let inner = inner.min(outer);
    if !dialect.is_blender {
        return Some((inner, outer));
    }
    // The exporter writes (1 - blend) · outer. The falloff of a lamp takes the part `blend` of the
    // cosines of its cone.
    let blend = 1.0 - inner / outer;
    let cos = outer.cos() + (1.0 - outer.cos()) * blend;
    Some((cos.clamp(-1.0, 1.0).acos().min(outer), outer))
}
