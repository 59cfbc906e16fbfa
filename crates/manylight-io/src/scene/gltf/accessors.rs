//! Accessors: typed arrays in buffer views. Every read is checked against the size of its view.

use super::buffers::{Buffers, ViewData};
use super::document::Document;
use super::json::Json;
use std::collections::HashMap;

/// Reads accessors by index.
pub(super) struct Accessors<'a, 'b> {
    pub(super) document: &'b Document<'a>,
    pub(super) buffers: &'b Buffers<'a>,
    /// Whether integers are allowed as vertex attributes: the extension KHR_mesh_quantization.
    pub(super) quantized: bool,
    /// Data that replaces what the accessors refer to.
    pub(super) decoded: Decoded,
}

/// Decompressed data of accessors by their indices, packed.
#[derive(Clone, Debug, Default)]
pub(super) struct Decoded(HashMap<usize, DecodedData>);

#[derive(Clone, Debug)]
struct DecodedData {
    bytes: Vec<u8>,
    count: usize,
}

impl Decoded {
    /// Sets the `count` elements of the accessor `index`.
    #[cfg_attr(
        not(feature = "draco"),
        expect(dead_code, reason = "only decoders make data")
    )]
    pub(super) fn insert(&mut self, index: usize, bytes: Vec<u8>, count: usize) {
        self.0.insert(index, DecodedData { bytes, count });
    }
}

/// A component type, by its number in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn new(code: u64) -> Option<Self> {
        Some(match code {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return None,
        })
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Component::I8 => "BYTE",
            Component::U8 => "UNSIGNED_BYTE",
            Component::I16 => "SHORT",
            Component::U16 => "UNSIGNED_SHORT",
            Component::U32 => "UNSIGNED_INT",
            Component::F32 => "FLOAT",
        }
    }

    fn bytes(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// The value at the start of `bytes`.
    fn read(self, bytes: &[u8]) -> f64 {
        match self {
            Component::I8 => f64::from(bytes[0] as i8),
            Component::U8 => f64::from(bytes[0]),
            Component::I16 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            Component::U16 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            Component::U32 => {
                f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
            }
            Component::F32 => {
                f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
            }
        }
    }

    /// Appends `value`, rounded and limited to the range of the type.
    #[cfg_attr(
        not(feature = "draco"),
        expect(dead_code, reason = "only decoders make data")
    )]
    pub(super) fn write(self, value: f64, bytes: &mut Vec<u8>) {
        match self {
            Component::I8 => bytes.push(value.round() as i8 as u8),
            Component::U8 => bytes.push(value.round() as u8),
            Component::I16 => bytes.extend((value.round() as i16).to_le_bytes()),
            Component::U16 => bytes.extend((value.round() as u16).to_le_bytes()),
            Component::U32 => bytes.extend((value.round() as u32).to_le_bytes()),
            Component::F32 => bytes.extend((value as f32).to_le_bytes()),
        }
    }

    /// Factor of normalized integers.
    fn unit(self) -> f64 {
        match self {
            Component::I8 => 1.0 / 127.0,
            Component::U8 => 1.0 / 255.0,
            Component::I16 => 1.0 / 32767.0,
            Component::U16 => 1.0 / 65535.0,
            Component::U32 => 1.0 / f64::from(u32::MAX),
            Component::F32 => 1.0,
        }
    }
}

/// The types of components that an attribute may have, and what they are called in messages.
#[derive(Clone, Copy)]
pub(super) struct Allowed {
    pub(super) components: &'static [Component],
    /// Whether only normalized integers are allowed.
    pub(super) normalized: bool,
}

/// Floating point only.
pub(super) const FLOAT: Allowed = Allowed {
    components: &[Component::F32],
    normalized: false,
};

/// Floating point, and integers of 8 or 16 bits.
pub(super) const QUANTIZED: Allowed = Allowed {
    components: &[
        Component::F32,
        Component::I8,
        Component::U8,
        Component::I16,
        Component::U16,
    ],
    normalized: false,
};

