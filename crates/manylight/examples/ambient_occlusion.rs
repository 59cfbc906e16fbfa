//! An integrator in sixty lines: computes the ambient occlusion of a scene and writes an image.
//! `cargo run --release -p manylight --example ambient_occlusion -- SCENE.xml RADIUS OUT.png`.
//!
//! The ambient occlusion of a point with the normal `n` is the part of the hemisphere above it, by
//! projected solid angle, in which no surface lies within the radius `r`:
//!
//!     A = 1/π ∫ V_r(ω) (n·ω) dω
//!
//! `V_r(ω)` is 0 if a ray along `ω` meets a surface within `r`, and 1 otherwise. For directions with
//! the density (n·ω)/π, the mean of `V_r` is an unbiased estimate of `A`.

use manylight::geometry::Ray;
use manylight::math::{Frame, Vec2};
use manylight::prelude::*;
use manylight::sampling::{Pass, Sampler, Stream, warp};
use manylight_io::image::{LayeredImage, write_image};
use manylight_io::{LoadOptions, load_scene};
use rayon::prelude::*;
use std::path::Path;

/// Camera rays per pixel, each with one direction at the surface.
const SAMPLES: u32 = 64;
/// Exposure of the PNG, in stops.
const EXPOSURE_EV: f32 = 0.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [scene, radius, output] = words.as_slice() else {
        return Err("usage: ambient_occlusion SCENE.xml RADIUS OUT.png".into());
    };
    render_to_file(scene.as_ref(), radius.parse()?, output.as_ref())
}

fn render_to_file(
    file: &Path,
    radius: f32,
    output: &Path,
) -> Result<(), Box<dyn std::error::Error>> {
    let desc = load_scene(file, &LoadOptions::default())?.desc;
    let image = ambient_occlusion(&Scene::build(desc, 0)?, radius);
    write_image(output, &LayeredImage::from_image(&image), EXPOSURE_EV)?;
    Ok(())
}

/// The ambient occlusion of what each pixel sees. `radius` is in the scene's unit.
fn ambient_occlusion(scene: &Scene, radius: f32) -> Image {
    let size = scene.sensor.desc().film.crop_size.as_usizevec2();
    let mut image = Image::new(size.x, size.y, 1);
    image
        .data
        .par_iter_mut()
        .enumerate()
        .for_each(|(i, value)| {
            let pixel = Vec2::new((i % size.x) as f32, (i / size.x) as f32);
            // The key of the random numbers is the pixel: the image does not depend on threads.
            let mut sampler = Pass { seed: 0, index: 0 }.sampler(Stream::Pixel, i as u64);
            let samples = (0..SAMPLES).map(|_| openness(scene, radius, pixel, &mut sampler));
            *value = samples.sum::<f32>() / SAMPLES as f32;
        });
    image
}

/// One sample of a pixel: 0 if a ray from the visible surface meets another one within `radius`.
fn openness(scene: &Scene, radius: f32, pixel: Vec2, sampler: &mut Sampler) -> f32 {
    let on_film = pixel + sampler.next_2d();
    let camera_ray = scene.sensor.ray(on_film, sampler.next_2d());
    let Some((_, x)) = scene.intersect(&camera_ray) else {
        return 1.0;
    };
    let above = Frame::from_normal(x.normal_towards(-camera_ray.d));
    let w = above.to_world(warp::cosine_hemisphere(sampler.next_2d()));
    let ray = Ray {
        t_max: radius,
        ..x.spawn(w)
    };
    match scene.geometry.intersect(&ray) {
        Some(_) => 0.0,
        None => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::math::Vec3;
    use manylight::testing::scenes::{Builder, diffuse, furnace};

    /// Edge of the images in pixels.
    const SIZE: u32 = 48;

    /// A large floor at height 0. The camera sees a small part of it around the origin.
    fn floor() -> Builder {
        let mut scene = Builder::new(Vec3::new(1.0, 0.8, 0.5), Vec3::ZERO, 0.5, SIZE);
        let gray = scene.material(diffuse(0.5, 0.5, 0.5));
        scene.rectangle(Vec3::ZERO, Vec3::Z * 1e3, Vec3::X * 1e3, gray, None);
        scene
    }

    /// Five standard errors of the mean of an image, at most: samples are 0 or 1.
    fn tolerance() -> f32 {
        5.0 * 0.5 / ((SIZE * SIZE * SAMPLES) as f32).sqrt()
    }

    fn mean(scene: Builder, radius: f32) -> f32 {
        let image = ambient_occlusion(&scene.build(), radius);
        image.data.iter().sum::<f32>() / image.data.len() as f32
    }

    #[test]
    fn an_open_plane_is_not_occluded() {
        assert_eq!(mean(floor(), f32::INFINITY), 1.0);
    }

    #[test]
    fn a_closed_room_is_occluded_completely() {
        assert_eq!(mean(furnace(0.5, SIZE), f32::INFINITY), 0.0);
    }

    /// A wall of height `h` at the distance `d` from a point of the floor leaves
    /// (1 + d / √(d² + h²)) / 2 of the hemisphere open (Howell, "A Catalog of Radiation Heat
    /// Transfer Configuration Factors": a strip element and a perpendicular infinite strip).
    #[test]
    fn a_floor_beside_a_wall_has_the_analytic_value() {
        let (distance, height) = (1.0f32, 1.5f32);
        let mut scene = floor();
        let gray = scene.material(diffuse(0.5, 0.5, 0.5));
        let center = Vec3::new(-distance, 0.5 * height, 0.0);
        scene.rectangle(center, Vec3::Y * 0.5 * height, Vec3::Z * 1e3, gray, None);
        let expected = 0.5 * (1.0 + distance / distance.hypot(height));
        let found = mean(scene, f32::INFINITY);
        assert!((found - expected).abs() < tolerance(), "{found} {expected}");
    }

    /// Under a ceiling at half the radius, directions within 60° of the normal are occluded:
    /// cos² 60° of the hemisphere is open.
    #[test]
    fn surfaces_beyond_the_radius_do_not_occlude() {
        let mut scene = floor();
        let gray = scene.material(diffuse(0.5, 0.5, 0.5));
        scene.rectangle(Vec3::Y, Vec3::X * 1e3, Vec3::Z * 1e3, gray, None);
        let found = mean(scene, 2.0);
        assert!((found - 0.25).abs() < tolerance(), "{found}");
    }

    #[test]
    fn the_example_writes_an_image() {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("box.png");
        render_to_file(&scenes.join("furnace/emissive-box.xml"), 1.0, &output).unwrap();
        assert!(std::fs::metadata(&output).unwrap().len() > 0);
    }
}
