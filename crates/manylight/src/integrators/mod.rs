//! The methods. Start reading at [`many_light`].

mod aov;
pub mod axes;
mod candidates;
mod carried;
mod caustics;
pub mod eye_path;
mod guided;
pub mod interim;
pub mod light_set;
mod light_tracer;
pub mod many_light;
pub mod memory;
pub mod partition;
mod path;
pub mod photon_map;
mod presets;
mod smooth_light;

pub use interim::{InterimMaps, PlacedLight};
pub use light_set::PreparedPasses;
pub use many_light::ManyLight;
pub use memory::StageMemory;
pub use photon_map::PhotonMap;

use crate::bsdf::{BsdfSample, Lobes};
use crate::color::Rgb;
use crate::film::{Film, Layer, TileSamples};
use crate::math::UVec2;
use crate::sampling::{Pass, Sampler};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::Vertex;
use std::sync::atomic::{AtomicBool, Ordering};

/// A method with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// Which.
    pub kind: MethodKind,
    /// How long paths may be.
    pub limits: PathLimits,
}

/// The methods.
#[derive(Clone, Debug, PartialEq)]
pub enum MethodKind {
    /// Path tracing with next-event estimation: the reference.
    Path,
    /// Photons splatted on the film: the adjoint of `Path`, for what the camera sees without specular events.
    LightTracer,
    /// Direct light alone: path tracing to depth 2.
    Direct,
    /// Albedo, normal, depth of the first surface; the beauty stays black.
    Aov,
    /// Virtual lights.
    ManyLight(ManyLight),
    /// Photon maps.
    PhotonMap(PhotonMap),
}

/// What a pass works with, besides the scene.
#[derive(Clone, Copy, Debug)]
pub struct PassContext<'a> {
    /// Names the random numbers.
    pub pass: Pass,
    /// Counters and stage times.
    pub stats: &'a Stats,
    /// Polled per tile.
    pub cancel: &'a AtomicBool,
}

impl PassContext<'_> {
    /// [`Film::add_shifted_pass`] with progress, as the stage "shade".
    fn shade(
        &self,
        film: &mut Film,
        shift: UVec2,
        shade: impl Fn(&mut TileSamples) + Sync,
    ) -> bool {
        let done = &self.stats.tiles_done;
        done.store(0, Ordering::Relaxed);
        self.stats
            .tiles
            .store(film.tile_count(shift) as u64, Ordering::Relaxed);
        self.stats.time("shade", || {
            film.add_shifted_pass(shift, self.cancel, &self.stats.dropped_samples, |samples| {
                shade(samples);
                Stats::count(done, 1);
            })
        })
    }

    /// Whether the pass shall be dropped.
    fn cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

/// A method at work on a scene, with what its passes leave for later ones.
#[derive(Debug)]
pub struct Renderer<'s> {
    scene: &'s Scene,
    method: Method,
    lights: Option<PreparedPasses<'s>>,
}

impl Method {
    /// The layers that this method fills, beauty first.
    pub fn layers(&self) -> Vec<Layer> {
        let mut layers = vec![Layer::Beauty];
        if !matches!(self.kind, MethodKind::LightTracer | MethodKind::Aov) {
            layers.extend([
                Layer::Emission,
                Layer::Direct,
                Layer::VirtualLights,
                Layer::Caustics,
            ]);
        }
        if self.kind != MethodKind::LightTracer {
            layers.extend([Layer::Albedo, Layer::Normal, Layer::Depth]);
        }
        if matches!(&self.kind, MethodKind::ManyLight(method) if method.strategy != many_light::Strategy::All)
        {
            layers.extend([Layer::CutSize, Layer::CutBound]);
        }
        layers
    }
}

impl<'s> Renderer<'s> {
    /// `method`, before its first pass.
    pub fn new(scene: &'s Scene, method: Method) -> Self {
        Renderer {
            scene,
            method,
            lights: None,
        }
    }

    /// Adds one pass to `film`; `false` if it was cancelled and dropped. A pass is the same whatever came before it.
    pub fn render_pass(&mut self, run: &PassContext, film: &mut Film) -> bool {
        let (scene, limits) = (self.scene, self.method.limits);
        if self.begins_batch(run.pass.index) {
            film.begin_batch();
        }
        match &self.method.kind {
            MethodKind::Path => path::render_pass(scene, limits, run, film),
            MethodKind::Direct => {
                let max_depth = Some(limits.max_depth.map_or(2, |max| max.min(2)));
                let limits = PathLimits {
                    max_depth,
                    ..limits
                };
                path::render_pass(scene, limits, run, film)
            }
            MethodKind::LightTracer => light_tracer::render_pass(scene, limits, run, film),
            MethodKind::Aov => aov::render_pass(scene, limits, run, film),
            MethodKind::ManyLight(settings) => {
                settings.render_pass(scene, limits, run, &mut self.lights, film)
            }
            MethodKind::PhotonMap(settings) => settings.render_pass(scene, limits, run, film),
        }
    }

    /// Whether a pass has no lights in common with those before.
    fn begins_batch(&self, index: u32) -> bool {
        match &self.method.kind {
            MethodKind::ManyLight(settings) => settings.passes_with(index).start == index,
            _ => true,
        }
    }
}

/// Fills the layers that describe the first surface of a camera path, one of several of the pixel that count `share` each. The albedo is the
/// reflectance towards the viewer, as the weight of one sampled direction: its mean over passes is right, and a Lambertian surface has it at once.
fn first_surface(
    v: &Vertex,
    share: f32,
    sampler: &mut Sampler,
    index: usize,
    out: &mut TileSamples,
) {
    let sample = v.bsdf.sample_wi(v.w_prev, sampler.next_bsdf(), Lobes::ALL);
    first_surface_sampled(v, share, sample.as_ref(), index, out);
}

/// [`first_surface`] with the direction that the path goes on along.
fn first_surface_sampled(
    v: &Vertex,
    share: f32,
    sample: Option<&BsdfSample>,
    index: usize,
    out: &mut TileSamples,
) {
    let n = v.x.frame.n;
    let albedo = sample.map_or(Rgb::BLACK, |s| s.weight);
    out.add(index, Layer::Normal, Rgb::new(n.x, n.y, n.z) * share);
    out.add(index, Layer::Depth, Rgb::splat(v.distance * share));
    out.add(index, Layer::Albedo, albedo * share);
}
