//! PBRT's scene format: version 4, and version 3 by its old names.
//!
//! Names, defaults and meanings are those of PBRT v4; `docs/formats/pbrt.md` lists what is read, approximated and refused. Loading has
//! four stages:
//!
//! 1. `lexer` and `parser` turn text into statements with source spans.
//! 2. `interpreter` runs the statements on the graphics state (`state`) and collects the declarations (`entities`).
//! 3. One module for each family (`materials`, `shapes`, ...) reads the parameters by `params` and fills a [`SceneDesc`].
//! 4. `assets` reads meshes and images in parallel; then values that depend on them are set.

mod cameras;
mod colors;
mod directives;
mod entities;
mod film;
mod interpreter;
mod lexer;
mod lights;
mod materials;
mod named_spectra;
mod param_types;
mod params;
mod parser;
mod shapes;
mod source;
mod state;
mod textures;
mod transforms;

use super::assets::Assets;
use super::growth::Growth;
use super::names::{ShapeNames, name_material};
use super::sink::{FileSpan, Problem, Sink, Text};
use super::{SupportedFamily, whole_file};
use crate::error::LoadErrorKind;
use crate::resolve::similar;
use colors::{ColorContext, ColorUse};
use entities::{Entities, Entity};
use interpreter::Interpreter;
use manylight::color::Rgb;
use manylight::ids::{MaterialId, TextureId};
use manylight::math::Affine3A;
use manylight::scene::{InstanceDesc, SceneDesc, check_textures};
use manylight::texture::{ColorInput, FloatInput};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

/// The supported plugins, by family, under the names of the families of `manylight list`.
pub(super) const SUPPORTED: &[SupportedFamily] = &[
    SupportedFamily {
        format: "pbrt",
        name: "bsdfs",
        plugins: materials::SUPPORTED,
    },
    SupportedFamily {
        format: "pbrt",
        name: "emitters",
        plugins: lights::SUPPORTED,
    },
    SupportedFamily {
        format: "pbrt",
        name: "shapes",
        plugins: shapes::SUPPORTED,
    },
    SupportedFamily {
        format: "pbrt",
        name: "textures",
        plugins: textures::SUPPORTED,
    },
    SupportedFamily {
        format: "pbrt",
        name: "sensors",
        plugins: cameras::SUPPORTED,
    },
    SupportedFamily {
        format: "pbrt",
        name: "filters",
        plugins: film::FILTERS,
    },
    SupportedFamily {
        format: "pbrt",
        name: "integrators",
        plugins: film::INTEGRATORS,
    },
];

/// Whether the file content starts like a PBRT scene: after comments, with a directive.
pub(super) fn is_scene(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty() && line[0] != b'#');
    let word = first.and_then(|line| line.split(u8::is_ascii_whitespace).next());
    word.and_then(|word| std::str::from_utf8(word).ok())
        .is_some_and(directives::is_directive)
}

/// The scene in the content `bytes` of the file `path`, without its invalid parts. `None` only if an error has been reported.
pub(super) fn load(path: &Path, bytes: Vec<u8>, sink: &Sink) -> Option<SceneDesc> {
    let text = match source::text_of(path, bytes, sink) {
        Ok(text) => text?,
        Err(what) => {
            let message = format!("cannot use the scene file {what}");
            sink.report(whole_file(
                "scene::unreadable",
                message,
                None,
                LoadErrorKind::Scene,
            ));
            return None;
        }
    };
    let Interpreter {
        entities,
        expansion,
        ..
    } = Interpreter::run(path, text, sink);
    let mut builder = Builder::new(sink, &entities, expansion.text_bytes());
    builder.scene(entities);
    Some(builder.load_assets())
}

/// What is done after all files have been read.
type Finish = Box<dyn FnOnce(&mut SceneDesc)>;

/// Fills a [`SceneDesc`] from the declarations of a scene.
struct Builder<'a> {
    sink: &'a Sink,
    /// Whether the scene uses names of PBRT v3.
    is_v3: bool,
    /// Factor of all emission: the imaging ratio of the film.
    film_scale: f32,
    desc: SceneDesc,
    assets: Assets,
    float_textures: HashMap<String, FloatInput>,
    spectrum_textures: HashMap<String, ColorInput>,
    /// Image textures by file and settings.
    bitmaps: HashMap<String, TextureId>,
    /// Roughness textures of PBRT v3 by their source.
    mapped_textures: HashMap<TextureId, TextureId>,
    /// Materials with a coat of the mean roughness of a texture.
    mean_coats: HashMap<TextureId, Rc<RefCell<Vec<MaterialId>>>>,
    named_materials: HashMap<String, MaterialId>,
    /// In the order of the `Material` directives.
    materials: Vec<MaterialId>,
    default_material: Option<MaterialId>,
    /// Materials behind opacities of shapes.
    masks: HashMap<(MaterialId, String), MaterialId>,
    shapes: shapes::ShapeCache,
    shape_names: ShapeNames,
    /// Meshes of surfaces that the files describe by some numbers.
    tessellated: Growth,
    /// Triangles of subdivision surfaces of many levels.
    finely_subdivided: usize,
    /// Environment maps that should be square, with the sizes that are found.
    square_maps: Vec<(FileSpan, Rc<Cell<[usize; 2]>>)>,
    finish: Vec<Finish>,
}

