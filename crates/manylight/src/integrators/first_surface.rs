//! The film layers that describe the first surface of a camera path: albedo, normal, depth.
//!
//! The albedo is the reflectance towards the viewer, estimated by the weight of one sampled direction. Its mean over passes
//! is right, and exact after one pass on a Lambertian surface.

use crate::bsdf::{BsdfSample, Lobes};
use crate::color::Rgb;
use crate::film::{Layer, TileSamples};
use crate::sampling::Sampler;
use crate::transport::Vertex;

/// Adds the vertex `v` to pixel `index` of the tile. `weight` is the inverse of the number of camera paths of the pixel.
pub(super) fn add_first_surface(
    v: &Vertex,
    weight: f32,
    sampler: &mut Sampler,
    index: usize,
    out: &mut TileSamples,
) {
    let sample = v.bsdf.sample_wi(v.w_prev, sampler.next_bsdf(), Lobes::ALL);
    add_sampled_first_surface(v, weight, sample.as_ref(), index, out);
}

/// [`add_first_surface`] with a direction that was already sampled from all lobes.
pub(super) fn add_sampled_first_surface(
    v: &Vertex,
    weight: f32,
    sample: Option<&BsdfSample>,
    index: usize,
    out: &mut TileSamples,
) {
    let n = v.x.frame.n;
    let albedo = sample.map_or(Rgb::BLACK, |s| s.weight);
    out.add(index, Layer::Normal, Rgb::new(n.x, n.y, n.z) * weight);
    out.add(index, Layer::Depth, Rgb::splat(v.distance * weight));
    out.add(index, Layer::Albedo, albedo * weight);
}
