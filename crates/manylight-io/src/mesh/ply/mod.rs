//! Stanford PLY: ASCII, binary little endian and binary big endian.
//!
//! Used are the properties `x y z`, `nx ny nz` and one pair of texture coordinates (`u v`, `s t`,
//! `texture_u texture_v` or `texture_s texture_t`) of the element `vertex`, and the list
//! `vertex_indices` or `vertex_index` of the element `face`. Other properties are attributes, if
//! they are wanted, or skipped. Polygons are triangulated as fans around their first corner.

mod attributes;
mod header;

use super::attributes::{AttributePlace, MeshAttribute};
use super::text::{Cursor, parse_number};
use crate::file_error::Fault;
use attributes::AttributeReader;
use header::{Encoding, Header, Number, PlyElement, Property};
use manylight::geometry::Mesh;
use manylight::math::{Vec2, Vec3};

/// The mesh in the file content `bytes`, and its attributes if they are wanted.
pub(super) fn parse(bytes: &[u8], wanted: bool) -> Result<(Mesh, Vec<MeshAttribute>), Fault> {
    let header = Header::parse(bytes)?;
    let mut body = Body::new(bytes, &header);
    let mut mesh = Mesh::default();
    let mut attributes = Vec::new();
    let mut seen = [false; 2];
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => {
                attributes.extend(read_vertices(element, &mut body, &mut mesh, wanted)?);
                seen[0] = true;
            }
            "face" => {
                attributes.extend(read_faces(element, &mut body, &mut mesh, wanted)?);
                seen[1] = true;
            }
            _ => skip_element(element, &mut body)?,
        }
        if seen == [true; 2] {
            break;
        }
    }
    check_indices(&mesh)?;
    Ok((mesh, attributes))
}

/// A reader of the values after the header.
struct Body<'a> {
    bytes: &'a [u8],
    encoding: Encoding,
    /// Position of a binary file.
    offset: usize,
    /// Position of an ASCII file.
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

    /// `count` limited to what the file can contain, so that a wrong count does not allocate.
    fn at_most(&self, count: usize) -> usize {
        count.min(self.bytes.len())
    }

    /// The next number.
    #[inline]
    fn value(&mut self, number: Number) -> Result<f64, Fault> {
        if self.encoding == Encoding::Ascii {
            return self.ascii_value();
        }
        Ok(match number {
            Number::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Number::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Number::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Number::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Number::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Number::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Number::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Number::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    /// The next bytes of a binary file, the lowest one first.
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let Some(chunk) = self.bytes[self.offset..].first_chunk::<N>() else {
            return Err(Fault::new(format!(
                "the file ends at byte {}, before the last item that its header declares",
                self.bytes.len()
            )));
        };
        self.offset += N;
        let mut chunk = *chunk;
        if self.encoding == Encoding::BigEndian {
            chunk.reverse();
        }
        Ok(chunk)
    }

    fn ascii_value(&mut self) -> Result<f64, Fault> {
        self.cursor.skip_white();
        match parse_number(self.cursor.rest()) {
            Some((value, length)) => {
                self.cursor.skip(length);
                Ok(value)
            }
            None => Err(self.cursor.expected("a number")),
        }
    }

    /// The next number as the length of a list.
    fn length(&mut self, number: Number) -> Result<usize, Fault> {
        let length = self.value(number)?;
        let left = self.bytes.len() - self.offset;
        if length >= 0.0 && length.fract() == 0.0 && length <= left as f64 {
            Ok(length as usize)
        } else {
            Err(self.fault(format!(
                "found {length} as the length of a list; expected a whole number that fits into the file"
            )))
        }
    }

    /// An error at the position.
    #[cold]
    fn fault(&self, message: String) -> Fault {
        match self.encoding {
            Encoding::Ascii => self.cursor.fault(message),
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

fn skip_element(element: &PlyElement, body: &mut Body) -> Result<(), Fault> {
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

/// Number of values of a vertex: position, normal, texture coordinates.
const VERTEX_VALUES: usize = 8;

/// For every property of a vertex, the index of its value in position, normal and texture
/// coordinates, if it has one.
fn vertex_layout(element: &PlyElement) -> Result<Vec<Option<usize>>, Fault> {
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
            for value in group {
                if let Some(property) = found[value] {
                    layout[property] = Some(value);
                }
            }
        } else if group.start == 0 {
            return Err(Fault::new(
                "expected the properties x, y and z of the element 'vertex'",
            ));
        }
    }
    Ok(layout)
}

fn read_vertices(
    element: &PlyElement,
    body: &mut Body,
    mesh: &mut Mesh,
    wanted: bool,
) -> Result<Vec<MeshAttribute>, Fault> {
    let layout = vertex_layout(element)?;
    let mut attributes = if wanted {
        AttributeReader::new(element, AttributePlace::Vertices, |i| layout[i].is_some())
    } else {
        AttributeReader::none(element)
    };
    let (has_normals, has_uvs) = (layout.contains(&Some(3)), layout.contains(&Some(6)));
    mesh.positions.reserve(body.at_most(element.count));
    for i in 0..element.count {
        let mut values = [0.0_f32; VERTEX_VALUES];
        attributes.next();
        for (k, (property, value)) in element.properties.iter().zip(&layout).enumerate() {
            match value {
                Some(value) => values[*value] = body.value(property.number)? as f32,
                None if attributes.wants(k) => {
                    attributes.set(k, property, body.value(property.number)?);
                }
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
    Ok(attributes.finish())
}

fn read_faces(
    element: &PlyElement,
    body: &mut Body,
    mesh: &mut Mesh,
    wanted: bool,
) -> Result<Vec<MeshAttribute>, Fault> {
    let is_list = |p: &Property| {
        p.length.is_some() && matches!(p.name.as_str(), "vertex_indices" | "vertex_index")
    };
    let list = element.properties.iter().position(is_list);
    let list =
        list.ok_or_else(|| Fault::new("expected a list 'vertex_indices' of the element 'face'"))?;
    let mut attributes = if wanted {
        AttributeReader::new(element, AttributePlace::Triangles, |_| false)
    } else {
        AttributeReader::none(element)
    };
    mesh.triangles.reserve(body.at_most(element.count));
    for _ in 0..element.count {
        attributes.next();
        for (i, property) in element.properties.iter().enumerate() {
            match property.length {
                Some(length) if i == list => read_polygon(length, property.number, body, mesh)?,
                None if attributes.wants(i) => {
                    attributes.set(i, property, body.value(property.number)?);
                }
                _ => body.skip_property(property)?,
            }
        }
        attributes.repeat_last(mesh.triangles.len());
    }
    Ok(attributes.finish())
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
        // An invalid index becomes one that `check_indices` rejects.
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
            "a face refers to the vertices {t:?}, but the file has {count}, counted from 0"
        ))),
        None => Ok(()),
    }
}
