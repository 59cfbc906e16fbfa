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
        let arriving: [u64; BATCHES * LANES] =
            std::array::from_fn(|k| self.wanted[k] & !occluded[k]);
        let mut crossing = [0; BATCHES * LANES];
        if scene.geometry.has_transparent() {
            crossing = scene
                .geometry
                .crossing_block(&origins, &self.targets, &arriving);
        }
        for (b, batch) in batches.iter().enumerate() {
            for (i, &member) in batch.members.iter().enumerate() {
                let k = b * LANES + i;
                let mut sum = self.arriving(arriving[k] & !crossing[k], (b, i));
                for t in bits_of(crossing[k]) {
                    let segment = Segment {
                        from: origins[k],
                        to: self.targets[t],
                    };
                    let through = scene.cross_transparent(&segment).0;
                    sum += self.values[t][b].rgb(i) * through;
                }
                sums[member].radiance += sum;
                sums[member].shadow_rays += u64::from(self.wanted[k].count_ones());
            }
        }
        self.targets.clear();
        self.values.clear();
        self.wanted.fill(0);
    }

    /// Sum over the targets in `arrives` of what lane `i` of batch `b` gets from them.
    fn arriving(&self, arrives: u64, (b, i): (usize, usize)) -> Rgb {
        bits_of(arrives).map(|t| self.values[t][b].rgb(i)).sum()
    }
}

/// The positions of the set bits, lowest first.
fn bits_of(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (bit < 64).then_some(bit as usize)
    })
}
