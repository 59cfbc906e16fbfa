//! XML elements with source spans.

use super::super::super::sink::{Problem, Sink, Text};
use crate::suggest::one_of;
use std::path::PathBuf;
use std::sync::Arc;

/// The generation of the scene format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Dialect {
    /// Versions 0.x and 1.x: camelCase names, other defaults, y up for the sky.
    V0,
    /// Versions 2 and 3.
    V3,
}

/// An attribute. Parameters in its value are replaced.
#[derive(Clone, Debug)]
pub(in super::super) struct Attribute {
    pub(in super::super) name: Text,
    pub(in super::super) value: Text,
}

/// An element. Included files are part of the children.
#[derive(Clone, Debug)]
pub(in super::super) struct XmlElement {
    pub(in super::super) tag: Text,
    pub(in super::super) attributes: Vec<Attribute>,
    pub(in super::super) children: Vec<XmlElement>,
    pub(in super::super) dialect: Dialect,
    /// Search path of the files that the element names.
    pub(in super::super) folders: Arc<[PathBuf]>,
}

impl XmlElement {
    /// The value of the attribute `name`.
    pub(in super::super) fn attribute(&self, name: &str) -> Option<&Text> {
        self.attributes
            .iter()
            .find(|attribute| attribute.name.value == name)
            .map(|attribute| &attribute.value)
    }
    /// The value of the attribute `name`; its absence is reported.
    pub(in super::super) fn required(&self, sink: &Sink, name: &str) -> Option<&Text> {
        let found = self.attribute(name);
        if found.is_none() {
            let message = format!("<{}> needs the attribute `{name}`", self.tag.value);
            let problem = Problem::new("scene::missing_attribute", self.tag.span, message);
            sink.error(problem.label("in this element"));
        }
        found
    }

    /// Reports the attributes that are not in `known`.
    pub(in super::super) fn check_attributes(&self, sink: &Sink, known: &[&str]) {
        for attribute in &self.attributes {
            let name = attribute.name.value.as_str();
            if known.contains(&name) {
                continue;
            }
            let message = format!("<{}> has no attribute `{name}`", self.tag.value);
            let problem = Problem::new("scene::unknown_attribute", attribute.name.span, message);
            sink.error(problem.help(one_of(name, known.iter().copied())));
        }
    }
}
