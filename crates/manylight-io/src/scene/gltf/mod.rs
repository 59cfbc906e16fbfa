//! glTF 2.0: JSON text (`.gltf`) and binary files (`.glb`).
//!
//! What is read, approximated and refused: `docs/formats/gltf.md`. Loading has these stages:
//!
//! 1. `container` splits the file, `json` gives values with their paths, `document` the arrays of
//!    the file, `origin` the program that made it.
//! 2. `buffers` reads the binary data; `accessors` reads typed arrays, checked against the sizes of
//!    the data.
//! 3. `nodes` places meshes, cameras and lights; `animations` moves cameras. `meshes` makes shapes of `primitives`, deformed by
//!    `deform`, with `tangents`.
//! 4. `materials`, by `material_reader`, `scattering`, `extensions`, `glass`, `specular_glossiness`
//!    and `textures`, maps materials to those of the renderer; `images` decodes images in parallel.
//!
//! Sources: "glTF 2.0 Specification" and its extensions, Khronos Group.

mod accessors;
mod animations;
mod buffers;
mod cameras;
mod compressed_primitives;
mod compressed_views;
mod container;
mod deform;
mod document;
mod emission;
mod environment;
mod extensions;
mod glass;
mod images;
mod json;
mod lights;
mod locate;
mod material_reader;
mod materials;
mod meshes;
mod nodes;
mod origin;
mod primitives;
mod report;
mod scattering;
mod specular_glossiness;
mod tangents;
mod textures;
mod uri;

pub(super) use container::MAGIC;

use super::names::name_light_group;
use super::options::LoadOptions;
use super::sink::Sink;
use crate::error::LoadErrorKind;
use crate::file_error::Fault;
use accessors::{Accessors, Decoded};
use animations::CameraAnimations;
use buffers::Buffers;
use container::Container;
use document::Document;
use glam::DMat4;
use json::Json;
use lights::Dialect;
use manylight::bsdf::Material;
use manylight::emitters::Emitter;
use manylight::ids::TextureId;
use manylight::image::Image;
use manylight::scene::SceneDesc;
use manylight::sensors::SensorDesc;
use manylight::texture::{ColorInput, FloatInput, Texture};
use materials::chosen_variant;
use meshes::Meshes;
use nodes::{Hierarchy, PlacedNode};
use report::Reporter;
use std::collections::HashMap;
use std::path::Path;