impl<'a> Builder<'a> {
    fn new(sink: &'a Sink, entities: &Entities, text_bytes: usize) -> Self {
        Builder {
            sink,
            is_v3: is_v3(entities),
            film_scale: 1.0,
            desc: SceneDesc::default(),
            assets: Assets::default(),
            float_textures: HashMap::new(),
            spectrum_textures: HashMap::new(),
            bitmaps: HashMap::new(),
            mapped_textures: HashMap::new(),
            mean_coats: HashMap::new(),
            named_materials: HashMap::new(),
            materials: Vec::new(),
            default_material: None,
            masks: HashMap::new(),
            shapes: shapes::ShapeCache::default(),
            shape_names: ShapeNames::default(),
            tessellated: Growth::new(text_bytes, shapes::TESSELLATED),
            finely_subdivided: 0,
            square_maps: Vec::new(),
            finish: Vec::new(),
        }
    }

    /// Adds all declarations.
    fn scene(&mut self, mut entities: Entities) {
        self.check_whole(&entities);
        self.desc.limits = self.limits(entities.integrator.as_ref());
        if let Some(camera) = &entities.camera {
            self.film_scale = self.imaging_ratio(camera, entities.film.as_ref());
            let film = self.film(entities.film.as_ref(), entities.filter.as_ref());
            self.camera(camera, film);
        }
        for texture in &entities.textures {
            self.texture(texture);
        }
        for named in &entities.named_materials {
            self.define_material(&named.name, &named.value);
        }
        for entity in &entities.materials {
            let material = self.material(entity, &entity.params.plugin);
            self.materials.push(material);
        }
        for light in &entities.lights {
            self.light(light);
        }
        // Each shape is dropped as soon as it has been read, because meshes are large.
        for shape in std::mem::take(&mut entities.shapes) {
            self.shape(&shape);
        }
        self.flush_curves();
        self.objects(&entities);
    }

    fn define_material(&mut self, name: &Text, entity: &Entity) {
        let Some(kind) = entity.params.required_string(self.sink, "type").cloned() else {
            entity.params.ignore_all();
            return;
        };
        let material = self.material(entity, &kind);
        name_material(&mut self.desc.material_names, material, &name.value);
        let former = self.named_materials.insert(name.value.clone(), material);
        if former.is_some() {
            let message = format!(
                "the material `{}` is defined twice; the last definition is used",
                name.value
            );
            let problem = Problem::new("scene::duplicate_id", name.span, message);
            self.sink.warn_once("material defined twice", problem);
        }
    }

    /// Adds the objects and their instances.
    fn objects(&mut self, entities: &Entities) {
        for object in &entities.objects {
            let primitives = self.group(&object.value);
            self.desc.groups.push(primitives);
        }
        for instance in &entities.instances {
            let name = &instance.object;
            let Some(group) = entities.object_ids.get(&name.value) else {
                let mut known: Vec<&str> = entities.object_ids.keys().map(String::as_str).collect();
                known.sort_unstable();
                let help =
                    similar(&name.value, known).map(|similar| format!("did you mean `{similar}`?"));
                let message = format!("no object has the name `{}`", name.value);
                let problem = Problem::new("scene::unresolved_reference", name.span, message);
                self.sink.error(problem.maybe_help(help));
                continue;
            };
            if let Some(world_from_group) = self.placement(instance.transform, name.span) {
                let name = self.shape_names.distinct(&name.value);
                self.desc.instances.push(InstanceDesc {
                    name,
                    group: *group,
                    world_from_group,
                });
            }
        }
    }

