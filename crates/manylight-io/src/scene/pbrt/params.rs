//! Parameter lists: declared types, values, and access with checks. A parameter that nothing reads
//! is unknown.

use super::super::parameters::{Numbers, Parameters, Reads};
use super::super::sink::{FileSpan, Sink, Text};
use super::param_types::{Param, ParamType, Values};
use manylight::math::{Vec2, Vec3};
use std::cell::Cell;
use std::fmt::Display;
use std::rc::Rc;

/// A directive with a name and parameters, such as `Shape "sphere"`.
pub(super) struct Params<'a> {
    /// What the directive declares, for messages, such as `shape`.
    pub(super) family: &'static str,
    /// The name after the directive.
    pub(super) plugin: Text,
    list: Vec<Param>,
    /// Parameters of `Attribute` directives in effect; those of the list come first.
    inherited: Rc<Vec<Param>>,
    sink: &'a Sink,
    reads: Reads,
    /// Whether a parameter has been refused, so that others may not have been read.
    refused: Cell<bool>,
}

impl Numbers for Params<'_> {
    fn maybe_float(&self, name: &'static str) -> Option<f32> {
        if let Some(Values::Integers(values)) = self.get(name).map(|param| &param.values)
            && let [value] = values[..]
        {
            return Some(value as f32);
        }
        let value = self.exactly::<1>(name, &[ParamType::Float]);
        value.map(|[value]| value)
    }

    fn refuse_float(&self, name: &'static str, _: f32, required: &str) {
        self.refuse_named(name, required);
    }
}

impl Parameters for Params<'_> {
    type Param = Param;

    fn sink(&self) -> &Sink {
        self.sink
    }

    fn describe(&self) -> String {
        format!("{} `{}`", self.family, self.plugin.value)
    }

    fn span(&self) -> FileSpan {
        self.plugin.span
    }

    fn get(&self, name: &'static str) -> Option<&Param> {
        if !self.list.is_empty() {
            self.reads.ask(name);
        }
        let mut found = None;
        for (i, param) in self.list.iter().enumerate() {
            if param.name.value == name {
                self.reads.note(i);
                found = found.or(Some(param));
            }
        }
        found.or_else(|| self.inherited.iter().find(|p| p.name.value == name))
    }

    fn has(&self, name: &str) -> bool {
        let given = |param: &Param| param.name.value == name;
        self.list.iter().any(given) || self.inherited.iter().any(given)
    }

    fn mismatch(&self, param: &Param, expected: &dyn Display) {
        self.refused.set(true);
        let (name, object) = (&param.name.value, self.describe());
        let found = param.ty.name();
        let message = format!("`{name}` of {object} is declared as `{found}`, expected {expected}");
        self.sink
            .error_at("scene::bad_type", param.name.span, message);
    }

    fn refuse(&self, param: &Param, required: &str) {
        self.refused.set(true);
        let (name, object) = (&param.name.value, self.describe());
        let message = format!("`{name}` of {object} must be {required}");
        self.sink.error_at("scene::bad_value", param.span, message);
    }

    fn string(&self, name: &'static str) -> Option<&Text> {
        let values = self.strings(name)?;
        if values.len() != 1 {
            self.refuse_named(name, "one string");
        }
        values.first()
    }
}

impl<'a> Params<'a> {
    pub(super) fn new(
        family: &'static str,
        plugin: Text,
        list: Vec<Param>,
        inherited: Rc<Vec<Param>>,
        sink: &'a Sink,
    ) -> Self {
        let reads = Reads::new(list.len());
        Params {
            family,
            plugin,
            list,
            inherited,
            sink,
            reads,
            refused: Cell::new(false),
        }
    }

    /// The parameter `type` of a named material, which does not count as read.
    pub(super) fn kind(&self) -> Option<&str> {
        let mut given = self.list.iter().filter(|param| param.name.value == "type");
        match &given.next()?.values {
            Values::Strings(names) => names.first().map(|name| name.value.as_str()),
            _ => None,
        }
    }

    /// Lets all parameters count as read, for a plugin that is replaced as a whole.
    pub(super) fn ignore_all(&self) {
        self.reads.note_all();
    }

