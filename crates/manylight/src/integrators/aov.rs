//! Albedo, normal and depth of the first surface.

use super::context::PassContext;
use super::first_surface::add_first_surface;
use crate::color::Rgb;
use crate::film::Film;
use crate::math::UVec2;
use crate::sampling::Stream;
use crate::scene::{PathLimits, Scene};
use crate::transport::Walk;

/// One sample per pixel. `false` if cancelled.
pub(super) fn render_pass(
    scene: &Scene,
    limits: PathLimits,
    run: &PassContext,
    film: &mut Film,
) -> bool {
    let positions = film.desc().sampler();
    run.shade(film, UVec2::ZERO, |samples| {
        for (i, pixel) in samples.tile().pixels().enumerate() {
            let mut sampler = run.pass.sampler(Stream::Pixel, positions.index(pixel));
            let at = positions.sample(pixel, sampler.next_2d());
            let camera = scene.sensor.ray(at.position, sampler.next_2d());
            let mut walk = Walk::from_sensor(scene, limits, camera.ray, Rgb::WHITE);
            if let Some(v) = walk.advance() {
                add_first_surface(&v, 1.0, &mut sampler, i, samples);
            }
        }
    })
}