/// Floating point, and normalized unsigned integers.
pub(super) const UNIT: Allowed = Allowed {
    components: &[Component::F32, Component::U8, Component::U16],
    normalized: true,
};

/// Unsigned integers.
pub(super) const INDEX: Allowed = Allowed {
    components: &[Component::U8, Component::U16, Component::U32],
    normalized: false,
};

/// The layout of an accessor.
struct Layout<'a> {
    json: Json<'a>,
    /// Of the accessor.
    index: usize,
    count: usize,
    component: Component,
    normalized: bool,
    /// Offset of each component in an element. Columns of matrices start at multiples of 4.
    offsets: Vec<usize>,
}

impl<'a> Layout<'a> {
    /// Size of an element in bytes.
    fn size(&self) -> usize {
        let last = self
            .offsets
            .last()
            .map_or(0, |last| last + self.component.bytes());
        if self.offsets.len() > 4 || self.json.string("type") == Some("MAT2") {
            return last.next_multiple_of(4);
        }
        last
    }

    /// The value of component `c` of the element at the start of `bytes`.
    fn value(&self, bytes: &[u8], c: usize) -> f32 {
        let value = self.component.read(&bytes[self.offsets[c]..]);
        if self.normalized {
            (value * self.component.unit()).max(-1.0) as f32
        } else {
            value as f32
        }
    }
}

/// The components of an element by the type of an accessor, as columns and rows.
fn shape(kind: &str) -> Option<(usize, usize)> {
    Some(match kind {
        "SCALAR" => (1, 1),
        "VEC2" => (1, 2),
        "VEC3" => (1, 3),
        "VEC4" => (1, 4),
        "MAT2" => (2, 2),
        "MAT3" => (3, 3),
        "MAT4" => (4, 4),
        _ => return None,
    })
}