    /// Reports that two points coincide.
    pub(super) fn refuse_pair(&self, first: &'static str, second: &'static str) {
        let object = self.describe();
        let message = format!("`{first}` and `{second}` of {object} must be different points");
        let given = [first, second].iter().find_map(|name| self.get(name));
        let span = given.map_or(self.plugin.span, |param| param.span);
        self.refused.set(true);
        self.sink.error_at("scene::bad_value", span, message);
    }

    /// The numbers of a parameter with one of the types `types`.
    fn numbers(&self, name: &'static str, types: &[ParamType]) -> Option<&[f32]> {
        let expected = format_args!("`{}`", types[0].name());
        self.typed(name, &expected, |param| match &param.values {
            Values::Numbers(values) if types.contains(&param.ty) => Some(values.as_slice()),
            _ => None,
        })
    }

    /// Like [`Params::numbers`], with exactly `count` numbers.
    fn exactly<const N: usize>(&self, name: &'static str, types: &[ParamType]) -> Option<[f32; N]> {
        let values = self.numbers(name, types)?;
        let exact = values.first_chunk::<N>().filter(|_| values.len() == N);
        if exact.is_none() {
            let found = values.len();
            let required = format!("one value of {N} numbers, found {found} numbers");
            self.refuse_named(name, &required);
        }
        exact.copied()
    }

    /// A list of numbers.
    pub(super) fn floats(&self, name: &'static str) -> Option<&[f32]> {
        self.numbers(name, &[ParamType::Float])
    }

    pub(super) fn point3(&self, name: &'static str, default: Vec3) -> Vec3 {
        let types = [ParamType::Point3, ParamType::Vector3];
        let point = self.exactly::<3>(name, &types);
        point.map_or(default, Vec3::from_array)
    }

    /// A list of vectors or points.
    pub(super) fn vectors(&self, name: &'static str) -> Option<Vec<Vec3>> {
        let types = [ParamType::Point3, ParamType::Vector3, ParamType::Normal];
        let triples = self.numbers(name, &types)?.chunks_exact(3);
        Some(triples.map(Vec3::from_slice).collect())
    }

    /// A list of pairs. In PBRT v3 texture coordinates are plain numbers.
    pub(super) fn pairs(&self, name: &'static str) -> Option<Vec<Vec2>> {
        let types = [ParamType::Point2, ParamType::Vector2, ParamType::Float];
        let values = self.numbers(name, &types)?;
        if !values.len().is_multiple_of(2) {
            self.refuse_named(name, "pairs of numbers");
        }
        Some(values.chunks_exact(2).map(Vec2::from_slice).collect())
    }

    /// A list of integers.
    pub(super) fn integers(&self, name: &'static str) -> Option<&[i32]> {
        self.typed(name, &"`integer`", |param| match &param.values {
            Values::Integers(values) => Some(values.as_slice()),
            _ => None,
        })
    }

    /// An integer of at least `least`.
    pub(super) fn integer(&self, name: &'static str, default: i32, least: i32) -> i32 {
        match self.integers(name) {
            None => default,
            Some(&[value]) if value >= least => value,
            Some(_) => {
                self.refuse_named(name, &format!("one integer of at least {least}"));
                default
            }
        }
    }

    pub(super) fn boolean(&self, name: &'static str, default: bool) -> bool {
        let value = self.typed(name, &"one `bool`", |param| match &param.values {
            Values::Bools(values) if values.len() == 1 => Some(values[0]),
            _ => None,
        });
        value.unwrap_or(default)
    }

    /// A list of strings.
    pub(super) fn strings(&self, name: &'static str) -> Option<&[Text]> {
        self.typed(name, &"`string`", |param| match &param.values {
            Values::Strings(values) if param.ty == ParamType::String => Some(values.as_slice()),
            _ => None,
        })
    }

    /// Reports the parameters that nothing has read: as warnings in files of PBRT v3, which ignores
    /// them, else as errors.
    pub(super) fn finish(&self, is_v3: bool) {
        if self.refused.get() {
            return;
        }
        for param in self.reads.unread(&self.list) {
            let name = &param.name.value;
            let problem = self.unknown_parameter(&param.name);
            if is_v3 {
                let subject = format!("parameter {name} of {}", self.describe());
                self.sink.warn_once(subject, problem);
            } else {
                let help = self.reads.expected(name, "remove it");
                self.sink.error(problem.help(help));
            }
        }
    }
}
