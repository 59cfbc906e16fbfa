//! Parameter lists: declared types, values, and access with checks. A parameter that nothing reads is unknown.

use super::super::sink::{Problem, Sink, Text};
use super::param_types::{Param, ParamType, Values};
use crate::resolve::similar;
use manylight::math::{Vec2, Vec3};
use std::cell::{Cell, RefCell};
use std::rc::Rc;

/// A directive with a name and parameters, such as `Shape "sphere"`.
#[derive(Debug)]
pub(super) struct Params {
    /// What the directive declares, for messages, such as `shape`.
    pub(super) family: &'static str,
    /// The name after the directive.
    pub(super) plugin: Text,
    list: Vec<Param>,
    /// Parameters of `Attribute` directives in effect; those of the list come first.
    inherited: Rc<Vec<Param>>,
    used: RefCell<Vec<bool>>,
    /// Names that have been asked for, for suggestions.
    asked: RefCell<Vec<&'static str>>,
    /// Whether a parameter has been refused, so that others may not have been read.
    broken: Cell<bool>,
}

impl Params {
    pub(super) fn new(
        family: &'static str,
        plugin: Text,
        list: Vec<Param>,
        inherited: Rc<Vec<Param>>,
    ) -> Self {
        let used = RefCell::new(vec![false; list.len()]);
        Params {
            family,
            plugin,
            list,
            inherited,
            used,
            asked: RefCell::default(),
            broken: Cell::new(false),
        }
    }

    /// Family and name, such as "shape `sphere`".
    pub(super) fn describe(&self) -> String {
        format!("{} `{}`", self.family, self.plugin.value)
    }

    /// Marks the parameter as known and returns it.
    pub(super) fn get(&self, name: &'static str) -> Option<&Param> {
        if !self.list.is_empty() {
            self.asked.borrow_mut().push(name);
        }
        let mut found = None;
        for (i, param) in self.list.iter().enumerate() {
            if param.name.value == name {
                self.used.borrow_mut()[i] = true;
                found = found.or(Some(param));
            }
        }
        found.or_else(|| self.inherited.iter().find(|p| p.name.value == name))
    }

    /// Whether the parameter is given. Does not mark it as known.
    pub(super) fn has(&self, name: &str) -> bool {
        let given = |param: &Param| param.name.value == name;
        self.list.iter().any(given) || self.inherited.iter().any(given)
    }

    /// The parameter `type` of a named material, without marking it as known.
    pub(super) fn kind(&self) -> Option<&str> {
        let mut given = self.list.iter().filter(|param| param.name.value == "type");
        match &given.next()?.values {
            Values::Strings(names) => names.first().map(|name| name.value.as_str()),
            _ => None,
        }
    }

