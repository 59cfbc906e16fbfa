//! The arrays of a glTF document, and the check of its version and extensions.

use super::json::Json;
use super::origin::Origin;

/// The arrays of a document.
pub(super) struct Document<'a> {
    pub(super) root: Json<'a>,
    pub(super) accessors: Vec<Json<'a>>,
    pub(super) buffers: Vec<Json<'a>>,
    pub(super) views: Vec<Json<'a>>,
    pub(super) cameras: Vec<Json<'a>>,
    pub(super) images: Vec<Json<'a>>,
    pub(super) lights: Vec<Json<'a>>,
    pub(super) materials: Vec<Json<'a>>,
    pub(super) meshes: Vec<Json<'a>>,
    pub(super) nodes: Vec<Json<'a>>,
    pub(super) samplers: Vec<Json<'a>>,
    pub(super) scenes: Vec<Json<'a>>,
    pub(super) skins: Vec<Json<'a>>,
    pub(super) textures: Vec<Json<'a>>,
    /// The program that made the scene.
    pub(super) origin: Origin,
}

/// Extensions that a file may require: all that are read or approximated.
const SUPPORTED: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Extensions that are reported where they are used, with more to say than here.
const REPORTED_AT_USE: &[&str] = &[
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "EXT_texture_avif",
    "MSFT_texture_dds",
];

impl<'a> Document<'a> {
    /// The arrays of `root`. Versions and required extensions that are not supported are reported.
    pub(super) fn new(root: Json<'a>) -> Self {
        check_version(&root);
        check_extensions(&root);
        warn_of_extensions(&root);
        let lights = root.extension("KHR_lights_punctual");
        let lights = lights.map_or_else(Vec::new, |lights| lights.objects("lights"));
        Document {
            origin: Origin::of(&root, &lights),
            accessors: root.objects("accessors"),
            buffers: root.objects("buffers"),
            views: root.objects("bufferViews"),
            cameras: root.objects("cameras"),
            images: root.objects("images"),
            lights,
            materials: root.objects("materials"),
            meshes: root.objects("meshes"),
            nodes: root.objects("nodes"),
            samplers: root.objects("samplers"),
            scenes: root.objects("scenes"),
            skins: root.objects("skins"),
            textures: root.objects("textures"),
            root,
        }
    }

    /// Whether the file says that it uses the extension `name`.
    pub(super) fn uses(&self, name: &str) -> bool {
        let used = self.root.items("extensionsUsed");
        used.iter().any(|used| used.as_string() == Some(name))
    }

    /// Whether the exporter of Blender made the scene. It means some things in the way of Blender
    /// where the specification differs.
    pub(super) fn is_by_blender(&self) -> bool {
        self.origin == Origin::Blender
    }
}

fn check_version(root: &Json<'_>) {
    let Some(asset) = root.member("asset") else {
        if !root.has("asset") {
            root.error("the object `asset` with the version of glTF is missing");
        }
        return;
    };
    let name = if asset.has("minVersion") {
        "minVersion"
    } else {
        "version"
    };
    let Some(version) = asset.string(name) else {
        if !asset.has(name) {
            asset.error("the property `version` is missing");
        }
        return;
    };
    if version != "2.0" && !(name == "version" && version.starts_with("2.")) {
        let advice = if version.starts_with("1.") {
            "; export the scene again as glTF 2.0"
        } else {
            ""
        };
        asset.error_at(name, format!("found glTF {version}, expected 2.0{advice}"));
    }
}

/// Extensions without an effect on the picture of a scene at rest: metadata, behavior, less detail
/// at a distance.
const WITHOUT_EFFECT: &[&str] = &[
    "CESIUM_primitive_outline",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "FB_ngon_encoding",
    "GODOT_single_root",
    "KHR_animation_pointer",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "MSFT_lod",
    "MSFT_screencoverage",
];

/// Warns about extensions that are used, but not known here.
fn warn_of_extensions(root: &Json<'_>) {
    let known = [SUPPORTED, REPORTED_AT_USE, WITHOUT_EFFECT];
    for used in root.items("extensionsUsed") {
        let Some(name) = used.as_string() else {
            continue;
        };
        if !known.iter().any(|list| list.contains(&name)) {
            let message = format!("the extension `{name}` is ignored");
            used.warn_once(name, message);
        }
    }
}

fn check_extensions(root: &Json<'_>) {
    for required in root.items("extensionsRequired") {
        let Some(name) = required.as_string() else {
            continue;
        };
        let known = [SUPPORTED, REPORTED_AT_USE, WITHOUT_EFFECT];
        if known.iter().any(|list| list.contains(&name)) {
            continue;
        }
        // Names of extensions are exact: a similar one is another feature.
        let help = format!("supported extensions: {}", SUPPORTED.join(", "));
        let message = format!("the file requires the extension `{name}`, which is not supported");
        let reporter = required.reporter();
        reporter.error_with_help(required.path(), &message, help);
    }
}
