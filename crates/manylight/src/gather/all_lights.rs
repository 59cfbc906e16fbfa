//! The sum over all lights of a subset.

use super::batch_sums::{BatchSums, add_light, flush};
use super::points::Batch;
use super::{Gather, Gathered, LightIndex};
use crate::color::Rgb;
use crate::ids::LightId;
use crate::math::prefetch::prefetch;
use crate::scene::Scene;
use crate::simd::{Isa, Simd, SimdKernel};

/// Lights of which the memory is prefetched ahead of their sum. Without, the first read of a light
/// took 3 to 5 % of the time of connections (100k lights; staircase2, third-party kitchen), with it
/// less than 1 %.
const AHEAD: usize = 8;

/// Adds the lights that up to [`BATCHES`](super::points::BATCHES) batches have in common to the
/// sums of their points, in all and by light group.
pub(super) fn add(
    gather: &Gather,
    scene: &Scene,
    lights: &LightIndex,
    batches: &[Batch],
    (sums, by_group): (&mut [Gathered], &mut [Rgb]),
) {
    Isa::best().run(AddLights {
        gather,
        scene,
        lights,
        batches,
        sums,
        by_group,
    });
}

struct AddLights<'a> {
    gather: &'a Gather,
    scene: &'a Scene,
    lights: &'a LightIndex<'a>,
    batches: &'a [Batch<'a, 'a>],
    sums: &'a mut [Gathered],
    by_group: &'a mut [Rgb],
}

impl SimdKernel for AddLights<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) {
        let ids = self.lights.in_order(self.batches[0].lights);
        let groups = self.lights.groups;
        let mut sum = BatchSums::new(
            isa.wide(),
            self.gather,
            self.scene,
            self.lights,
            self.batches,
            groups.max(1),
        )
        .with_roulette();
        let of = |id: LightId| &self.lights.set.lights()[id.index()];
        for (k, &id) in ids.iter().enumerate() {
            if let Some(&next) = ids.get(k + AHEAD) {
                prefetch(of(next));
            }
            if groups > 0 {
                sum.slot = of(id).group.index();
            }
            add_light(&mut sum, id, self.sums);
        }
        flush(&mut sum, self.sums);
        sum.count_clamped(self.sums);
        for (b, batch) in self.batches.iter().enumerate() {
            for (i, &member) in batch.members.iter().enumerate() {
                let sum_there = &mut self.sums[member];
                for slot in &sum.gathered {
                    sum_there.radiance += slot[b].rgb(i);
                }
                let of_point = self.by_group.iter_mut().skip(member * groups);
                for (group, slot) in of_point.zip(&sum.gathered).take(groups) {
                    *group += slot[b].rgb(i);
                }
                sum_there.terms = ids.len() as u32;
                sum_there.connections = ids.len() as u64;
            }
        }
    }
}
