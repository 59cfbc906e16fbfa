//! Fuzz targets: functions from arbitrary bytes to checks of a reader or of a render.
//!
//! A target panics, aborts, or runs out of time or memory where a promise is broken; [`TARGETS`]
//! lists all of them. They are called by cargo-fuzz (the crate in `fuzz/`), by the program `replay`
//! with files, and by a test that replays the committed corpus.
//!
//! What every target checks: the code neither panics nor hangs, takes at most [`MEMORY_LIMIT`]
//! bytes, and every error has a message. `docs/robustness.md` says more.

mod folder;
mod images;
mod limits;
mod meshes;
mod messages;
mod parts;
mod plans;
mod render;
mod scene_files;
mod spectra;

pub use limits::{MEMORY_LIMIT, limited, limited_allocator};

/// A fuzz target.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name: that of the folder of its corpus, and of its program in `fuzz/fuzz_targets`.
    pub name: &'static str,
    /// Runs the target on the content of an input.
    pub run: fn(&[u8]),
}

macro_rules! targets {
    ($($(#[$doc:meta])* $name:ident = $run:expr;)*) => {
        /// All targets.
        pub const TARGETS: &[Target] = &[$(Target { name: stringify!($name), run: $name }),*];
        $(
            $(#[$doc])*
            pub fn $name(input: &[u8]) {
                limited(|| $run(input));
            }
        )*
    };
}

targets! {
    /// A Mitsuba scene, with further files as [`folder`](self) describes.
    xml = |input| scene_files::check(input, "scene.xml");
    /// A PBRT scene, with further files.
    pbrt = |input| scene_files::check(input, "scene.pbrt");
    /// A glTF scene as JSON, with further files.
    gltf = |input| scene_files::check(input, "scene.gltf");
    /// A binary glTF scene.
    glb = scene_files::check_glb;
    /// A Wavefront OBJ mesh.
    obj = meshes::check_obj;
    /// A PLY mesh.
    ply = meshes::check_ply;
    /// A mesh of Mitsuba's serialized format.
    serialized = meshes::check_serialized;
    /// A text file of curves.
    curves = meshes::check_curves;
    /// A PNG image.
    png = |input| images::check(input, "image.png");
    /// A JPEG image.
    jpeg = |input| images::check(input, "image.jpg");
    /// A WebP image.
    webp = |input| images::check(input, "image.webp");
    /// A TGA image.
    tga = |input| images::check(input, "image.tga");
    /// A BMP image.
    bmp = |input| images::check(input, "image.bmp");
    /// A Radiance HDR image.
    hdr = |input| images::check(input, "image.hdr");
    /// An OpenEXR image.
    exr = |input| images::check(input, "image.exr");
    /// A PFM image.
    pfm = |input| images::check(input, "image.pfm");
    /// A spectrum as text.
    spd = spectra::check;
    /// A part of a render.
    part = parts::check;
    /// The plan of a study.
    plan = plans::check;
    /// A random scene, rendered with one of the methods.
    render = render::check;
    /// Kept virtual lights with changed arrays, by which a picture is rendered.
    lights = render::kept::check;
}
