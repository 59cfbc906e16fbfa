//! Wavefront OBJ: `v`, `vt`, `vn` and `f` lines; groups, materials and everything else is skipped, so a file is one mesh.
//!
//! A reader of our own, because scenes hold hundreds of megabytes of this text, and because general readers split a file by
//! groups, which has to be undone here, and report damage without a line. Vertices are split and numbered as Mitsuba does:
//! one per distinct triple of position, texture coordinate and normal, in the order of their first use. Indices may point
//! forwards in the file and may be negative (counted back from the latest element), which Mitsuba refuses.

use super::text::Cursor;
use crate::file_error::Fault;
use manylight::geometry::Mesh;
use manylight::math::{Vec2, Vec3};

/// Marks an absent index and the end of a list.
const NONE: u32 = u32::MAX;

/// The mesh in `bytes`. Vertices without a usable normal get a zero normal if others have one.
pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, Fault> {
    let mut reader = Reader::new(bytes);
    while !reader.cursor.at_end() {
        reader.line()?;
    }
    reader.check_references()?;
    Ok(reader.into_mesh())
}

/// The three kinds of elements that a corner of a face refers to, in the order of the file's `v/vt/vn`.
#[derive(Clone, Copy)]
enum Element {
    Position = 0,
    Uv = 1,
    Normal = 2,
}

const ELEMENTS: [Element; 3] = [Element::Position, Element::Uv, Element::Normal];

impl Element {
    fn name(self) -> &'static str {
        match self {
            Element::Position => "vertex",
            Element::Uv => "texture coordinate",
            Element::Normal => "normal",
        }
    }
}

/// A vertex of the mesh: what it refers to, and the next one with the same position.
struct Corner {
    indices: [u32; 3],
    next: u32,
}

/// The largest index of one kind and where it stands, to be compared with the count when the whole file is known.
#[derive(Clone, Copy, Default)]
struct Furthest {
    count: u32,
    line: u32,
    column: u32,
}

struct Reader<'a> {
    cursor: Cursor<'a>,
    largest_index: usize,
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    corners: Vec<Corner>,
    first_corner: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    furthest: [Furthest; 3],
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        // The shortest element is "vt 0\n".
        const SHORTEST_ELEMENT: usize = 5;
        Reader {
            cursor: Cursor::new(bytes, 1),
            largest_index: bytes.len() / SHORTEST_ELEMENT + 1,
            positions: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            corners: Vec::new(),
            first_corner: Vec::new(),
            triangles: Vec::new(),
            furthest: [Furthest::default(); 3],
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
            Err(start.complaint(format!("this {what} is not finite")))
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
            return Err(start.complaint("this texture coordinate is not finite"));
        }
        self.uvs.push(Vec2::new(u, v));
        Ok(())
    }

    /// Polygons become fans around their first corner. Faces of fewer than three corners have no area and are skipped.
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
        indices[0] = self.index(Element::Position)?;
        for element in [Element::Uv, Element::Normal] {
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
            Err(self.cursor.fault("a face corner such as 1/2/3"))
        }
    }

    #[inline]
    fn index(&mut self, element: Element) -> Result<u32, Fault> {
        let start = self.cursor;
        let Some(number) = self.cursor.integer() else {
            return Err(start.fault(&format!("the index of a {}", element.name())));
        };
        let known = self.count(element);
        let index = if number > 0 {
            number - 1
        } else {
            known as i64 + number
        };
        if number == 0 || index < 0 || index as usize >= self.largest_index {
            return Err(out_of_range(
                element,
                number,
                known,
                start.line(),
                start.column(),
            ));
        }
        let furthest = &mut self.furthest[element as usize];
        if index as u32 >= furthest.count {
            *furthest = Furthest {
                count: index as u32 + 1,
                line: start.line(),
                column: start.column(),
            };
        }
        Ok(index as u32)
    }

    fn count(&self, element: Element) -> usize {
        match element {
            Element::Position => self.positions.len(),
            Element::Uv => self.uvs.len(),
            Element::Normal => self.normals.len(),
        }
    }

    /// The number of the vertex that refers to `indices`.
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
        while at != NONE {
            let corner = &mut self.corners[at as usize];
            if corner.indices == indices {
                return at;
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
            let furthest = self.furthest[element as usize];
            let known = self.count(element);
            if furthest.count as usize > known {
                return Err(out_of_range(
                    element,
                    i64::from(furthest.count),
                    known,
                    furthest.line,
                    furthest.column,
                ));
            }
        }
        Ok(())
    }

    fn into_mesh(self) -> Mesh {
        let uses = |element: Element| {
            self.corners
                .iter()
                .any(|c| c.indices[element as usize] != NONE)
        };
        let positions = self
            .corners
            .iter()
            .map(|c| self.positions[c.indices[0] as usize])
            .collect();
        let uvs = if uses(Element::Uv) {
            self.corners
                .iter()
                .map(|c| pick(&self.uvs, c.indices[1]))
                .collect()
        } else {
            Vec::new()
        };
        let normals = if uses(Element::Normal) {
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
            uvs,
            triangles: self.triangles,
        }
    }
}

/// The element, or zero where the file gives none.
fn pick<T: Copy + Default>(elements: &[T], index: u32) -> T {
    if index == NONE {
        T::default()
    } else {
        elements[index as usize]
    }
}

#[cold]
fn out_of_range(element: Element, number: i64, known: usize, line: u32, column: u32) -> Fault {
    let name = element.name();
    Fault::at(
        line,
        column,
        format!("there is no {name} {number}: the file has {known}, counted from 1"),
    )
}