impl<'a> Accessors<'a, '_> {
    /// These accessors with decompressed data.
    pub(super) fn with_decoded(&self, decoded: Decoded) -> Self {
        Accessors { decoded, ..*self }
    }

    /// Index and component type of the accessor to which `at` refers, into which data is
    /// decompressed.
    #[cfg(feature = "draco")]
    pub(super) fn target(&self, at: &Json<'a>) -> Option<(usize, Component)> {
        let index = at.as_index("accessors", self.document.accessors.len())?;
        let json = &self.document.accessors[index];
        let code = json.required_unsigned("componentType")?;
        let component = Component::new(code);
        if component.is_none() {
            let message = format!("found {code}, expected the number of a component type");
            json.error_at("componentType", message);
        }
        Some((index, component?))
    }

    /// Whether the accessor to which `at` refers refers to a buffer view.
    #[cfg(not(feature = "draco"))]
    pub(super) fn has_view(&self, at: &Json<'a>) -> bool {
        let index = at.as_index("accessors", self.document.accessors.len());
        index.is_some_and(|index| self.document.accessors[index].has("bufferView"))
    }

    /// The allowed components of positions, normals, tangents and texture coordinates.
    pub(super) fn attribute(&self) -> Allowed {
        if self.quantized { QUANTIZED } else { FLOAT }
    }

    /// The elements of the accessor to which `at` refers, of the type `kind` with `N` components.
    pub(super) fn floats<const N: usize>(
        &self,
        at: &Json<'a>,
        kind: &str,
        allowed: Allowed,
    ) -> Option<Vec<[f32; N]>> {
        let layout = self.layout(at, &[kind], allowed)?;
        let elements = self.elements(&layout, |bytes| {
            std::array::from_fn(|c| layout.value(bytes, c))
        })?;
        let is_bad = |element: &[f32; N]| element.iter().any(|v| !v.is_finite());
        if let Some(bad) = elements.iter().position(is_bad) {
            layout.json.error(format!(
                "element {bad} is not finite: {:?} (used by {})",
                elements[bad],
                at.path()
            ));
            return None;
        }
        Some(elements)
    }

    /// The same for colors: three or four components; the fourth is 1 by default.
    pub(super) fn colors(&self, at: &Json<'a>) -> Option<Vec<[f32; 4]>> {
        let layout = self.layout(at, &["VEC3", "VEC4"], UNIT)?;
        let has_alpha = layout.offsets.len() == 4;
        self.elements(&layout, |bytes| {
            let finite = |v: f32| if v.is_finite() { v } else { 0.0 };
            let color = |c| finite(layout.value(bytes, c));
            let alpha = if has_alpha { color(3) } else { 1.0 };
            [color(0), color(1), color(2), alpha]
        })
    }

    /// Integers of the accessor to which `at` refers.
    pub(super) fn integers<const N: usize>(
        &self,
        at: &Json<'a>,
        kind: &str,
        allowed: Allowed,
    ) -> Option<Vec<[u32; N]>> {
        let layout = self.layout(at, &[kind], allowed)?;
        self.elements(&layout, |bytes| {
            std::array::from_fn(|c| layout.component.read(&bytes[layout.offsets[c]..]) as u32)
        })
    }

    /// The checked layout of the accessor to which `at` refers.
    fn layout(&self, at: &Json<'a>, kinds: &[&str], allowed: Allowed) -> Option<Layout<'a>> {
        let index = at.as_index("accessors", self.document.accessors.len())?;
        let json = self.document.accessors[index].clone();
        let kind = json.string("type");
        let Some(kind) = kind.filter(|kind| kinds.contains(kind)) else {
            let found = kind.map_or("nothing".into(), |kind| format!("`{kind}`"));
            let expected = kinds.join(" or ");
            json.error_at(
                "type",
                format!("found {found}, expected {expected} for {}", at.path()),
            );
            return None;
        };
        let code = json.required_unsigned("componentType")?;
        let component = Component::new(code);
        let normalized = json.boolean("normalized");
        let fits = |c: &Component| {
            allowed.components.contains(c)
                && (!allowed.normalized || normalized || *c == Component::F32)
        };
        let Some(component) = component.filter(fits) else {
            json.error_at(
                "componentType",
                mismatch(component, code, allowed, at.path()),
            );
            return None;
        };
        let count = json.required_unsigned("count")?;
        if count == 0 {
            json.unexpected("count", 0, "at least 1");
            return None;
        }
        let (columns, rows) = shape(kind)?;
        let bytes = component.bytes();
        let column = if columns > 1 {
            (rows * bytes).next_multiple_of(4)
        } else {
            rows * bytes
        };
        let offsets = (0..columns).flat_map(|c| (0..rows).map(move |r| c * column + r * bytes));
        Some(Layout {
            count: usize::try_from(count).ok()?,
            component,
            normalized,
            offsets: offsets.collect(),
            index,
            json,
        })
    }

    /// All elements, converted by `read`.
    fn elements<T: Copy>(&self, layout: &Layout<'a>, read: impl Fn(&[u8]) -> T) -> Option<Vec<T>> {
        let json = &layout.json;
        let decoded = self.decoded.0.get(&layout.index);
        let mut elements = match (decoded, json.get("bufferView")) {
            (Some(decoded), _) => decoded_elements(decoded, layout, &read)?,
            (None, Some(view)) => {
                let index = view.as_index("bufferViews", self.document.views.len())?;
                let offset = json.unsigned("byteOffset").unwrap_or(0);
                let data = self.buffers.view(index)?;
                let parts = strided(json, data, offset, layout.count, layout.size())?;
                parts.map(&read).collect()
            }
            (None, None) => {
                // Nothing in the file limits the count of an accessor without data but the data
                // that belong to it.
                if layout.count > self.buffers.total_bytes() {
                    json.error_at(
                        "count",
                        format!(
                            "found {} elements without a `bufferView`, more than the buffers of the file have bytes",
                            layout.count
                        ),
                    );
                    return None;
                }
                vec![read(&vec![0; layout.size()]); layout.count]
            }
        };
        if let Some(sparse) = json.member("sparse") {
            self.replace(&sparse, layout, &mut elements, read)?;
        }
        Some(elements)
    }

    /// Replaces the elements of a sparse accessor.
    fn replace<T: Copy>(
        &self,
        sparse: &Json<'a>,
        layout: &Layout<'a>,
        elements: &mut [T],
        read: impl Fn(&[u8]) -> T,
    ) -> Option<()> {
        let count = sparse.required_unsigned("count")? as usize;
        let part = |name: &str, size: usize| {
            let Some(json) = sparse.member(name) else {
                sparse.error(format!("the object `{name}` is missing"));
                return None;
            };
            let index = json.index("bufferView", "bufferViews", self.document.views.len())?;
            let data = self.buffers.view(index)?;
            let offset = json.unsigned("byteOffset").unwrap_or(0);
            let packed = ViewData {
                stride: None,
                ..data
            };
            Some(strided(&json, packed, offset, count, size)?.collect::<Vec<_>>())
        };
        let json = sparse.member("indices");
        let code = json.and_then(|json| json.required_unsigned("componentType"));
        let component = code.and_then(Component::new);
        let Some(component) = component.filter(|c| INDEX.components.contains(c)) else {
            sparse.error("the indices need a `componentType` of unsigned integers");
            return None;
        };
        let indices = part("indices", component.bytes())?;
        let values = part("values", layout.size())?;
        for (i, (index, value)) in indices.into_iter().zip(values).enumerate() {
            let index = component.read(index) as usize;
            let Some(element) = elements.get_mut(index) else {
                let limit = layout.count;
                sparse.error(format!("index {i} is {index}, expected less than {limit}"));
                return None;
            };
            *element = read(value);
        }
        Some(())
    }
}

