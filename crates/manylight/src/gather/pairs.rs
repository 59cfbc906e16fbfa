//! Pairs of a cluster of gather points and a cluster of lights: upper bounds; and the values of
//! single connections.

use super::clamping::ClampReceiver;
use super::gather_tree::{GatherNode, GatherTree, WeightedPoint};
use super::light_points::{LightPoint, light_part, part_count};
use super::points::rounding_at;
use super::receivers::ConnectedLight;
use super::{Gather, Gathered, LightIndex};
use crate::color::Rgb;
use crate::geometry::Segment;
use crate::ids::LightId;

use crate::light_tree::{LightNode, LightTree, Receiver};
use crate::math::{Aabb, Cone, Spread, Vec3};
use crate::scene::Scene;
use crate::virtual_lights::{SingleEmission, VirtualLight};
use std::f32::consts::PI;

/// Luminance of the light that the lights of a cluster send through the points of a cluster to the
/// camera, in W/(m² sr).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PairBound {
    /// Upper bound; infinite where the boxes overlap.
    pub(super) bound: f32,
    /// Heuristic estimate for the order of refinement: with points and lights spread over their
    /// clusters.
    pub(super) likely: f32,
}

/// Light of one connection at a gather point, before its throughput.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ConnectionValue {
    /// `Σ f cosθ I w_c V / d²` over the parts of the light, in W/(m² sr).
    pub(super) radiance: Rgb,
    /// As in [`Gathered`].
    pub(super) clamped: f32,
    pub(super) unclamped: f32,
}

/// What the connections of a pixel have in common.
#[derive(Clone, Copy)]
pub(super) struct PairContext<'a, 'b, 's> {
    pub(super) gather: &'a Gather,
    pub(super) scene: &'a Scene,
    pub(super) lights: &'a LightIndex<'s>,
    pub(super) tree: &'a LightTree,
    pub(super) gather_tree: &'a GatherTree<'b, 's>,
}

/// The parts of a light that are connected with a point, where it is more than one part.
#[derive(Clone, Copy, Debug)]
pub(super) enum Parts {
    /// All of them.
    All,
    /// One, chosen by a random number in [0, 1), for all of them.
    One(f32),
}

impl<'a, 'b, 's> PairContext<'a, 'b, 's> {
    /// The connections of `gather_tree` with lights that have a tree.
    pub(super) fn new(
        gather: &'a Gather,
        scene: &'a Scene,
        lights: &'a LightIndex<'s>,
        gather_tree: &'a GatherTree<'b, 's>,
    ) -> Self {
        let tree = lights.tree.as_ref();
        PairContext {
            gather,
            scene,
            lights,
            tree: tree.expect("invariant: lights have a tree where cuts are asked for"),
            gather_tree,
        }
    }

    /// Bounds of the light from the lights of the node `light` through the points of the node
    /// `gather`.
    ///
    /// The product of the maxima of `Σ T f cosθ` and `Σ I` over the directions between the boxes,
    /// with `V = 1`, clamping weights of 1, and the distance between the boxes.
    pub(super) fn bound(&self, gather: usize, light: usize) -> PairBound {
        let (x, y) = (&self.gather_tree.nodes[gather], &self.tree.nodes()[light]);
        if !is_facing(&x.bounds, &x.normals, &y.bounds)
            || !is_facing(&y.bounds, &y.normals, &x.bounds)
        {
            return PairBound::default();
        }
        let (axis, spread) = directions(x, y);
        let radius = radius(x, y);
        let intensity = y.intensity_within(-axis, spread);
        if intensity == 0.0 {
            return PairBound::default();
        }
        let product = intensity * self.gather_tree.reflectance_bound(x, axis, spread);
        if product == 0.0 {
            return PairBound::default();
        }
        let nearest2 = distance_squared(&x.bounds, &y.bounds);
        PairBound {
            bound: product / nearest2,
            likely: product / (nearest2 + radius * radius),
        }
    }

