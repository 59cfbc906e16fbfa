//! Connections of up to 64 points with up to 64 targets that wait for their visibility test.

use super::Gathered;
use super::points::{BATCHES, Batch};
use crate::geometry::Segment;
use crate::lanes::{LANES, LaneMask, Lanes3};
use crate::math::Vec3;
use crate::math::bits::transpose;
use crate::scene::Scene;
use crate::simd::{Wide, set_bits};

/// Targets that are tested together; also the bits of a mask.
const TARGETS: usize = 64;

/// Shadow rays to common targets, with what they carry. All leave their surfaces on the same side.
#[derive(Debug)]
pub(super) struct Block {
    /// Index into [`Batch::origins`].
    side: usize,
    targets: Vec<Vec3>,
    /// To which sum each target belongs.
    slots: Vec<usize>,
    /// For each target and batch what arrives if it is visible, in the lanes that are wanted. Room for the most targets so far.
    values: Vec<[Lanes3; BATCHES]>,
    /// For each target the points that it is to be connected with.
    wanted: [u64; TARGETS],
}

impl Block {
    pub(super) fn new(side: usize) -> Self {
        Block {
            side,
            targets: Vec::with_capacity(TARGETS),
            slots: Vec::with_capacity(TARGETS),
            values: Vec::new(),
            wanted: [0; TARGETS],
        }
    }

    /// Whether another target would be too many.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.targets.len() == TARGETS
    }

    /// Adds a target, what comes from which belongs to the sum `slot`.
    #[inline(always)]
    pub(super) fn open(&mut self, target: Vec3, slot: usize) {
        self.targets.push(target);
        self.slots.push(slot);
        if self.values.len() < self.targets.len() {
            self.values.push([Lanes3::ZERO; BATCHES]);
        }
    }

    /// What the last target sends to the lanes of batch `b`.
    #[inline(always)]
    pub(super) fn put(&mut self, b: usize, lanes: LaneMask, values: &Lanes3) {
        let t = self.targets.len() - 1;
        self.values[t][b] = *values;
        self.wanted[t] |= u64::from(lanes) << (b * LANES);
    }

    /// Tests what waits and adds what arrives to `gathered`, the sums by slot and batch.
    #[inline(always)]
    pub(super) fn flush<W: Wide>(
        &mut self,
        w: W,
        scene: &Scene,
        batches: &[Batch],
        sums: &mut [Gathered],
        gathered: &mut [[Lanes3; BATCHES]],
    ) {
        if self.targets.is_empty() {
            return;
        }
        let arriving = self.trace(scene, batches, sums);
        for b in 0..batches.len() {
            let mut slot = self.slots[0];
            let mut sum = gathered[slot][b].load(w);
            let targets = self.values.iter().zip(&self.slots);
            for ((values, &own), arriving) in targets.zip(&arriving) {
                if own != slot {
                    gathered[slot][b] = Lanes3::store(w, sum);
                    slot = own;
                    sum = gathered[slot][b].load(w);
                }
                let lanes = (arriving >> (b * LANES)) as LaneMask;
                if lanes != 0 {
                    let lanes = w.lanes(u32::from(lanes));
                    for (sum, value) in sum.iter_mut().zip(values[b].load(w)) {
                        *sum = w.select(lanes, w.add(*sum, value), *sum);
                    }
                }
            }
            gathered[slot][b] = Lanes3::store(w, sum);
        }
        self.targets.clear();
        self.slots.clear();
        self.wanted.fill(0);
    }

    /// For each target the points that it is visible from. What passes through transparent surfaces is reduced in `values`.
    fn trace(&mut self, scene: &Scene, batches: &[Batch], sums: &mut [Gathered]) -> [u64; TARGETS] {
        let geometry = &scene.geometry;
        let mut origins = [batches[0].origins[self.side][0]; BATCHES * LANES];
        for (b, batch) in batches.iter().enumerate() {
            origins[b * LANES..][..LANES].copy_from_slice(&batch.origins[self.side]);
        }
        let mut wanted = self.wanted;
        transpose(&mut wanted);
        for (batch, wanted) in batches.iter().zip(wanted.chunks(LANES)) {
            for (&member, wanted) in batch.members.iter().zip(wanted) {
                sums[member].shadow_rays += u64::from(wanted.count_ones());
            }
        }
        let occluded = geometry.occluded_block(&origins, &self.targets, &wanted);
        let mut arriving: [u64; TARGETS] = std::array::from_fn(|k| wanted[k] & !occluded[k]);
        if geometry.has_transparent() {
            let crossing = geometry.crossing_block(&origins, &self.targets, &arriving);
            for (k, &crossing) in crossing.iter().enumerate() {
                for t in set_bits(crossing) {
                    let (from, to) = (origins[k], self.targets[t]);
                    let through = scene.cross_transparent(&Segment { from, to }).0;
                    let values = &mut self.values[t][k / LANES];
                    values.set(k % LANES, values.rgb(k % LANES) * through);
                }
            }
        }
        transpose(&mut arriving);
        arriving
    }
}
