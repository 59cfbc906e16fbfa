//! PBRT's scene format: version 4, and version 3 by its old names.
//!
//! Names, defaults and meanings are those of PBRT v4; `docs/formats/pbrt.md` lists what is read,
//! approximated and refused. Loading has four stages:
//!
//! 1. `lexer` and `parser` turn text into statements with source spans.
//! 2. `interpreter` runs the statements on the graphics state (`state`) and collects the
//!    declarations (`entities`).
//! 3. One module for each family (`materials`, `shapes`, ...) reads the parameters by `params` and
//!    fills the [`SceneDesc`] of `builder`.
//! 4. `assets` reads meshes and images in parallel; then values that depend on them are set.

mod bindings;
mod builder;
mod cameras;
mod colors;
mod directives;
mod elements;
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

use super::names::name_material;
use super::parameters::{Parameters, unresolved};
use super::plugins::{SupportedFamily, families};
use super::sink::{Problem, Sink, Text};
use crate::error::LoadErrorKind;
use builder::Builder;
use entities::{Entities, Entity, WrongBlock};
use film::film_scale;
use interpreter::Interpreter;
use manylight::scene::{InstanceDesc, SceneDesc, check_textures};
use std::path::Path;

/// The supported plugins, by family, under the names of the families of `manylight list`.
pub(super) static SUPPORTED: [SupportedFamily; 7] = families(
    "pbrt",
    [
        ("bsdfs", materials::SUPPORTED),
        ("emitters", lights::SUPPORTED),
        ("shapes", shapes::SUPPORTED),
        ("textures", textures::SUPPORTED),
        ("sensors", cameras::SUPPORTED),
        ("filters", film::FILTERS),
        ("integrators", film::INTEGRATORS),
    ],
);

/// Whether the file content starts like a PBRT scene: after comments, with a directive.
pub(super) fn is_scene(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty() && line[0] != b'#');
    let word = first.and_then(|line| line.split(u8::is_ascii_whitespace).next());
    word.and_then(|word| std::str::from_utf8(word).ok())
        .is_some_and(directives::is_directive)
}

/// The scene in the content `bytes` of the file `path`, without its invalid parts; cameras move at
/// `fps` frames per second. `None` only if an error has been reported.
pub(super) fn load(path: &Path, bytes: Vec<u8>, fps: f32, sink: &Sink) -> Option<SceneDesc> {
    let text = match source::text_of(path, bytes, sink) {
        Ok(text) => text?,
        Err(what) => {
            let message = format!("cannot use the scene file {what}");
            sink.file_error("scene::unreadable", message, None, LoadErrorKind::Scene);
            return None;
        }
    };
    let Interpreter {
        entities,
        expansion,
        ..
    } = Interpreter::run(path, text, sink);
    let mut builder = Builder::new(sink, is_v3(&entities), expansion.text_bytes());
    builder.fps = fps;
    builder.scene(entities);
    Some(builder.load_assets())
}

impl Builder<'_> {
    /// Adds all declarations.
    fn scene(&mut self, mut entities: Entities<'_>) {
        self.check_blocks(std::mem::take(&mut entities.wrong_blocks));
        self.check_whole(&entities);
        self.bindings = std::mem::take(&mut entities.bindings);
        self.desc.limits = self.limits(entities.integrator.as_ref());
        if let Some(camera) = &entities.camera {
            self.film_scale = self.imaging_ratio(camera, entities.film.as_ref());
            self.film_scale *= film_scale(entities.film.as_ref());
            let film = self.film(entities.film.as_ref(), entities.filter.as_ref());
            let times = entities.motion_times.unwrap_or([0.0, 1.0]);
            let motion = entities.camera_at_end.map(|at_end| (at_end, times));
            self.camera(camera, motion, film);
        }
        for texture in &entities.textures {
            self.texture(texture);
        }
        for named in &entities.named_materials {
            self.define_material(&named.name, &named.value);
        }
        for entity in &entities.materials {
            let material = self.material(entity, &entity.params.plugin);
            self.made.materials.push(material);
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

    fn define_material(&mut self, name: &Text, entity: &Entity<'_>) {
        let index = self.made.named_materials.len();
        let Some(kind) = entity.params.required_string("type") else {
            entity.params.ignore_all();
            self.made.named_materials.push(None);
            return;
        };
        let material = self.material(entity, kind);
        name_material(&mut self.desc.material_names, material, &name.value);
        self.made.named_materials.push(Some(material));
        let names = &mut self.made.material_names;
        if names.insert(name.value.clone(), index).is_some() && !self.is_v3 {
            self.defined_twice("material", name);
        }
    }

    /// Reports wrong ends of blocks: errors in PBRT v4, of which PBRT v3 reads some and passes the
    /// others over.
    fn check_blocks(&self, wrong: Vec<WrongBlock>) {
        for WrongBlock {
            problem,
            is_valid_in_v3,
        } in wrong
        {
            if !self.is_v3 {
                self.sink.error(problem);
            } else if !is_valid_in_v3 {
                self.sink.warn(problem);
            }
        }
    }

    /// Adds the objects and their instances.
    fn objects(&mut self, entities: &Entities<'_>) {
        for object in &entities.objects {
            let primitives = self.group(&object.value);
            self.desc.groups.push(primitives);
        }
        for instance in &entities.instances {
            let name = &instance.object;
            let Some(group) = entities.object_ids.get(&name.value) else {
                let message = format!("no object has the name `{}`", name.value);
                let known = entities.object_ids.keys().map(String::as_str);
                self.sink.error(unresolved(name, message, known));
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
    fn check_whole(&self, entities: &Entities<'_>) {
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
        self.check_gray_colors();
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
}

/// Whether a scene is one of PBRT v3: by names that only PBRT v3 has, or by an end of the world
/// without names of PBRT v4.
fn is_v3(entities: &Entities<'_>) -> bool {
    let plugin = |entity: &Option<Entity<'_>>, names: &[&str]| {
        let name = entity
            .as_ref()
            .map(|entity| entity.params.plugin.value.as_str());
        name.is_some_and(|name| names.contains(&name))
    };
    let old_samplers = ["02sequence", "lowdiscrepancy", "maxmindist", "random"];
    let named = entities.named_materials.iter().map(|named| &named.value);
    let kinds: Vec<&str> = named
        .filter_map(|entity| entity.params.kind())
        .chain(
            entities
                .materials
                .iter()
                .map(|material| material.params.plugin.value.as_str()),
        )
        .collect();
    let has_new_names = plugin(&entities.film, film::FILMS)
        || kinds.iter().any(|kind| materials::is_v4_material(kind));
    plugin(&entities.film, &["image"])
        || plugin(&entities.sampler, &old_samplers)
        || plugin(&entities.integrator, &["directlighting", "whitted"])
        || kinds.iter().any(|kind| materials::is_v3_material(kind))
        || entities
            .lights
            .iter()
            .any(|light| light.params.has("mapname"))
        || entities.has_world_end && !has_new_names
}
