//! Mesh files: OBJ, PLY and Mitsuba's serialized format.
//!
//! Positions and texture coordinates are those of the file. Note that v = 0 is the top row of an
//! image: Mitsuba replaces v by 1 - v (`flip_tex_coords`) by default for OBJ, but not for PLY and
//! serialized meshes.
//!
//! If a file has no normals, Mitsuba computes smooth normals in world space, unless `face_normals`
//! is set: [`smooth_normals_placed`]. For transforms that preserve angles and orientation, they are
//! those of object space: [`smooth_normals`].

mod attributes;
mod curves;
mod normals;
mod obj;
mod ply;
mod serialized;
mod text;

#[cfg(test)]
mod tests;

pub use attributes::{AttributePlace, MeshAttribute};
pub use curves::read_curves;
pub use normals::{orient_to_normals, smooth_normals, smooth_normals_placed};
pub(crate) use text::parse_number;

use crate::file_error::{Fault, FileError, read_bytes};
use crate::gzip::unpacked;
use manylight::geometry::Mesh;
use std::path::Path;

/// Format of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ. Groups and materials are ignored.
    Obj,
    /// Stanford PLY.
    Ply,
    /// Mitsuba's compressed format, with several meshes per file.
    Serialized {
        /// Index of the mesh in the file, from 0.
        shape_index: usize,
    },
}

/// Reads a mesh with the normals of the file, normalized, and its attributes if they are wanted,
/// which OBJ files do not have. The file may be compressed by gzip. Polygons are triangulated as
/// fans. The normals are empty if the file has none; if only some vertices have one, the others get
/// smooth normals.
///
/// # Errors
/// The file cannot be read, is malformed, or has no mesh of this index; the error gives line and
/// column of a text.
pub fn read_mesh(
    path: &Path,
    format: MeshFormat,
    attributes: bool,
) -> Result<(Mesh, Vec<MeshAttribute>), FileError> {
    let parsed = unpacked(read_bytes(path)?).and_then(|bytes| parse(&bytes, format, attributes));
    let (mut mesh, attributes) = parsed.map_err(|fault| fault.in_file(path))?;
    normals::complete_normals(&mut mesh);
    Ok((mesh, attributes))
}

/// The mesh of a file's content; its attributes if `attributes` is set.
fn parse(
    bytes: &[u8],
    format: MeshFormat,
    attributes: bool,
) -> Result<(Mesh, Vec<MeshAttribute>), Fault> {
    match format {
        MeshFormat::Obj => obj::parse(bytes).map(|mesh| (mesh, Vec::new())),
        MeshFormat::Ply => ply::parse(bytes, attributes),
        MeshFormat::Serialized { shape_index } => serialized::parse(bytes, shape_index),
    }
}
