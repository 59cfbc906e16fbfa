//! The sum over all lights of a subset.

use super::batch_sums::BatchSums;
use super::points::Batch;
use super::{Gather, Gathered, LightIndex};
use crate::ids::LightId;
use crate::scene::Scene;
use crate::simd::{Isa, Simd, SimdKernel};

/// Adds the lights that up to [`BATCHES`](super::points::BATCHES) batches have in common to the
/// sums of their points.
pub(super) fn add(
    gather: &Gather,
    scene: &Scene,
    lights: &LightIndex,
    batches: &[Batch],
    sums: &mut [Gathered],
) {
    Isa::best().run(AddLights {
        gather,
        scene,
        lights,
        batches,
        sums,
    });
}

struct AddLights<'a> {
    gather: &'a Gather,
    scene: &'a Scene,
    lights: &'a LightIndex<'a>,
    batches: &'a [Batch<'a, 'a>],
    sums: &'a mut [Gathered],
}

impl SimdKernel for AddLights<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) {
        let subset = self.batches[0].lights;
        let lights = subset.indices(self.lights.set.lights().len());
        let connections = lights.len();
        let mut sum = BatchSums::new(
            isa.wide(),
            self.gather,
            self.scene,
            self.lights,
            self.batches,
            1,
        )
        .with_roulette();
        for id in lights.map(|k| LightId(k as u32)) {
            sum.add_light(id, self.sums);
        }
        sum.flush(self.sums);
        sum.count_clamped(self.sums);
        for (b, batch) in self.batches.iter().enumerate() {
            for (i, &member) in batch.members.iter().enumerate() {
                let sum_there = &mut self.sums[member];
                sum_there.radiance += sum.gathered[0][b].rgb(i);
                sum_there.terms = connections as u32;
                sum_there.connections = connections as u64;
            }
        }
    }
}
