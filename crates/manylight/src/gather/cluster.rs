//! Lights in groups that lie near each other, as arrays: the unit that a point is compared with before anything dear is done.

use crate::math::Vec3;
use crate::virtual_lights::{LightField, VirtualLight};

/// Lights in a cluster; also the bits of a mask.
pub(super) const CLUSTER_SIZE: usize = 64;

/// Up to 64 consecutive lights of a field: positions, normals, and how far their parts reach.
#[derive(Clone, Debug)]
pub(super) struct Cluster {
    /// Index of the first light.
    pub first: usize,
    p: [[f32; CLUSTER_SIZE]; 3],
    n: [[f32; CLUSTER_SIZE]; 3],
    reach: [f32; CLUSTER_SIZE],
    /// Lights that shine to one side only.
    one_sided: u64,
    used: u64,
}

impl Cluster {
    /// The lights of `field`, cut into clusters along its space-filling curve.
    pub(super) fn all(field: &LightField) -> Vec<Cluster> {
        let clusters = field.lights().chunks(CLUSTER_SIZE).enumerate();
        clusters
            .map(|(c, lights)| Cluster::new(c * CLUSTER_SIZE, lights))
            .collect()
    }

    fn new(first: usize, lights: &[VirtualLight]) -> Self {
        let zeros = [0.0; CLUSTER_SIZE];
        let mut cluster = Cluster {
            first,
            p: [zeros; 3],
            n: [zeros; 3],
            reach: zeros,
            one_sided: 0,
            used: 0,
        };
        for (i, light) in lights.iter().enumerate() {
            for axis in 0..3 {
                cluster.p[axis][i] = light.p[axis];
                cluster.n[axis][i] = light.n[axis];
            }
            let farthest = light
                .points
                .iter()
                .map(|q| q.distance(light.p))
                .fold(0.0, f32::max);
            // Rounding of the comparison itself must not cut off what the exact test would keep.
            cluster.reach[i] = farthest + 1e-5 * light.p.abs().max_element();
            cluster.used |= 1 << i;
            if light.shines_one_sided() {
                cluster.one_sided |= 1 << i;
            }
        }
        cluster
    }

    /// The lights that there are.
    pub(super) fn used(&self) -> u64 {
        self.used
    }

    /// The lights that may reach `x`: no part of any other lies on the lit side of the receiver (`n`, or `None` for one that
    /// sees both sides) with `x` on its own lit side. Exact: what is left out contributes nothing.
    #[inline]
    pub(super) fn facing(&self, x: Vec3, n: Option<Vec3>) -> u64 {
        let receiver = n.unwrap_or(Vec3::ZERO);
        let mut above = [0.0f32; CLUSTER_SIZE];
        let mut before = [0.0f32; CLUSTER_SIZE];
        for i in 0..CLUSTER_SIZE {
            let (dx, dy, dz) = (self.p[0][i] - x.x, self.p[1][i] - x.y, self.p[2][i] - x.z);
            above[i] = receiver.x * dx + receiver.y * dy + receiver.z * dz + self.reach[i];
            before[i] = self.reach[i] - (self.n[0][i] * dx + self.n[1][i] * dy + self.n[2][i] * dz);
        }
        let positive = |values: &[f32; CLUSTER_SIZE]| {
            values
                .iter()
                .enumerate()
                .fold(0u64, |mask, (i, &v)| mask | u64::from(v > 0.0) << i)
        };
        let above = if n.is_some() {
            positive(&above)
        } else {
            u64::MAX
        };
        self.used & above & (positive(&before) | !self.one_sided)
    }
}
