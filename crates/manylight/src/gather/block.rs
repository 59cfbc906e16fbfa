//! Connections of up to 64 points with up to 64 targets that wait for their visibility test.

use super::Gathered;
use super::points::{BATCHES, Batch};
use crate::color::Rgb;
use crate::geometry::Segment;
use crate::lanes::{LANES, LaneMask, Lanes3, lanes_of};
use crate::math::Vec3;
use crate::scene::Scene;

/// Targets that are tested together; also the bits of a mask.
const TARGETS: usize = 64;

/// Shadow rays to common targets, with what they carry. All leave their surfaces on the same side.
#[derive(Debug)]
pub(super) struct Block {
    /// Index into [`Batch::origins`].
    side: usize,
    targets: Vec<Vec3>,
    /// For each target and batch what arrives if it is visible.
    values: Vec<[Lanes3; BATCHES]>,
    /// For each point the targets that it is to be connected with.
    wanted: [u64; BATCHES * LANES],
}

impl Block {
    pub(super) fn new(side: usize) -> Self {
        Block {
            side,
            targets: Vec::with_capacity(TARGETS),
            values: Vec::with_capacity(TARGETS),
            wanted: [0; BATCHES * LANES],
        }
    }

    /// Whether another target would be too many.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.targets.len() == TARGETS
    }

    /// Adds a target.
    #[inline(always)]
    pub(super) fn open(&mut self, target: Vec3) {
        self.targets.push(target);
        self.values.push([Lanes3::ZERO; BATCHES]);
    }

    /// What the last target sends to the lanes of batch `b`.
    #[inline(always)]
    pub(super) fn put(&mut self, b: usize, lanes: LaneMask, values: &Lanes3) {
        let t = self.targets.len() - 1;
        self.values[t][b] = *values;
        for i in lanes_of(lanes) {
            self.wanted[b * LANES + i] |= 1 << t;
        }
    }

    /// Tests what waits and adds what arrives.
    pub(super) fn flush(&mut self, scene: &Scene, batches: &[Batch], sums: &mut [Gathered]) {
        if self.targets.is_empty() {
            return;
        }
        let mut origins = [batches[0].origins[self.side][0]; BATCHES * LANES];
        for (b, batch) in batches.iter().enumerate() {
            origins[b * LANES..][..LANES].copy_from_slice(&batch.origins[self.side]);
        }
        let occluded = scene
            .geometry
            .occluded_block(&origins, &self.targets, &self.wanted);
        for (b, batch) in batches.iter().enumerate() {
            for (i, &member) in batch.members.iter().enumerate() {
                let k = b * LANES + i;
                let arrives = self.wanted[k] & !occluded[k];
                sums[member].radiance += self.arriving(scene, arrives, origins[k], (b, i));
                sums[member].shadow_rays += u64::from(self.wanted[k].count_ones());
            }
        }
        self.targets.clear();
        self.values.clear();
        self.wanted.fill(0);
    }

    /// Sum over the targets in `arrives` of what lane `i` of batch `b` gets from them.
    fn arriving(
        &self,
        scene: &Scene,
        mut arrives: u64,
        origin: Vec3,
        (b, i): (usize, usize),
    ) -> Rgb {
        let transparent = scene.geometry.has_transparent();
        let mut sum = Rgb::BLACK;
        while arrives != 0 {
            let t = arrives.trailing_zeros() as usize;
            arrives &= arrives - 1;
            let mut value = self.values[t][b].rgb(i);
            if transparent {
                let segment = Segment {
                    from: origin,
                    to: self.targets[t],
                };
                value *= scene.cross_transparent(&segment).0;
            }
            sum += value;
        }
        sum
    }
}
