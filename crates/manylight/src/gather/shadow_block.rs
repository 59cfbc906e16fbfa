//! Connections of up to 64 points with up to 64 targets that wait for their shadow rays.

use super::Gathered;
use super::points::{BATCHES, Batch};
use crate::geometry::Segment;
use crate::lanes::{Color, LANES, LaneMask, Lanes3, Mask, Sixteen};
use crate::math::Vec3;
use crate::math::bits::transpose;
use crate::scene::Scene;
use crate::simd::set_bits;

/// Targets of a block: the bits of a mask.
const TARGETS: usize = 64;

/// Waiting shadow rays to common targets, with the light that they test. All start on the same side
/// of their surfaces.
#[derive(Debug)]
pub(super) struct ShadowBlock {
    /// Index into [`Batch::origins`].
    side: usize,
    targets: Vec<Vec3>,
    /// The slot of the sum to which each target belongs.
    slots: Vec<usize>,
    /// Light that arrives from each visible target, by batch, in the lanes that are connected with
    /// it. Kept at its largest size.
    values: Vec<[Lanes3; BATCHES]>,
    /// The points that each target is connected with.
    connected: [u64; TARGETS],
}

impl ShadowBlock {
    pub(super) fn new(side: usize) -> Self {
        ShadowBlock {
            side,
            targets: Vec::with_capacity(TARGETS),
            slots: Vec::with_capacity(TARGETS),
            values: Vec::new(),
            connected: [0; TARGETS],
        }
    }

    /// Whether there is no room for another target.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.targets.len() == TARGETS
    }

    /// Adds a target of the sum `slot`.
    #[inline(always)]
    pub(super) fn open(&mut self, target: Vec3, slot: usize) {
        self.targets.push(target);
        self.slots.push(slot);
        if self.values.len() < self.targets.len() {
            self.values.push([Lanes3::ZERO; BATCHES]);
        }
    }

    /// Sets the light of the last target in the lanes of batch `b`.
    #[inline(always)]
    pub(super) fn put(&mut self, b: usize, lanes: LaneMask, values: &Lanes3) {
        let t = self.targets.len() - 1;
        self.values[t][b] = *values;
        self.connected[t] |= u64::from(lanes) << (b * LANES);
    }

    /// Traces the shadow rays and adds the light that arrives to `gathered`, the sums by slot and
    /// batch.
    #[inline(always)]
    pub(super) fn flush<S: Sixteen>(
        &mut self,
        s: S,
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
            let mut sum = gathered[slot][b].colors(s);
            let targets = self.values.iter().zip(&self.slots);
            for ((values, &own), arriving) in targets.zip(&arriving) {
                if own != slot {
                    gathered[slot][b] = Lanes3::of_colors(sum);
                    slot = own;
                    sum = gathered[slot][b].colors(s);
                }
                let lanes = (arriving >> (b * LANES)) as LaneMask;
                if lanes != 0 {
                    let lanes = Mask::of_lanes(s, lanes);
                    sum = Color::select(lanes, sum + values[b].colors(s), sum);
                }
            }
            gathered[slot][b] = Lanes3::of_colors(sum);
        }
        self.targets.clear();
        self.slots.clear();
        self.connected.fill(0);
    }

    /// The points from which each target is visible. Light through transparent surfaces and media
    /// is attenuated in `values`.
    fn trace(&mut self, scene: &Scene, batches: &[Batch], sums: &mut [Gathered]) -> [u64; TARGETS] {
        let geometry = &scene.geometry;
        let mut origins = [batches[0].origins[self.side][0]; BATCHES * LANES];
        for (b, batch) in batches.iter().enumerate() {
            origins[b * LANES..][..LANES].copy_from_slice(&batch.origins[self.side]);
        }
        let mut connected = self.connected;
        transpose(&mut connected);
        for (batch, connected) in batches.iter().zip(connected.chunks(LANES)) {
            for (&member, connected) in batch.members.iter().zip(connected) {
                sums[member].shadow_rays += u64::from(connected.count_ones());
            }
        }
        let occluded = geometry.occluded_block(&origins, &self.targets, &connected);
        let mut arriving: [u64; TARGETS] = std::array::from_fn(|k| connected[k] & !occluded[k]);
        if geometry.has_transparent() || !scene.media.is_empty() {
            let attenuated = self.attenuated(scene, &origins, &arriving);
            for (k, &attenuated) in attenuated.iter().enumerate() {
                for t in set_bits(attenuated) {
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

    /// Of the `arriving` segments, by origin, those that cross transparent surfaces or may lie in a
    /// medium.
    fn attenuated(
        &self,
        scene: &Scene,
        origins: &[Vec3; BATCHES * LANES],
        arriving: &[u64; TARGETS],
    ) -> [u64; TARGETS] {
        let geometry = &scene.geometry;
        let mut attenuated = match geometry.has_transparent() {
            true => geometry.crossing_block(origins, &self.targets, arriving),
            false => [0; TARGETS],
        };
        if !scene.media.is_empty() {
            for (k, attenuated) in attenuated.iter_mut().enumerate() {
                for t in set_bits(arriving[k] & !*attenuated) {
                    let (from, to) = (origins[k], self.targets[t]);
                    if scene.media.may_contain(&Segment { from, to }) {
                        *attenuated |= 1 << t;
                    }
                }
            }
        }
        attenuated
    }
}
