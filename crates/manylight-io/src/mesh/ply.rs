//! Stanford PLY: ASCII, binary little and big endian.
//!
//! Of the element `vertex` it takes `x y z`, `nx ny nz` and one pair of texture coordinates (`u v`, `s t`,
//! `texture_u texture_v`, `texture_s texture_t`); of the element `face` the list `vertex_indices` (or `vertex_index`).
//! Everything else is skipped. Polygons become fans around their first corner.

use super::text::{Cursor, parse_number};
use crate::file_error::Fault;
use manylight::geometry::Mesh;
use manylight::math::{Vec2, Vec3};

/// The mesh in `bytes`.
pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, Fault> {
    let header = Header::parse(bytes)?;
    let mut body = Body::new(bytes, &header);
    let mut mesh = Mesh::default();
    let mut seen = [false; 2];
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => {
                read_vertices(element, &mut body, &mut mesh)?;
                seen[0] = true;
            }
            "face" => {
                read_faces(element, &mut body, &mut mesh)?;
                seen[1] = true;
            }
            _ => skip_element(element, &mut body)?,
        }
        if seen == [true; 2] {
            break;
        }
    }
    check_indices(&mesh)?;
    Ok(mesh)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn from_name(name: &str) -> Option<Number> {
        Some(match name {
            "char" | "int8" => Number::I8,
            "uchar" | "uint8" => Number::U8,
            "short" | "int16" => Number::I16,
            "ushort" | "uint16" => Number::U16,
            "int" | "int32" => Number::I32,
            "uint" | "uint32" => Number::U32,
            "float" | "float32" => Number::F32,
            "double" | "float64" => Number::F64,
            _ => return None,
        })
    }
}

#[derive(Debug)]
struct Property {
    name: String,
    /// The type of a list's length; `None` for a single number.
    length: Option<Number>,
    number: Number,
}

#[derive(Debug)]
struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

impl Element {
    fn position(&self, names: &[&str]) -> Option<usize> {
        self.properties
            .iter()
            .position(|p| p.length.is_none() && names.contains(&p.name.as_str()))
    }
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    /// Offset of the first byte after it.
    end: usize,
    /// The line on which the body begins.
    end_line: u32,
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Header, Fault> {
        let mut cursor = Cursor::new(bytes, 1);
        if !(bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r\n")) {
            return Err(cursor.fault("a PLY file, which starts with the line 'ply'"));
        }
        cursor.next_line();
        let mut encoding = None;
        let mut elements = Vec::new();
        loop {
            if cursor.at_end() {
                return Err(cursor.fault("'end_header'"));
            }
            let line = first_line(cursor.rest());
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words[..] {
                [] | ["comment", ..] | ["obj_info", ..] => {}
                ["end_header"] => break,
                ["format", name, ..] => encoding = Some(parse_encoding(name, cursor)?),
                ["element", name, count] => elements.push(parse_element(name, count, cursor)?),
                ["property", ..] => {
                    let property = parse_property(&words, cursor)?;
                    let element: Option<&mut Element> = elements.last_mut();
                    element
                        .ok_or_else(|| cursor.complaint("a property before the first element"))?
                        .properties
                        .push(property);
                }
                _ => {
                    return Err(cursor.fault(
                        "a line of a PLY header (format, comment, element, property, end_header)",
                    ));
                }
            }
            cursor.next_line();
        }
        cursor.next_line();
        let encoding = encoding.ok_or_else(|| cursor.complaint("the header names no format"))?;
        Ok(Header {
            encoding,
            elements,
            end: bytes.len() - cursor.rest().len(),
            end_line: cursor.line(),
        })
    }
}

fn first_line(rest: &[u8]) -> &str {
    let line = rest.split(|&b| b == b'\n').next().unwrap_or_default();
    // Comments may be in any encoding and are not looked at.
    std::str::from_utf8(line).unwrap_or("comment")
}

fn parse_encoding(name: &str, cursor: Cursor) -> Result<Encoding, Fault> {
    match name {
        "ascii" => Ok(Encoding::Ascii),
        "binary_little_endian" => Ok(Encoding::LittleEndian),
        "binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(cursor.complaint(format!(
            "unknown format '{name}'; expected ascii, binary_little_endian or binary_big_endian"
        ))),
    }
}

