//! Photons: flux that arrives at surfaces.

use crate::bsdf::{Bsdf, Lobes};
use crate::color::Rgb;
use crate::emitters::EmissionGuide;
use crate::geometry::SurfaceRef;
use crate::math::Vec3;
use crate::sampling::{Pass, Sampler, Stream};
use crate::scene::{PathLimits, Scene};
use crate::transport::{Walk, roulette};
use rayon::prelude::*;

/// Flux that arrives at `p` from direction `wi`, already divided by the number of emitted paths:
/// `E[Σ flux h(p, wi)] = ∫∫ L_i(p, w) |n·w| h(p, w) dw dA` for any `h`.
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// Position.
    pub p: Vec3,
    /// Geometric normal, turned to the side from which the photon arrives.
    pub n: Vec3,
    /// Unit direction to the previous vertex.
    pub wi: Vec3,
    /// W.
    pub flux: Rgb,
    /// Flux times [`Bsdf::diffuse_weight`](crate::bsdf::Bsdf::diffuse_weight) at `wi`: what the diffuse lobes send out, before
    /// their exit term. W.
    pub diffuse_flux: Rgb,
    /// Position of the previous vertex; for distant emitters a point outside the scene.
    pub prev: Vec3,
    /// Where on the surface; the scattering function is rebuilt from here.
    pub at: SurfaceRef,
    /// Segments from the emitter: 1 is direct light.
    pub depth: u16,
    /// Class of the scattering event at `prev`; [`Lobes::NONE`] at an emitter.
    pub event: Lobes,
    /// Class of the last event that was not specular; [`Lobes::NONE`] if there was none since the emitter.
    pub origin: Lobes,
}

impl AsRef<Photon> for Photon {
    fn as_ref(&self) -> &Photon {
        self
    }
}

/// Index of the photon at the vertex from which photon `j` was scattered by smooth lobes, in a list from [`trace_photons`].
pub fn parent(photons: &[Photon], j: usize) -> Option<usize> {
    let child = &photons[j];
    if !child.event.has(Lobes::NON_SPECULAR) {
        return None;
    }
    // What lies between is transparent, and of the same path.
    (0..j)
        .rev()
        .take_while(|&i| photons[i].depth < child.depth)
        .find(|&i| photons[i].p == child.prev)
}

/// Paths traced by one task.
const PATHS_PER_TASK: u32 = 1024;

/// The use of a photon on a surface with smooth lobes that comes from a scattering event of the given class, in the many-light
/// methods: a virtual light at depth m makes paths of m + 2 segments, a caustic photon of m + 1. See [`trace_photons`].
pub fn for_lights(bsdf: &Bsdf, event: Lobes) -> Option<u32> {
    let segments = if event.has(Lobes::SPECULAR) { 1 } else { 2 };
    bsdf.lobes().has(Lobes::NON_SPECULAR).then_some(segments)
}

/// Traces `path_count` photon paths and stores a photon wherever it is of use: `segments_added` tells for the surface and the
/// class of the event that the photon comes from how many segments an eye path adds at least, or `None` if it is of no use.
///
/// The list is in path order, the same for any number of threads. Photons that no eye path within `limits` can use are
/// left out.
pub fn trace_photons(
    scene: &Scene,
    limits: PathLimits,
    path_count: u32,
    pass: Pass,
    segments_added: impl Fn(&Bsdf, Lobes) -> Option<u32> + Sync,
) -> Vec<Photon> {
    let guide = scene.emission_guide();
    let tasks: Vec<Vec<Photon>> = (0..path_count.div_ceil(PATHS_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let mut photons = Vec::new();
            for index in task * PATHS_PER_TASK..((task + 1) * PATHS_PER_TASK).min(path_count) {
                let mut sampler = pass.sampler(Stream::Photon, u64::from(index));
                trace_path(
                    scene,
                    &guide,
                    limits,
                    1.0 / path_count as f32,
                    &mut sampler,
                    &segments_added,
                    &mut photons,
                );
            }
            photons
        })
        .collect();
    // Not `concat`: each task's own list is freed on the way.
    let mut photons = Vec::with_capacity(tasks.iter().map(Vec::len).sum());
    photons.extend(tasks.into_iter().flatten());
    photons
}

/// One path; its photons are appended.
fn trace_path(
    scene: &Scene,
    guide: &EmissionGuide,
    limits: PathLimits,
    share: f32,
    sampler: &mut Sampler,
    segments_added: &impl Fn(&Bsdf, Lobes) -> Option<u32>,
    photons: &mut Vec<Photon>,
) {
    let start = scene.emitters.sample_emission(
        &scene.geometry,
        &scene.textures,
        guide,
        sampler.next_emission(),
    );
    let Some(start) = start else {
        return;
    };
    let mut walk = Walk::from_emitter(scene, start.ray, start.flux * share);
    let mut origin = Lobes::NONE;
    while let Some(v) = walk.advance() {
        let event = walk.previous().event;
        if !event.has(Lobes::SPECULAR) {
            origin = event;
        }
        let is_useful = |added| limits.allow(v.segments + added);
        if segments_added(&v.bsdf, event).is_some_and(is_useful) {
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
