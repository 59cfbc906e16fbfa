//! Values of the JSON tree with their paths. A value of a wrong type is reported, and its default
//! returned: loading goes on.

use super::super::parameters::Numbers;
use super::report::Reporter;
use serde_json::{Map, Value};
use std::fmt::Display;

/// A JSON value and where it is.
#[derive(Clone)]
pub(super) struct Json<'a> {
    value: &'a Value,
    path: String,
    reporter: &'a Reporter<'a>,
}

impl Numbers for Json<'_> {
    fn maybe_float(&self, name: &'static str) -> Option<f32> {
        self.number(name).map(|v| v as f32)
    }

    fn refuse_float(&self, name: &'static str, found: f32, required: &str) {
        self.unexpected(name, found, required);
    }
}

impl<'a> Json<'a> {
    /// The whole document.
    pub(super) fn root(value: &'a Value, reporter: &'a Reporter<'a>) -> Self {
        Json {
            value,
            path: String::new(),
            reporter,
        }
    }

    /// The path of the value, such as `/meshes/0/name`.
    pub(super) fn path(&self) -> &str {
        &self.path
    }

    /// The path of a member.
    pub(super) fn path_of(&self, name: &str) -> String {
        format!("{}/{name}", self.path)
    }

    /// Reports an error about this value.
    pub(super) fn error(&self, message: impl AsRef<str>) {
        self.reporter.error(&self.path, message);
    }

    /// Reports an error about the member `name`.
    pub(super) fn error_at(&self, name: &str, message: impl AsRef<str>) {
        self.reporter.error(&self.path_of(name), message);
    }

    /// Reports that the member `name` is not as `expected`.
    pub(super) fn unexpected(&self, name: &str, found: impl Display, expected: &str) {
        self.error_at(name, format!("found {found}, expected {expected}"));
    }

    /// Warns about this value, once for each `subject`.
    pub(super) fn warn_once(&self, subject: &str, message: impl AsRef<str>) {
        self.reporter.warn_once(subject, &self.path, message);
    }

    /// Reports that the geometry here is compressed by an extension of which this build has no
    /// decoder.
    #[cfg(not(all(feature = "draco", feature = "meshopt")))]
    pub(super) fn refuse_compressed(&self, extension: &str, feature: &str) {
        let message =
            format!("geometry compressed by the extension `{extension}` is not read by this build");
        // gltf-transform 4 does not read the newer name of the extension.
        let expanding = match extension {
            "KHR_meshopt_compression" => "",
            _ => ", or expand the file, for example by `gltf-transform copy IN OUT`",
        };
        let help = format!(
            "build with `--features {feature}`, export the scene without mesh compression{expanding}"
        );
        self.reporter
            .error_once(extension, &self.path, &message, help);
    }

    pub(super) fn reporter(&self) -> &'a Reporter<'a> {
        self.reporter
    }

