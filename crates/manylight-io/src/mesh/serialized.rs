//! Mitsuba's serialized meshes: consecutive zlib streams, and a table of their offsets at the end
//! of the file.
//!
//! All numbers are little endian. Each stream is preceded by the number 0x041C and the version. A
//! stream contains flags, a name (version 4), counts, positions, normals, texture coordinates,
//! colors and triangles. Source: the documentation of Mitsuba's `serialized` plugin.

use super::attributes::{AttributePlace, MeshAttribute};
use crate::file_error::Fault;
use crate::gzip::most_unpacked;
use flate2::read::ZlibDecoder;
use manylight::color::Rgb;
use manylight::geometry::Mesh;
use manylight::math::{Vec2, Vec3};
use std::io::Read;

/// The number at the start of the file and of each mesh.
const MAGIC: u16 = 0x041C;
/// Flags of a mesh.
const HAS_NORMALS: u32 = 0x0001;
const HAS_UVS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const DOUBLE_PRECISION: u32 = 0x2000;

/// The mesh `shape_index` in the file content `bytes`, and the colors of its vertices as an
/// attribute.
pub(super) fn parse(bytes: &[u8], shape_index: usize) -> Result<(Mesh, Vec<MeshAttribute>), Fault> {
    check_magic(bytes, 0)?;
    let version = u16_at(bytes, 2).ok_or_else(truncated)?;
    let offset_size = match version {
        3 => 4,
        4 => 8,
        _ => {
            return Err(Fault::new(format!(
                "found version {version} of the serialized format, expected 3 or 4"
            )));
        }
    };
    let start = stream_start(bytes, shape_index, offset_size)?;
    check_magic(bytes, start)?;
    /// Bytes before a stream: magic number and version.
    const HEADER: usize = 4;
    let compressed = bytes.get(start + HEADER..).ok_or_else(truncated)?;
    MeshStream::new(compressed).mesh(version)
}

fn check_magic(bytes: &[u8], offset: usize) -> Result<(), Fault> {
    match u16_at(bytes, offset) {
        Some(MAGIC) => Ok(()),
        Some(other) => Err(Fault::new(format!(
            "expected 0x041C, the start of a serialized mesh, at byte {offset}, found 0x{other:04X}"
        ))),
        None => Err(truncated()),
    }
}

/// The offset of a mesh in bytes, from the table at the end of the file. `offset_size` is the size
/// of a table entry in bytes.
fn stream_start(bytes: &[u8], shape_index: usize, offset_size: usize) -> Result<usize, Fault> {
    let table_end = bytes.len().checked_sub(4).ok_or_else(truncated)?;
    let count = u32::from_le_bytes(array_at(bytes, table_end).ok_or_else(truncated)?) as usize;
    let table_start = count
        .checked_mul(offset_size)
        .and_then(|size| table_end.checked_sub(size));
    let table_start = table_start.ok_or_else(|| {
        Fault::new(format!(
            "the table at the end of the file declares {count} meshes, more than fit into the file"
        ))
    })?;
    if shape_index >= count {
        return Err(Fault::new(format!(
            "there is no shape {shape_index}: the file has {count}, counted from 0"
        )));
    }
    let entry = table_start + shape_index * offset_size;
    let offset = match offset_size {
        4 => array_at(bytes, entry).map(|b| u64::from(u32::from_le_bytes(b))),
        _ => array_at(bytes, entry).map(u64::from_le_bytes),
    };
    let offset = offset
        .and_then(|o| usize::try_from(o).ok())
        .filter(|&o| o < table_start);
    offset.ok_or_else(|| {
        Fault::new(format!(
            "the offset of shape {shape_index} is beyond the end of the file"
        ))
    })
}

fn array_at<const N: usize>(bytes: &[u8], offset: usize) -> Option<[u8; N]> {
    bytes.get(offset..offset.checked_add(N)?)?.try_into().ok()
}

fn u16_at(bytes: &[u8], offset: usize) -> Option<u16> {
    array_at(bytes, offset).map(u16::from_le_bytes)
}

fn truncated() -> Fault {
    Fault::new("the file ends before the end of a serialized mesh")
}

/// How the numbers of a mesh are stored.
#[derive(Clone, Copy)]
enum Precision {
    Single,
    Double,
}

/// A reader of the decompressed content of one mesh.
struct MeshStream<'a> {
    decoder: ZlibDecoder<&'a [u8]>,
    /// Upper bound of the decompressed size.
    max_bytes: u64,
}

impl<'a> MeshStream<'a> {
    fn new(compressed: &'a [u8]) -> Self {
        MeshStream {
            decoder: ZlibDecoder::new(compressed),
            max_bytes: most_unpacked(compressed.len()),
        }
    }

