//! Photons: flux incident at surfaces, traced from the emitters.

use crate::bsdf::{Bsdf, Lobes};
use crate::color::Rgb;
use crate::emitters::EmissionGuide;
use crate::geometry::SurfaceRef;
use crate::math::Vec3;
use crate::sampling::{Pass, Sampler, Stream};
use crate::scene::{PathLimits, Scene};
use crate::transport::{Walk, roulette};
use rayon::prelude::*;

/// Flux incident at `p` from direction `wi`, already divided by the number of photon paths: for any function `h`
///
/// ```text
/// E[Σ_j Φ_j h(p_j, wi_j)] = ∫∫ L_i(p, w) |n·w| h(p, w) dw dA
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// Position.
    pub p: Vec3,
    /// Geometric normal, turned to the side from which the photon arrives.
    pub n: Vec3,
    /// Unit direction to the previous vertex.
    pub wi: Vec3,
    /// Flux `Φ`, in W.
    pub flux: Rgb,
    /// Flux times [`Bsdf::diffuse_weight`](crate::bsdf::Bsdf::diffuse_weight) at `wi`, in W: the flux of the diffuse lobes before the exit
    /// transmittance.
    pub diffuse_flux: Rgb,
    /// Position of the previous vertex; for infinite lights a point outside of the scene.
    pub prev: Vec3,
    /// The surface and coordinates on it, from which the scattering function is evaluated.
    pub at: SurfaceRef,
    /// Number of segments from the emitter; 1 for direct light.
    pub depth: u16,
    /// Class of the scattering event at `prev`; [`Lobes::NONE`] at an emitter.
    pub event: Lobes,
    /// Class of the last non-specular scattering event; [`Lobes::NONE`] without one since the emitter.
    pub origin: Lobes,
}

impl AsRef<Photon> for Photon {
    fn as_ref(&self) -> &Photon {
        self
    }
}

/// Index of the photon at the vertex from which photon `j` was scattered by non-specular lobes, in a list from [`trace_photons`]; `None` if it came
/// from an emitter or a specular event.
pub fn parent(photons: &[Photon], j: usize) -> Option<usize> {
    let child = &photons[j];
    if !child.event.has(Lobes::NON_SPECULAR) {
        return None;
    }
    // Photons in between are of the same path, on transparent surfaces that it passed through.
    (0..j)
        .rev()
        .take_while(|&i| photons[i].depth < child.depth)
        .find(|&i| photons[i].p == child.prev)
}

/// Number of paths traced by one task.
const PATHS_PER_TASK: u32 = 1024;

/// For [`trace_photons`]: the smallest number of segments by which a many-light method extends a photon after an event of the given class; `None` on
/// surfaces without non-specular lobes. A virtual light at depth m makes paths of at least m + 2 segments, a photon of m + 1: caustic photons, and
/// those that glossy lobes reflect, which compensate clamping.
pub fn usable_by_virtual_lights(bsdf: &Bsdf, event: Lobes) -> Option<u32> {
    let is_estimate = event.has(Lobes::SPECULAR) || event.has(Lobes::GLOSSY);
    let segments = if is_estimate { 1 } else { 2 };
    bsdf.lobes().has(Lobes::NON_SPECULAR).then_some(segments)
}

/// Traces `path_count` photon paths and stores a photon at every vertex where it is useful: `segments_added` returns, for a surface and the class of
/// the previous event, the smallest number of segments that a camera path adds, or `None` for a useless photon.
///
/// `guide` concentrates photons on what the camera sees; it changes no expected value. Photons of which every extended path would exceed `limits`
/// are left out. The list is in path order, the same for any number of threads.
pub fn trace_photons(
    scene: &Scene,
    guide: &EmissionGuide,
    limits: PathLimits,
    path_count: u32,
    pass: Pass,
    segments_added: impl Fn(&Bsdf, Lobes) -> Option<u32> + Sync,
) -> Vec<Photon> {
    let tracer = PathTracer {
        scene,
        guide,
        limits,
        path_fraction: 1.0 / path_count as f32,
        segments_added,
    };
    let tasks: Vec<Vec<Photon>> = (0..path_count.div_ceil(PATHS_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let mut photons = Vec::new();
            for index in task * PATHS_PER_TASK..((task + 1) * PATHS_PER_TASK).min(path_count) {
                let mut sampler = pass.sampler(Stream::Photon, u64::from(index));
                tracer.trace(&mut sampler, &mut photons);
            }
            photons
        })
        .collect();
    // Not `concat`: frees the list of each task while copying.
    let mut photons = Vec::with_capacity(tasks.iter().map(Vec::len).sum());
    photons.extend(tasks.into_iter().flatten());
    photons
}

/// The arguments of [`trace_photons`] that all paths share.
struct PathTracer<'a, F> {
    scene: &'a Scene,
    guide: &'a EmissionGuide,
    limits: PathLimits,
    /// One over the number of paths.
    path_fraction: f32,
    segments_added: F,
}

impl<F: Fn(&Bsdf, Lobes) -> Option<u32>> PathTracer<'_, F> {
    /// Traces one path and appends its photons.
    fn trace(&self, sampler: &mut Sampler, photons: &mut Vec<Photon>) {
        let (scene, limits) = (self.scene, self.limits);
        let start = scene.emitters.sample_emission(
            &scene.geometry,
            &scene.textures,
            self.guide,
            sampler.next_emission(),
        );
        let Some(start) = start else {
            return;
        };
        let mut walk = Walk::from_emitter(scene, start.ray, start.flux * self.path_fraction);
        let mut origin = Lobes::NONE;
        while let Some(v) = walk.advance() {
            let event = walk.previous().event;
            if !event.has(Lobes::SPECULAR) {
                origin = event;
            }
            let is_useful = |added| limits.allow(v.segments + added);
            if (self.segments_added)(&v.bsdf, event).is_some_and(is_useful) {
                photons.push(Photon {
                    p: v.x.p,
                    n: v.x.normal_towards(v.w_prev),
                    wi: v.w_prev,
                    flux: walk.throughput(),
                    diffuse_flux: walk.throughput() * v.bsdf.diffuse_weight(v.w_prev),
                    prev: walk.previous().p,
                    at: v.x.at,
                    depth: v.segments.min(u32::from(u16::MAX)) as u16,
                    event,
                    origin,
                });
            }
            if !limits.allow(v.segments + 2) {
                return;
            }
            if walk.pass_through(&v, sampler.next_1d()) {
                continue;
            }
            let before = walk.throughput();
            if !walk.scatter(&v, sampler.next_bsdf(), Lobes::ALL)
                || !walk.survive(
                    roulette::photon_survival(before, walk.throughput()),
                    sampler.next_1d(),
                )
            {
                return;
            }
        }
    }
}