    /// Reports scenes without a camera or a light.
    fn check_whole(&self, entities: &Entities) {
        let Some(start) = entities.start else { return };
        if entities.camera.is_none() && !self.sink.has_errors() {
            let problem = Problem::new("scene::no_sensor", start, "the scene has no camera");
            let help = "add for example `Camera \"perspective\"` before `WorldBegin`";
            self.sink.error(problem.help(help));
        }
        let emits = entities
            .shapes
            .iter()
            .any(|shape| shape.area_light.is_some());
        if entities.lights.is_empty() && !emits && !self.sink.has_errors() {
            let message = "the scene has no light; its image will be black";
            self.sink
                .warn(Problem::new("scene::no_emitter", start, message));
        }
    }

    /// Reads all files and sets what depends on them.
    fn load_assets(mut self) -> SceneDesc {
        let assets = std::mem::take(&mut self.assets);
        assets.load(&mut self.desc, self.sink);
        self.check_square_maps();
        // What follows may evaluate textures.
        if let Err(error) = check_textures(&self.desc) {
            let problem = Problem::without_location("scene::too_deep", error.message);
            self.sink.error(problem);
        }
        if !self.sink.has_errors() {
            for finish in std::mem::take(&mut self.finish) {
                finish(&mut self.desc);
            }
        }
        self.desc
    }

    /// Defers a change of the description until all files have been read.
    fn after_loading(&mut self, finish: impl FnOnce(&mut SceneDesc) + 'static) {
        self.finish.push(Box::new(finish));
    }

    /// The color of a parameter that is not a texture.
    fn color(&self, entity: &Entity, name: &'static str, color_use: ColorUse) -> Option<Rgb> {
        let context = ColorContext {
            sink: self.sink,
            folders: &entity.folders,
            space: entity.color_space,
        };
        context.color(&entity.params, name, color_use)
    }

    /// Reports the parameters of `entity` that have not been read.
    fn finish(&self, entity: &Entity) {
        entity.params.finish(self.sink, self.is_v3);
    }

    /// The transform of an entity. Singular transforms are reported and replaced by the identity.
    fn world_from(&self, entity: &Entity) -> Affine3A {
        self.placement(entity.transform, entity.params.plugin.span)
            .unwrap_or(Affine3A::IDENTITY)
    }

    /// A transform in single precision. `None` if it is singular, which is reported at `span`.
    fn placement(&self, transform: glam::DMat4, span: FileSpan) -> Option<Affine3A> {
        let affine = Affine3A::from_mat4(transform.as_mat4());
        let inverse = glam::Mat3::from(affine.matrix3).as_dmat3().inverse();
        if affine.is_finite() && inverse.is_finite() {
            return Some(affine);
        }
        let message = "the current transform is singular or too large";
        self.sink
            .error(Problem::new("scene::bad_value", span, message));
        None
    }

    /// Reports that no plugin of the family has this name.
    fn unknown_plugin<'n>(&self, entity: &Entity, known: impl IntoIterator<Item = &'n str>) {
        let params = &entity.params;
        self.unknown_name(params.family, &params.plugin, known);
    }

    fn unknown_name<'n>(
        &self,
        family: &str,
        name: &Text,
        known: impl IntoIterator<Item = &'n str>,
    ) {
        let mut known: Vec<&str> = known.into_iter().collect();
        known.sort_unstable();
        let list = format!("known types: {}", known.join(", "));
        let help = match similar(&name.value, known) {
            Some(similar) => format!("did you mean `{similar}`? {list}"),
            None => list,
        };
        let message = format!("unknown {family} type `{}`", name.value);
        let problem = Problem::new("scene::unknown_plugin", name.span, message);
        self.sink.error(
            problem
                .label(format!("no {family} has this type"))
                .help(help),
        );
    }
}

/// Whether a scene uses names that only PBRT v3 has.
fn is_v3(entities: &Entities) -> bool {
    let plugin = |entity: &Option<Entity>, names: &[&str]| {
        let name = entity
            .as_ref()
            .map(|entity| entity.params.plugin.value.as_str());
        name.is_some_and(|name| names.contains(&name))
    };
    let old_samplers = ["02sequence", "lowdiscrepancy", "maxmindist", "random"];
    let named = entities.named_materials.iter().map(|named| &named.value);
    let kinds = named.filter_map(|entity| entity.params.kind());
    let kinds = kinds.chain(
        entities
            .materials
            .iter()
            .map(|m| m.params.plugin.value.as_str()),
    );
    plugin(&entities.film, &["image"])
        || plugin(&entities.sampler, &old_samplers)
        || plugin(&entities.integrator, &["directlighting", "whitted"])
        || kinds.into_iter().any(materials::is_v3_material)
        || entities
            .lights
            .iter()
            .any(|light| light.params.has("mapname"))
}
