//! The gather tree: a binary tree over the gather points of a pixel, for product cuts. Every node
//! bounds the points below it.
//!
//! Source: Walter, Arbree, Bala, Greenberg, "Multidimensional Lightcuts", SIGGRAPH 2006.

use super::receivers::Receivers;
use super::{ShadingPoint, Subset};
use crate::bsdf::{FixedWo, Lobes};
use crate::color::Rgb;
use crate::ids::LightId;
use crate::lanes::{Color, Float, Mask, One, Vector};
use crate::math::{Aabb, Cone, Spread, Vec3};
use crate::virtual_lights::VirtualLights;

/// Distance that corresponds to a unit distance between normals, relative to the diagonal of all
/// points, as for the light tree. At 0.125 and 0.5 (2 passes of `bidirectional-lightcuts` at 72x40,
/// 3 seeds; Kitchen): relMSE +0.6 and +1.1 % (standard error 1 %).
const NORMAL_SCALE: f32 = 0.25;

/// A gather point of the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct WeightedPoint<'b, 's> {
    /// Index in the list that the tree was made of.
    pub(super) index: usize,
    pub(super) at: &'b ShadingPoint<'s>,
    /// Scattering function of the non-specular lobes towards the camera path.
    pub(super) bsdf: FixedWo<'b, 's>,
    /// Throughput of the camera path up to the point.
    pub(super) throughput: Rgb,
    /// Luminance of the throughput: the point represents a node with a probability proportional to
    /// it.
    pub(super) weight: f32,
    /// Largest channel of the throughput.
    importance: f32,
    /// Normal on the side that receives light; `None` if both do.
    receiving: Option<Vec3>,
    /// For a Lambertian surface, the largest channel of `f`, in 1/sr.
    lambert: Option<f32>,
    /// Position, in m, and normal scaled by [`NORMAL_SCALE`] times the diagonal.
    place: [f32; 6],
}

impl<'b, 's> WeightedPoint<'b, 's> {
    fn new(index: usize, (at, throughput): (&'b ShadingPoint<'s>, Rgb)) -> Self {
        let ShadingPoint { bsdf, wo, .. } = at;
        let receiving = bsdf.receiving_normal(*wo);
        let fixed = FixedWo::new(bsdf, *wo, Lobes::NON_SPECULAR);
        WeightedPoint {
            index,
            at,
            bsdf: fixed,
            throughput,
            weight: throughput.luminance(),
            importance: throughput.max_channel(),
            receiving,
            lambert: fixed.lambert().map(Rgb::max_channel),
            place: [0.0; 6],
        }
    }

    /// Whether the point receives light from `p`. Positions in its plane are outside, up to the
    /// distance `rounding`.
    pub(super) fn receives(&self, p: Vec3, rounding: f32) -> bool {
        let to = p - self.at.x.p;
        self.receiving.is_none_or(|n| n.dot(to) > rounding)
    }

    /// Upper bound of `T f cosθ` over the directions within `spread` of `axis`, in 1/sr; `T` is the
    /// largest channel of the throughput.
    fn bound(&self, axis: Vec3, spread: Spread) -> f32 {
        self.importance * self.bsdf.bound(axis, spread)
    }
}

impl Receivers<One> for WeightedPoint<'_, '_> {
    #[inline(always)]
    fn towards(&self, p: Vec3) -> Vector<One> {
        (p - self.at.x.p).into()
    }

    #[inline(always)]
    fn normals(&self) -> Vector<One> {
        self.at.x.ng.into()
    }

    #[inline(always)]
    fn lights(&self) -> Subset {
        self.at.lights
    }

    #[inline(always)]
    fn f_cos_wi(&self, wi: Vector<One>, _: Mask<One>) -> Color<One> {
        self.bsdf.f_cos_wi(wi.into()).into()
    }

    #[inline(always)]
    fn count_light_from(&self, wi: Vector<One>) -> Mask<One> {
        let is_wanted = |n: Vec3| n.dot(wi.into()) > 0.0;
        Mask::splat(One, self.at.lit_from.is_none_or(is_wanted))
    }

    #[inline(always)]
    fn shares(&self, lights: &VirtualLights, id: LightId) -> Float<One> {
        let depth = self.at.max_photon_depth;
        depth
            .map_or(1.0, |depth| lights.share_up_to(id, depth))
            .into()
    }
}

/// A leaf with one gather point, or an inner node with two children.
#[derive(Clone, Debug)]
pub(super) struct GatherNode {
    /// Bounding box of the points.
    pub(super) bounds: Aabb,
    /// Bounding cone of the normals on the sides that receive light; full if a point receives light
    /// on both sides.
    pub(super) normals: Cone,
    /// Spread of that cone.
    spread: Spread,
    /// Sum of `T f` over the Lambertian points, in 1/sr.
    diffuse: f32,
    /// Whether there are other points.
    has_others: bool,
    /// Sum of the weights of the points.
    pub(super) weight: f32,
    /// Range of the points.
    pub(super) first: usize,
    pub(super) end: usize,
    /// The second child of an inner node; the first follows its parent.
    second: Option<usize>,
}

