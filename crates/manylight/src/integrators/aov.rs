//! What the camera sees first: albedo, normal and depth, alpha, position and ids.

use super::context::PassContext;
use super::first_event::{FirstEvent, SampleShare, add_first_event};
use super::first_surface::add_first_surface;
use crate::color::Rgb;
use crate::film::{Film, Tiling};
use crate::sampling::Stream;
use crate::scene::{PathLimits, Scene};
use crate::transport::{Walk, next_scattering_vertex};

/// One sample per pixel. `false` if cancelled.
pub(super) fn render_pass(
    scene: &Scene,
    limits: PathLimits,
    run: &PassContext,
    film: &mut Film,
) -> bool {
    let positions = film.desc().sampler();
    run.shade(film, Tiling::UNSHIFTED, |samples| {
        for (i, pixel) in samples.tile().pixels().enumerate() {
            let mut sampler = run.pass.sampler(Stream::Pixel, positions.index(pixel));
            let at = positions.sample(pixel, sampler.next_2d());
            let camera = scene.sensor.ray(at.position, sampler.next_2d());
            let mut walk = Walk::from_sensor(scene, limits, camera.ray, Rgb::WHITE);
            let path = SampleShare {
                filter_weight: at.weight,
                share: 1.0,
            };
            let mut ends_by = FirstEvent::Nothing;
            let found = next_scattering_vertex(
                limits,
                &mut walk,
                None,
                &mut sampler,
                |step, _, sampler| {
                    ends_by = FirstEvent::of_last_step(scene, limits, step);
                    if let Some(v) = step.vertex.as_ref().filter(|v| v.segments == 1) {
                        add_first_surface(v, 1.0, sampler, i, samples);
                    }
                    true
                },
            );
            let event = found.as_ref().map_or(ends_by, FirstEvent::scattering);
            add_first_event(scene, event, path, i, samples);
        }
    })
}
