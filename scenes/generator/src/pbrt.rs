//! PBRT v4 scene files, which refer to the meshes and textures of the Mitsuba files.
//!
//! Two things are written differently so that pictures agree: the base of a coat
//! ([`Coat::pbrt_base`]), and the cone of a spot ([`SpotLight::smooth_cutoff`]). Tinted metals
//! cannot be said: they become conductors of the same reflectance at normal incidence.

use crate::fresnel::Coat;
use crate::head;
use crate::material::{LinearRgb, Material, Metal, Reflectance};
use crate::png::PixelEncoding;
use crate::pose::Pose;
use crate::rounding::decimal;
use crate::scene::{Camera, MeshId, PlacedShape, Scene, ShapeKind, SpotLight};
use glam::DVec3;

/// Default samples per pixel of the generated scenes.
const DEFAULT_SPP: u32 = 64;

/// The text of a scene. Files are referred to as `meshes/NAME.ply` and `textures/NAME.png`.
pub fn encode(scene: &Scene) -> String {
    let mut text = String::from("# SPDX-License-Identifier: CC0-1.0\n");
    for line in head::lines(&scene.about) {
        text += format!("# {line}").trim_end();
        text += "\n";
    }
    push_camera(&mut text, &scene.camera);
    text += "\nWorldBegin\n\n";
    for (name, image) in &scene.textures {
        push_texture(&mut text, name, name, image.encoding);
    }
    for CoatedTexture { name, .. } in coated_textures(scene) {
        push_texture(&mut text, &name, &name, PixelEncoding::Srgb);
    }
    for (name, material) in &scene.materials {
        push_material(&mut text, name, material);
    }
    text += "\n";
    for spot in &scene.spots {
        push_spot(&mut text, spot);
    }
    for shape in &scene.shapes {
        push_shape(&mut text, scene, shape);
    }
    text
}

/// A texture of a base under a coat, for which PBRT needs other values.
pub(crate) struct CoatedTexture {
    pub(crate) name: String,
    /// Index of the base in the textures of the scene.
    pub(crate) base: usize,
    pub(crate) alpha: f64,
    pub(crate) ior: f64,
}

/// The textures of bases under coats.
pub(crate) fn coated_textures(scene: &Scene) -> Vec<CoatedTexture> {
    let mut found: Vec<CoatedTexture> = Vec::new();
    let mut bases = Vec::new();
    for (_, material) in &scene.materials {
        collect_coated(material, &mut bases);
    }
    for (texture, alpha, ior) in bases {
        let base = scene.textures.iter().position(|(name, _)| *name == texture);
        let name = coated_name(texture, alpha, ior);
        if let Some(base) = base
            && found.iter().all(|known| known.name != name)
        {
            found.push(CoatedTexture {
                name,
                base,
                alpha,
                ior,
            });
        }
    }
    found
}