/// All elements of decompressed data. Their number may differ from that of the accessor only by
/// mistake.
fn decoded_elements<T>(
    decoded: &DecodedData,
    layout: &Layout<'_>,
    read: impl Fn(&[u8]) -> T,
) -> Option<Vec<T>> {
    let DecodedData { bytes, count } = decoded;
    let size = layout.component.bytes() * layout.offsets.len();
    if *count != layout.count || bytes.len() != size * count {
        layout.json.error(format!(
            "found {} elements of {size} bytes, but the compressed data has {count} in {} bytes",
            layout.count,
            bytes.len()
        ));
        return None;
    }
    Some(bytes.chunks_exact(size).map(read).collect())
}

/// The message about a component type that is not allowed.
fn mismatch(found: Option<Component>, code: u64, allowed: Allowed, user: &str) -> String {
    let names: Vec<&str> = allowed.components.iter().map(|c| c.name()).collect();
    let names = names.join(", ");
    match found {
        Some(found) if allowed.components.contains(&found) => {
            format!(
                "found {} that is not `normalized`, for {user}",
                found.name()
            )
        }
        Some(found) => format!("found {}, expected {names} for {user}", found.name()),
        None => format!("found {code}, expected the number of {names} for {user}"),
    }
}

/// `count` elements of `size` bytes each, `offset` bytes into a view. `json` describes them in
/// messages.
fn strided<'v>(
    json: &Json<'_>,
    data: ViewData<'v>,
    offset: u64,
    count: usize,
    size: usize,
) -> Option<impl Iterator<Item = &'v [u8]>> {
    let stride = data.stride.unwrap_or(size);
    let available = data.bytes.len();
    if stride < size {
        json.error(format!(
            "elements of {size} bytes do not fit the stride of {stride} bytes of the buffer view"
        ));
        return None;
    }
    let span = (count as u64).saturating_sub(1).checked_mul(stride as u64);
    let end = span.and_then(|span| span.checked_add(size as u64)?.checked_add(offset));
    if count == 0 || end.is_none_or(|end| end > available as u64) {
        json.error(format!(
            "{count} elements of {size} bytes at offset {offset} do not fit the {available} bytes of the buffer view"
        ));
        return None;
    }
    let bytes = &data.bytes[offset as usize..];
    Some((0..count).map(move |i| &bytes[i * stride..i * stride + size]))
}
