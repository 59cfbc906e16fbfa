//! Access to the parameters of one object. A parameter that is never read is reported as unknown.

use super::super::sink::{FileSpan, Problem, Sink};
use super::object::{Object, ObjectId, ObjectTree, Param, PluginFamily};
use super::values::Value;
use super::xml::{Dialect, Text};
use crate::resolve::similar;
use glam::{DMat4, DVec3};
use std::cell::{Cell, RefCell};

/// The parameters of one object. An invalid value is reported, and the default is returned, so that all errors are found.
pub(super) struct Props<'a> {
    pub(super) tree: &'a ObjectTree,
    pub(super) id: ObjectId,
    sink: &'a Sink,
    /// Names that have been read.
    known: RefCell<Vec<&'static str>>,
    /// For each parameter, whether it has been read.
    used: Vec<Cell<bool>>,
}

impl<'a> Props<'a> {
    pub(super) fn new(tree: &'a ObjectTree, id: ObjectId, sink: &'a Sink) -> Self {
        let used = tree
            .get(id)
            .params
            .iter()
            .map(|_| Cell::new(false))
            .collect();
        Props {
            tree,
            id,
            sink,
            known: RefCell::default(),
            used,
        }
    }

    pub(super) fn object(&self) -> &'a Object {
        self.tree.get(self.id)
    }

    /// Name of the plugin.
    pub(super) fn plugin(&self) -> &'a Text {
        &self.object().plugin
    }

    /// Location of the name of the plugin.
    pub(super) fn span(&self) -> FileSpan {
        self.plugin().span
    }

    pub(super) fn is_v0(&self) -> bool {
        self.object().dialect == Dialect::V0
    }

    /// The object in messages, such as "bsdf `diffuse`".
    pub(super) fn describe(&self) -> String {
        let object = self.object();
        match object.family {
            PluginFamily::Scene => "the scene".to_owned(),
            family => format!("{} `{}`", family.tag(), object.plugin.value),
        }
    }

    /// The parameter `name`, marked as read.
    pub(super) fn get(&self, name: &'static str) -> Option<&'a Param> {
        if !self.known.borrow().contains(&name) {
            self.known.borrow_mut().push(name);
        }
        let index = self
            .object()
            .params
            .iter()
            .position(|param| param.name.value == name)?;
        self.used[index].set(true);
        Some(&self.object().params[index])
    }

    /// Whether the parameter `name` is given. It is not marked as read.
    pub(super) fn has(&self, name: &str) -> bool {
        self.object()
            .params
            .iter()
            .any(|param| param.name.value == name)
    }

    /// Marks parameters as read that are valid but have no effect.
    pub(super) fn ignore(&self, names: &[&'static str]) {
        for name in names {
            self.get(name);
        }
    }

    /// Marks all parameters as read that start with `prefix`: valid, but without effect.
    pub(super) fn ignore_prefix(&self, prefix: &str) {
        for (param, used) in self.object().params.iter().zip(&self.used) {
            if param.name.value.starts_with(prefix) {
                used.set(true);
            }
        }
    }

    /// All nested objects of a family, marked as read.
    pub(super) fn objects(&self, family: PluginFamily) -> Vec<(ObjectId, &'a Param)> {
        let mut found = Vec::new();
        for (param, used) in self.object().params.iter().zip(&self.used) {
            if let Value::Object(id) = param.value
                && self.tree.get(id).family == family
            {
                used.set(true);
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
            self.sink.error(
                Problem::new("scene::too_many", second.span, message)
                    .label("unexpected second one"),
            );
        }
        found.first().map(|(id, _)| *id)
    }

    /// Reports a value of the wrong type.
    pub(super) fn mismatch(&self, param: &Param, expected: &str) {
        if param.value != Value::Broken {
            let name = &param.name.value;
            let message = format!(
                "`{name}` of {} is {}, expected {expected}",
                self.describe(),
                param.value.describe()
            );
            self.sink.error(
                Problem::new("scene::wrong_type", param.span, message)
                    .label(format!("expected {expected}")),
            );
        }
    }

    /// Reports a value of the right type that is not allowed.
    pub(super) fn refuse(&self, param: &Param, expected: &str) {
        let name = &param.name.value;
        let message = format!("`{name}` of {} must be {expected}", self.describe());
        self.sink.error(
            Problem::new("scene::bad_value", param.span, message)
                .label(format!("expected {expected}")),
        );
    }

    pub(super) fn maybe_float(&self, name: &'static str) -> Option<f32> {
        let param = self.get(name)?;
        match param.value {
            Value::Float(value) => Some(value as f32),
            Value::Integer(value) => Some(value as f32),
            _ => {
                self.mismatch(param, "a number");
                None
            }
        }
    }

    pub(super) fn float(&self, name: &'static str, default: f32) -> f32 {
        self.maybe_float(name).unwrap_or(default)
    }

    /// A number that satisfies `allowed`, which `expected` describes.
    pub(super) fn float_where(
        &self,
        name: &'static str,
        default: f32,
        allowed: impl Fn(f32) -> bool,
        expected: &str,
    ) -> f32 {
        match self.maybe_float(name) {
            Some(value) if allowed(value) => value,
            Some(_) => {
                self.refuse(
                    self.get(name).expect("a parameter with a value is there"),
                    expected,
                );
                default
            }
            None => default,
        }
    }

    pub(super) fn maybe_integer(&self, name: &'static str) -> Option<i64> {
        let param = self.get(name)?;
        match param.value {
            Value::Integer(value) => Some(value),
            _ => {
                self.mismatch(param, "an integer");
                None
            }
        }
    }

    /// An integer in [`least`, `i32::MAX`].
    pub(super) fn integer(&self, name: &'static str, default: i64, least: i64) -> i64 {
        match self.maybe_integer(name) {
            Some(value) if value >= least && value <= i64::from(i32::MAX) => value,
            Some(_) => {
                let param = self.get(name).expect("a parameter with a value is there");
                self.refuse(param, &format!("at least {least}"));
                default
            }
            None => default,
        }
    }

    pub(super) fn boolean(&self, name: &'static str, default: bool) -> bool {
        let Some(param) = self.get(name) else {
            return default;
        };
        match param.value {
            Value::Boolean(value) => value,
            _ => {
                self.mismatch(param, "`true` or `false`");
                default
            }
        }
    }

    pub(super) fn string(&self, name: &'static str) -> Option<Text> {
        let param = self.get(name)?;
        match &param.value {
            Value::String(value) => Some(Text {
                value: value.clone(),
                span: param.span,
            }),
            _ => {
                self.mismatch(param, "a string");
                None
            }
        }
    }

    /// A string without a default. Its absence is reported.
    pub(super) fn required_string(&self, name: &'static str) -> Option<Text> {
        if !self.has(name) {
            self.missing(name);
            return None;
        }
        self.string(name)
    }

    /// Whether any parameter is invalid and has been reported. Missing parameters are not reported in this case.
    pub(super) fn is_broken(&self) -> bool {
        self.object()
            .params
            .iter()
            .any(|param| param.value == Value::Broken)
    }

    /// Reports the absence of a parameter without a default.
    pub(super) fn missing(&self, name: &'static str) {
        if self.is_broken() {
            return;
        }
        let message = format!("{} needs the parameter `{name}`", self.describe());
        self.sink.error(Problem::new(
            "scene::missing_parameter",
            self.span(),
            message,
        ));
    }

    /// A string that is one of the names in `choices`.
    pub(super) fn choice<T: Copy>(
        &self,
        name: &'static str,
        default: T,
        choices: &[(&str, T)],
    ) -> T {
        let Some(text) = self.string(name) else {
            return default;
        };
        match choices.iter().find(|(choice, _)| *choice == text.value) {
            Some((_, value)) => *value,
            None => {
                let names = choices.iter().map(|(name, _)| *name);
                let help = match similar(&text.value, names.clone()) {
                    Some(similar) => format!("did you mean `{similar}`?"),
                    None => format!("expected one of {}", names.collect::<Vec<_>>().join(", ")),
                };
                let object = self.describe();
                let message = format!("unknown value `{}` of `{name}` of {object}", text.value);
                self.sink
                    .error(Problem::new("scene::bad_value", text.span, message).help(help));
                default
            }
        }
    }

    pub(super) fn vector(&self, name: &'static str) -> Option<DVec3> {
        let param = self.get(name)?;
        match param.value {
            Value::Vector(value) => Some(value),
            _ => {
                self.mismatch(param, "a point or vector");
                None
            }
        }
    }

    pub(super) fn transform(&self, name: &'static str) -> Option<DMat4> {
        let param = self.get(name)?;
        match param.value {
            Value::Transform(value) => Some(value),
            _ => {
                self.mismatch(param, "a transform");
                None
            }
        }
    }

    /// The parameter `to_world`, or the identity. A singular matrix is reported.
    pub(super) fn to_world(&self) -> DMat4 {
        let Some(matrix) = self.transform("to_world") else {
            return DMat4::IDENTITY;
        };
        let determinant = matrix.determinant();
        if determinant == 0.0 || !determinant.is_finite() {
            self.refuse(
                self.get("to_world")
                    .expect("a parameter with a value is there"),
                "invertible",
            );
            return DMat4::IDENTITY;
        }
        matrix
    }

    /// Reports the parameters that have not been read.
    pub(super) fn finish(&self) {
        let known = self.known.borrow();
        for (param, used) in self.object().params.iter().zip(&self.used) {
            if used.get() || param.value == Value::Broken {
                continue;
            }
            let name = param.name.value.as_str();
            // A known name that was not read is a duplicate, which has been reported.
            if known.contains(&name) {
                continue;
            }
            let problem = match param.value {
                Value::Object(id) if self.is_unnamed_or_nested(name, id) => {
                    let message = format!(
                        "{} cannot contain a {}",
                        self.describe(),
                        self.tree.get(id).family.tag()
                    );
                    Problem::new("scene::unexpected_object", param.span, message)
                }
                _ => {
                    let mut names: Vec<&str> = known.clone();
                    names.sort_unstable();
                    let help = match (similar(name, names.iter().copied()), names.is_empty()) {
                        (Some(similar), _) => format!("did you mean `{similar}`?"),
                        (None, true) => "expected no parameters".to_owned(),
                        (None, false) => format!("expected one of {}", names.join(", ")),
                    };
                    let message = format!("{} has no parameter `{name}`", self.describe());
                    Problem::new("scene::unknown_parameter", param.name.span, message)
                        .label("unknown parameter")
                        .help(help)
                }
            };
            self.sink.error(problem);
        }
    }

    /// Whether a nested object is reported as an object. Named textures and spectra are reported as parameters instead.
    fn is_unnamed_or_nested(&self, name: &str, id: ObjectId) -> bool {
        name.is_empty()
            || !matches!(
                self.tree.get(id).family,
                PluginFamily::Texture | PluginFamily::Spectrum
            )
    }
}