    /// The gather node `gather` as a receiver for which lights are drawn.
    pub(super) fn receiver(&self, gather: usize) -> Receiver<impl Fn(&LightNode) -> f32> {
        let x = &self.gather_tree.nodes[gather];
        Receiver {
            p: x.bounds.center(),
            reflectance: move |light: &LightNode| {
                let (axis, spread) = directions(x, light);
                self.gather_tree.reflectance_bound(x, axis, spread)
            },
        }
    }

    /// The connection of a gather point with light `id`.
    pub(super) fn value(
        &self,
        point: &WeightedPoint,
        id: LightId,
        parts: Parts,
        cost: &mut Gathered,
    ) -> ConnectionValue {
        let set = &self.lights.set;
        let light = &set.lights()[id.index()];
        let connected = ConnectedLight {
            lights: set,
            id,
            light,
            emission: SingleEmission { lights: set, id },
            radius: 0.0,
            lobe: None,
        };
        let mut value = ConnectionValue::default();
        let mut add = |part: LightPoint| self.add_part(point, &connected, part, &mut value, cost);
        let count = part_count(self.gather, &ClampReceiver::from(point.at), light);
        let part = |k: usize| light_part(self.gather, light, point.at.lights, (k, count));
        match parts {
            Parts::All => (0..count).for_each(|k| add(part(k))),
            Parts::One(u) => add(LightPoint {
                weight: 1.0,
                ..part(((u * count as f32) as usize).min(count - 1))
            }),
        }
        value
    }

    /// Adds the connection with one part of a light.
    fn add_part(
        &self,
        point: &WeightedPoint,
        light: &ConnectedLight<SingleEmission>,
        part: LightPoint,
        value: &mut ConnectionValue,
        cost: &mut Gathered,
    ) {
        cost.connections += 1;
        let x = &point.at.x;
        let rounding = rounding_at(x.p) + rounding_at(part.p);
        let VirtualLight { n, offset, .. } = *light.light;
        let is_behind = light.light.one_sided && (x.p - part.p).dot(n) <= rounding;
        if is_behind || !point.receives(part.p, rounding) {
            return;
        }
        let connection = self.gather.connect(point, light, &part);
        if connection.lit.none() {
            return;
        }
        let unclamped = connection.unclamped.luminance().get();
        value.unclamped += unclamped;
        value.clamped += unclamped * (1.0 - connection.weight.get());
        cost.shadow_rays += 1;
        let w = Vec3::from(connection.wi);
        let transmittance = self.scene.transmittance(&Segment {
            from: x.offset_towards(w),
            to: part.p + n * offset.copysign(-w.dot(n)),
        });
        value.radiance += Rgb::from(connection.clamped()) * transmittance;
    }
}

/// A cone that contains the directions from the points of a gather node to the lights of a light
/// node.
fn directions(x: &GatherNode, y: &LightNode) -> (Vec3, Spread) {
    let to = y.bounds.center() - x.bounds.center();
    let axis = to.try_normalize().unwrap_or(Vec3::Z);
    (axis, Spread::to_ball(radius(x, y), to.length()))
}

/// Sum of the radii of the balls around both boxes, in m.
fn radius(x: &GatherNode, y: &LightNode) -> f32 {
    0.5 * (x.bounds.diagonal() + y.bounds.diagonal())
}

/// Whether some position in `to` is above the horizon of some position in `from` with a normal in
/// `normals`.
fn is_facing(from: &Aabb, normals: &Cone, to: &Aabb) -> bool {
    if normals.half_angle >= PI {
        return true;
    }
    let center = to.center() - from.center();
    let half = 0.5 * (to.extent() + from.extent());
    let n = normals.axis;
    // The chord to the farthest normal, times the distance, is how much nearer to a horizon a
    // position may be.
    let chord = 2.0 * (0.5 * normals.half_angle).sin();
    let highest = n.dot(center) + n.abs().dot(half) + chord * (center.length() + half.length());
    // Half the rounding that connections allow: they are dark wherever this leaves them out.
    highest > 0.5 * (rounding_at(from.center()) + rounding_at(to.center()))
}

/// Squared distance between two boxes, in m²; 0 where they overlap.
fn distance_squared(a: &Aabb, b: &Aabb) -> f32 {
    let apart = (a.min - b.max).max(b.min - a.max).max(Vec3::ZERO);
    apart.length_squared()
}