/// A binary tree over gather points.
#[derive(Clone, Debug)]
pub(super) struct GatherTree<'b, 's> {
    /// In the order of the leaves.
    pub(super) points: Vec<WeightedPoint<'b, 's>>,
    /// In depth-first order.
    pub(super) nodes: Vec<GatherNode>,
}

impl<'b, 's> GatherTree<'b, 's> {
    /// The tree over the points with throughput.
    pub(super) fn new(points: &[(&'b ShadingPoint<'s>, Rgb)]) -> Self {
        let lit = |(_, (_, throughput)): &(usize, &(_, Rgb))| throughput.luminance() > 0.0;
        let points = points.iter().enumerate().filter(lit);
        let mut points: Vec<WeightedPoint> = points
            .map(|(i, &point)| WeightedPoint::new(i, point))
            .collect();
        let bounds = Aabb::from_points(points.iter().map(|point| point.at.x.p));
        let scale = NORMAL_SCALE * bounds.diagonal();
        for point in &mut points {
            let (p, n) = (point.at.x.p, point.receiving.unwrap_or(Vec3::ZERO) * scale);
            point.place = [p.x, p.y, p.z, n.x, n.y, n.z];
        }
        let mut nodes = Vec::with_capacity(2 * points.len());
        if !points.is_empty() {
            build(&mut points, 0, &mut nodes);
        }
        GatherTree { points, nodes }
    }

    /// Indices of the children of `node`; `None` for a leaf.
    pub(super) fn children(&self, node: usize) -> Option<[usize; 2]> {
        (self.nodes[node].second).map(|second| [node + 1, second])
    }

    /// Draws a point of `node` in proportion to the weights; with the probability.
    pub(super) fn draw(&self, node: usize, u: f32) -> (usize, f32) {
        let GatherNode {
            first, end, weight, ..
        } = self.nodes[node];
        let mut left = u * weight;
        for k in first..end - 1 {
            left -= self.points[k].weight;
            if left < 0.0 {
                return (k, self.points[k].weight / weight);
            }
        }
        (end - 1, self.points[end - 1].weight / weight)
    }

    /// Upper bound of `Σ T f cosθ` over the points of `node`, in 1/sr. The directions may differ
    /// between the points, and are within `spread` of `axis`.
    pub(super) fn reflectance_bound(&self, node: &GatherNode, axis: Vec3, spread: Spread) -> f32 {
        let mut sum = 0.0;
        if node.diffuse > 0.0 {
            let cos = axis.dot(node.normals.axis);
            let [_, most] = spread.plus(node.spread).cosines(cos);
            sum += node.diffuse * most.max(0.0);
        }
        if node.has_others {
            let others = self.points[node.first..node.end].iter();
            let others = others.filter(|point| point.lambert.is_none());
            sum += others.map(|point| point.bound(axis, spread)).sum::<f32>();
        }
        sum
    }
}

/// Builds the tree over `points`, the first of which has the index `first`, behind `nodes`.
fn build(points: &mut [WeightedPoint], first: usize, nodes: &mut Vec<GatherNode>) {
    let normals = points.iter().map(|point| point.receiving);
    let normals = normals.map(|n| n.map_or(Cone::FULL, Cone::from_axis));
    let normals = normals.fold(Cone::EMPTY, Cone::union);
    let diffuse = |point: &WeightedPoint| point.importance * point.lambert.unwrap_or(0.0);
    let node = nodes.len();
    nodes.push(GatherNode {
        bounds: Aabb::from_points(points.iter().map(|point| point.at.x.p)),
        normals,
        spread: Spread::new(normals.half_angle),
        diffuse: points.iter().map(diffuse).sum(),
        has_others: points.iter().any(|point| point.lambert.is_none()),
        weight: points.iter().map(|point| point.weight).sum(),
        first,
        end: first + points.len(),
        second: None,
    });
    if points.len() > 1 {
        let half = split(points);
        let (left, right) = points.split_at_mut(half);
        build(left, first, nodes);
        nodes[node].second = Some(nodes.len());
        build(right, first + half, nodes);
    }
}

/// Partitions the points at the middle of the longest axis, in position or normal; returns the size
/// of the first set.
fn split(points: &mut [WeightedPoint]) -> usize {
    let range = |axis: usize| {
        let at = points.iter().map(|point| point.place[axis]);
        at.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        })
    };
    let ranges: [(f32, f32); 6] = std::array::from_fn(range);
    let size = |axis: usize| ranges[axis].1 - ranges[axis].0;
    let axis = (0..6).max_by(|&a, &b| size(a).total_cmp(&size(b)));
    let axis = axis.unwrap_or(0);
    let middle = 0.5 * (ranges[axis].0 + ranges[axis].1);
    points.sort_unstable_by(|a, b| {
        (a.place[axis].total_cmp(&b.place[axis])).then(a.index.cmp(&b.index))
    });
    let below = points.partition_point(|point| point.place[axis] < middle);
    if (1..points.len()).contains(&below) {
        below
    } else {
        points.len() / 2
    }
}
