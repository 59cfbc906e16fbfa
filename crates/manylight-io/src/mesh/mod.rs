//! Mesh files: OBJ, PLY and Mitsuba's serialized format.
//!
//! Positions and texture coordinates are passed on as they stand in the file. Mitsuba's textures have v = 0 in the top row;
//! its `flip_tex_coords` replaces v by 1 - v and is on by default for OBJ and off for PLY and serialized meshes.
//! Where a file stores no normals, Mitsuba computes smooth ones after placing the mesh in the world, unless `face_normals`
//! is set. [`read_obj`], [`read_ply`] and [`read_serialized`] compute them in object space; [`read_stored`] followed by
//! [`smooth_normals_placed`] also agrees for placements that mirror or distort.

mod normals;
mod obj;
mod ply;
mod serialized;
mod text;

#[cfg(test)]
mod tests;

pub use normals::{smooth_normals, smooth_normals_placed};

use crate::file_error::{Fault, FileError, read_bytes};
use manylight::geometry::Mesh;
use std::path::Path;

/// The formats of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ. Groups and materials are ignored.
    Obj,
    /// Stanford PLY.
    Ply,
    /// Mitsuba's compressed meshes, several in a file.
    Serialized {
        /// Which of them, from 0.
        shape_index: usize,
    },
}

/// The one mesh of an OBJ file; polygons become fans. Normals are smooth where the file has none.
pub fn read_obj(path: &Path) -> Result<Mesh, FileError> {
    read(path, MeshFormat::Obj)
}

/// The mesh of an ASCII or binary PLY file; polygons become fans, unknown elements and properties are skipped.
/// Normals are smooth where the file has none.
pub fn read_ply(path: &Path) -> Result<Mesh, FileError> {
    read(path, MeshFormat::Ply)
}

/// Mesh number `shape_index` of a serialized file, version 3 or 4. Normals are smooth where the file has none.
pub fn read_serialized(path: &Path, shape_index: usize) -> Result<Mesh, FileError> {
    read(path, MeshFormat::Serialized { shape_index })
}

/// The mesh with the normals that the file stores, made unit; `normals` is empty if it stores none.
pub fn read_stored(path: &Path, format: MeshFormat) -> Result<Mesh, FileError> {
    let bytes = read_bytes(path)?;
    let mut mesh = parse(&bytes, format).map_err(|fault| fault.in_file(path))?;
    normals::complete_normals(&mut mesh);
    Ok(mesh)
}

fn read(path: &Path, format: MeshFormat) -> Result<Mesh, FileError> {
    let mut mesh = read_stored(path, format)?;
    if mesh.normals.is_empty() {
        smooth_normals(&mut mesh);
    }
    Ok(mesh)
}

fn parse(bytes: &[u8], format: MeshFormat) -> Result<Mesh, Fault> {
    match format {
        MeshFormat::Obj => obj::parse(bytes),
        MeshFormat::Ply => ply::parse(bytes),
        MeshFormat::Serialized { shape_index } => serialized::parse(bytes, shape_index),
    }
}
