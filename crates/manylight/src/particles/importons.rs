//! Importons: importance incident at surfaces, traced from the camera by way of the points at which
//! virtual lights are summed.

use super::tasks::in_path_order;
use crate::bsdf::Lobes;
use crate::lanes::{Float, Width, lane};
use crate::math::Vec3;
use crate::sampling::{Pass, Stream};
use crate::scene::{PathLimits, Scene};
use crate::simd::set_bits;
use crate::transport::stream::{
    Bits, VertexShader, Vertices, WalkRow, Walks, follow_and_shade, lanes_where,
};
use crate::transport::walk::{MAX_SPECULAR_SEGMENTS, visible_part};
use std::ops::Range;

/// Importance incident at `p` from a gather point: the weight of a virtual light at `p` in the
/// image.
#[derive(Clone, Copy, Debug)]
pub struct Importon {
    /// Position.
    pub p: Vec3,
    /// Geometric normal on the side from which the importon arrives; for the copy on a transmitting
    /// surface, on the other side.
    pub n: Vec3,
    /// Importance `Ψ`, already divided by the number of importon paths.
    pub importance: f32,
}

/// Traces `path_count` camera paths through uniform film positions, by [`Scene::views`] in turns.
///
/// Each path follows specular events to a gather point, samples a non-specular event there, and
/// deposits an importon at the next surface: a virtual light there illuminates the gather point
/// (`Ŵ(x3)` in Simon et al. 2015). It ends there, as photons cover the rest of the transport.
pub fn trace_importons(
    scene: &Scene,
    limits: PathLimits,
    path_count: u32,
    pass: Pass,
) -> Vec<Importon> {
    trace(scene, limits, path_count, pass, Deposit::BehindGatherPoints)
}

/// Traces `path_count` camera paths through uniform film positions, and deposits an importon at
/// each gather point: a density estimate there is seen.
pub fn trace_gather_importons(
    scene: &Scene,
    limits: PathLimits,
    path_count: u32,
    pass: Pass,
) -> Vec<Importon> {
    trace(scene, limits, path_count, pass, Deposit::AtGatherPoints)
}

fn trace(
    scene: &Scene,
    limits: PathLimits,
    path_count: u32,
    pass: Pass,
    deposit: Deposit,
) -> Vec<Importon> {
    let tracer = PathTracer {
        scene,
        limits,
        path_fraction: 1.0 / path_count as f32,
        deposit,
    };
    in_path_order(path_count, |paths| tracer.trace(pass, paths))
}

/// Where importons are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Deposit {
    AtGatherPoints,
    /// At the next surfaces.
    BehindGatherPoints,
}

/// The arguments of [`trace`] that all paths share.
struct PathTracer<'a> {
    scene: &'a Scene,
    limits: PathLimits,
    /// One over the number of paths.
    path_fraction: f32,
    deposit: Deposit,
}

impl PathTracer<'_> {
    /// Traces paths, and returns their importons with the index of their path.
    fn trace(&self, pass: Pass, paths: Range<u32>) -> Vec<(u32, Importon)> {
        let mut importons = StoredImportons {
            limits: self.limits,
            deposit: self.deposit,
            stored: Vec::new(),
        };
        follow_and_shade(self.scene, self.start(pass, paths), &mut importons);
        importons.stored
    }

    /// The paths at the camera. They carry their index.
    fn start(&self, pass: Pass, paths: Range<u32>) -> Walks<u32> {
        let scene = self.scene;
        let mut walks = Walks::with_capacity(paths.len());
        for index in paths {
            let mut sampler = pass.sampler(Stream::Importon, u64::from(index));
            let ray = scene.random_camera_ray(u64::from(index), &mut sampler);
            let (ray, _) = visible_part(scene, self.limits.hide_emitters, ray);
            let throughput = [self.path_fraction; 3];
            walks.push(WalkRow::start(ray, throughput, sampler, index));
        }
        walks
    }
}

/// The importons of the paths of a task.
struct StoredImportons {
    limits: PathLimits,
    deposit: Deposit,
    /// With the index of their path.
    stored: Vec<(u32, Importon)>,
}

impl VertexShader<u32> for StoredImportons {
    #[inline(always)]
    fn shade<S: Width>(
        &mut self,
        v: &Vertices<S>,
        walks: &Walks<u32>,
        lanes: Bits,
        next: &mut Walks<u32>,
    ) {
        let gathered = lanes_where(lanes, |i| {
            walks.event(v.index.as_ref()[i]).has(Lobes::NON_SPECULAR)
        });
        let stored = match self.deposit {
            Deposit::BehindGatherPoints => gathered,
            Deposit::AtGatherPoints => lanes & !gathered,
        };
        self.store(v, walks, stored);
        advance(self.limits, v, walks, (lanes, gathered), next);
    }
}

impl StoredImportons {
    /// Stores the importons of the paths in `lanes` at surfaces with non-specular lobes.
    #[inline(always)]
    fn store<S: Width>(&mut self, v: &Vertices<S>, walks: &Walks<u32>, lanes: Bits) {
        let receives = lanes & v.bsdf.has(Lobes::NON_SPECULAR).bits();
        if receives == 0 {
            return;
        }
        let transmits = v.bsdf.transmitting().bits();
        let s = v.w_prev.x.width();
        let importance = walks.throughput(s, &v.index).luminance().store();
        let n = v.x.normals_towards(v.w_prev).store();
        let p = v.x.p.store();
        for i in set_bits(receives) {
            let path = v.payload(walks, i);
            let importon = Importon {
                p: Vec3::from(lane(&p, i)),
                n: Vec3::from(lane(&n, i)),
                importance: importance.as_ref()[i],
            };
            self.stored.push((path, importon));
            if transmits >> i & 1 != 0 {
                // Lights on the far side emit through the surface.
                let n = -importon.n;
                self.stored.push((path, Importon { n, ..importon }));
            }
        }
    }
}

/// Appends the paths in `lanes` that go on to `next`. Those that come from a gather point,
/// `gathered`, do not scatter.
#[inline(always)]
fn advance<S: Width>(
    limits: PathLimits,
    v: &Vertices<S>,
    walks: &Walks<u32>,
    (lanes, gathered): (Bits, Bits),
    next: &mut Walks<u32>,
) {
    // A light here lengthens the path by at least its own connection and one photon segment.
    let goes_on = lanes_where(lanes, |i| limits.allow(v.segments.as_ref()[i] + 2));
    if goes_on == 0 {
        return;
    }
    let s = v.w_prev.x.width();
    let mut generators = v.generators(s, walks);
    let mut throughput = walks.throughput(s, &v.index);
    let path = |i| v.payload(walks, i);
    let u = generators.next();
    let state = (&mut throughput, &generators, u);
    let scatters = v.pass_through(walks, next, state, goes_on, path);
    let scatters = lanes_where(scatters & !gathered, |i| {
        v.segments.as_ref()[i] <= MAX_SPECULAR_SEGMENTS
    });
    if scatters == 0 {
        return;
    }
    let numbers = generators.next_bsdf();
    let sample = v.bsdf.sample_each_wi(v.w_prev, numbers, Lobes::ALL);
    let alive = sample.valid & !sample.weight.is_black();
    let one = Float::splat(s, 1.0);
    let segments = v.next_segments(&sample, throughput * sample.weight, one);
    for i in set_bits(alive.bits() & scatters) {
        next.push(segments.row(i, generators.get(i), path(i)));
    }
}
