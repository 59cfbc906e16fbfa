//! Mesh files: OBJ, PLY and Mitsuba's serialized format.
//!
//! Positions and texture coordinates are those of the file. Note that v = 0 is the top row of an image: Mitsuba replaces v by
//! 1 - v (`flip_tex_coords`) by default for OBJ, but not for PLY and serialized meshes.
//!
//! If a file has no normals, Mitsuba computes smooth normals in world space, unless `face_normals` is set. [`read_obj`],
//! [`read_ply`] and [`read_serialized`] compute them in object space, which is the same for transforms that preserve angles
//! and orientation. For other transforms, call [`read_stored`] and [`smooth_normals_placed`].

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

/// Reads all faces of an OBJ file as one mesh. Polygons are triangulated as fans. Missing normals are smooth.
///
/// # Errors
/// The file cannot be read or is malformed; the error gives line and column.
pub fn read_obj(path: &Path) -> Result<Mesh, FileError> {
    read(path, MeshFormat::Obj)
}

/// Reads an ASCII or binary PLY file. Polygons are triangulated as fans, unknown elements and properties are skipped. Missing
/// normals are smooth.
///
/// # Errors
/// The file cannot be read or is malformed.
pub fn read_ply(path: &Path) -> Result<Mesh, FileError> {
    read(path, MeshFormat::Ply)
}

/// Reads the mesh `shape_index` (from 0) of a serialized file of version 3 or 4. Missing normals are smooth.
///
/// # Errors
/// The file cannot be read, is malformed, or has no mesh of this index.
pub fn read_serialized(path: &Path, shape_index: usize) -> Result<Mesh, FileError> {
    read(path, MeshFormat::Serialized { shape_index })
}

/// Reads a mesh with the normals of the file, normalized. The file may be compressed by gzip. `normals` is empty if the file has none; if only some vertices
/// have one, the others get smooth normals.
///
/// # Errors
/// The file cannot be read or is malformed.
pub fn read_stored(path: &Path, format: MeshFormat) -> Result<Mesh, FileError> {
    read_parsed(path, format, false).map(|(mesh, _)| mesh)
}

/// Like [`read_stored`], with the attributes of PLY and serialized meshes.
///
/// # Errors
/// The file cannot be read or is malformed.
pub fn read_with_attributes(
    path: &Path,
    format: MeshFormat,
) -> Result<(Mesh, Vec<MeshAttribute>), FileError> {
    read_parsed(path, format, true)
}

fn read_parsed(
    path: &Path,
    format: MeshFormat,
    attributes: bool,
) -> Result<(Mesh, Vec<MeshAttribute>), FileError> {
    let bytes = unpacked(read_bytes(path)?).map_err(|fault| fault.in_file(path))?;
    let (mut mesh, attributes) =
        parse(&bytes, format, attributes).map_err(|fault| fault.in_file(path))?;
    normals::complete_normals(&mut mesh);
    Ok((mesh, attributes))
}

fn read(path: &Path, format: MeshFormat) -> Result<Mesh, FileError> {
    let mut mesh = read_stored(path, format)?;
    if mesh.normals.is_empty() {
        smooth_normals(&mut mesh);
    }
    Ok(mesh)
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