    /// Marks parameters without effect as known.
    pub(super) fn ignore(&self, names: &[&'static str]) {
        for name in names {
            self.get(name);
        }
    }

    /// Marks all parameters as known, for a plugin that is replaced as a whole.
    pub(super) fn ignore_all(&self) {
        self.used.borrow_mut().fill(true);
    }

    /// Reports that `param` has another type than `expected`.
    pub(super) fn mismatch(&self, sink: &Sink, param: &Param, expected: &str) {
        self.broken.set(true);
        let message = format!(
            "`{}` of {} is declared as `{}`, expected {expected}",
            param.name.value,
            self.describe(),
            param.ty.name()
        );
        sink.error(Problem::new("scene::bad_type", param.name.span, message));
    }

    /// Reports that the value of `param` is not as required.
    pub(super) fn refuse(&self, sink: &Sink, param: &Param, required: &str) {
        self.broken.set(true);
        let message = format!(
            "`{}` of {} must be {required}",
            param.name.value,
            self.describe()
        );
        sink.error(Problem::new("scene::bad_value", param.span, message));
    }

    /// Reports that two points coincide.
    pub(super) fn refuse_pair(&self, sink: &Sink, first: &'static str, second: &'static str) {
        let message = format!(
            "`{first}` and `{second}` of {} must be different points",
            self.describe()
        );
        let span = [first, second]
            .iter()
            .find_map(|name| self.get(name))
            .map_or(self.plugin.span, |param| param.span);
        self.broken.set(true);
        sink.error(Problem::new("scene::bad_value", span, message));
    }

    /// Reports that a parameter is missing.
    pub(super) fn missing(&self, sink: &Sink, name: &str) {
        let message = format!("{} needs the parameter `{name}`", self.describe());
        sink.error(Problem::new(
            "scene::missing_parameter",
            self.plugin.span,
            message,
        ));
    }

    /// The numbers of a parameter with one of the types `types`.
    fn numbers(&self, sink: &Sink, name: &'static str, types: &[ParamType]) -> Option<&[f32]> {
        let param = self.get(name)?;
        match &param.values {
            Values::Numbers(values) if types.contains(&param.ty) => Some(values),
            _ => {
                self.mismatch(sink, param, &format!("`{}`", types[0].name()));
                None
            }
        }
    }

    /// Like [`Params::numbers`], with exactly `count` numbers.
    fn exactly<const N: usize>(
        &self,
        sink: &Sink,
        name: &'static str,
        types: &[ParamType],
    ) -> Option<[f32; N]> {
        let values = self.numbers(sink, name, types)?;
        let exact = values.first_chunk::<N>().filter(|_| values.len() == N);
        if exact.is_none() {
            let found = values.len();
            let required = format!("one value of {N} numbers, found {found} numbers");
            self.refuse(sink, self.get(name)?, &required);
        }
        exact.copied()
    }

    /// A number, if it is given.
    pub(super) fn maybe_float(&self, sink: &Sink, name: &'static str) -> Option<f32> {
        if let Some(Values::Integers(values)) = self.get(name).map(|param| &param.values)
            && let [value] = values[..]
        {
            return Some(value as f32);
        }
        self.exactly::<1>(sink, name, &[ParamType::Float])
            .map(|[value]| value)
    }

    pub(super) fn float(&self, sink: &Sink, name: &'static str, default: f32) -> f32 {
        self.maybe_float(sink, name).unwrap_or(default)
    }

    /// A number that must satisfy `accept`, which `required` describes.
    pub(super) fn float_where(
        &self,
        sink: &Sink,
        name: &'static str,
        default: f32,
        accept: impl Fn(f32) -> bool,
        required: &str,
    ) -> f32 {
        let value = self.float(sink, name, default);
        if accept(value) {
            return value;
        }
        if let Some(param) = self.get(name) {
            self.refuse(sink, param, required);
        }
        default
    }

    /// A list of numbers.
    pub(super) fn floats(&self, sink: &Sink, name: &'static str) -> Option<&[f32]> {
        self.numbers(sink, name, &[ParamType::Float])
    }

    pub(super) fn point3(&self, sink: &Sink, name: &'static str, default: Vec3) -> Vec3 {
        let types = [ParamType::Point3, ParamType::Vector3];
        self.exactly::<3>(sink, name, &types)
            .map_or(default, Vec3::from_array)
    }

    /// A list of vectors or points.
    pub(super) fn vectors(&self, sink: &Sink, name: &'static str) -> Option<Vec<Vec3>> {
        let types = [ParamType::Point3, ParamType::Vector3, ParamType::Normal];
        let values = self.numbers(sink, name, &types)?;
        let triples = values.chunks_exact(3);
        Some(triples.map(Vec3::from_slice).collect())
    }

    /// A list of pairs. In PBRT v3 texture coordinates are plain numbers.
    pub(super) fn pairs(&self, sink: &Sink, name: &'static str) -> Option<Vec<Vec2>> {
        let types = [ParamType::Point2, ParamType::Vector2, ParamType::Float];
        let values = self.numbers(sink, name, &types)?;
        if !values.len().is_multiple_of(2) {
            self.refuse(sink, self.get(name)?, "pairs of numbers");
        }
        Some(values.chunks_exact(2).map(Vec2::from_slice).collect())
    }

    /// A list of integers.
    pub(super) fn integers(&self, sink: &Sink, name: &'static str) -> Option<&[i32]> {
        let param = self.get(name)?;
        match &param.values {
            Values::Integers(values) => Some(values),
            _ => {
                self.mismatch(sink, param, "`integer`");
                None
            }
        }
    }

    /// An integer of at least `least`.
    pub(super) fn integer(&self, sink: &Sink, name: &'static str, default: i32, least: i32) -> i32 {
        let Some(values) = self.integers(sink, name) else {
            return default;
        };
        match *values {
            [value] if value >= least => value,
            _ => {
                if let Some(param) = self.get(name) {
                    self.refuse(sink, param, &format!("one integer of at least {least}"));
                }
                default
            }
        }
    }

    pub(super) fn boolean(&self, sink: &Sink, name: &'static str, default: bool) -> bool {
        let Some(param) = self.get(name) else {
            return default;
        };
        match &param.values {
            Values::Bools(values) if values.len() == 1 => values[0],
            _ => {
                self.mismatch(sink, param, "one `bool`");
                default
            }
        }
    }

    /// A list of strings.
    pub(super) fn strings(&self, sink: &Sink, name: &'static str) -> Option<&[Text]> {
        let param = self.get(name)?;
        match &param.values {
            Values::Strings(values) if param.ty == ParamType::String => Some(values),
            _ => {
                self.mismatch(sink, param, "`string`");
                None
            }
        }
    }

    pub(super) fn string(&self, sink: &Sink, name: &'static str) -> Option<&Text> {
        let values = self.strings(sink, name)?;
        if values.len() != 1 {
            self.refuse(sink, self.get(name)?, "one string");
        }
        values.first()
    }

    /// A string that must be given.
    pub(super) fn required_string(&self, sink: &Sink, name: &'static str) -> Option<&Text> {
        if !self.has(name) {
            self.missing(sink, name);
        }
        self.string(sink, name)
    }

    /// The value of `choices` with the given name.
    pub(super) fn choice<T: Copy>(
        &self,
        sink: &Sink,
        name: &'static str,
        default: T,
        choices: &[(&'static str, T)],
    ) -> T {
        let Some(text) = self.string(sink, name) else {
            return default;
        };
        if let Some((_, value)) = choices.iter().find(|(choice, _)| *choice == text.value) {
            return *value;
        }
        let names = choices.iter().map(|(choice, _)| *choice);
        let help = match similar(&text.value, names.clone()) {
            Some(similar) => format!("did you mean `{similar}`?"),
            None => format!("expected one of {}", names.collect::<Vec<_>>().join(", ")),
        };
        let message = format!(
            "unknown value `{}` of `{name}` of {}",
            text.value,
            self.describe()
        );
        sink.error(Problem::new("scene::bad_value", text.span, message).help(help));
        default
    }

    /// Reports the parameters that nothing has read: as warnings in files of PBRT v3, which ignores them, else as errors.
    pub(super) fn finish(&self, sink: &Sink, is_v3: bool) {
        let mut known = self.asked.borrow().clone();
        known.sort_unstable();
        known.dedup();
        for (param, used) in self.list.iter().zip(self.used.borrow().iter()) {
            if *used || self.broken.get() {
                continue;
            }
            let name = &param.name.value;
            let help = match similar(name, known.iter().copied()) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None if known.is_empty() => "remove it".to_owned(),
                None => format!("expected one of {}", known.join(", ")),
            };
            let message = format!("{} has no parameter `{name}`", self.describe());
            let problem = Problem::new("scene::unknown_parameter", param.name.span, message);
            if is_v3 {
                sink.warn_once(format!("parameter {name} of {}", self.describe()), problem);
            } else {
                sink.error(problem.help(help));
            }
        }
    }
}
