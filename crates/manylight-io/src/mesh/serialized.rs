//! Mitsuba's serialized meshes: zlib streams one behind the other, and a table of their offsets at the end of the file.
//!
//! The format is described in Mitsuba's documentation of the `serialized` plugin: little endian throughout; a stream is
//! preceded by the number 0x041C and the version, and holds flags, a name (version 4), counts, positions, normals, uvs,
//! colors and triangles.

use crate::file_error::Fault;
use flate2::read::ZlibDecoder;
use manylight::geometry::Mesh;
use manylight::math::{Vec2, Vec3};
use std::io::Read;

const MAGIC: u16 = 0x041C;
const HAS_NORMALS: u32 = 0x0001;
const HAS_UVS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const DOUBLE_PRECISION: u32 = 0x2000;

/// Mesh `shape_index` of the file `bytes`.
pub(super) fn parse(bytes: &[u8], shape_index: usize) -> Result<Mesh, Fault> {
    check_magic(bytes, 0)?;
    let version = u16_at(bytes, 2).ok_or_else(truncated)?;
    let offset_size = match version {
        3 => 4,
        4 => 8,
        _ => {
            return Err(Fault::new(format!(
                "version {version} of the serialized format is unknown; expected 3 or 4"
            )));
        }
    };
    let start = stream_start(bytes, shape_index, offset_size)?;
    check_magic(bytes, start)?;
    const HEADER: usize = 4;
    let compressed = bytes.get(start + HEADER..).ok_or_else(truncated)?;
    Stream::new(compressed).mesh(version)
}

fn check_magic(bytes: &[u8], offset: usize) -> Result<(), Fault> {
    match u16_at(bytes, offset) {
        Some(MAGIC) => Ok(()),
        Some(other) => Err(Fault::new(format!(
            "expected the mark 0x041C of a serialized mesh at byte {offset}, found 0x{other:04X}"
        ))),
        None => Err(truncated()),
    }
}

/// The offset of a mesh, from the table that ends the file.
fn stream_start(bytes: &[u8], shape_index: usize, offset_size: usize) -> Result<usize, Fault> {
    let table_end = bytes.len().checked_sub(4).ok_or_else(truncated)?;
    let count = u32::from_le_bytes(array_at(bytes, table_end).ok_or_else(truncated)?) as usize;
    let table_start = count
        .checked_mul(offset_size)
        .and_then(|size| table_end.checked_sub(size));
    let table_start = table_start.ok_or_else(|| {
        Fault::new(format!(
            "the table at the end claims {count} meshes, more than the file can hold"
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
            "the offset of shape {shape_index} points behind the end of the file"
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
    Fault::new("the file ends too early for a serialized mesh")
}

/// The decompressed content of one mesh.
struct Stream<'a> {
    decoder: ZlibDecoder<&'a [u8]>,
    most_bytes: u64,
}

impl<'a> Stream<'a> {
    fn new(compressed: &'a [u8]) -> Self {
        // Deflate cannot do better than 1032 : 1.
        const BEST_COMPRESSION: u64 = 1032;
        Stream {
            decoder: ZlibDecoder::new(compressed),
            most_bytes: compressed.len() as u64 * BEST_COMPRESSION,
        }
    }

    fn mesh(&mut self, version: u16) -> Result<Mesh, Fault> {
        let flags = self.u32()?;
        if version == 4 {
            self.skip_name()?;
        }
        let (vertex_count, triangle_count) = (self.u64()?, self.u64()?);
        let precise = flags & DOUBLE_PRECISION != 0;
        let positions = self.vectors(vertex_count, precise)?;
        let mut normals = if flags & HAS_NORMALS != 0 {
            self.vectors(vertex_count, precise)?
        } else {
            Vec::new()
        };
        let uvs = if flags & HAS_UVS != 0 {
            self.reals::<2>(vertex_count, precise)?
        } else {
            Vec::new()
        };
        if flags & HAS_COLORS != 0 {
            self.reals::<3>(vertex_count, precise)?;
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
        Ok(Mesh {
            positions,
            normals,
            uvs,
            triangles,
        })
    }

    fn skip_name(&mut self) -> Result<(), Fault> {
        loop {
            let [byte] = self.array()?;
            if byte == 0 {
                return Ok(());
            }
        }
    }

    fn vectors(&mut self, count: u64, precise: bool) -> Result<Vec<Vec3>, Fault> {
        Ok(self
            .reals::<3>(count, precise)?
            .into_iter()
            .map(Vec3::from)
            .collect())
    }

    /// `count` vectors of `N` numbers, stored as double (`precise`) or single precision.
    fn reals<const N: usize>(&mut self, count: u64, precise: bool) -> Result<Vec<[f32; N]>, Fault> {
        let size = if precise { 8 } else { 4 };
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
                "triangle {i} refers to the vertices {t:?}, but there are only {vertex_count}"
            ))),
            None => Ok(triangles),
        }
    }

    /// The next `count * size` bytes. Counts that the compressed data cannot hold are refused before memory is taken.
    fn block(&mut self, count: u64, size: usize) -> Result<Vec<u8>, Fault> {
        let length = count
            .checked_mul(size as u64)
            .filter(|&l| l <= self.most_bytes);
        let length = length.ok_or_else(|| {
            Fault::new(format!(
                "the mesh claims {count} elements, more than the file can hold"
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
