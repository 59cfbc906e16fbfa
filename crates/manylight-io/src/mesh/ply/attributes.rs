//! Attributes of PLY elements, by the naming rules of Mitsuba 3.9: `r g b` or `red green blue` are
//! the color; other attributes are runs of properties `NAME_x`, `NAME_r`, `NAME_0` or `NAME_1`,
//! alone or followed by the two next letters or digits.

use super::header::{PlyElement, Property};
use crate::mesh::attributes::{AttributePlace, MeshAttribute};
use manylight::color::Rgb;
use std::collections::HashSet;

/// First, second and third letter of the names of the channels, by kind.
const CHANNELS: [[char; 3]; 4] = [
    ['x', 'y', 'z'],
    ['r', 'g', 'b'],
    ['0', '1', '2'],
    ['1', '2', '3'],
];
/// Kind of [`CHANNELS`] that adds `_color` to the name.
const COLOR_KIND: usize = 1;

/// The attributes of an element, while it is read.
pub(super) struct AttributeReader {
    attributes: Vec<MeshAttribute>,
    /// By property: index of the attribute and channels that it sets.
    targets: Vec<Option<(usize, [bool; 3])>>,
}

impl AttributeReader {
    /// Without attributes.
    pub(super) fn none(element: &PlyElement) -> Self {
        AttributeReader {
            attributes: Vec::new(),
            targets: vec![None; element.properties.len()],
        }
    }

    /// The attributes of `element` among the properties that are not `reserved`.
    pub(super) fn new(
        element: &PlyElement,
        place: AttributePlace,
        reserved: impl Fn(usize) -> bool,
    ) -> Self {
        let mut reader = AttributeReader::none(element);
        let prefix = match place {
            AttributePlace::Vertices => "vertex_",
            AttributePlace::Triangles => "face_",
        };
        let mut add = |name: String, properties: &[usize]| {
            let attribute = reader.attributes.len();
            for (channel, &property) in properties.iter().enumerate() {
                let all = properties.len() == 1;
                let channels = std::array::from_fn(|c| all || c == channel);
                reader.targets[property] = Some((attribute, channels));
            }
            reader.attributes.push(MeshAttribute {
                name,
                place,
                from_integers: properties
                    .iter()
                    .any(|&i| element.properties[i].number.is_integer()),
                values: Vec::new(),
            });
        };
        let color = color_properties(element);
        if let Some(color) = color {
            add(format!("{prefix}color"), &color);
        }
        let is_free = |i: usize| !reserved(i) && color.is_none_or(|color| !color.contains(&i));
        for run in runs(element, is_free) {
            let color = if run.kind == COLOR_KIND { "_color" } else { "" };
            add(format!("{prefix}{}{color}", run.name), &run.properties);
        }
        reader
    }

    /// Whether the property `index` belongs to an attribute.
    pub(super) fn wants(&self, index: usize) -> bool {
        self.targets[index].is_some()
    }

    /// Starts the next vertex or triangle.
    pub(super) fn next(&mut self) {
        for attribute in &mut self.attributes {
            attribute.values.push(Rgb::BLACK);
        }
    }

    /// Sets the value of the property `index` for the current vertex or triangle.
    pub(super) fn set(&mut self, index: usize, property: &Property, value: f64) {
        let Some((attribute, channels)) = self.targets[index] else {
            return;
        };
        let value = property.number.normalized(value);
        let Some(color) = self.attributes[attribute].values.last_mut() else {
            return;
        };
        for (slot, _) in [&mut color.r, &mut color.g, &mut color.b]
            .into_iter()
            .zip(channels)
            .filter(|(_, is_set)| *is_set)
        {
            *slot = value;
        }
    }

    /// Gives the last value again, or takes it back, so that there are `count` of them: a polygon
    /// may be any number of triangles.
    pub(super) fn repeat_last(&mut self, count: usize) {
        for attribute in &mut self.attributes {
            let last = attribute.values.last().copied().unwrap_or(Rgb::BLACK);
            attribute.values.resize(count, last);
        }
    }

    pub(super) fn finish(self) -> Vec<MeshAttribute> {
        self.attributes
    }
}

/// The properties of the color of an element.
fn color_properties(element: &PlyElement) -> Option<[usize; 3]> {
    let find = |names: [&str; 3]| {
        let found = names.map(|name| element.position(&[name]));
        match found {
            [Some(r), Some(g), Some(b)] => Some([r, g, b]),
            _ => None,
        }
    };
    find(["r", "g", "b"]).or_else(|| find(["red", "green", "blue"]))
}

/// Consecutive properties of one attribute.
struct Run<'a> {
    name: &'a str,
    /// Index into [`CHANNELS`].
    kind: usize,
    properties: Vec<usize>,
}

/// The runs of one or three channels among the free properties.
fn runs(element: &PlyElement, is_free: impl Fn(usize) -> bool) -> Vec<Run<'_>> {
    let mut found: Vec<Run<'_>> = Vec::new();
    let mut names: HashSet<&str> = HashSet::new();
    for (i, property) in element.properties.iter().enumerate() {
        let Some((name, channel)) = property.name.rsplit_once('_') else {
            continue;
        };
        if property.length.is_some() || !is_free(i) {
            continue;
        }
        if let Some(run) = found.last_mut()
            && run.name == name
        {
            run.properties.push(i);
            continue;
        }
        let mut letters = channel.chars();
        let first = letters.next().filter(|_| letters.next().is_none());
        let kind = CHANNELS.iter().position(|kind| Some(kind[0]) == first);
        if let Some(kind) = kind
            && names.insert(name)
        {
            found.push(Run {
                name,
                kind,
                properties: vec![i],
            });
        }
    }
    let in_order = |run: &Run<'_>| {
        let channels = run.properties.iter().map(|&i| &element.properties[i].name);
        let expected = CHANNELS[run.kind];
        channels
            .zip(expected)
            .all(|(name, letter)| name.ends_with(letter))
    };
    found.retain(|run| matches!(run.properties.len(), 1 | 3) && in_order(run));
    found
}
