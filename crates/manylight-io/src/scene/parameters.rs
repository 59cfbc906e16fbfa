//! Parameters of the objects of a scene: what the readers of all formats share. Every parameter
//! that is read is noted, so that those that nothing reads can be reported as unknown.

use super::sink::{FileSpan, Problem, Sink, Text};
use crate::suggest::{did_you_mean, one_of};
use std::cell::{Cell, RefCell};
use std::fmt::Display;

/// Which of the parameters of an object have been read, and the names that have been asked for.
#[derive(Debug, Default)]
pub(super) struct Reads {
    asked: RefCell<Vec<&'static str>>,
    read: Vec<Cell<bool>>,
}

impl Reads {
    /// For `count` parameters.
    pub(super) fn new(count: usize) -> Self {
        Reads {
            asked: RefCell::default(),
            read: vec![Cell::new(false); count],
        }
    }

    /// Notes that a parameter of this name is valid.
    pub(super) fn ask(&self, name: &'static str) {
        self.asked.borrow_mut().push(name);
    }

    /// Notes that the parameter of this index has been read.
    pub(super) fn note(&self, index: usize) {
        self.read[index].set(true);
    }

    /// Notes that all parameters have been read, for an object that is replaced as a whole.
    pub(super) fn note_all(&self) {
        self.read.iter().for_each(|read| read.set(true));
    }

    /// The parameters in `list` that have not been read.
    pub(super) fn unread<'l, P>(&self, list: &'l [P]) -> impl Iterator<Item = &'l P> {
        let unread = list.iter().zip(&self.read).filter(|(_, read)| !read.get());
        unread.map(|(param, _)| param)
    }

    /// The names that have been asked for, sorted.
    pub(super) fn names(&self) -> Vec<&'static str> {
        let mut names = self.asked.borrow().clone();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// The names that may be meant by one that has not been asked for; `nothing` if there are none.
    pub(super) fn expected(&self, name: &str, nothing: &str) -> String {
        match self.names().as_slice() {
            [] => nothing.to_owned(),
            names => one_of(name, names.iter().copied()),
        }
    }
}

/// Numbers of an object, by name. An invalid one is reported, and the default is returned, so that
/// all errors are found.
pub(super) trait Numbers {
    /// The number `name`, if it is given.
    fn maybe_float(&self, name: &'static str) -> Option<f32>;

    /// Reports that the number `name` is not as `required`.
    fn refuse_float(&self, name: &'static str, found: f32, required: &str);

    /// The number `name`, by default `default`.
    fn float(&self, name: &'static str, default: f32) -> f32 {
        self.maybe_float(name).unwrap_or(default)
    }

    /// The number `name`, which `accept` accepts; `required` says which numbers it does.
    fn float_where(
        &self,
        name: &'static str,
        default: f32,
        accept: impl Fn(f32) -> bool,
        required: &str,
    ) -> f32 {
        match self.maybe_float(name) {
            Some(value) if accept(value) => value,
            Some(value) => {
                self.refuse_float(name, value, required);
                default
            }
            None => default,
        }
    }
}

/// Parameters of a plugin in a text file.
pub(super) trait Parameters: Numbers {
    /// A parameter with its location.
    type Param;

    fn sink(&self) -> &Sink;

    /// The object in messages, such as "shape `sphere`".
    fn describe(&self) -> String;

    /// Location of the name of the plugin.
    fn span(&self) -> FileSpan;

    /// The parameter `name`, which counts as read.
    fn get(&self, name: &'static str) -> Option<&Self::Param>;

    /// Whether the parameter `name` is given. It does not count as read.
    fn has(&self, name: &str) -> bool;

    /// Whether a parameter is invalid and has been reported, so that others may seem to be missing.
    fn is_broken(&self) -> bool {
        false
    }

    /// Reports that a value has another type than `expected`.
    fn mismatch(&self, param: &Self::Param, expected: &dyn Display);

    /// Reports that a value of the right type is not as `required`.
    fn refuse(&self, param: &Self::Param, required: &str);

    /// The string `name`, if it is given.
    fn string(&self, name: &'static str) -> Option<&Text>;

    /// The value of the parameter `name` as `read` gives it. Another type than `expected` is
    /// reported.
    fn typed<'s, T>(
        &'s self,
        name: &'static str,
        expected: &dyn Display,
        read: impl FnOnce(&'s Self::Param) -> Option<T>,
    ) -> Option<T> {
        let param = self.get(name)?;
        let value = read(param);
        if value.is_none() {
            self.mismatch(param, expected);
        }
        value
    }

    /// Lets parameters count as read that are valid but have no effect.
    fn ignore(&self, names: &[&'static str]) {
        for name in names {
            self.get(name);
        }
    }

    /// Reports that the parameter `name` is not as `required`. It must be given.
    fn refuse_named(&self, name: &'static str, required: &str) {
        if let Some(param) = self.get(name) {
            self.refuse(param, required);
        }
    }

    /// Reports the absence of a parameter without a default.
    fn missing(&self, name: &str) {
        if !self.is_broken() {
            let message = format!("{} needs the parameter `{name}`", self.describe());
            let sink = self.sink();
            sink.error_at("scene::missing_parameter", self.span(), message);
        }
    }

    /// Reports the parameter `name` if it is missing.
    fn require(&self, name: &str) {
        if !self.has(name) {
            self.missing(name);
        }
    }

    /// A string without a default.
    fn required_string(&self, name: &'static str) -> Option<&Text> {
        self.require(name);
        self.string(name)
    }

    /// The value of `choices` with the given name.
    fn choice<T: Copy>(&self, name: &'static str, default: T, choices: &[(&str, T)]) -> T {
        let Some(text) = self.string(name) else {
            return default;
        };
        if let Some((_, value)) = choices.iter().find(|(choice, _)| *choice == text.value) {
            return *value;
        }
        let (value, object) = (&text.value, self.describe());
        let message = format!("unknown value `{value}` of `{name}` of {object}");
        let help = one_of(value, choices.iter().map(|(choice, _)| *choice));
        let problem = Problem::new("scene::bad_value", text.span, message);
        self.sink().error(problem.help(help));
        default
    }

    /// Warns once for each `subject` that something about the object is not supported.
    fn unsupported(&self, subject: impl Into<String>, message: impl Into<String>) {
        self.sink().unsupported(subject, self.span(), message);
    }

    /// The report that the object has no parameter of this name.
    fn unknown_parameter(&self, name: &Text) -> Problem {
        let message = format!("{} has no parameter `{}`", self.describe(), name.value);
        Problem::new("scene::unknown_parameter", name.span, message)
    }
}

/// The report that nothing has this name. `message` says so.
pub(super) fn unresolved<'n>(
    name: &Text,
    message: String,
    known: impl IntoIterator<Item = &'n str>,
) -> Problem {
    let help = did_you_mean(&name.value, known);
    Problem::new("scene::unresolved_reference", name.span, message).maybe_help(help)
}
