//! Objects: plugins with parameters, as the elements of a scene give them.

use super::super::sink::{FileSpan, Text};
use super::family::PluginFamily;
use super::values::{ObjectId, Value};
use super::xml::Dialect;
use std::path::PathBuf;
use std::sync::Arc;

/// A parameter or a nested object. The name of a nested object may be empty.
#[derive(Clone, Debug)]
pub(super) struct Param {
    pub(super) name: Text,
    pub(super) value: Value,
    /// Location of the value, or of the tag of a nested object.
    pub(super) span: FileSpan,
}

/// A plugin with its parameters.
#[derive(Clone, Debug)]
pub(super) struct Object {
    pub(super) family: PluginFamily,
    pub(super) plugin: Text,
    pub(super) id: String,
    pub(super) dialect: Dialect,
    /// Search path of the files that the object names.
    pub(super) folders: Arc<[PathBuf]>,
    pub(super) params: Vec<Param>,
}

/// All objects of a scene. The first one is the scene itself.
#[derive(Debug)]
pub(super) struct ObjectTree {
    pub(super) objects: Vec<Object>,
}

impl ObjectTree {
    /// The scene.
    pub(super) const ROOT: ObjectId = ObjectId(0);

    /// Whether any object belongs to the family.
    pub(super) fn has(&self, family: PluginFamily) -> bool {
        self.objects.iter().any(|object| object.family == family)
    }

    pub(super) fn get(&self, id: ObjectId) -> &Object {
        &self.objects[id.0]
    }
}
