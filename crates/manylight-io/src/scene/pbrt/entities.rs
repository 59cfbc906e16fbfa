//! The declarations of a scene, with the graphics state at each of them.

use super::super::sink::{FileSpan, Text};
use super::colors::ColorSpace;
use super::params::Params;
use glam::DMat4;
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

/// A declaration with its transform.
#[derive(Debug)]
pub(super) struct Entity {
    pub(super) params: Params,
    /// Object to world; at the start of the shutter interval.
    pub(super) transform: DMat4,
    pub(super) color_space: ColorSpace,
    /// Folders in which the files that the parameters name are searched.
    pub(super) folders: Rc<[PathBuf]>,
}

/// The name of a material, texture or object.
#[derive(Debug)]
pub(super) struct Named<T> {
    pub(super) name: Text,
    pub(super) value: T,
}

/// The material of a shape.
#[derive(Clone, Debug)]
pub(super) enum MaterialRef {
    /// Gray diffuse: the default.
    Default,
    /// Index of a `Material`.
    Index(usize),
    /// Name of a `MakeNamedMaterial`.
    Named(Text),
}

/// A shape with its attributes.
#[derive(Debug)]
pub(super) struct ShapeEntity {
    pub(super) entity: Entity,
    pub(super) material: MaterialRef,
    pub(super) area_light: Option<Rc<Entity>>,
    pub(super) reverse_orientation: bool,
}

/// A texture: whether it is a spectrum, and its declaration.
#[derive(Debug)]
pub(super) struct TextureEntity {
    pub(super) is_spectrum: bool,
    pub(super) entity: Entity,
}

/// An instance of an object.
#[derive(Debug)]
pub(super) struct InstanceEntity {
    pub(super) object: Text,
    pub(super) transform: DMat4,
}

/// All declarations of a scene, in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Entities {
    pub(super) camera: Option<Entity>,
    pub(super) film: Option<Entity>,
    pub(super) filter: Option<Entity>,
    pub(super) integrator: Option<Entity>,
    /// Samplers, accelerators and renderers, which have no effect.
    pub(super) sampler: Option<Entity>,
    pub(super) textures: Vec<Named<TextureEntity>>,
    pub(super) named_materials: Vec<Named<Entity>>,
    pub(super) materials: Vec<Entity>,
    pub(super) lights: Vec<Entity>,
    pub(super) shapes: Vec<ShapeEntity>,
    /// Shapes of objects.
    pub(super) objects: Vec<Named<Vec<ShapeEntity>>>,
    pub(super) object_ids: HashMap<String, usize>,
    pub(super) instances: Vec<InstanceEntity>,
    /// Where the scene file begins, for messages about the scene as a whole.
    pub(super) start: Option<FileSpan>,
}
