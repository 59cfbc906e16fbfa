//! Renaming of objects in files of version 0.x to the names of version 3: camelCase becomes
//! snake_case, renamed plugins and parameters get their current names, and offset and scale of a
//! texture become a transform.

use super::super::sink::Text;
use super::family::PluginFamily;
use super::object::{Object, Param};
use super::values::Value;
use super::xml::Dialect;
use glam::{DMat4, DVec3};

/// The current name of a plugin.
fn current_plugin(family: PluginFamily, old: &str) -> Option<&'static str> {
    Some(match (family, old) {
        (PluginFamily::Bsdf, "lambertian") => "diffuse",
        (PluginFamily::Bsdf, "bump") => "bumpmap",
        (PluginFamily::Bsdf, "roughglass") => "roughdielectric",
        (PluginFamily::Bsdf, "roughmetal") => "roughconductor",
        (PluginFamily::Film, "exrfilm") => "hdrfilm",
        (PluginFamily::Film, "pngfilm") => "ldrfilm",
        (PluginFamily::Texture, "ldrtexture" | "exrtexture") => "bitmap",
        (PluginFamily::Integrator, "pathtracer") => "path",
        _ => return None,
    })
}

/// The current name of a parameter with this name in snake_case of a plugin with a current name.
fn current_parameter(family: PluginFamily, plugin: &str, old: &str) -> Option<&'static str> {
    Some(match (family, plugin, old) {
        (PluginFamily::Bsdf, "diffuse" | "roughdiffuse", "diffuse_reflectance") => "reflectance",
        (PluginFamily::Emitter, "area" | "constant", "intensity") => "radiance",
        (PluginFamily::Emitter, "directional", "intensity") => "irradiance",
        (PluginFamily::Emitter, "envmap", "intensity_scale") => "scale",
        (PluginFamily::Filter, "mitchell", "b") => "B",
        (PluginFamily::Filter, "mitchell", "c") => "C",
        _ => return None,
    })
}

/// Renames an object of a 0.x file; objects of later versions are unchanged.
pub(super) fn upgrade(object: &mut Object) {
    if object.dialect != Dialect::V0 {
        return;
    }
    let family = object.family;
    if let Some(current) = current_plugin(family, &object.plugin.value) {
        object.plugin.value = current.to_owned();
    }
    for param in &mut object.params {
        let name = snake_case(&param.name.value);
        let current = current_parameter(family, &object.plugin.value, &name);
        param.name.value = current.map_or(name, str::to_owned);
    }
    if family == PluginFamily::Texture {
        combine_uv_transform(object);
    }
}

/// `toWorld` becomes `to_world`, `intIOR` becomes `int_ior`.
fn snake_case(name: &str) -> String {
    let mut result = String::with_capacity(name.len() + 4);
    let mut previous = ' ';
    for c in name.chars() {
        if c.is_ascii_uppercase() && previous.is_ascii_lowercase() {
            result.push('_');
        }
        let in_capitals = c.is_ascii_uppercase()
            && (previous.is_ascii_lowercase() || previous.is_ascii_uppercase());
        result.push(if in_capitals {
            c.to_ascii_lowercase()
        } else {
            c
        });
        previous = c;
    }
    result
}

/// Replaces `uoffset`, `voffset`, `uscale` and `vscale` by `to_uv`. The offset is applied before
/// the scale, as in Mitsuba's own upgrade.
fn combine_uv_transform(object: &mut Object) {
    let mut offset = DVec3::ZERO;
    let mut scale = DVec3::ONE;
    let mut span = None;
    object.params.retain(|param| {
        let target = match param.name.value.as_str() {
            "uoffset" => &mut offset.x,
            "voffset" => &mut offset.y,
            "uscale" => &mut scale.x,
            "vscale" => &mut scale.y,
            _ => return true,
        };
        match param.value {
            Value::Float(value) => *target = value,
            Value::Integer(value) => *target = value as f64,
            _ => return true,
        }
        span = Some(param.span);
        false
    });
    if let Some(span) = span {
        let value = Value::Transform(DMat4::from_scale(scale) * DMat4::from_translation(offset));
        object.params.push(Param {
            name: Text {
                value: "to_uv".to_owned(),
                span,
            },
            value,
            span,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn camel_case_becomes_snake_case() {
        for (old, new) in [
            ("toWorld", "to_world"),
            ("intIOR", "int_ior"),
            ("alphaU", "alpha_u"),
            ("maxDepth", "max_depth"),
            ("to_world", "to_world"),
            ("extEta", "ext_eta"),
            ("B", "B"),
        ] {
            assert_eq!(snake_case(old), new);
        }
    }
}
