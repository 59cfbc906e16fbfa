//! The tree of elements as objects (plugins) with parameters, references resolved.

use super::super::sink::{FileSpan, Problem, Sink};
use super::upgrade;
use super::values::{self, Value};
use super::xml::{Dialect, Text, XmlElement};
use crate::resolve::similar;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// What kind of plugin an object is.
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

/// Tags of objects; some families have other tags in old files.
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
    /// The family whose objects are written with `tag`.
    pub(super) fn of_tag(tag: &str) -> Option<PluginFamily> {
        FAMILY_TAGS
            .iter()
            .find(|(name, _)| *name == tag)
            .map(|(_, family)| *family)
    }

    /// The tag of the family.
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

/// A parameter or a nested object (then the name may be empty).
#[derive(Clone, Debug)]
pub(super) struct Param {
    pub(super) name: Text,
    pub(super) value: Value,
    /// The value as it is written, or the tag of a nested object.
    pub(super) span: FileSpan,
}

/// A plugin with its parameters.
#[derive(Clone, Debug)]
pub(super) struct Object {
    pub(super) family: PluginFamily,
    pub(super) plugin: Text,
    pub(super) id: String,
    pub(super) dialect: Dialect,
    /// Where the files that it names are looked for.
    pub(super) folders: Arc<[PathBuf]>,
    pub(super) params: Vec<Param>,
}

/// All objects of a scene. The first is the scene itself.
#[derive(Debug)]
pub(super) struct ObjectTree {
    objects: Vec<Object>,
}

impl ObjectTree {
    /// The scene.
    pub(super) const ROOT: ObjectId = ObjectId(0);

    /// Makes objects of elements. `None` if the root is no scene.
    pub(super) fn new(root: &XmlElement, sink: &Sink) -> Option<Self> {
        if PluginFamily::of_tag(&root.tag.value) != Some(PluginFamily::Scene) {
            let message = format!("the file is a <{}>, not a <scene>", root.tag.value);
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

    /// Whether any object is of the family.
    pub(super) fn has(&self, family: PluginFamily) -> bool {
        self.objects.iter().any(|object| object.family == family)
    }

    pub(super) fn get(&self, id: ObjectId) -> &Object {
        &self.objects[id.0]
    }
}

/// A `<ref>` whose target is looked up when all ids are known.
struct Reference {
    owner: ObjectId,
    param: usize,
    id: Text,
}

struct ObjectTreeBuilder<'a> {
    sink: &'a Sink,
    objects: Vec<Object>,
    ids: HashMap<String, (ObjectId, FileSpan)>,
    pending: Vec<Reference>,
}

impl ObjectTreeBuilder<'_> {
    fn object(&mut self, element: &XmlElement, family: PluginFamily) -> ObjectId {
        let this = ObjectId(self.objects.len());
        let plugin = match element.attribute("type") {
            Some(plugin) => plugin.clone(),
            None if family == PluginFamily::Scene => element.tag.clone(),
            None => {
                let message = format!("<{}> needs the attribute `type`", element.tag.value);
                self.sink.error(Problem::new(
                    "scene::missing_attribute",
                    element.tag.span,
                    message,
                ));
                Text {
                    value: String::new(),
                    span: element.tag.span,
                }
            }
        };
        values::check_attributes(self.sink, element, &["type", "id", "name", "version"]);
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

    fn register(&mut self, id: &Text, object: ObjectId) {
        if let Some((_, first)) = self.ids.get(&id.value) {
            let report = Problem::new(
                "scene::duplicate_id",
                id.span,
                format!("the id `{}` is used twice", id.value),
            );
            self.sink
                .error(report.label("again here").second(*first, "first here"));
        } else {
            self.ids.insert(id.value.clone(), (object, id.span));
        }
    }

    fn child(&mut self, owner: ObjectId, element: &XmlElement) {
        let nameless = Text {
            value: String::new(),
            span: element.tag.span,
        };
        let name = element.attribute("name").cloned().unwrap_or(nameless);
        let tag = element.tag.value.as_str();
        let is_object = match tag {
            // A <spectrum> without a type is a value.
            "spectrum" => element.attribute("type").is_some(),
            _ => PluginFamily::of_tag(tag).is_some(),
        };
        match tag {
            _ if is_object => {
                let family = PluginFamily::of_tag(tag).expect("objects have a family");
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
                    if values::required_attribute(self.sink, element, "name").is_some() {
                        self.objects[owner.0]
                            .params
                            .push(Param { name, value, span });
                    }
                }
            }
        }
    }

    fn reference(&mut self, owner: ObjectId, name: Text, element: &XmlElement) {
        values::check_attributes(self.sink, element, &["id", "name"]);
        let Some(id) = values::required_attribute(self.sink, element, "id") else {
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
            values::required_attribute(self.sink, element, "id"),
            values::required_attribute(self.sink, element, "as"),
        ) else {
            return;
        };
        match self.ids.get(&id.value) {
            Some((object, _)) => self.register(alias, *object),
            None => self.unresolved(id),
        }
    }

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
                let report = Problem::new("scene::duplicate_parameter", param.name.span, message);
                self.sink
                    .error(report.label("again here").second(first, "first here"));
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
                .label("nothing to refer to")
                .maybe_help(help),
        );
    }

    /// Reports every reference that leads back to an object that holds it, and removes it.
    fn break_cycles(&mut self) {
        #[derive(Clone, Copy, PartialEq)]
        enum Mark {
            New,
            Open,
            Done,
        }
        let mut marks = vec![Mark::New; self.objects.len()];
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
                Mark::New => {
                    marks[child] = Mark::Open;
                    stack.push((child, 0));
                }
                Mark::Done => {}
                Mark::Open => {
                    let message =
                        format!("the object `{}` refers to itself", self.objects[child].id);
                    self.sink.error(
                        Problem::new("scene::circular_reference", param.span, message)
                            .label("closes the circle"),
                    );
                    self.objects[object].params[next].value = Value::Broken;
                }
            }
        }
    }
}
