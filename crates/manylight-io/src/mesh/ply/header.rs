//! The header of a PLY file: encoding, elements and their properties.

use super::super::text::Cursor;
use crate::file_error::Fault;
use crate::image::linear_from_srgb;
use std::borrow::Cow;

/// How the values after the header are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Names of the number types, for messages.
const NUMBER_NAMES: &str = "char, uchar, short, ushort, int, uint, float or double";

/// The type of a stored number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
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
    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Number::F32 | Number::F64)
    }

    /// A value as attributes have it: integers as fractions of the largest one with the sRGB
    /// transfer function, as in Mitsuba.
    pub(super) fn normalized(self, value: f64) -> f32 {
        let largest = match self {
            Number::I8 => f64::from(i8::MAX),
            Number::U8 => f64::from(u8::MAX),
            Number::I16 => f64::from(i16::MAX),
            Number::U16 => f64::from(u16::MAX),
            Number::I32 => f64::from(i32::MAX),
            Number::U32 => f64::from(u32::MAX),
            Number::F32 | Number::F64 => return value as f32,
        };
        linear_from_srgb((value / largest) as f32)
    }

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

/// A number, or a list of numbers, of every item of an element.
#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// Type of the length of a list; `None` for a single number.
    pub(super) length: Option<Number>,
    pub(super) number: Number,
}

/// An element of the header, such as `vertex`: `count` items with the same properties.
#[derive(Debug)]
pub(super) struct PlyElement {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

impl PlyElement {
    /// Index of the first property that is not a list and has one of these names.
    pub(super) fn position(&self, names: &[&str]) -> Option<usize> {
        self.properties
            .iter()
            .position(|p| p.length.is_none() && names.contains(&p.name.as_str()))
    }
}

/// The header of a PLY file.
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<PlyElement>,
    /// Offset of the first byte after the header.
    pub(super) end: usize,
    /// Line number of the first line after the header.
    pub(super) end_line: u32,
}

impl Header {
    /// The header at the start of the file content `bytes`.
    pub(super) fn parse(bytes: &[u8]) -> Result<Header, Fault> {
        let mut cursor = Cursor::new(bytes, 1);
        if !(bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r\n")) {
            return Err(cursor.expected("a PLY file, which starts with the line 'ply'"));
        }
        cursor.next_line();
        let mut encoding = None;
        let mut elements: Vec<PlyElement> = Vec::new();
        loop {
            if cursor.at_end() {
                return Err(cursor.expected("'end_header'"));
            }
            let line = first_line(cursor.rest());
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words[..] {
                [] | ["comment", ..] | ["obj_info", ..] => {}
                ["end_header"] => break,
                ["format", name, ..] => encoding = Some(parse_encoding(name, cursor)?),
                ["element", name, _] if elements.iter().any(|element| element.name == name) => {
                    return Err(cursor.fault(format!("the element '{name}' is declared twice")));
                }
                ["element", name, count] => elements.push(parse_element(name, count, cursor)?),
                ["property", ..] => {
                    let property = parse_property(&words, cursor)?;
                    elements
                        .last_mut()
                        .ok_or_else(|| {
                            cursor.fault("expected an element before the first property")
                        })?
                        .properties
                        .push(property);
                }
                _ => {
                    return Err(cursor.expected(
                        "a line of a PLY header (format, comment, element, property, end_header)",
                    ));
                }
            }
            cursor.next_line();
        }
        cursor.next_line();
        let encoding = encoding.ok_or_else(|| {
            cursor.fault("expected a line 'format ...' in the header, found none")
        })?;
        Ok(Header {
            encoding,
            elements,
            end: bytes.len() - cursor.rest().len(),
            end_line: cursor.line(),
        })
    }
}

/// The first line of `rest` as text. Only comments may have bytes that are not UTF-8; elsewhere
/// they become unknown words.
fn first_line(rest: &[u8]) -> Cow<'_, str> {
    let line = rest.split(|&b| b == b'\n').next().unwrap_or_default();
    String::from_utf8_lossy(line)
}

fn parse_encoding(name: &str, cursor: Cursor) -> Result<Encoding, Fault> {
    match name {
        "ascii" => Ok(Encoding::Ascii),
        "binary_little_endian" => Ok(Encoding::LittleEndian),
        "binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(cursor.fault(format!(
            "unknown format '{name}'; expected ascii, binary_little_endian or binary_big_endian"
        ))),
    }
}

fn parse_element(name: &str, count: &str, cursor: Cursor) -> Result<PlyElement, Fault> {
    let count = count
        .parse()
        .map_err(|_| cursor.fault(format!("expected a number of items, found '{count}'")))?;
    Ok(PlyElement {
        name: name.to_owned(),
        count,
        properties: Vec::new(),
    })
}

fn parse_property(words: &[&str], cursor: Cursor) -> Result<Property, Fault> {
    let number = |name: &str| {
        Number::from_name(name).ok_or_else(|| {
            cursor.fault(format!(
                "unknown property type '{name}'; expected {NUMBER_NAMES}"
            ))
        })
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
        _ => Err(cursor.fault("expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'")),
    }
}
