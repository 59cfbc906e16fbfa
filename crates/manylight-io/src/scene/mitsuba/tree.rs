//! The tree of objects of a scene, made from XML elements. References are resolved.

use super::super::parameters::unresolved;
use super::super::sink::{FileSpan, Problem, Sink, Text};
use super::family::PluginFamily;
use super::object::{Object, ObjectTree, Param};
use super::upgrade::upgrade;
use super::values::{self, ObjectId, Value};
use super::xml::XmlElement;
use std::collections::HashMap;
use std::sync::Arc;

/// The objects of `root`. `None` if `root` is not a scene, which is reported.
pub(super) fn read_objects(root: &XmlElement, sink: &Sink) -> Option<ObjectTree> {
    if PluginFamily::of_tag(&root.tag.value) != Some(PluginFamily::Scene) {
        let tag = &root.tag.value;
        let message = format!("found the root element <{tag}>, expected <scene>");
        sink.error_at("scene::unknown_element", root.tag.span, message);
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
    let objects = builder.objects;
    Some(ObjectTree { objects })
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
            let message = format!("the id `{}` is used twice", id.value);
            let problem = Problem::new("scene::duplicate_id", id.span, message);
            let problem = problem.label("second definition");
            self.sink.error(problem.second(*first, "first definition"));
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
        // A <spectrum> without `type` is a value.
        let family = PluginFamily::of_tag(tag)
            .filter(|_| tag != "spectrum" || element.attribute("type").is_some());
        if let Some(family) = family {
            let family = family.of_plugin(element.attribute("type"));
            let value = Value::Object(self.object(element, family));
            let span = element.tag.span;
            let param = Param { name, value, span };
            self.objects[owner.0].params.push(param);
            return;
        }
        match tag {
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
            upgrade(&mut self.objects[index]);
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
        let message = format!("no object has the id `{}`", id.value);
        let problem = unresolved(id, message, self.ids.keys().map(String::as_str));
        self.sink.error(problem.label("unknown id"));
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
                    let id = &self.objects[child].id;
                    let message = format!("the object `{id}` contains itself");
                    let problem = Problem::new("scene::circular_reference", param.span, message);
                    let problem = problem.label("this reference closes the cycle");
                    self.sink.error(problem);
                    self.objects[object].params[next].value = Value::Broken;
                }
            }
        }
    }
}
