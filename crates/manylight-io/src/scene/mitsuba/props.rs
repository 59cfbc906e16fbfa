//! Reading the parameters of one object: each is asked for by name, and what nobody asked for is an error.

use super::super::sink::{FileSpan, Problem, Sink};
use super::object::{Object, ObjectId, ObjectTree, Param, PluginFamily};
use super::values::Value;
use super::xml::{Dialect, Text};
use crate::resolve::similar;
use glam::{DMat4, DVec3};
use std::cell::{Cell, RefCell};

/// The parameters of an object. Errors go to the sink, and the default is returned, so that reading goes on.
pub(super) struct Props<'a> {
    pub(super) tree: &'a ObjectTree,
    pub(super) id: ObjectId,
    sink: &'a Sink,
    known: RefCell<Vec<&'static str>>,
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

    /// The plugin's name, with its span.
    pub(super) fn plugin(&self) -> &'a Text {
        &self.object().plugin
    }

    /// Where the object is named.
    pub(super) fn span(&self) -> FileSpan {
        self.plugin().span
    }

    pub(super) fn is_v0(&self) -> bool {
        self.object().dialect == Dialect::V0
    }

    /// "bsdf `diffuse`".
    pub(super) fn describe(&self) -> String {
        let object = self.object();
        match object.family {
            PluginFamily::Scene => "the scene".to_owned(),
            family => format!("{} `{}`", family.tag(), object.plugin.value),
        }
    }

    /// The parameter called `name`, marked as read.
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

    /// Whether the parameter is given; does not count as reading it.
    pub(super) fn has(&self, name: &str) -> bool {
        self.object()
            .params
            .iter()
            .any(|param| param.name.value == name)
    }

    /// These may be given and mean nothing to us.
    pub(super) fn ignore(&self, names: &[&'static str]) {
        for name in names {
            self.get(name);
        }
    }

    /// All parameters whose names begin so may be given and mean nothing to us.
    pub(super) fn ignore_prefix(&self, prefix: &str) {
        for (param, used) in self.object().params.iter().zip(&self.used) {
            if param.name.value.starts_with(prefix) {
                used.set(true);
            }
        }
    }

    /// Objects of a family, whatever their parameter names.
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

    /// The only object of a family, if there is one; more are an error.
    pub(super) fn single(&self, family: PluginFamily) -> Option<ObjectId> {
        let found = self.objects(family);
        if let Some((_, second)) = found.get(1) {
            let message = format!("{} can have only one {}", self.describe(), family.tag());
            self.sink
                .error(Problem::new("scene::too_many", second.span, message).label("one too many"));
        }
        found.first().map(|(id, _)| *id)
    }

    /// The value was something else.
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

    /// The value is of the right type but not allowed.
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

    /// A number for which `allowed` holds; `expected` says what that is.
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

    /// An integer of at least `least`.
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

    /// A string that must be there.
    pub(super) fn required_string(&self, name: &'static str) -> Option<Text> {
        if !self.has(name) {
            self.missing(name);
            return None;
        }
        self.string(name)
    }

    /// Whether a part has been reported as broken already, which explains why others are missing.
    pub(super) fn is_broken(&self) -> bool {
        self.object()
            .params
            .iter()
            .any(|param| param.value == Value::Broken)
    }

    /// The object lacks a parameter that has no default.
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

    /// One of several names.
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
                let message = format!("`{}` is no {name} of {}", text.value, self.describe());
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

    /// `to_world`, or the identity; a singular one is an error.
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

    /// Reports whatever has not been read.
    pub(super) fn finish(&self) {
        let known = self.known.borrow();
        for (param, used) in self.object().params.iter().zip(&self.used) {
            if used.get() || param.value == Value::Broken {
                continue;
            }
            let name = param.name.value.as_str();
            // A known name that was not read is a second one, which has been reported.
            if known.contains(&name) {
                continue;
            }
            let report = match param.value {
                Value::Object(id) if self.is_unnamed_or_nested(name, id) => {
                    let message = format!(
                        "{} cannot hold a {}",
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
                        (None, true) => "it has no parameters".to_owned(),
                        (None, false) => format!("its parameters are {}", names.join(", ")),
                    };
                    let message = format!("{} has no parameter `{name}`", self.describe());
                    Problem::new("scene::unknown_parameter", param.name.span, message)
                        .label("unknown")
                        .help(help)
                }
            };
            self.sink.error(report);
        }
    }

    /// Textures and spectra with a name are parameters; everything else that is nested is a part.
    fn is_unnamed_or_nested(&self, name: &str, id: ObjectId) -> bool {
        name.is_empty()
            || !matches!(
                self.tree.get(id).family,
                PluginFamily::Texture | PluginFamily::Spectrum
            )
    }
}
