//! Importons: importance that arrives at surfaces from the points that will sum virtual lights.

use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::math::{Vec2, Vec3};
use crate::sampling::{Pass, Sampler, Stream};
use crate::scene::{PathLimits, Scene};
use crate::transport::Walk;
use rayon::prelude::*;

/// Importance that arrives at `p` from the shading point that would sum lights standing here.
#[derive(Clone, Copy, Debug)]
pub struct Importon {
    /// Position.
    pub p: Vec3,
    /// Geometric normal, turned to the side from which the importon arrives; of the twin on a transmitting surface, to the other.
    pub n: Vec3,
    /// Unit direction to the shading point.
    pub wo: Vec3,
    /// Importance, already divided by the number of importon paths.
    pub importance: f32,
}

/// Paths traced by one task.
const PATHS_PER_TASK: u32 = 1024;

/// Traces `path_count` camera paths through uniform film positions. Each follows specular events to a vertex `x` with a
/// smooth event (the same walk as shading) and deposits an importon at the surfaces that this event sees: a virtual light
/// there is seen from `x`. Deeper bounces deposit nothing; their transport is the photons'.
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
                // Lights on the far side shine through.
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

/// Chains of mirrors longer than this matter to nobody.
const MAX_SPECULAR_SEGMENTS: u32 = 64;
