//! The declarations of a scene, with the graphics state at each of them.

use super::super::files::find_external_file;
use super::super::parameters::Parameters;
use super::super::sink::{FileSpan, Problem, Text};
use super::bindings::{Bindings, Place, TextureType};
use super::colors::{ColorContext, ColorSpace, ColorUse};
use super::params::Params;
use glam::DMat4;
use manylight::color::Rgb;
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

/// A declaration with its transform.
pub(super) struct Entity<'a> {
    pub(super) params: Params<'a>,
    /// Object to world; at the start of the motion.
    pub(super) transform: DMat4,
    pub(super) color_space: ColorSpace,
    /// Folders in which the files that the parameters name are searched.
    pub(super) folders: Rc<[PathBuf]>,
    /// Where the names in the parameters are looked up.
    pub(super) place: Place,
}

impl Entity<'_> {
    /// The file `name`. `what` describes it in the report of its absence.
    pub(super) fn find_file(&self, name: &Text, what: &str) -> Option<PathBuf> {
        find_external_file(self.params.sink(), &self.folders, name, what)
    }

    /// The color of the parameter `name`, if it is given and not a texture.
    pub(super) fn color(&self, name: &'static str, color_use: ColorUse) -> Option<Rgb> {
        let context = ColorContext {
            sink: self.params.sink(),
            folders: &self.folders,
            space: self.color_space,
        };
        context.color(&self.params, name, color_use)
    }
}

/// The name of a material, texture or object.
pub(super) struct Named<T> {
    pub(super) name: Text,
    pub(super) value: T,
}

/// The material of a shape.
#[derive(Clone)]
pub(super) enum MaterialRef {
    /// Gray diffuse: the default.
    Default,
    /// Index of a `Material`.
    Index(usize),
    /// Name of a `MakeNamedMaterial`, and the place where it is looked up.
    Named(Text, Place),
}

/// A shape with its attributes.
pub(super) struct ShapeEntity<'a> {
    pub(super) entity: Entity<'a>,
    pub(super) material: MaterialRef,
    pub(super) area_light: Option<Rc<Entity<'a>>>,
    pub(super) reverse_orientation: bool,
}

/// A texture: its type, and its declaration.
pub(super) struct TextureEntity<'a> {
    pub(super) ty: TextureType,
    pub(super) entity: Entity<'a>,
}

/// An instance of an object.
pub(super) struct InstanceEntity {
    pub(super) object: Text,
    pub(super) transform: DMat4,
}

/// An end of a block that is wrong in PBRT v4.
pub(super) struct WrongBlock {
    pub(super) problem: Problem,
    /// Whether PBRT v3 reads it without a message.
    pub(super) is_valid_in_v3: bool,
}

/// All declarations of a scene, in the order of the file.
#[derive(Default)]
pub(super) struct Entities<'a> {
    pub(super) camera: Option<Entity<'a>>,
    /// From the world to the camera at the end of its motion, if it moves.
    pub(super) camera_at_end: Option<DMat4>,
    /// The times of the start and the end of all motion, in s, if they are given.
    pub(super) motion_times: Option<[f64; 2]>,
    pub(super) film: Option<Entity<'a>>,
    pub(super) filter: Option<Entity<'a>>,
    pub(super) integrator: Option<Entity<'a>>,
    /// Samplers, accelerators and renderers, which have no effect.
    pub(super) sampler: Option<Entity<'a>>,
    pub(super) textures: Vec<Named<TextureEntity<'a>>>,
    pub(super) named_materials: Vec<Named<Entity<'a>>>,
    pub(super) materials: Vec<Entity<'a>>,
    pub(super) lights: Vec<Entity<'a>>,
    pub(super) shapes: Vec<ShapeEntity<'a>>,
    /// Shapes of objects.
    pub(super) objects: Vec<Named<Vec<ShapeEntity<'a>>>>,
    pub(super) object_ids: HashMap<String, usize>,
    /// The definitions of textures and named materials.
    pub(super) bindings: Bindings,
    pub(super) instances: Vec<InstanceEntity>,
    /// Whether the world has an end, which PBRT v4 does not know.
    pub(super) has_world_end: bool,
    /// Ends of blocks that are errors in PBRT v4.
    pub(super) wrong_blocks: Vec<WrongBlock>,
    /// Where the scene file begins, for messages about the scene as a whole.
    pub(super) start: Option<FileSpan>,
}
