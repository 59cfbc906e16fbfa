//! Albedo, normal and depth of the first surface.

use super::path::pixel_index;
use super::{PassContext, first_surface};
use crate::color::Rgb;
use crate::film::{Film, Layer};
use crate::sampling::Stream;
use crate::scene::Scene;
use crate::transport::{Step, Walk};

/// One sample per pixel. `false` if cancelled.
pub(super) fn render_pass(scene: &Scene, run: &PassContext, film: &mut Film) -> bool {
    let desc = film.desc().clone();
    run.shade(film, |samples| {
        for (i, pixel) in samples.tile().pixels().enumerate() {
            let mut sampler = run.pass.sampler(Stream::Pixel, pixel_index(pixel, desc.crop_size.x));
            let at = desc.sample(pixel, sampler.next_2d());
            let camera = scene.sensor.ray(at.position, sampler.next_2d());
            let mut walk = Walk::from_sensor(scene, camera.ray, Rgb::WHITE);
            if let Step::Hit(v) = walk.advance() {
                first_surface(&v, i, samples);
                samples.add(i, Layer::Beauty, v.bsdf.quick_albedo(v.w_prev));
            }
        }
    })
}
