//! Mitsuba 3 scene files.

use crate::head;
use crate::material::{LinearRgb, Material, Metal, Reflectance};
use crate::png::PixelEncoding;
use crate::pose::Pose;
use crate::rounding::decimal;
use crate::scene::{Camera, MeshId, PlacedShape, Scene, ShapeKind, SpotLight};
use glam::DVec3;

/// Default samples per pixel of the generated scenes.
const DEFAULT_SPP: u32 = 64;

/// The XML of a scene. Files are referred to as `meshes/NAME.ply` and `textures/NAME.png`.
pub fn encode(scene: &Scene) -> String {
    let mut xml = Xml::default();
    xml.text += "<!-- SPDX-License-Identifier: CC0-1.0 -->\n";
    push_head(&mut xml.text, scene);
    xml.open("scene", &[("version", "3.0.0")]);
    push_camera(&mut xml, &scene.camera);
    for (name, material) in &scene.materials {
        push_material(&mut xml, scene, &[("id", name)], material);
    }
    for (i, spot) in scene.spots.iter().enumerate() {
        push_spot(&mut xml, i, spot);
    }
    for shape in &scene.shapes {
        push_shape(&mut xml, scene, shape);
    }
    xml.close("scene");
    xml.text
}

/// Indented XML text.
#[derive(Default)]
struct Xml {
    text: String,
    depth: usize,
}

impl Xml {
    /// Adds a start tag that ends with `end`.
    fn line(&mut self, name: &str, attributes: &[(&str, &str)], end: &str) {
        self.text += &"\t".repeat(self.depth);
        self.text += &format!("<{name}");
        for (key, value) in attributes {
            self.text += &format!(" {key}=\"{value}\"");
        }
        self.text += end;
    }

    fn open(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.line(name, attributes, ">\n");
        self.depth += 1;
    }

    fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.text += &format!("{}</{name}>\n", "\t".repeat(self.depth));
    }

    fn leaf(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.line(name, attributes, " />\n");
    }

    /// `<kind name="name" value="value" />`
    fn value(&mut self, kind: &str, name: &str, value: &str) {
        self.leaf(kind, &[("name", name), ("value", value)]);
    }
}

/// The comment with the title and description.
fn push_head(text: &mut String, scene: &Scene) {
    *text += "<!--\n";
    for line in head::lines(&scene.about) {
        let indent = if line.is_empty() { "" } else { "  " };
        *text += &format!("{indent}{line}\n");
    }
    *text += "-->\n";
}

fn push_camera(xml: &mut Xml, camera: &Camera) {
    let defaults = [
        ("spp", DEFAULT_SPP),
        ("width", camera.size[0]),
        ("height", camera.size[1]),
        ("max_depth", camera.max_depth),
    ];
    for (name, value) in defaults {
        xml.value("default", name, &value.to_string());
    }
    xml.open("integrator", &[("type", "path")]);
    xml.value("integer", "max_depth", "$max_depth");
    xml.close("integrator");

    xml.open("sensor", &[("type", "perspective")]);
    xml.value("string", "fov_axis", "x");
    xml.value("float", "fov", &decimal(camera.fov_x));
    xml.open("transform", &[("name", "to_world")]);
    let (origin, target) = (list(camera.origin), list(camera.target));
    xml.leaf(
        "lookat",
        &[("origin", &origin), ("target", &target), ("up", "0, 1, 0")],
    );
    xml.close("transform");
    xml.open("sampler", &[("type", "independent")]);
    xml.value("integer", "sample_count", "$spp");
    xml.close("sampler");
    xml.open("film", &[("type", "hdrfilm")]);
    xml.value("integer", "width", "$width");
    xml.value("integer", "height", "$height");
    xml.value("string", "pixel_format", "rgb");
    xml.leaf("rfilter", &[("type", "gaussian")]);
    xml.close("film");
    xml.close("sensor");
}

fn push_material(xml: &mut Xml, scene: &Scene, attributes: &[(&str, &str)], material: &Material) {
    // The plugins reflect on one side only. Glass has two sides by itself, and `twosided` rejects
    // it.
    let one_sided = !matches!(material, Material::Glass { .. });
    if one_sided {
        xml.open("bsdf", &[&[("type", "twosided")], attributes].concat());
        push_plugin(xml, scene, &[], material);
        xml.close("bsdf");
    } else {
        push_plugin(xml, scene, attributes, material);
    }
}

fn push_plugin(xml: &mut Xml, scene: &Scene, attributes: &[(&str, &str)], material: &Material) {
    let kind = match material {
        Material::Diffuse(_) => "diffuse",
        Material::Coated { .. } => "roughplastic",
        Material::Metal { .. } => "roughconductor",
        Material::Glass { .. } => "dielectric",
        Material::Mixed { .. } => "blendbsdf",
    };
    xml.open("bsdf", &[&[("type", kind)], attributes].concat());
    match material {
        Material::Diffuse(color) => push_reflectance(xml, scene, "reflectance", color),
        Material::Coated { base, alpha, ior } => {
            push_reflectance(xml, scene, "diffuse_reflectance", base);
            xml.value("float", "int_ior", &decimal(*ior));
            push_roughness(xml, *alpha);
        }
        Material::Metal { metal, alpha, tint } => {
            push_metal(xml, *metal);
            if *tint != [1.0; 3] {
                xml.value("rgb", "specular_reflectance", &rgb(*tint));
            }
            push_roughness(xml, *alpha);
        }
        Material::Glass { ior } => {
            xml.value("float", "int_ior", &decimal(*ior));
            xml.value("float", "ext_ior", "1");
        }
        Material::Mixed {
            first,
            second,
            weight,
        } => {
            push_texture(xml, scene, "weight", weight);
            push_plugin(xml, scene, &[], first);
            push_plugin(xml, scene, &[], second);
        }
    }
    xml.close("bsdf");
}