    fn object(&self) -> Option<&'a Map<String, Value>> {
        self.value.as_object()
    }

    fn child(&self, name: &str, value: &'a Value) -> Json<'a> {
        Json {
            value,
            path: self.path_of(name),
            reporter: self.reporter,
        }
    }

    /// The member `name`, of any type.
    pub(super) fn get(&self, name: &str) -> Option<Json<'a>> {
        let value = self.object()?.get(name)?;
        Some(self.child(name, value))
    }

    /// The member `name` of `extras`, where anything may stand, if it is text.
    pub(super) fn extra_text(&self, name: &str) -> Option<&'a str> {
        self.object()?.get("extras")?.get(name)?.as_str()
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.object()
            .is_some_and(|object| object.contains_key(name))
    }

    /// Reports this value, which is not what was `expected`.
    fn mismatch(&self, expected: &str) {
        self.error(format!("found {}, expected {expected}", shown(self.value)));
    }

    /// The member `name`, an object.
    pub(super) fn member(&self, name: &str) -> Option<Json<'a>> {
        let member = self.get(name)?;
        if member.value.is_object() {
            return Some(member);
        }
        member.mismatch("an object");
        None
    }

    /// The names and values of an object.
    pub(super) fn members(&self) -> Vec<(&'a str, Json<'a>)> {
        let members = self.object().into_iter().flatten();
        members
            .map(|(name, value)| (name.as_str(), self.child(name, value)))
            .collect()
    }

    /// The elements of the array `name`; none if it is absent.
    pub(super) fn items(&self, name: &str) -> Vec<Json<'a>> {
        let Some(array) = self.get(name) else {
            return Vec::new();
        };
        let Value::Array(values) = array.value else {
            array.mismatch("an array");
            return Vec::new();
        };
        let items = values.iter().enumerate();
        items
            .map(|(i, value)| array.child(&i.to_string(), value))
            .collect()
    }

    /// The elements of the array `name`, all objects.
    pub(super) fn objects(&self, name: &str) -> Vec<Json<'a>> {
        let items = self.items(name);
        for item in items.iter().filter(|item| !item.value.is_object()) {
            item.mismatch("an object");
        }
        items
    }

    /// The extension `name` of this object.
    pub(super) fn extension(&self, name: &str) -> Option<Json<'a>> {
        self.member("extensions")?.member(name)
    }

    /// Whether both values are the same.
    pub(super) fn equals(&self, other: &Json<'_>) -> bool {
        self.value == other.value
    }

    /// The value as a string.
    pub(super) fn as_string(&self) -> Option<&'a str> {
        let text = self.value.as_str();
        if text.is_none() {
            self.mismatch("a string");
        }
        text
    }

    pub(super) fn string(&self, name: &str) -> Option<&'a str> {
        self.get(name)?.as_string()
    }

    pub(super) fn boolean(&self, name: &str) -> bool {
        let Some(member) = self.get(name) else {
            return false;
        };
        member.value.as_bool().unwrap_or_else(|| {
            member.mismatch("`true` or `false`");
            false
        })
    }

    /// The value as an integer of at least 0.
    pub(super) fn as_unsigned(&self) -> Option<u64> {
        let number = match self.value.as_f64() {
            // Some writers give integers as 3.0.
            Some(v) if v >= 0.0 && v.fract() == 0.0 && v < 9e15 => Some(v as u64),
            _ => None,
        };
        if number.is_none() {
            self.mismatch("an integer of at least 0");
        }
        number
    }

    pub(super) fn unsigned(&self, name: &str) -> Option<u64> {
        self.get(name)?.as_unsigned()
    }

    /// Reports the absence of the property `name`.
    pub(super) fn check_given(&self, name: &str) -> Option<()> {
        if self.has(name) {
            return Some(());
        }
        self.error(format!("the property `{name}` is missing"));
        None
    }

    /// The object `name`, which must be present.
    pub(super) fn required_member(&self, name: &str) -> Option<Json<'a>> {
        if !self.has(name) {
            self.error(format!("the object `{name}` is missing"));
        }
        self.member(name)
    }

    /// The integer `name`, which must be present.
    pub(super) fn required_unsigned(&self, name: &str) -> Option<u64> {
        self.check_given(name)?;
        self.unsigned(name)
    }

    /// The value as an index into `count` elements of the array `of`.
    pub(super) fn as_index(&self, of: &str, count: usize) -> Option<usize> {
        let index = self.as_unsigned()?;
        if index < count as u64 {
            return Some(index as usize);
        }
        let range = match count {
            0 => format!("but the file has no {of}"),
            _ => format!("expected an index of {of} from 0 to {}", count - 1),
        };
        self.error(format!("found {index}, {range}"));
        None
    }

    pub(super) fn index(&self, name: &str, of: &str, count: usize) -> Option<usize> {
        self.get(name)?.as_index(of, count)
    }

    /// The value as a finite number.
    fn as_number(&self) -> Option<f64> {
        let number = self.value.as_f64().filter(|v| (*v as f32).is_finite());
        if number.is_none() {
            self.mismatch("a number");
        }
        number
    }

    /// The value as a finite `f32`.
    pub(super) fn as_float(&self) -> Option<f32> {
        self.as_number().map(|v| v as f32)
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.get(name)?.as_number()
    }

    /// A factor in [0, 1].
    pub(super) fn fraction(&self, name: &'static str, default: f32) -> f32 {
        let is_inside = |v| (0.0..=1.0).contains(&v);
        self.float_where(name, default, is_inside, "a number from 0 to 1")
    }

    /// The array `name` of `N` numbers.
    pub(super) fn numbers<const N: usize>(&self, name: &str) -> Option<[f64; N]> {
        let array = self.get(name)?;
        let Value::Array(values) = array.value else {
            array.mismatch(&format!("an array of {N} numbers"));
            return None;
        };
        if values.len() != N {
            array.error(format!("found {} numbers, expected {N}", values.len()));
            return None;
        }
        let mut numbers = [0.0; N];
        for (i, (number, value)) in numbers.iter_mut().zip(values).enumerate() {
            *number = match value.as_f64() {
                Some(v) if (v as f32).is_finite() => v,
                _ => array.child(&i.to_string(), value).as_number()?,
            };
        }
        Some(numbers)
    }

    /// The same as `f32`, by default `default`.
    pub(super) fn floats<const N: usize>(&self, name: &str, default: [f32; N]) -> [f32; N] {
        self.numbers(name)
            .map_or(default, |numbers| numbers.map(|v| v as f32))
    }
}

/// A value in a message.
fn shown(value: &Value) -> String {
    match value {
        Value::Object(_) => "an object".into(),
        Value::Array(_) => "an array".into(),
        other => format!("`{other}`"),
    }
}
