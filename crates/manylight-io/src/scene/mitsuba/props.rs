//! Access to the parameters of one object. A parameter that is never read is reported as unknown.

use super::super::motion::KeyFrame;
use super::super::parameters::{Numbers, Parameters, Reads};
use super::super::sink::{FileSpan, Problem, Sink, Text};
use super::family::PluginFamily;
use super::object::{Object, ObjectTree, Param};
use super::values::{ObjectId, Value};
use super::xml::Dialect;
use glam::{DMat4, DVec3};
use std::fmt::Display;

/// The parameters of one object. An invalid value is reported, and the default is returned, so that
/// all errors are found.
pub(super) struct Props<'a> {
    pub(super) tree: &'a ObjectTree,
    pub(super) id: ObjectId,
    sink: &'a Sink,
    reads: Reads,
}

impl Numbers for Props<'_> {
    fn maybe_float(&self, name: &'static str) -> Option<f32> {
        self.typed(name, &"a number", |param| match &param.value {
            Value::Float(value) => Some(*value as f32),
            Value::Integer(value) => Some(*value as f32),
            _ => None,
        })
    }

    fn refuse_float(&self, name: &'static str, _: f32, required: &str) {
        self.refuse_named(name, required);
    }
}

impl Parameters for Props<'_> {
    type Param = Param;

    fn sink(&self) -> &Sink {
        self.sink
    }

    fn describe(&self) -> String {
        let object = self.object();
        match object.family {
            PluginFamily::Scene => "the scene".to_owned(),
            family => format!("{} `{}`", family.tag(), object.plugin.value),
        }
    }

    fn span(&self) -> FileSpan {
        self.plugin().span
    }

    fn get(&self, name: &'static str) -> Option<&Param> {
        self.reads.ask(name);
        let index = self.index(name)?;
        self.reads.note(index);
        Some(&self.object().params[index])
    }

    fn has(&self, name: &str) -> bool {
        self.index(name).is_some()
    }

    fn is_broken(&self) -> bool {
        let params = &self.object().params;
        params.iter().any(|param| param.value == Value::Broken)
    }

    fn mismatch(&self, param: &Param, expected: &dyn Display) {
        if param.value != Value::Broken {
            let (name, found) = (&param.name.value, param.value.describe());
            let object = self.describe();
            let message = format!("`{name}` of {object} is {found}, expected {expected}");
            let problem = Problem::new("scene::wrong_type", param.span, message);
            self.sink
                .error(problem.label(format!("expected {expected}")));
        }
    }

    fn refuse(&self, param: &Param, required: &str) {
        let name = &param.name.value;
        let message = format!("`{name}` of {} must be {required}", self.describe());
        let problem = Problem::new("scene::bad_value", param.span, message);
        self.sink
            .error(problem.label(format!("expected {required}")));
    }

    fn string(&self, name: &'static str) -> Option<&Text> {
        self.typed(name, &"a string", |param| match &param.value {
            Value::String(text) => Some(text),
            _ => None,
        })
    }

    fn required_string(&self, name: &'static str) -> Option<&Text> {
        self.require(name);
        // A name that is missing is not suggested for those that are unknown.
        self.has(name).then(|| self.string(name)).flatten()
    }
}

impl<'a> Props<'a> {
    pub(super) fn new(tree: &'a ObjectTree, id: ObjectId, sink: &'a Sink) -> Self {
        Props {
            tree,
            id,
            sink,
            reads: Reads::new(tree.get(id).params.len()),
        }
    }

