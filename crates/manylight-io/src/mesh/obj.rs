//! Wavefront OBJ. `v`, `vt`, `vn` and `f` lines are read; groups, materials and all other lines are
//! skipped, so that a file is one mesh.
//!
//! Vertices are split and numbered as in Mitsuba: one per distinct triple of position, texture
//! coordinate and normal, in the order of first use. Beyond Mitsuba, indices may refer to later
//! lines and may be negative (relative to the last element).
//!
//! The parser is written here because scenes contain hundreds of megabytes of OBJ text, and because
//! existing crates split a file into groups and report errors without a line.

use super::text::Cursor;
use crate::file_error::Fault;
use manylight::geometry::Mesh;
use manylight::math::{Vec2, Vec3};
use std::collections::HashMap;

/// Corners of one position that are searched one after the other. A map costs more than a chain
/// until then; without it, the time grows with the square of the number of corners of a position.
const LONGEST_CHAIN: usize = 64;

/// An absent index, or the end of a linked list.
const NONE: u32 = u32::MAX;

/// The mesh in the file content `bytes`. If some vertices have a normal, the others get a zero
/// normal.
pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, Fault> {
    let mut reader = Reader::new(bytes);
    while !reader.cursor.at_end() {
        reader.line()?;
    }
    reader.check_references()?;
    Ok(reader.into_mesh())
}

/// The elements that a face corner `v/vt/vn` refers to, in this order.
#[derive(Clone, Copy)]
enum ObjElement {
    Position = 0,
    Uv = 1,
    Normal = 2,
}

const ELEMENTS: [ObjElement; 3] = [ObjElement::Position, ObjElement::Uv, ObjElement::Normal];

impl ObjElement {
    fn name(self) -> &'static str {
        match self {
            ObjElement::Position => "vertex",
            ObjElement::Uv => "texture coordinate",
            ObjElement::Normal => "normal",
        }
    }
}

/// A vertex of the mesh.
struct Corner {
    /// Indices of position, texture coordinate and normal.
    indices: [u32; 3],
    /// The next corner with the same position.
    next: u32,
}

/// The largest index to one kind of element, and its location. It is checked at the end of the
/// file, because indices may refer to later lines.
#[derive(Clone, Copy, Default)]
struct LargestIndex {
    /// The index plus 1.
    count: u32,
    line: u32,
    column: u32,
}