fn parse_element(name: &str, count: &str, cursor: Cursor) -> Result<Element, Fault> {
    let count = count
        .parse()
        .map_err(|_| cursor.complaint(format!("'{count}' is not a number of elements")))?;
    Ok(Element {
        name: name.to_owned(),
        count,
        properties: Vec::new(),
    })
}

fn parse_property(words: &[&str], cursor: Cursor) -> Result<Property, Fault> {
    let number = |name: &str| {
        Number::from_name(name)
            .ok_or_else(|| cursor.complaint(format!("unknown property type '{name}'")))
    };
    match *words {
        ["property", "list", length, item, name] => Ok(Property {
            name: name.to_owned(),
            length: Some(number(length)?),
            number: number(item)?,
        }),
        ["property", item, name] => Ok(Property {
            name: name.to_owned(),
            length: None,
            number: number(item)?,
        }),
        _ => {
            Err(cursor.complaint("expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'"))
        }
    }
}

/// The values behind the header, one after the other.
struct Body<'a> {
    bytes: &'a [u8],
    encoding: Encoding,
    offset: usize,
    cursor: Cursor<'a>,
}

impl<'a> Body<'a> {
    fn new(bytes: &'a [u8], header: &Header) -> Self {
        let cursor = Cursor::new(&bytes[header.end..], header.end_line);
        Body {
            bytes,
            encoding: header.encoding,
            offset: header.end,
            cursor,
        }
    }

    /// A bound on how many elements can still follow, so that a wrong count takes no memory.
    fn at_most(&self, count: usize) -> usize {
        count.min(self.bytes.len())
    }

    #[inline]
    fn value(&mut self, number: Number) -> Result<f64, Fault> {
        match self.encoding {
            Encoding::Ascii => self.ascii_value(),
            Encoding::LittleEndian => match number {
                Number::I8 => Ok(f64::from(i8::from_le_bytes(self.take()?))),
                Number::U8 => Ok(f64::from(u8::from_le_bytes(self.take()?))),
                Number::I16 => Ok(f64::from(i16::from_le_bytes(self.take()?))),
                Number::U16 => Ok(f64::from(u16::from_le_bytes(self.take()?))),
                Number::I32 => Ok(f64::from(i32::from_le_bytes(self.take()?))),
                Number::U32 => Ok(f64::from(u32::from_le_bytes(self.take()?))),
                Number::F32 => Ok(f64::from(f32::from_le_bytes(self.take()?))),
                Number::F64 => Ok(f64::from_le_bytes(self.take()?)),
            },
            Encoding::BigEndian => match number {
                Number::I8 => Ok(f64::from(i8::from_be_bytes(self.take()?))),
                Number::U8 => Ok(f64::from(u8::from_be_bytes(self.take()?))),
                Number::I16 => Ok(f64::from(i16::from_be_bytes(self.take()?))),
                Number::U16 => Ok(f64::from(u16::from_be_bytes(self.take()?))),
                Number::I32 => Ok(f64::from(i32::from_be_bytes(self.take()?))),
                Number::U32 => Ok(f64::from(u32::from_be_bytes(self.take()?))),
                Number::F32 => Ok(f64::from(f32::from_be_bytes(self.take()?))),
                Number::F64 => Ok(f64::from_be_bytes(self.take()?)),
            },
        }
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        match self.bytes[self.offset..].first_chunk::<N>() {
            Some(chunk) => {
                self.offset += N;
                Ok(*chunk)
            }
            None => Err(Fault::new(format!(
                "the file ends at byte {} within the elements that its header announces",
                self.bytes.len()
            ))),
        }
    }

    fn ascii_value(&mut self) -> Result<f64, Fault> {
        self.cursor.skip_white();
        match parse_number(self.cursor.rest()) {
            Some((value, length)) => {
                self.cursor.skip(length);
                Ok(value)
            }
            None => Err(self.cursor.fault("a number")),
        }
    }

    /// The length of a list.
    fn length(&mut self, number: Number) -> Result<usize, Fault> {
        let length = self.value(number)?;
        let left = self.bytes.len() - self.offset;
        if length >= 0.0 && length.fract() == 0.0 && length <= left as f64 {
            Ok(length as usize)
        } else {
            Err(self.fault(format!("a list cannot have {length} items here")))
        }
    }

    #[cold]
    fn fault(&self, message: String) -> Fault {
        match self.encoding {
            Encoding::Ascii => self.cursor.complaint(message),
            _ => Fault::new(format!("{message} (before byte {})", self.offset)),
        }
    }

