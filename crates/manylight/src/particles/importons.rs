//! Importons: importance incident at surfaces, traced from the camera by way of the points at which virtual lights are summed.

use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::math::{Vec2, Vec3};
use crate::sampling::{Pass, Sampler, Stream};
use crate::scene::{PathLimits, Scene};
use crate::transport::Walk;
use rayon::prelude::*;

/// Importance incident at `p` from a gather point: the weight of a virtual light at `p` in the image.
#[derive(Clone, Copy, Debug)]
pub struct Importon {
    /// Position.
    pub p: Vec3,
    /// Geometric normal on the side from which the importon arrives; for the copy on a transmitting surface, on the other side.
    pub n: Vec3,
    /// Unit direction to the gather point.
    pub wo: Vec3,
    /// Importance `Ψ`, already divided by the number of importon paths.
    pub importance: f32,
}

/// Largest number of segments of a specular chain; longer ones contribute little.
const MAX_SPECULAR_SEGMENTS: u32 = 64;
/// Number of paths traced by one task.
const PATHS_PER_TASK: u32 = 1024;

/// Traces `path_count` camera paths through uniform film positions.
///
/// Each path follows specular events to a gather point, samples a non-specular event there, and deposits an importon at the next surface: a
/// virtual light there illuminates the gather point (`Ŵ(x3)` in Simon et al. 2015). It ends there, as photons cover the rest of the transport.
pub fn trace_importons(
    scene: &Scene,
    limits: PathLimits,
    path_count: u32,
    pass: Pass,
) -> Vec<Importon> {
    let tasks: Vec<Vec<Importon>> = (0..path_count.div_ceil(PATHS_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let mut importons = Vec::new();
            for index in task * PATHS_PER_TASK..((task + 1) * PATHS_PER_TASK).min(path_count) {
                let mut sampler = pass.sampler(Stream::Importon, u64::from(index));
                trace_path(
                    scene,
                    limits,
                    1.0 / path_count as f32,
                    &mut sampler,
                    &mut importons,
                );
            }
            importons
        })
        .collect();
    tasks.concat()
}

/// Traces one path with the fraction `share` of the importance of the sensor and appends its importons.
fn trace_path(
    scene: &Scene,
    limits: PathLimits,
    share: f32,
    sampler: &mut Sampler,
    importons: &mut Vec<Importon>,
) {
    let size = scene.sensor.desc().film.crop_size.as_vec2();
    let film_position: Vec2 = sampler.next_2d() * size;
    let camera = scene.sensor.ray(film_position, sampler.next_2d());
    let mut walk = Walk::from_sensor(scene, limits, camera.ray, Rgb::splat(camera.weight * share));
    while let Some(v) = walk.advance() {
        if walk.previous().event.has(Lobes::NON_SPECULAR) && v.bsdf.lobes().has(Lobes::NON_SPECULAR)
        {
            let importon = Importon {
                p: v.x.p,
                n: v.x.normal_towards(v.w_prev),
                wo: v.w_prev,
                importance: walk.throughput().luminance(),
            };
            importons.push(importon);
            if v.bsdf.transmits() {
                // Lights on the far side emit through the surface.
                importons.push(Importon {
                    n: -importon.n,
                    ..importon
                });
            }
        }
        // A light here lengthens the path by at least its own connection and one photon segment.
        if !limits.allow(v.segments + 2) {
            return;
        }
        if walk.pass_through(&v, sampler.next_1d()) {
            continue;
        }
        if walk.previous().event.has(Lobes::NON_SPECULAR)
            || !walk.scatter(&v, sampler.next_bsdf(), Lobes::ALL)
        {
            return;
        }
        if v.segments > MAX_SPECULAR_SEGMENTS {
            return;
        }
    }
}
