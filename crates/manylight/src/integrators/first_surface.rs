//! The film layers that describe the first surface of a camera path: albedo, normal, depth.
//!
//! The albedo is the reflectance towards the viewer, estimated by the weight of one sampled direction. Its mean over passes
//! is right, and exact after one pass on a Lambertian surface.

use crate::bsdf::{BsdfSamples, Lobes};
use crate::color::Rgb;
use crate::film::{Layer, TileSamples};
use crate::lanes::{Width, lane};
use crate::sampling::Sampler;
use crate::simd::set_bits;
use crate::transport::Vertex;
use crate::transport::stream::{Bits, Vertices};

/// The first surface of a camera path, beside what its vertex tells.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstSurface {
    /// Index of the pixel in the tile.
    pub(super) pixel: usize,
    /// Distance from the camera, in m.
    pub(super) depth: f32,
    /// Inverse of the number of camera paths of the pixel.
    pub(super) share: f32,
}

/// Adds the vertices in `lanes`, the first of their camera paths. `samples` are directions sampled from all lobes.
#[inline(always)]
pub(super) fn add_first_surfaces<S: Width>(
    v: &Vertices<S>,
    samples: &BsdfSamples<S>,
    lanes: Bits,
    first: impl Fn(usize) -> FirstSurface,
    out: &mut TileSamples,
) {
    let albedo = samples.weight.within(samples.valid).store();
    let normal = v.x.frame.n.store();
    for i in set_bits(lanes) {
        let first = first(i);
        let mut add = |layer, value: Rgb| out.add(first.pixel, layer, value * first.share);
        add(Layer::Normal, Rgb::from(lane(&normal, i)));
        add(Layer::Depth, Rgb::splat(first.depth));
        add(Layer::Albedo, Rgb::from(lane(&albedo, i)));
    }
}

/// [`add_first_surfaces`] for a single vertex.
pub(super) fn add_first_surface(
    v: &Vertex,
    share: f32,
    sampler: &mut Sampler,
    pixel: usize,
    out: &mut TileSamples,
) {
    let sample = v.bsdf.sample_wi(v.w_prev, sampler.next_bsdf(), Lobes::ALL);
    let n = v.x.frame.n;
    let albedo = sample.map_or(Rgb::BLACK, |s| s.weight);
    out.add(pixel, Layer::Normal, Rgb::new(n.x, n.y, n.z) * share);
    out.add(pixel, Layer::Depth, Rgb::splat(v.distance * share));
    out.add(pixel, Layer::Albedo, albedo * share);
}
