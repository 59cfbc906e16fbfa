//! The tree of objects (plugins with parameters) of a scene, made from XML elements. References are resolved.

use super::super::sink::{FileSpan, Problem, Sink};
use super::values::{self, Value};
use super::xml::{Dialect, Text, XmlElement};
use super::{colors, textures, upgrade};
use crate::resolve::similar;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// The family of a plugin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum PluginFamily {
    Scene,
    Integrator,
    Sensor,
    Film,
    Filter,
    Sampler,
    Emitter,
    Shape,
    Bsdf,
    Texture,
    Spectrum,
    Medium,
    Phase,
    Volume,
    Subsurface,
}

/// Tags of objects, the current tag of a family first. `camera` and `luminaire` occur in old files.
const FAMILY_TAGS: [(&str, PluginFamily); 17] = [
    ("scene", PluginFamily::Scene),
    ("integrator", PluginFamily::Integrator),
    ("sensor", PluginFamily::Sensor),
    ("camera", PluginFamily::Sensor),
    ("film", PluginFamily::Film),
    ("rfilter", PluginFamily::Filter),
    ("sampler", PluginFamily::Sampler),
    ("emitter", PluginFamily::Emitter),
    ("luminaire", PluginFamily::Emitter),
    ("shape", PluginFamily::Shape),
    ("bsdf", PluginFamily::Bsdf),
    ("texture", PluginFamily::Texture),
    ("spectrum", PluginFamily::Spectrum),
    ("medium", PluginFamily::Medium),
    ("phase", PluginFamily::Phase),
    ("volume", PluginFamily::Volume),
    ("subsurface", PluginFamily::Subsurface),
];

impl PluginFamily {
    /// The family of objects with this tag.
    pub(super) fn of_tag(tag: &str) -> Option<PluginFamily> {
        FAMILY_TAGS
            .iter()
            .find(|(name, _)| *name == tag)
            .map(|(_, family)| *family)
    }

    /// The family of an object with the tag of this one: plugins of textures and spectra may have either tag.
    fn of_plugin(self, plugin: Option<&Text>) -> PluginFamily {
        let is_in = |list: &[&str]| plugin.is_some_and(|name| list.contains(&name.value.as_str()));
        match self {
            PluginFamily::Texture if is_in(colors::SPECTRA) => PluginFamily::Spectrum,
            PluginFamily::Spectrum if is_in(textures::SUPPORTED) => PluginFamily::Texture,
            family => family,
        }
    }

    /// The current tag of the family.
    pub(super) fn tag(self) -> &'static str {
        FAMILY_TAGS
            .iter()
            .find(|(_, family)| *family == self)
            .map_or("", |(name, _)| *name)
    }
}

/// Index of an object in its [`ObjectTree`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct ObjectId(pub(super) usize);

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
    objects: Vec<Object>,
}

impl ObjectTree {
    /// The scene.
    pub(super) const ROOT: ObjectId = ObjectId(0);

    /// Builds the objects of `root`. `None` if `root` is not a scene, which is reported.
    pub(super) fn new(root: &XmlElement, sink: &Sink) -> Option<Self> {
        if PluginFamily::of_tag(&root.tag.value) != Some(PluginFamily::Scene) {
            let message = format!(
                "found the root element <{}>, expected <scene>",
                root.tag.value
            );
            sink.error(Problem::new(
                "scene::unknown_element",
                root.tag.span,
                message,
            ));
            return None;
        }
        let mut builder = ObjectTreeBuilder {
            sink,
            objects: Vec::new(),
            ids: HashMap::new(),
            pending: Vec::new(),
        };
        builder.object(root, PluginFamily::Scene);
        builder.resolve();
        builder.upgrade();
        Some(ObjectTree {
            objects: builder.objects,
        })
    }

    /// Whether any object belongs to the family.
    pub(super) fn has(&self, family: PluginFamily) -> bool {
        self.objects.iter().any(|object| object.family == family)
    }

    pub(super) fn get(&self, id: ObjectId) -> &Object {
        &self.objects[id.0]
    }
}

/// A `<ref>`. It is resolved when all ids are known.
struct Reference {
    owner: ObjectId,
    /// Index of the parameter of `owner`.
    param: usize,
    id: Text,
}

/// Builds an [`ObjectTree`].
struct ObjectTreeBuilder<'a> {
    sink: &'a Sink,
    objects: Vec<Object>,
    /// Objects by id, with the location of the id.
    ids: HashMap<String, (ObjectId, FileSpan)>,
    /// References that are not resolved yet.
    pending: Vec<Reference>,
}