    fn skip_property(&mut self, property: &Property) -> Result<(), Fault> {
        let count = match property.length {
            Some(number) => self.length(number)?,
            None => 1,
        };
        for _ in 0..count {
            self.value(property.number)?;
        }
        Ok(())
    }
}

fn skip_element(element: &Element, body: &mut Body) -> Result<(), Fault> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            body.skip_property(property)?;
        }
    }
    Ok(())
}

/// Where the values of a vertex go: position, normal, texture coordinates.
const VERTEX_VALUES: usize = 8;

/// For every property the place of its value, if it has one.
fn vertex_layout(element: &Element) -> Result<Vec<Option<usize>>, Fault> {
    const NAMES: [&[&str]; VERTEX_VALUES] = [
        &["x"],
        &["y"],
        &["z"],
        &["nx"],
        &["ny"],
        &["nz"],
        &["u", "s", "texture_u", "texture_s"],
        &["v", "t", "texture_v", "texture_t"],
    ];
    let found = NAMES.map(|names| element.position(names));
    let mut layout = vec![None; element.properties.len()];
    for group in [0..3, 3..6, 6..8] {
        if found[group.clone()].iter().all(Option::is_some) {
            for place in group {
                if let Some(property) = found[place] {
                    layout[property] = Some(place);
                }
            }
        } else if group.start == 0 {
            return Err(Fault::new(
                "the element 'vertex' lacks a property x, y or z",
            ));
        }
    }
    Ok(layout)
}

fn read_vertices(element: &Element, body: &mut Body, mesh: &mut Mesh) -> Result<(), Fault> {
    let layout = vertex_layout(element)?;
    let (has_normals, has_uvs) = (layout.contains(&Some(3)), layout.contains(&Some(6)));
    mesh.positions.reserve(body.at_most(element.count));
    for i in 0..element.count {
        let mut values = [0.0_f32; VERTEX_VALUES];
        for (property, place) in element.properties.iter().zip(&layout) {
            match place {
                Some(place) => values[*place] = body.value(property.number)? as f32,
                None => body.skip_property(property)?,
            }
        }
        let [x, y, z, nx, ny, nz, u, v] = values;
        let p = Vec3::new(x, y, z);
        if !p.is_finite() {
            return Err(body.fault(format!("the position of vertex {i} is not finite")));
        }
        mesh.positions.push(p);
        if has_normals {
            mesh.normals.push(Vec3::new(nx, ny, nz).normalize_or_zero());
        }
        if has_uvs {
            let uv = Vec2::new(u, v);
            mesh.uvs.push(if uv.is_finite() { uv } else { Vec2::ZERO });
        }
    }
    Ok(())
}

fn read_faces(element: &Element, body: &mut Body, mesh: &mut Mesh) -> Result<(), Fault> {
    let is_list = |p: &Property| {
        p.length.is_some() && matches!(p.name.as_str(), "vertex_indices" | "vertex_index")
    };
    let list = element.properties.iter().position(is_list);
    let list =
        list.ok_or_else(|| Fault::new("the element 'face' lacks a list 'vertex_indices'"))?;
    mesh.triangles.reserve(body.at_most(element.count));
    for _ in 0..element.count {
        for (i, property) in element.properties.iter().enumerate() {
            match property.length {
                Some(length) if i == list => read_polygon(length, property.number, body, mesh)?,
                _ => body.skip_property(property)?,
            }
        }
    }
    Ok(())
}

fn read_polygon(
    length: Number,
    number: Number,
    body: &mut Body,
    mesh: &mut Mesh,
) -> Result<(), Fault> {
    let count = body.length(length)?;
    let (mut first, mut previous) = (0, 0);
    for corner in 0..count {
        let value = body.value(number)?;
        // An index that is no index becomes one that no vertex has.
        let index = if value >= 0.0 && value < f64::from(u32::MAX) && value.fract() == 0.0 {
            value as u32
        } else {
            u32::MAX
        };
        match corner {
            0 => first = index,
            1 => {}
            _ => mesh.triangles.push([first, previous, index]),
        }
        previous = index;
    }
    Ok(())
}

fn check_indices(mesh: &Mesh) -> Result<(), Fault> {
    let count = mesh.positions.len();
    match mesh
        .triangles
        .iter()
        .find(|t| t.iter().any(|&i| i as usize >= count))
    {
        Some(t) => Err(Fault::new(format!(
            "a face refers to the vertices {t:?}, but there are only {count}, counted from 0"
        ))),
        None => Ok(()),
    }
}