/// The scene in `bytes`, the content of `path`, without its invalid parts. `None` only if an error
/// has been reported.
pub(super) fn load(
    path: &Path,
    bytes: &[u8],
    options: &LoadOptions,
    sink: &Sink,
) -> Option<SceneDesc> {
    let (container, text, value) = match parse(bytes) {
        Ok(parts) => parts,
        Err(fault) => {
            let message = format!("cannot use the glTF file {}", fault.in_file(path));
            sink.file_error("gltf::container", message, None, LoadErrorKind::Scene);
            return None;
        }
    };
    let reporter = Reporter::new(path, text, container.is_binary, sink);
    let root = Json::root(&value, &reporter);
    let document = Document::new(root);
    // What the file requires decides whether its other parts can be understood.
    if reporter.has_errors() {
        return None;
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let buffers = Buffers::read(&document, container.data, folder);
    let accessors = Accessors {
        document: &document,
        buffers: &buffers,
        quantized: document.uses("KHR_mesh_quantization"),
        decoded: Decoded::default(),
    };
    let mut builder = Builder {
        document: &document,
        options,
        desc: SceneDesc::default(),
        meshes: Meshes::new(accessors, chosen_variant(&document.root, &options.gltf)),
    };
    builder.scene();
    let Builder {
        mut desc, meshes, ..
    } = builder;
    let mut textures = meshes.into_parts(&mut desc);
    let images = std::mem::take(&mut textures.images);
    images.load(&document, &buffers, folder, &mut textures.list);
    desc.textures = textures.list;
    fill_missing(&mut desc.textures);
    let first = desc.emitters.len();
    environment::add(&mut desc, &document.root, &options.gltf);
    name_light_group(&mut desc, first, Some(ENVIRONMENT_GROUP));
    drop_full_masks(&mut desc);
    if desc.sensors.is_empty() {
        desc.sensors.push(cameras::framing(meshes::bounds(&desc)));
    }
    Some(desc)
}

/// Name of the light group of the environment, which glTF files do not have.
const ENVIRONMENT_GROUP: &str = "environment";

/// The parts of a file, its JSON text, and the value of the text.
fn parse(bytes: &[u8]) -> Result<(Container<'_>, &str, serde_json::Value), Fault> {
    let container = Container::new(bytes)?;
    let text = std::str::from_utf8(container.json).map_err(|error| {
        let offset = error.valid_up_to();
        Fault::new(format!(
            "the JSON text is not UTF-8: invalid byte at offset {offset}"
        ))
    })?;
    let value = serde_json::from_str(text).map_err(|error| {
        let what = error.to_string();
        let what = what.split(" at line ").next().unwrap_or_default();
        let message = format!("malformed JSON: {what}");
        Fault::at(error.line() as u32, error.column() as u32, message)
    })?;
    Ok((container, text, value))
}

/// Replaces images that could not be decoded by one black pixel. The errors have been reported.
fn fill_missing(textures: &mut [Texture]) {
    for texture in textures {
        if let Texture::Bitmap(bitmap) = texture
            && bitmap.image.data.is_empty()
        {
            bitmap.image = Image::new(1, 1, 1);
        }
    }
}

/// Replaces masks of opacity 1 everywhere by the masked material, and radiance with this opacity by
/// that of the opaque surface: they are faster.
fn drop_full_masks(desc: &mut SceneDesc) {
    // Each image is read once, whatever number of materials has it.
    let mut full: HashMap<TextureId, bool> = HashMap::new();
    let textures = &desc.textures;
    let mut is_full = |opacity: FloatInput| match opacity {
        FloatInput::Constant(_) => false,
        FloatInput::Texture(id) => *full.entry(id).or_insert_with(|| is_one(textures, id)),
    };
    for i in 0..desc.materials.len() {
        if let Material::Mask { opacity, inner } = desc.materials[i]
            && is_full(opacity)
        {
            desc.materials[i] = desc.materials[inner.index()].clone();
        }
    }
    for emitter in &mut desc.emitters {
        if let Emitter::Area { radiance } = emitter
            && let ColorInput::Texture(id) = *radiance
            && let Texture::Mix { second, weight, .. } = textures[id.index()]
            && is_full(weight)
        {
            *radiance = second;
        }
    }
}

/// Whether a texture has the value 1 or more everywhere.
fn is_one(textures: &[Texture], id: TextureId) -> bool {
    least(textures, id).is_some_and(|least| least >= 1.0)
}

/// Lower bound of an opacity; `None` for textures of other kinds than the reader makes of it.
fn least(textures: &[Texture], id: TextureId) -> Option<f32> {
    let of_input = |input: &ColorInput| match *input {
        ColorInput::Constant(color) => Some(color.r),
        ColorInput::Texture(id) => least(textures, id),
    };
    match &textures[id.index()] {
        Texture::Transformed { inner, .. } | Texture::OtherUv { inner, .. } => {
            least(textures, *inner)
        }
        Texture::Bitmap(bitmap) => bitmap.image.data.iter().copied().reduce(f32::min),
        Texture::VertexColors(opacities) => opacities.values.iter().map(|v| v.r).reduce(f32::min),
        Texture::Product { first, second } => {
            let factors = [of_input(first)?, of_input(second)?];
            Some(factors[0] * factors[1]).filter(|_| factors.iter().all(|v| *v >= 0.0))
        }
        Texture::Step { base, threshold } => {
            let is_full = least(textures, *base)? >= *threshold;
            Some(if is_full { 1.0 } else { 0.0 })
        }
        _ => None,
    }
}

/// Fills a [`SceneDesc`] from a document.
struct Builder<'a, 'b> {
    document: &'b Document<'a>,
    options: &'b LoadOptions,
    desc: SceneDesc,
    meshes: Meshes<'a, 'b>,
}

impl<'a> Builder<'a, '_> {
    fn scene(&mut self) {
        let hierarchy = Hierarchy::new(self.document);
        let animations = CameraAnimations::read(&hierarchy, self.meshes.accessors());
        self.meshes.count_uses(&hierarchy);
        for (index, node) in hierarchy.nodes.iter().enumerate() {
            self.light(node);
            self.camera(node, |fps| animations.frames(&hierarchy, node.index, fps));
            self.meshes.add_node(index, &hierarchy, &mut self.desc);
        }
    }

    fn light(&mut self, node: &PlacedNode<'a>) {
        let Some(extension) = node.json.extension("KHR_lights_punctual") else {
            return;
        };
        let lights = &self.document.lights;
        let Some(index) = extension.index("light", "lights", lights.len()) else {
            return;
        };
        let dialect = Dialect::new(self.document.origin, self.options.gltf.light_units);
        dialect.warn_of_units(&lights[index]);
        let emitter = lights::emitter(&lights[index], &node.world_from_node, dialect);
        let first = self.desc.emitters.len();
        self.desc.emitters.extend(emitter);
        let group = node.light_group().or_else(|| node.json.string("name"));
        name_light_group(&mut self.desc, first, group);
    }

    /// Adds the camera of a node, which `frames` moves.
    fn camera(&mut self, node: &PlacedNode<'a>, frames: impl FnOnce(f32) -> Vec<DMat4>) {
        let cameras = &self.document.cameras;
        let Some(index) = node.json.index("camera", "cameras", cameras.len()) else {
            return;
        };
        let camera = &cameras[index];
        let name = node.json.string("name").or_else(|| camera.string("name"));
        let name = name.unwrap_or_default();
        let at = |world_from_node: &DMat4| cameras::sensor(camera, name, world_from_node);
        self.desc
            .sensors
            .extend(at(&node.world_from_node).map(|sensor| {
                let frames = frames(self.options.fps);
                let motion = frames
                    .iter()
                    .filter_map(at)
                    .map(|sensor| sensor.world_from_camera);
                SensorDesc {
                    motion: motion.collect(),
                    ..sensor
                }
            }));
    }
}