impl ObjectTreeBuilder<'_> {
    fn object(&mut self, element: &XmlElement, family: PluginFamily) -> ObjectId {
        let this = ObjectId(self.objects.len());
        let plugin = match element.attribute("type") {
            Some(plugin) => plugin.clone(),
            None if family == PluginFamily::Scene => element.tag.clone(),
            None => {
                element.required(self.sink, "type");
                Text {
                    value: String::new(),
                    span: element.tag.span,
                }
            }
        };
        element.check_attributes(self.sink, &["type", "id", "name", "version"]);
        let id = element
            .attribute("id")
            .map_or(String::new(), |id| id.value.clone());
        self.objects.push(Object {
            family,
            plugin,
            id,
            dialect: element.dialect,
            folders: Arc::clone(&element.folders),
            params: Vec::new(),
        });
        if let Some(id) = element.attribute("id") {
            self.register(id, this);
        }
        for child in &element.children {
            self.child(this, child);
        }
        this
    }

    /// Defines the id of an object.
    fn register(&mut self, id: &Text, object: ObjectId) {
        if let Some((_, first)) = self.ids.get(&id.value) {
            let problem = Problem::new(
                "scene::duplicate_id",
                id.span,
                format!("the id `{}` is used twice", id.value),
            );
            self.sink.error(
                problem
                    .label("second definition")
                    .second(*first, "first definition"),
            );
        } else {
            self.ids.insert(id.value.clone(), (object, id.span));
        }
    }

    /// Adds a nested element to an object: an object, a reference, an alias or a value.
    fn child(&mut self, owner: ObjectId, element: &XmlElement) {
        let nameless = Text {
            value: String::new(),
            span: element.tag.span,
        };
        let name = element.attribute("name").cloned().unwrap_or(nameless);
        let tag = element.tag.value.as_str();
        let is_object = match tag {
            // A <spectrum> without `type` is a value.
            "spectrum" => element.attribute("type").is_some(),
            _ => PluginFamily::of_tag(tag).is_some(),
        };
        match tag {
            _ if is_object => {
                let family = PluginFamily::of_tag(tag).expect("objects have a family");
                let family = family.of_plugin(element.attribute("type"));
                let object = self.object(element, family);
                let param = Param {
                    name,
                    value: Value::Object(object),
                    span: element.tag.span,
                };
                self.objects[owner.0].params.push(param);
            }
            "ref" => self.reference(owner, name, element),
            "alias" => self.alias(element),
            _ => {
                if let Some(value) = values::parse(self.sink, element) {
                    let span = element
                        .attribute("value")
                        .map_or(element.tag.span, |value| value.span);
                    if element.required(self.sink, "name").is_some() {
                        self.objects[owner.0]
                            .params
                            .push(Param { name, value, span });
                    }
                }
            }
        }
    }

    fn reference(&mut self, owner: ObjectId, name: Text, element: &XmlElement) {
        element.check_attributes(self.sink, &["id", "name"]);
        let Some(id) = element.required(self.sink, "id") else {
            return;
        };
        let params = &mut self.objects[owner.0].params;
        self.pending.push(Reference {
            owner,
            param: params.len(),
            id: id.clone(),
        });
        params.push(Param {
            name,
            value: Value::Broken,
            span: id.span,
        });
    }

    fn alias(&mut self, element: &XmlElement) {
        let (Some(id), Some(alias)) = (
            element.required(self.sink, "id"),
            element.required(self.sink, "as"),
        ) else {
            return;
        };
        match self.ids.get(&id.value) {
            Some((object, _)) => self.register(alias, *object),
            None => self.unresolved(id),
        }
    }

    /// Renames the objects and parameters of old files, and reports duplicate parameters.
    fn upgrade(&mut self) {
        for index in 0..self.objects.len() {
            upgrade::upgrade(&mut self.objects[index]);
            self.check_duplicates(ObjectId(index));
        }
    }

    fn check_duplicates(&self, owner: ObjectId) {
        let mut seen: HashMap<&str, FileSpan> = HashMap::new();
        for param in &self.objects[owner.0].params {
            let name = param.name.value.as_str();
            if name.is_empty() {
                continue;
            }
            if let Some(first) = seen.insert(name, param.name.span) {
                let message = format!("the parameter `{name}` is given twice");
                let problem = Problem::new("scene::duplicate_parameter", param.name.span, message);
                self.sink
                    .error(problem.label("second value").second(first, "first value"));
            }
        }
    }

    fn resolve(&mut self) {
        for reference in std::mem::take(&mut self.pending) {
            match self.ids.get(&reference.id.value) {
                Some((target, _)) => {
                    self.objects[reference.owner.0].params[reference.param].value =
                        Value::Object(*target);
                }
                None => self.unresolved(&reference.id),
            }
        }
        self.break_cycles();
    }

    fn unresolved(&self, id: &Text) {
        let mut known: Vec<&str> = self.ids.keys().map(String::as_str).collect();
        known.sort_unstable();
        let help = similar(&id.value, known).map(|similar| format!("did you mean `{similar}`?"));
        let message = format!("no object has the id `{}`", id.value);
        self.sink.error(
            Problem::new("scene::unresolved_reference", id.span, message)
                .label("unknown id")
                .maybe_help(help),
        );
    }

    /// Reports and removes every reference that closes a cycle, by depth-first search.
    fn break_cycles(&mut self) {
        #[derive(Clone, Copy, PartialEq)]
        enum Mark {
            Unvisited,
            /// On the path from the root to the current object.
            Open,
            Done,
        }
        let mut marks = vec![Mark::Unvisited; self.objects.len()];
        let mut stack = vec![(0, 0)];
        marks[0] = Mark::Open;
        while let Some((object, next)) = stack.pop() {
            let Some(param) = self.objects[object].params.get(next) else {
                marks[object] = Mark::Done;
                continue;
            };
            stack.push((object, next + 1));
            let Value::Object(ObjectId(child)) = param.value else {
                continue;
            };
            match marks[child] {
                Mark::Unvisited => {
                    marks[child] = Mark::Open;
                    stack.push((child, 0));
                }
                Mark::Done => {}
                Mark::Open => {
                    let message =
                        format!("the object `{}` contains itself", self.objects[child].id);
                    self.sink.error(
                        Problem::new("scene::circular_reference", param.span, message)
                            .label("this reference closes the cycle"),
                    );
                    self.objects[object].params[next].value = Value::Broken;
                }
            }
        }
    }
}