struct Reader<'a> {
    cursor: Cursor<'a>,
    /// Upper bound of valid indices from the size of the file.
    index_bound: usize,
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    corners: Vec<Corner>,
    /// For each position, the first corner that uses it.
    first_corner: Vec<u32>,
    /// Corners beyond the first [`LONGEST_CHAIN`] of their position, by their indices.
    further_corners: HashMap<[u32; 3], u32>,
    triangles: Vec<[u32; 3]>,
    largest: [LargestIndex; 3],
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        /// Bytes of the shortest element, "vt 0\n".
        const SHORTEST_ELEMENT: usize = 5;
        Reader {
            cursor: Cursor::new(bytes, 1),
            index_bound: bytes.len() / SHORTEST_ELEMENT + 1,
            positions: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            corners: Vec::new(),
            first_corner: Vec::new(),
            further_corners: HashMap::new(),
            triangles: Vec::new(),
            largest: [LargestIndex::default(); 3],
        }
    }

    #[inline]
    fn line(&mut self) -> Result<(), Fault> {
        self.cursor.skip_spaces();
        match *self.cursor.rest() {
            [b'v', b' ' | b'\t', ..] => {
                let p = self.vector(1, "vertex position")?;
                self.positions.push(p);
            }
            [b'v', b'n', b' ' | b'\t', ..] => {
                let n = self.vector(2, "normal")?;
                self.normals.push(n.normalize_or_zero());
            }
            [b'v', b't', b' ' | b'\t', ..] => self.texture_coordinate()?,
            [b'f', b' ' | b'\t', ..] => self.face()?,
            _ => {}
        }
        self.cursor.next_line();
        Ok(())
    }

    #[inline]
    fn vector(&mut self, keyword: usize, what: &str) -> Result<Vec3, Fault> {
        let start = self.cursor;
        self.cursor.skip(keyword);
        let mut next = || self.cursor.number().map(|v| v as f32);
        let v = Vec3::new(next()?, next()?, next()?);
        if v.is_finite() {
            Ok(v)
        } else {
            Err(start.fault(format!("this {what} is not finite")))
        }
    }

    #[inline]
    fn texture_coordinate(&mut self) -> Result<(), Fault> {
        let start = self.cursor;
        self.cursor.skip(2);
        let u = self.cursor.number()? as f32;
        self.cursor.skip_spaces();
        let v = if self.cursor.at_line_end() {
            0.0
        } else {
            self.cursor.number()? as f32
        };
        if !(u.is_finite() && v.is_finite()) {
            return Err(start.fault("this texture coordinate is not finite"));
        }
        self.uvs.push(Vec2::new(u, v));
        Ok(())
    }

    /// Triangulates a polygon as a fan around its first corner. Faces with fewer than three corners
    /// are skipped.
    #[inline]
    fn face(&mut self) -> Result<(), Fault> {
        self.cursor.skip(1);
        let (mut first, mut previous) = (NONE, NONE);
        loop {
            self.cursor.skip_spaces();
            if self.cursor.at_line_end() || self.cursor.peek() == b'#' {
                return Ok(());
            }
            let indices = self.corner()?;
            let vertex = self.vertex(indices);
            if first == NONE {
                first = vertex;
            } else {
                if previous != NONE {
                    self.triangles.push([first, previous, vertex]);
                }
                previous = vertex;
            }
        }
    }

    /// One of `v`, `v/vt`, `v//vn`, `v/vt/vn`.
    #[inline]
    fn corner(&mut self) -> Result<[u32; 3], Fault> {
        let mut indices = [NONE; 3];
        indices[0] = self.index(ObjElement::Position)?;
        for element in [ObjElement::Uv, ObjElement::Normal] {
            if self.cursor.peek() != b'/' {
                break;
            }
            self.cursor.skip(1);
            if !matches!(self.cursor.peek(), b'/' | b' ' | b'\t' | b'\r' | b'\n') {
                indices[element as usize] = self.index(element)?;
            }
        }
        if self.cursor.peek().is_ascii_whitespace() {
            Ok(indices)
        } else {
            Err(self.cursor.expected("a face corner such as 1/2/3"))
        }
    }

    #[inline]
    fn index(&mut self, element: ObjElement) -> Result<u32, Fault> {
        let start = self.cursor;
        let Some(number) = self.cursor.integer() else {
            return Err(start.expected(&format!("the index of a {}", element.name())));
        };
        let known = self.count(element);
        let index = if number > 0 {
            number - 1
        } else {
            known as i64 + number
        };
        if number == 0 || index < 0 || index as usize >= self.index_bound {
            return Err(out_of_range(
                element,
                number,
                known,
                start.line(),
                start.column(),
            ));
        }
        let largest = &mut self.largest[element as usize];
        if index as u32 >= largest.count {
            *largest = LargestIndex {
                count: index as u32 + 1,
                line: start.line(),
                column: start.column(),
            };
        }
        Ok(index as u32)
    }

    fn count(&self, element: ObjElement) -> usize {
        match element {
            ObjElement::Position => self.positions.len(),
            ObjElement::Uv => self.uvs.len(),
            ObjElement::Normal => self.normals.len(),
        }
    }

    /// The vertex with these indices of position, texture coordinate and normal; a new one at first
    /// use.
    #[inline]
    fn vertex(&mut self, indices: [u32; 3]) -> u32 {
        let position = indices[0] as usize;
        if position >= self.first_corner.len() {
            self.first_corner
                .resize(self.positions.len().max(position + 1), NONE);
        }
        let new = self.corners.len() as u32;
        let mut at = self.first_corner[position];
        if at == NONE {
            self.first_corner[position] = new;
        }
        let mut searched = 0;
        while at != NONE {
            let corner = &mut self.corners[at as usize];
            if corner.indices == indices {
                return at;
            }
            searched += 1;
            if searched == LONGEST_CHAIN {
                let vertex = *self.further_corners.entry(indices).or_insert(new);
                if vertex != new {
                    return vertex;
                }
                break;
            }
            if corner.next == NONE {
                corner.next = new;
                break;
            }
            at = corner.next;
        }
        self.corners.push(Corner {
            indices,
            next: NONE,
        });
        new
    }

    fn check_references(&self) -> Result<(), Fault> {
        for element in ELEMENTS {
            let largest = self.largest[element as usize];
            let known = self.count(element);
            if largest.count as usize > known {
                return Err(out_of_range(
                    element,
                    i64::from(largest.count),
                    known,
                    largest.line,
                    largest.column,
                ));
            }
        }
        Ok(())
    }

    fn into_mesh(self) -> Mesh {
        let uses = |element: ObjElement| {
            self.corners
                .iter()
                .any(|c| c.indices[element as usize] != NONE)
        };
        let positions = self
            .corners
            .iter()
            .map(|c| self.positions[c.indices[0] as usize])
            .collect();
        let uvs = if uses(ObjElement::Uv) {
            self.corners
                .iter()
                .map(|c| pick(&self.uvs, c.indices[1]))
                .collect()
        } else {
            Vec::new()
        };
        let normals = if uses(ObjElement::Normal) {
            self.corners
                .iter()
                .map(|c| pick(&self.normals, c.indices[2]))
                .collect()
        } else {
            Vec::new()
        };
        Mesh {
            positions,
            normals,
            tangents: Vec::new(),
            uvs,
            triangles: self.triangles,
        }
    }
}

/// The element, or zero if the index is absent.
fn pick<T: Copy + Default>(elements: &[T], index: u32) -> T {
    if index == NONE {
        T::default()
    } else {
        elements[index as usize]
    }
}

#[cold]
fn out_of_range(element: ObjElement, number: i64, known: usize, line: u32, column: u32) -> Fault {
    let name = element.name();
    Fault::at(
        line,
        column,
        format!("there is no {name} {number}: the file has {known}, counted from 1"),
    )
}