    fn mesh(&mut self, version: u16) -> Result<(Mesh, Vec<MeshAttribute>), Fault> {
        let flags = self.u32()?;
        if version == 4 {
            self.skip_name()?;
        }
        let (vertex_count, triangle_count) = (self.u64()?, self.u64()?);
        let precision = if flags & DOUBLE_PRECISION == 0 {
            Precision::Single
        } else {
            Precision::Double
        };
        let positions = self.vectors(vertex_count, precision)?;
        let mut normals = if flags & HAS_NORMALS != 0 {
            self.vectors(vertex_count, precision)?
        } else {
            Vec::new()
        };
        let uvs = if flags & HAS_UVS != 0 {
            self.reals::<2>(vertex_count, precision)?
        } else {
            Vec::new()
        };
        let mut attributes = Vec::new();
        if flags & HAS_COLORS != 0 {
            let colors = self.reals::<3>(vertex_count, precision)?;
            attributes.push(MeshAttribute {
                name: "vertex_color".to_owned(),
                place: AttributePlace::Vertices,
                from_integers: false,
                values: colors.into_iter().map(Rgb::from).collect(),
            });
        }
        let triangles = self.triangles(triangle_count, vertex_count)?;
        if let Some(i) = positions.iter().position(|p| !p.is_finite()) {
            return Err(Fault::new(format!(
                "the position of vertex {i} is not finite"
            )));
        }
        for n in &mut normals {
            *n = n.normalize_or_zero();
        }
        let finite_or_zero = |v: f32| if v.is_finite() { v } else { 0.0 };
        let uvs = uvs
            .into_iter()
            .map(|uv| Vec2::from(uv.map(finite_or_zero)))
            .collect();
        let mesh = Mesh {
            positions,
            normals,
            tangents: Vec::new(),
            uvs,
            triangles,
        };
        Ok((mesh, attributes))
    }

    fn skip_name(&mut self) -> Result<(), Fault> {
        loop {
            let [byte] = self.array()?;
            if byte == 0 {
                return Ok(());
            }
        }
    }

    fn vectors(&mut self, count: u64, precision: Precision) -> Result<Vec<Vec3>, Fault> {
        Ok(self
            .reals::<3>(count, precision)?
            .into_iter()
            .map(Vec3::from)
            .collect())
    }

    /// `count` vectors of `N` numbers.
    fn reals<const N: usize>(
        &mut self,
        count: u64,
        precision: Precision,
    ) -> Result<Vec<[f32; N]>, Fault> {
        let size = match precision {
            Precision::Single => 4,
            Precision::Double => 8,
        };
        let bytes = self.block(count, N * size)?;
        let real = |b: &[u8]| match *b {
            [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
            [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]) as f32,
            _ => unreachable!("invariant: chunks of 4 or 8 bytes"),
        };
        Ok(bytes
            .chunks_exact(N * size)
            .map(|v| std::array::from_fn(|i| real(&v[i * size..(i + 1) * size])))
            .collect())
    }

    fn triangles(&mut self, count: u64, vertex_count: u64) -> Result<Vec<[u32; 3]>, Fault> {
        let bytes = self.block(count, 12)?;
        let index = |t: &[u8], corner: usize| {
            u32::from_le_bytes([
                t[4 * corner],
                t[4 * corner + 1],
                t[4 * corner + 2],
                t[4 * corner + 3],
            ])
        };
        let triangles: Vec<[u32; 3]> = bytes
            .chunks_exact(12)
            .map(|t| [index(t, 0), index(t, 1), index(t, 2)])
            .collect();
        match triangles
            .iter()
            .enumerate()
            .find(|(_, t)| t.iter().any(|&i| u64::from(i) >= vertex_count))
        {
            Some((i, t)) => Err(Fault::new(format!(
                "triangle {i} refers to the vertices {t:?}, but the mesh has {vertex_count}, counted from 0"
            ))),
            None => Ok(triangles),
        }
    }

    /// The next `count * size` bytes. A count that the compressed data cannot contain is an error
    /// before anything is allocated.
    fn block(&mut self, count: u64, size: usize) -> Result<Vec<u8>, Fault> {
        let length = count
            .checked_mul(size as u64)
            .filter(|&l| l <= self.max_bytes);
        let length = length.ok_or_else(|| {
            Fault::new(format!(
                "the mesh declares {count} elements, more than fit into the file"
            ))
        })?;
        let mut bytes = Vec::new();
        self.decoder
            .by_ref()
            .take(length)
            .read_to_end(&mut bytes)
            .map_err(|e| Fault::new(format!("the compressed data is damaged: {e}")))?;
        if bytes.len() as u64 == length {
            Ok(bytes)
        } else {
            Err(truncated())
        }
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let mut bytes = [0; N];
        self.decoder
            .read_exact(&mut bytes)
            .map_err(|e| Fault::new(format!("the compressed data is damaged: {e}")))?;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, Fault> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, Fault> {
        self.array().map(u64::from_le_bytes)
    }
}