    pub(super) fn object(&self) -> &'a Object {
        self.tree.get(self.id)
    }

    /// Name of the plugin.
    pub(super) fn plugin(&self) -> &'a Text {
        &self.object().plugin
    }

    pub(super) fn is_v0(&self) -> bool {
        self.object().dialect == Dialect::V0
    }

    fn index(&self, name: &str) -> Option<usize> {
        let mut params = self.object().params.iter();
        params.position(|param| param.name.value == name)
    }

    /// Lets all parameters count as read that start with `prefix`: valid, but without effect.
    pub(super) fn ignore_prefix(&self, prefix: &str) {
        for (index, param) in self.object().params.iter().enumerate() {
            if param.name.value.starts_with(prefix) {
                self.reads.note(index);
            }
        }
    }

    /// All nested objects of a family, which count as read.
    pub(super) fn objects(&self, family: PluginFamily) -> Vec<(ObjectId, &'a Param)> {
        let mut found = Vec::new();
        for (index, param) in self.object().params.iter().enumerate() {
            if let Value::Object(id) = param.value
                && self.tree.get(id).family == family
            {
                self.reads.note(index);
                found.push((id, param));
            }
        }
        found
    }

    /// The nested object of a family, if there is one. More than one are reported.
    pub(super) fn single(&self, family: PluginFamily) -> Option<ObjectId> {
        let found = self.objects(family);
        if let Some((_, second)) = found.get(1) {
            let message = format!("{} can have only one {}", self.describe(), family.tag());
            let problem = Problem::new("scene::too_many", second.span, message);
            self.sink.error(problem.label("unexpected second one"));
        }
        found.first().map(|(id, _)| *id)
    }

    pub(super) fn maybe_integer(&self, name: &'static str) -> Option<i64> {
        self.typed(name, &"an integer", |param| match &param.value {
            Value::Integer(value) => Some(*value),
            _ => None,
        })
    }

    /// An integer in [`least`, `i32::MAX`].
    pub(super) fn integer(&self, name: &'static str, default: i64, least: i64) -> i64 {
        match self.maybe_integer(name) {
            Some(value) if value >= least && value <= i64::from(i32::MAX) => value,
            Some(_) => {
                self.refuse_named(name, &format!("at least {least}"));
                default
            }
            None => default,
        }
    }

    pub(super) fn boolean(&self, name: &'static str, default: bool) -> bool {
        let value = self.typed(name, &"`true` or `false`", |param| match &param.value {
            Value::Boolean(value) => Some(*value),
            _ => None,
        });
        value.unwrap_or(default)
    }

    pub(super) fn vector(&self, name: &'static str) -> Option<DVec3> {
        self.typed(name, &"a point or vector", |param| match &param.value {
            Value::Vector(value) => Some(*value),
            _ => None,
        })
    }

    pub(super) fn transform(&self, name: &'static str) -> Option<DMat4> {
        self.typed(name, &"a transform", |param| match &param.value {
            Value::Transform(value) => Some(*value),
            Value::Animation(keys) => keys.first().map(|key| key.1),
            _ => None,
        })
    }

    /// The key frames of the parameter `to_world`, if it is animated, and where they are.
    pub(super) fn motion(&self) -> Option<(&[KeyFrame], FileSpan)> {
        let params = self.object().params.iter();
        let mut keys = params.filter_map(|param| match &param.value {
            Value::Animation(keys) if param.name.value == "to_world" => {
                Some((&keys[..], param.span))
            }
            _ => None,
        });
        keys.next()
    }

    /// [`Props::first_to_world`] of what stands still. Warns once of animations.
    pub(super) fn to_world(&self) -> DMat4 {
        if let Some((_, span)) = self.motion() {
            let message = "only cameras move; the first transform of this <animation> is used";
            self.sink.unsupported("animation", span, message);
        }
        self.first_to_world()
    }

    /// The parameter `to_world`, its first key frame, or the identity. A singular matrix is reported.
    pub(super) fn first_to_world(&self) -> DMat4 {
        let Some(matrix) = self.transform("to_world") else {
            return DMat4::IDENTITY;
        };
        let determinant = matrix.determinant();
        if determinant == 0.0 || !determinant.is_finite() {
            self.refuse_named("to_world", "invertible");
            return DMat4::IDENTITY;
        }
        matrix
    }

    /// Reports the parameters that have not been read.
    pub(super) fn finish(&self) {
        let known = self.reads.names();
        for param in self.reads.unread(&self.object().params) {
            let name = param.name.value.as_str();
            // A known name that was not read is a duplicate, which has been reported.
            if param.value == Value::Broken || known.contains(&name) {
                continue;
            }
            if let Value::Object(id) = param.value
                && self.is_unnamed_or_nested(name, id)
            {
                let family = self.tree.get(id).family.tag();
                let message = format!("{} cannot contain a {family}", self.describe());
                self.sink
                    .error_at("scene::unexpected_object", param.span, message);
                continue;
            }
            let help = self.reads.expected(name, "expected no parameters");
            let problem = self
                .unknown_parameter(&param.name)
                .label("unknown parameter");
            self.sink.error(problem.help(help));
        }
    }

    /// Whether a nested object is reported as an object. Named textures and spectra are reported as
    /// parameters instead.
    fn is_unnamed_or_nested(&self, name: &str, id: ObjectId) -> bool {
        name.is_empty()
            || !matches!(
                self.tree.get(id).family,
                PluginFamily::Texture | PluginFamily::Spectrum
            )
    }
}