fn push_roughness(xml: &mut Xml, alpha: f64) {
    xml.value("float", "alpha", &decimal(alpha));
    xml.value("string", "distribution", "ggx");
}

fn push_reflectance(xml: &mut Xml, scene: &Scene, name: &str, reflectance: &Reflectance) {
    match reflectance {
        Reflectance::Uniform(color) => xml.value("rgb", name, &rgb(*color)),
        Reflectance::Texture(texture) => push_texture(xml, scene, name, texture),
    }
}

fn push_texture(xml: &mut Xml, scene: &Scene, name: &str, texture: &str) {
    xml.open("texture", &[("type", "bitmap"), ("name", name)]);
    xml.value("string", "filename", &format!("textures/{texture}.png"));
    let image = scene.textures.iter().find(|(name, _)| *name == texture);
    if image.is_some_and(|(_, image)| image.encoding == PixelEncoding::Linear) {
        xml.value("boolean", "raw", "true");
    }
    xml.close("texture");
}

/// The index of refraction: by name where Mitsuba has measured data, otherwise as RGB.
fn push_metal(xml: &mut Xml, metal: Metal) {
    let name = match metal {
        Metal::Aluminium => "Al",
        Metal::Chromium => "Cr",
        Metal::Copper => "Cu",
        Metal::Silver => "Ag",
        Metal::Brass | Metal::Bronze => "",
    };
    if !name.is_empty() {
        return xml.value("string", "material", name);
    }
    let [eta, k] = metal.index_of_refraction();
    xml.value("rgb", "eta", &rgb(eta));
    xml.value("rgb", "k", &rgb(k));
}

fn push_spot(xml: &mut Xml, i: usize, spot: &SpotLight) {
    xml.open(
        "emitter",
        &[("type", "spot"), ("id", &format!("light_{i}"))],
    );
    xml.open("transform", &[("name", "to_world")]);
    let (origin, target) = (list(spot.origin), list(spot.target));
    let up = beam_up(spot.target - spot.origin);
    xml.leaf(
        "lookat",
        &[("origin", &origin), ("target", &target), ("up", up)],
    );
    xml.close("transform");
    xml.value("rgb", "intensity", &rgb(spot.intensity));
    xml.value("float", "cutoff_angle", &decimal(spot.cutoff));
    xml.value("float", "beam_width", &decimal(spot.beam));
    xml.close("emitter");
}

/// An up vector for a spot light that is not parallel to its axis.
fn beam_up(direction: DVec3) -> &'static str {
    if direction.x.abs() < 0.7 * direction.length() {
        "1, 0, 0"
    } else {
        "0, 1, 0"
    }
}

fn push_shape(xml: &mut Xml, scene: &Scene, shape: &PlacedShape) {
    let kind = match shape.kind {
        ShapeKind::Mesh(_) => "ply",
        ShapeKind::Rectangle => "rectangle",
        ShapeKind::Sphere => "sphere",
    };
    xml.open("shape", &[("type", kind), ("id", &shape.name)]);
    if let ShapeKind::Mesh(MeshId(i)) = shape.kind {
        let name = &scene.meshes[i].0;
        xml.value("string", "filename", &format!("meshes/{name}.ply"));
    }
    push_pose(xml, &shape.pose);
    xml.leaf("ref", &[("id", &scene.materials[shape.material.0].0)]);
    if let Some(radiance) = shape.emission {
        xml.open("emitter", &[("type", "area")]);
        xml.value("rgb", "radiance", &rgb(radiance));
        xml.close("emitter");
    }
    xml.close("shape");
}

fn push_pose(xml: &mut Xml, pose: &Pose) {
    if *pose == Pose::identity() {
        return;
    }
    xml.open("transform", &[("name", "to_world")]);
    let [x, y, z] = pose.scale.to_array().map(decimal);
    if x == y && y == z {
        if x != "1" {
            xml.leaf("scale", &[("value", &x)]);
        }
    } else {
        xml.leaf("scale", &[("x", &x), ("y", &y), ("z", &z)]);
    }
    for (axis, angle) in [("z", pose.roll), ("x", pose.tilt), ("y", pose.turn)] {
        let angle = decimal(angle);
        if angle != "0" {
            xml.leaf("rotate", &[(axis, "1"), ("angle", &angle)]);
        }
    }
    if pose.position != DVec3::ZERO {
        let [x, y, z] = pose.position.to_array().map(decimal);
        xml.leaf("translate", &[("x", &x), ("y", &y), ("z", &z)]);
    }
    xml.close("transform");
}

fn rgb(color: LinearRgb) -> String {
    color.map(decimal).join(", ")
}

fn list(v: DVec3) -> String {
    v.to_array().map(decimal).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::small_scene;

    #[test]
    fn a_shape_has_its_mesh_transform_and_material() {
        let text = encode(&small_scene());
        let expected = r#"	<shape type="ply" id="box">
		<string name="filename" value="meshes/cube.ply" />
		<transform name="to_world">
			<scale value="2" />
			<rotate y="1" angle="90" />
			<translate x="1" y="0" z="0" />
		</transform>
		<ref id="copper" />
	</shape>
"#;
        assert!(text.contains(expected), "{text}");
    }

    #[test]
    fn a_lamp_emits_and_the_identity_transform_is_omitted() {
        let text = encode(&small_scene());
        let expected = r#"	<shape type="rectangle" id="lamp">
		<ref id="black" />
		<emitter type="area">
			<rgb name="radiance" value="3, 2, 1" />
		</emitter>
	</shape>
"#;
        assert!(text.contains(expected), "{text}");
    }
}
