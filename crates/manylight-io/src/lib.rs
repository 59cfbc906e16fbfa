//! Files of the many-light renderer `manylight`: scenes, meshes, images, spectra and skies.
//!
//! [`load_scene`] turns a scene file (Mitsuba XML, versions 0.4 to 3; PBRT, versions 3 and 4; or
//! glTF 2.0) into a [`SceneDesc`](manylight::scene::SceneDesc), the description that [`manylight`]
//! renders. [`image::write_image`] writes the result. Names, defaults and meanings of scene files
//! are those of Mitsuba 3.9 and PBRT v4; [`supported`] lists the plugins. [`GltfOptions`] says what
//! glTF files do not.
//!
//! # Promises
//!
//! * **All problems at once.** An error does not end loading: [`check_scene`] returns every error
//!   and warning of a scene.
//! * **Located messages.** A [`Diagnostic`] says what was found, where (file, line, column), what
//!   was expected, and often the most similar valid name. Printed by [`miette`], it shows an
//!   excerpt of the file.
//! * **No silent differences.** Unknown elements and parameters are errors. Unsupported features of
//!   a format are warnings, which [`LoadOptions::strict`] turns into errors. Only settings without
//!   effect on the converged image, such as samplers, are accepted silently.
//! * **Damaged files are errors.** Parsers neither panic nor allocate more than a file can contain.
//! * **Atomic writing.** A written file is complete or unchanged.
//!
//! # Example
//!
//! ```
//! use manylight_io::image::{LayeredImage, Transfer, read_image, write_image};
//! use manylight_io::{LoadOptions, load_scene};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let folder = tempfile::tempdir()?;
//! let file = folder.path().join("scene.xml");
//! std::fs::write(
//!     &file,
//!     r#"<scene version="3.0.0">
//!         <sensor type="perspective">
//!             <transform name="to_world"><lookat origin="0 0 4" target="0 0 0" up="0 1 0"/></transform>
//!             <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film>
//!         </sensor>
//!         <emitter type="constant"/>
//!         <shape type="sphere"/>
//!     </scene>"#,
//! )?;
//! let loaded = load_scene(&file, &LoadOptions::default())?;
//! assert!(loaded.warnings.is_empty());
//! let size = loaded.desc.sensors[0].film.size;
//!
//! // A renderer fills the image from `loaded.desc`; here it stays black.
//! let rendered = manylight::image::Image::new(size.x as usize, size.y as usize, 3);
//! let output = folder.path().join("image.exr");
//! write_image(&output, &LayeredImage::from_image(&rendered), 0.0)?;
//! assert_eq!(read_image(&output, Transfer::Auto)?, rendered);
//! # Ok(())
//! # }
//! ```
//!
//! # Layers
//!
//! A module imports only from modules with smaller numbers. Within a folder, no files import each
//! other in a circle.
//!
//! ```text
//! 5 scene
//! 4 mesh
//! 3 image spectra sky part
//! 2 error replace gzip
//! 1 source_text file_error resolve
//! 0 hex shown read suggest
//! ```
//!
//! | module | content |
//! |---|---|
//! | `scene` | scene files to descriptions |
//! | `mesh` | file formats of meshes and curves |
//! | `image`, `spectra`, `part` | file formats |
//! | `sky` | computed environment maps |
//! | `error`, `file_error` | diagnostics of scene files, errors of other files |
//! | `read`, `gzip`, `replace` | regular files, compressed ones, whole files or none |
//! | `resolve`, `suggest` | file lookup, misspelled names |
//! | `source_text`, `shown` | excerpts, text for terminals |

pub mod error;
pub mod file_error;
mod gzip;
mod hex;
pub mod image;
pub mod mesh;
pub mod part;
mod read;
mod replace;
mod resolve;
pub mod scene;
mod shown;
pub mod sky;
mod source_text;
pub mod spectra;
mod suggest;

#[cfg(test)]
mod testing;

pub use error::{Diagnostic, LoadError, LoadErrorKind, Location, Severity, Warning};
pub use file_error::{FileError, FileErrorKind, read_text};
pub use replace::{check_replaceable, is_same_file, write_file};
pub use scene::{
    DEFAULT_FPS, EnvironmentSource, GltfOptions, LightUnits, LoadOptions, LoadedScene,
    SCENE_EXTENSIONS, SupportedFamily, check_scene, load_scene, read_camera_path, scene_digest,
    supported,
};
pub use shown::{clean_text, shown_path};