fn collect_coated(material: &Material, bases: &mut Vec<(&'static str, f64, f64)>) {
    match material {
        Material::Coated {
            base: Reflectance::Texture(texture),
            alpha,
            ior,
        } => bases.push((texture, *alpha, *ior)),
        Material::Mixed { first, second, .. } => {
            collect_coated(first, bases);
            collect_coated(second, bases);
        }
        _ => {}
    }
}

/// Name of a texture with the values for a base under a coat.
fn coated_name(texture: &str, alpha: f64, ior: f64) -> String {
    format!("{texture}_coated_{}_{}", decimal(alpha), decimal(ior))
}

fn push_camera(text: &mut String, camera: &Camera) {
    let [width, height] = camera.size;
    // PBRT measures the field of view along the shorter edge, and its images are mirrored in a
    // right-handed world.
    let aspect = f64::from(width.min(height)) / f64::from(width);
    let fov = 2.0 * ((camera.fov_x.to_radians() / 2.0).tan() * aspect).atan();
    *text += &format!(
        "\nIntegrator \"path\" \"integer maxdepth\" {}\n\
         Sampler \"independent\" \"integer pixelsamples\" {DEFAULT_SPP}\n\
         PixelFilter \"gaussian\" \"float xradius\" 2 \"float yradius\" 2 \"float sigma\" 0.5\n\
         Film \"rgb\" \"integer xresolution\" {width} \"integer yresolution\" {height} \"string filename\" \"scene.exr\"\n\
         Scale -1 1 1\n\
         LookAt {}  {}  0 1 0\n\
         Camera \"perspective\" \"float fov\" {}\n",
        camera.max_depth - 1,
        list(camera.origin),
        list(camera.target),
        decimal(fov.to_degrees()),
    );
}

/// An image texture. PBRT's v grows upwards in images, that of the meshes downwards.
fn push_texture(text: &mut String, name: &str, file: &str, encoding: PixelEncoding) {
    let (kind, decoding) = match encoding {
        PixelEncoding::Srgb => ("spectrum", ""),
        PixelEncoding::Linear | PixelEncoding::LinearRgb => {
            ("float", " \"string encoding\" \"linear\"")
        }
    };
    *text += &format!(
        "Texture \"{name}\" \"{kind}\" \"imagemap\" \"string filename\" \"textures/{file}.png\"{decoding} \"float vscale\" -1 \"float vdelta\" 1\n"
    );
}

fn push_material(text: &mut String, name: &str, material: &Material) {
    if let Material::Mixed { first, second, .. } = material {
        push_material(text, &format!("{name}_first"), first);
        push_material(text, &format!("{name}_second"), second);
    }
    *text += &format!("MakeNamedMaterial \"{name}\" \"string type\" ");
    match material {
        Material::Diffuse(color) => {
            *text += "\"diffuse\"";
            push_reflectance(text, color, |value| value, |texture| texture.to_owned());
        }
        Material::Coated { base, alpha, ior } => {
            let coat = Coat::new(*alpha, *ior);
            *text += "\"coateddiffuse\"";
            let uniform = |value| coat.pbrt_base(value);
            push_reflectance(text, base, uniform, |texture| {
                coated_name(texture, *alpha, *ior)
            });
            *text += &format!(" \"float eta\" {}", decimal(*ior));
            push_roughness(text, *alpha);
        }
        Material::Metal { metal, alpha, tint } => {
            *text += "\"conductor\"";
            push_metal(text, *metal, *tint);
            push_roughness(text, *alpha);
        }
        Material::Glass { ior } => {
            *text += &format!("\"dielectric\" \"float eta\" {}", decimal(*ior))
        }
        Material::Mixed { weight, .. } => {
            *text += &format!(
                "\"mix\" \"string materials\" [ \"{name}_first\" \"{name}_second\" ] \"texture amount\" \"{weight}\""
            );
        }
    }
    *text += "\n";
}

/// The parameter `reflectance`: `uniform` converts a color, `texture` the name of a texture.
fn push_reflectance(
    text: &mut String,
    reflectance: &Reflectance,
    uniform: impl Fn(f64) -> f64,
    texture: impl Fn(&str) -> String,
) {
    *text += &match reflectance {
        Reflectance::Uniform(color) => rgb("reflectance", color.map(uniform)),
        Reflectance::Texture(name) => format!(" \"texture reflectance\" \"{}\"", texture(name)),
    };
}

fn push_metal(text: &mut String, metal: Metal, tint: LinearRgb) {
    if tint == [1.0; 3] {
        let [eta, k] = metal.index_of_refraction();
        *text += &(rgb("eta", eta) + &rgb("k", k));
    } else {
        let reflectance = metal.reflectance();
        *text += &rgb(
            "reflectance",
            std::array::from_fn(|c| reflectance[c] * tint[c]),
        );
    }
}

fn push_roughness(text: &mut String, alpha: f64) {
    *text += &format!(
        " \"float roughness\" {} \"bool remaproughness\" false",
        decimal(alpha)
    );
}

fn push_spot(text: &mut String, spot: &SpotLight) {
    let cutoff = spot.smooth_cutoff();
    *text += &format!(
        "LightSource \"spot\" \"point3 from\" [ {} ] \"point3 to\" [ {} ]{} \"float coneangle\" {} \"float conedeltaangle\" {}\n",
        list(spot.origin),
        list(spot.target),
        rgb("I", spot.intensity),
        decimal(cutoff),
        decimal(cutoff - spot.beam),
    );
}

fn push_shape(text: &mut String, scene: &Scene, shape: &PlacedShape) {
    *text += &format!("AttributeBegin # {}\n", shape.name);
    push_pose(text, &shape.pose);
    *text += &format!(
        "\tNamedMaterial \"{}\"\n",
        scene.materials[shape.material.0].0
    );
    if let Some(radiance) = shape.emission {
        *text += &format!("\tAreaLightSource \"diffuse\"{}\n", rgb("L", radiance));
    }
    *text += &match shape.kind {
        ShapeKind::Mesh(MeshId(i)) => {
            let name = &scene.meshes[i].0;
            format!("\tShape \"plymesh\" \"string filename\" \"meshes/{name}.ply\"\n")
        }
        ShapeKind::Rectangle => "\tShape \"trianglemesh\" \"integer indices\" [ 0 1 2 0 2 3 ] \
             \"point3 P\" [ -1 -1 0  1 -1 0  1 1 0  -1 1 0 ] \"point2 uv\" [ 0 0  1 0  1 1  0 1 ]\n"
            .to_owned(),
        ShapeKind::Sphere => "\tShape \"sphere\"\n".to_owned(),
    };
    *text += "AttributeEnd\n";
}

/// The transforms of a pose, the last one first, as PBRT applies them.
fn push_pose(text: &mut String, pose: &Pose) {
    if pose.position != DVec3::ZERO {
        *text += &format!("\tTranslate {}\n", list(pose.position));
    }
    for (axis, angle) in [
        ("0 1 0", pose.turn),
        ("1 0 0", pose.tilt),
        ("0 0 1", pose.roll),
    ] {
        let angle = decimal(angle);
        if angle != "0" {
            *text += &format!("\tRotate {angle} {axis}\n");
        }
    }
    if pose.scale != DVec3::ONE {
        *text += &format!("\tScale {}\n", list(pose.scale));
    }
}

/// ` "rgb NAME" [ R G B ]`
fn rgb(name: &str, color: LinearRgb) -> String {
    format!(" \"rgb {name}\" [ {} ]", color.map(decimal).join(" "))
}

fn list(v: DVec3) -> String {
    v.to_array().map(decimal).join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{coated, tinted_metal};
    use crate::testing::small_scene;

    #[test]
    fn a_shape_has_its_mesh_transform_and_material() {
        let text = encode(&small_scene());
        let expected = "AttributeBegin # box\n\tTranslate 1 0 0\n\tRotate 90 0 1 0\n\tScale 2 2 2\n\
            \tNamedMaterial \"copper\"\n\tShape \"plymesh\" \"string filename\" \"meshes/cube.ply\"\nAttributeEnd\n";
        assert!(text.contains(expected), "{text}");
        assert!(
            text.contains("\tAreaLightSource \"diffuse\" \"rgb L\" [ 3 2 1 ]\n"),
            "{text}"
        );
    }

    #[test]
    fn the_field_of_view_is_that_of_the_shorter_edge() {
        let text = encode(&small_scene());
        assert!(text.contains("\"float fov\" 30.53"), "{text}");
        assert!(text.contains("\"integer maxdepth\" 4"), "{text}");
    }

    #[test]
    fn coats_and_tinted_metals_are_converted() {
        let mut scene = small_scene();
        scene.add_material("gray", coated([0.5; 3], 0.2));
        scene.add_material("iron", tinted_metal(Metal::Chromium, 0.3, [0.5; 3]));
        let text = encode(&scene);
        // 0.5 / (1 - 0.486 + 0.5 · 0.486): gray bases lose more light in PBRT.
        assert!(
            text.contains("\"coateddiffuse\" \"rgb reflectance\" [ 0.66"),
            "{text}"
        );
        assert!(
            text.contains("\"conductor\" \"rgb reflectance\" [ 0."),
            "{text}"
        );
    }
}
