//! Renders a scene file with Rich-VPLs and writes a PNG:
//! `cargo run --release -p manylight --example render_scene -- SCENE.xml OUT.png`.

use manylight::prelude::*;
use manylight_io::image::{LayeredImage, write_image};
use manylight_io::{LoadOptions, load_scene};
use std::path::Path;

/// Passes of the image.
const PASSES: u32 = 4;
/// Exposure of the PNG, in stops.
const EXPOSURE_EV: f32 = 0.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let [scene, output] = files.as_slice() else {
        return Err("usage: render_scene SCENE.xml OUT.png".into());
    };
    render_to_file(scene.as_ref(), output.as_ref())
}

fn render_to_file(file: &Path, output: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let desc = load_scene(file, &LoadOptions::default())?.desc;
    let scene = Scene::build(desc, 0)?;
    let method = MethodKind::ManyLight(ManyLight::rich_vpl());
    let film = render_film(&scene, method, Budget::passes(PASSES), 0);
    let image = film
        .image(Layer::Beauty)
        .ok_or("every film has a beauty layer")?;
    write_image(output, &LayeredImage::from_image(&image), EXPOSURE_EV)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_writes_an_image() {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("box.png");
        render_to_file(&scenes.join("furnace/emissive-box.xml"), &output).unwrap();
        assert!(std::fs::metadata(&output).unwrap().len() > 0);
    }
}
