//! The files of a scene.

use crate::fresnel::Coat;
use crate::scene::Scene;
use crate::{gltf, mitsuba, pbrt, ply};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A format of scene files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `scene.xml` for Mitsuba 3, with `meshes/NAME.ply` and `textures/NAME.png`.
    Mitsuba,
    /// `scene.pbrt` for PBRT v4, with the same meshes and textures, and
    /// `textures/NAME_coated_ALPHA_IOR.png`.
    Pbrt,
    /// `scene.gltf` with `scene.bin` and `textures/NAME.png`. It shares no meshes with the others:
    /// PLY files have no arrays of indices.
    Gltf,
}

impl Format {
    /// The formats in the repository.
    pub const COMMITTED: [Format; 2] = [Format::Mitsuba, Format::Pbrt];

    /// The format of this name.
    pub fn named(name: &str) -> Option<Format> {
        Some(match name {
            "mitsuba" => Format::Mitsuba,
            "pbrt" => Format::Pbrt,
            "gltf" => Format::Gltf,
            _ => return None,
        })
    }
}

/// Path relative to the scene's folder, and bytes.
type NamedFile = (PathBuf, Vec<u8>);

/// All files of a scene in these formats, as (path relative to the scene's folder, bytes). The
/// scene files are first.
///
/// # Errors
/// Returns an error if a texture cannot be compressed.
pub fn of(scene: &Scene, formats: &[Format]) -> io::Result<Vec<NamedFile>> {
    let mut files: Vec<NamedFile> = Vec::new();
    let has = |format: Format| formats.contains(&format);
    if has(Format::Mitsuba) {
        files.push(("scene.xml".into(), mitsuba::encode(scene).into_bytes()));
    }
    if has(Format::Pbrt) {
        files.push(("scene.pbrt".into(), pbrt::encode(scene).into_bytes()));
    }
    let mut images: Vec<(String, Vec<u8>)> = Vec::new();
    if has(Format::Gltf) {
        let document = gltf::encode(scene);
        files.push(("scene.gltf".into(), document.json.into_bytes()));
        files.push(("scene.bin".into(), document.binary));
        for (name, image) in document.images {
            images.push((name, image.encode()?));
        }
    }
    if has(Format::Mitsuba) || has(Format::Pbrt) {
        for (name, mesh) in &scene.meshes {
            files.push((format!("meshes/{name}.ply").into(), ply::encode(mesh)));
        }
        for (name, image) in &scene.textures {
            images.push(((*name).to_owned(), image.encode()?));
        }
    }
    if has(Format::Pbrt) {
        for texture in pbrt::coated_textures(scene) {
            let coat = Coat::new(texture.alpha, texture.ior);
            let base = |color: [f64; 3]| color.map(|value| coat.pbrt_base(value));
            let image = scene.textures[texture.base].1.recolored(base);
            images.push((texture.name, image.encode()?));
        }
    }
    images.sort();
    images.dedup();
    let named = |(name, bytes)| (format!("textures/{name}.png").into(), bytes);
    files.extend(images.into_iter().map(named));
    Ok(files)
}

/// Writes the files of a scene into `folder`, which is created if it does not exist.
///
/// Each file is written under a temporary name and then renamed, so no incomplete file has its
/// final name.
///
/// # Errors
/// Returns the first error of the file system. Files written before it stay.
pub fn write(scene: &Scene, formats: &[Format], folder: &Path) -> io::Result<()> {
    for (name, bytes) in of(scene, formats)? {
        let path = folder.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        let mut unfinished = path.clone().into_os_string();
        unfinished.push(".part");
        fs::write(&unfinished, bytes)?;
        fs::rename(&unfinished, &path)?;
    }
    Ok(())
}
