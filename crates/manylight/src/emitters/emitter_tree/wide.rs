//! A node of the wide tree, and the importance of its children for a receiver.

use super::binary::ClusterNode;
use crate::lanes::{LANES, Lanes, Lanes3};
use crate::math::{Vec3, float::safe_sqrt};
use crate::simd::{Simd, SimdKernel};

/// Lower bound of the cosines at emitter and receiver in the importance. Bounds on cosines are poor near the horizon, where an
/// underestimate gives samples of large weight. Not measured.
const COSINE_FLOOR: f32 = 0.05;

/// Tolerance for rounding of cosines: a cluster must not be excluded if it emits towards the receiver.
const COSINE_TOLERANCE: f32 = 1e-3;

/// Lower bound of the squared radius of a cluster, for receivers inside: it keeps the importance finite.
const MIN_RADIUS2: f32 = 1e-20;

/// A child, as a lane of a wide node.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChildLane {
    /// Index of the wide node.
    pub(super) node: u32,
    pub(super) lane: u32,
}

/// The children of a node of the wide tree, one per lane. Unused lanes have no power.
#[derive(Clone, Debug)]
pub(super) struct WideEmitterNode {
    center: Lanes3,
    radius: Lanes,
    axis: Lanes3,
    cos_normals: Lanes,
    sin_normals: Lanes,
    cos_emission: Lanes,
    power: Lanes,
    /// Index of the child's wide node, or of the element of a leaf.
    pub(super) content: [u32; LANES],
    pub(super) is_leaf: [bool; LANES],
    /// Number of children.
    pub(super) count: usize,
    /// This node as a child; `None` for the root.
    pub(super) parent: Option<ChildLane>,
}

/// The importance of each child of a node for a receiver at `p` with normal `n`.
pub(super) struct ImportanceKernel<'a> {
    pub(super) node: &'a WideEmitterNode,
    pub(super) p: Vec3,
    pub(super) n: Option<Vec3>,
}

impl SimdKernel for ImportanceKernel<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Lanes {
        let ImportanceKernel { node, p, n } = self;
        // Without a normal the cosine at the receiver is 1.
        let (n, min_cosine) = n.map_or((Vec3::ZERO, 1.0), |n| (n, COSINE_FLOOR));
        let mut importances = [0.0; LANES];
        for (i, importance) in importances.iter_mut().enumerate() {
            *importance = node.importance(i, p, n, min_cosine);
        }
        importances
    }
}

impl WideEmitterNode {
    /// The node with the children `children` of the binary tree.
    pub(super) fn new(
        nodes: &[ClusterNode],
        children: &[usize],
        parent: Option<ChildLane>,
    ) -> Self {
        let mut wide = WideEmitterNode {
            center: Lanes3::ZERO,
            radius: [0.0; LANES],
            axis: Lanes3::ZERO,
            cos_normals: [1.0; LANES],
            sin_normals: [0.0; LANES],
            cos_emission: [1.0; LANES],
            power: [0.0; LANES],
            content: [0; LANES],
            is_leaf: [true; LANES],
            count: children.len(),
            parent,
        };
        for (lane, &child) in children.iter().enumerate() {
            let node = &nodes[child];
            wide.center.set(lane, node.center);
            wide.radius[lane] = node.radius;
            wide.axis.set(lane, node.axis);
            wide.cos_normals[lane] = node.cos_normals;
            wide.sin_normals[lane] = node.sin_normals;
            wide.cos_emission[lane] = node.cos_emission;
            wide.power[lane] = node.power;
            wide.content[lane] = node.content;
            wide.is_leaf[lane] = node.is_leaf;
        }
        wide
    }

    /// Importance of child `i`: power · cosine at the emitter · cosine at the receiver / distance². Each cosine is the largest
    /// within the bounds, and at least [`COSINE_FLOOR`] and `min_cosine`. 0 only if no element of the child emits towards `p`.
    #[inline(always)]
    fn importance(&self, i: usize, p: Vec3, n: Vec3, min_cosine: f32) -> f32 {
        let to_center = self.center.vec(i) - p;
        let d2 = to_center.length_squared();
        let r2 = self.radius[i] * self.radius[i];
        let inverse = 1.0 / d2.max(f32::MIN_POSITIVE).sqrt();
        let w = to_center * inverse;
        let sin_extent = (self.radius[i] * inverse).min(1.0);
        let cos_extent = safe_sqrt(1.0 - sin_extent * sin_extent);

        let at_emitter = -self.axis.vec(i).dot(w);
        let (cos, sin) = less_angle(
            at_emitter,
            safe_sqrt(1.0 - at_emitter * at_emitter),
            self.cos_normals[i],
            self.sin_normals[i],
        );
        let (cos, _) = less_angle(cos, sin, cos_extent, sin_extent);
        let at_receiver = n.dot(w);
        let sin = safe_sqrt(1.0 - at_receiver * at_receiver);
        let (cos_receiver, _) = less_angle(at_receiver, sin, cos_extent, sin_extent);
        let outside = self.power[i]
            * cos.max(COSINE_FLOOR)
            * cos_receiver.max(min_cosine)
            * (inverse * inverse);
        let reached = if cos < self.cos_emission[i] - COSINE_TOLERANCE {
            0.0
        } else {
            outside
        };
        // Inside of the bounding sphere all angles are possible.
        if d2 <= r2 {
            self.power[i] / r2.max(MIN_RADIUS2)
        } else {
            reached
        }
    }
}

/// Cosine and sine of max(0, a - b) from cosines and sines of the angles a and b, both in [0, π].
#[inline(always)]
fn less_angle(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> (f32, f32) {
    let is_less = cos_a < cos_b;
    let (cos, sin) = (cos_a * cos_b + sin_a * sin_b, sin_a * cos_b - cos_a * sin_b);
    (
        if is_less { cos } else { 1.0 },
        if is_less { sin } else { 0.0 },
    )
}
