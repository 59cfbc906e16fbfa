//! Connections of up to 64 points, sixteen at a time, with one light after the other: the innermost loop of all methods.

use super::block::ShadowBlock;
use super::clamping::ClampedConnections;
use super::light_points::{FacingPoints, LightPoint, PointCounts, point_of_disc};
use super::points::{BATCHES, Batch};
use super::roulette::Roulette;
use super::sphere::{
    DirectionCone, LightLobe, SphereConnection, SphereSamples, only, sphere_radius,
};
use super::{Gather, Gathered, Kernel, LightIndex};
use crate::ids::LightId;
use crate::lanes::vectors::{dot, luminance, mul3, scale3, splat3};
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3};
use crate::scene::Scene;
use crate::simd::{self, Isa, Simd, Sixteen};
use crate::virtual_lights::moments::POINTS;
use crate::virtual_lights::{EmissionView, VirtualLight};

/// See [`Gather::add_lights`]. The loops over lanes in it become vectors of the chosen instructions.
struct AddLights<'a> {
    gather: &'a Gather,
    scene: &'a Scene,
    lights: &'a LightIndex<'a>,
    batches: &'a [Batch<'a, 'a>],
    sums: &'a mut [Gathered],
}

impl simd::SimdKernel for AddLights<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let w = s.wide();
        let subset = self.batches[0].lights;
        let lights = subset.indices(self.lights.set.lights().len());
        let connections = lights.len();
        let mut sum = BatchSums {
            roulette: Roulette::of(self.gather, self.batches),
            ..BatchSums::new(w, self.gather, self.scene, self.lights, self.batches, 1)
        };
        for id in lights.map(|k| LightId(k as u32)) {
            sum.add_light(w, id, self.sums);
        }
        sum.flush(w, self.sums);
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

impl Gather {
    /// Adds the lights that up to [`BATCHES`] batches have in common to the sums of their points.
    pub(super) fn add_lights(
        &self,
        scene: &Scene,
        lights: &LightIndex,
        batches: &[Batch],
        sums: &mut [Gathered],
    ) {
        Isa::best().run(AddLights {
            gather: self,
            scene,
            lights,
            batches,
            sums,
        });
    }
}

/// A light that is connected with the points.
struct ConnectedLight<'f, 's> {
    id: LightId,
    light: &'f VirtualLight<'s>,
    emission: EmissionView<'f, 's>,
    /// Radius as a sphere, in m.
    radius: f32,
    /// The glossy lobe of a light of one photon, for sampling directions to a sphere.
    lobe: Option<LightLobe>,
}

/// The points of a batch to which a part of a light contributes.
#[derive(Clone, Copy, Default)]
struct LitPoints {
    lit: LaneMask,
    /// Points at which the shadow ray starts on the side of the geometric normal.
    front_of_point: LaneMask,
    /// Points before the light, on the side of its normal.
    front_of_light: LaneMask,
}

impl LitPoints {
    /// The lit points with a shadow ray that starts and ends on these sides.
    #[inline(always)]
    fn on_sides(&self, front_of_point: bool, front_of_light: bool) -> LaneMask {
        let side = |mask: LaneMask, wanted: bool| if wanted { mask } else { !mask };
        self.lit
            & side(self.front_of_point, front_of_point)
            & side(self.front_of_light, front_of_light)
    }
}

/// Unfinished sums of the points of some batches.
pub(super) struct BatchSums<'a, 'b, 's> {
    gather: &'a Gather,
    scene: &'a Scene,
    lights: &'a LightIndex<'s>,
    batches: &'a [Batch<'b, 's>],
    /// Visible light so far, by slot: the terms of a cut have one each.
    pub(super) gathered: Vec<[Lanes3; BATCHES]>,
    /// Slot of the light that is being added.
    pub(super) slot: usize,
    /// Light of the part that is being added, by batch; arbitrary in lanes without a connection.
    values: [Lanes3; BATCHES],
    /// Waiting shadow rays that start on the side of the geometric normal, and on the other.
    blocks: [ShadowBlock; 2],
    /// For spheres.
    samples: [Option<SphereSamples>; BATCHES],
    clamped: [Lanes; BATCHES],
    unclamped: [Lanes; BATCHES],
    /// Before shadow rays.
    roulette: Option<Roulette>,
}

impl<'a, 'b, 's> BatchSums<'a, 'b, 's> {
    /// Empty sums with `slots` slots, without roulette.
    #[inline(always)]
    pub(super) fn new<W: Sixteen>(
        w: W,
        gather: &'a Gather,
        scene: &'a Scene,
        lights: &'a LightIndex<'s>,
        batches: &'a [Batch<'b, 's>],
        slots: usize,
    ) -> Self {
        BatchSums {
            gather,
            scene,
            lights,
            batches,
            gathered: vec![[Lanes3::ZERO; BATCHES]; slots],
            slot: 0,
            values: [Lanes3::ZERO; BATCHES],
            blocks: [ShadowBlock::new(0), ShadowBlock::new(1)],
            samples: std::array::from_fn(|b| {
                let batch = batches.get(b)?;
                (gather.kernel == Kernel::Sphere).then(|| SphereSamples::of(w, batch))
            }),
            clamped: [[0.0; LANES]; BATCHES],
            unclamped: [[0.0; LANES]; BATCHES],
            roulette: None,
        }
    }

    /// Adds the light `id` to the slot; its shadow rays may wait in a block.
    #[inline(always)]
    pub(super) fn add_light<W: Sixteen>(&mut self, w: W, id: LightId, sums: &mut [Gathered]) {
        let light = &self.lights.set.lights()[id.index()];
        let cylinder = &self.lights.cylinders[id.index()];
        let is_sphere = self.gather.kernel == Kernel::Sphere;
        let radius = sphere_radius(light, self.gather.area_factor(self.batches[0].lights));
        let mut counts = [PointCounts::default(); BATCHES];
        for (counts, batch) in counts.iter_mut().zip(self.batches) {
            let to = batch.towards(w, light.p);
            let facing = batch.facing(w, to, light, cylinder);
            if facing != 0 {
                let u = &batch.u;
                let points = FacingPoints { to, u, facing };
                *counts = self.gather.point_counts(w, light, radius, points);
            }
        }
        if counts.iter().all(PointCounts::are_empty) {
            return;
        }
        let connected = ConnectedLight {
            id,
            light,
            emission: self.lights.set.emission_view(id),
            radius,
            lobe: if is_sphere {
                // The random numbers of the points differ from pass to pass.
                LightLobe::of(&self.lights.set, id, self.batches[0].u[0].to_bits())
            } else {
                None
            },
        };
        let by_count = [
            (1, by_batch(&counts, |v| v.one)),
            (4, by_batch(&counts, |v| v.four)),
            (POINTS, by_batch(&counts, |v| v.sixteen)),
        ];
        for (count, active) in by_count {
            if active == [0; BATCHES] {
                continue;
            }
            if is_sphere {
                let whole = LightPoint {
                    directions: Some(count),
                    ..self.gather.whole_light(light)
                };
                self.add_part(w, &connected, whole, active, sums);
                continue;
            }
            for k in 0..count {
                let part = match count {
                    1 => self.gather.whole_light(light),
                    _ => point_of_disc(light, k * (POINTS / count), 1.0 / count as f32),
                };
                self.add_part(w, &connected, part, active, sums);
            }
        }
    }

    /// Connects the active points with one part of a light.
    #[inline(always)]
    fn add_part<W: Sixteen>(
        &mut self,
        w: W,
        light: &ConnectedLight,
        part: LightPoint,
        active: [LaneMask; BATCHES],
        sums: &mut [Gathered],
    ) {
        let mut connected = [LitPoints::default(); BATCHES];
        for (b, connected) in connected.iter_mut().enumerate().take(self.batches.len()) {
            if active[b] != 0 {
                *connected = self.connect(w, light, part, b, active[b]);
            }
        }
        let lit = by_batch(&connected, |points| points.lit);
        if let Some(roulette) = &mut self.roulette
            && !roulette.survives(w, part.weight, lit, &mut self.values)
        {
            return;
        }
        for (side, towards) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
            let lanes = by_batch(&connected, |c| c.on_sides(side == 0, towards > 0.0));
            if lanes == [0; BATCHES] {
                continue;
            }
            let block = &mut self.blocks[side];
            if block.is_full() {
                block.flush(w, self.scene, self.batches, sums, &mut self.gathered);
            }
            let VirtualLight { n, offset, .. } = light.light;
            block.open(part.p + *n * (offset * towards), self.slot);
            for (b, &lanes) in lanes.iter().enumerate().filter(|(_, lanes)| **lanes != 0) {
                block.put(b, lanes, &self.values[b]);
            }
        }
    }

    /// Sets the values of batch `b`: the clamped light of one part at the active points.
    #[inline(always)]
    fn connect<W: Sixteen>(
        &mut self,
        w: W,
        light: &ConnectedLight,
        part: LightPoint,
        b: usize,
        active: LaneMask,
    ) -> LitPoints {
        let zero = w.splat(0.0);
        let batch = &self.batches[b];
        let to = batch.towards(w, part.p);
        let d2 = dot(w, to, to);
        let inv_d = w.div(w.splat(1.0), w.sqrt(d2));
        let inv_d2 = w.mul(inv_d, inv_d);
        let wi = scale3(w, to, inv_d);
        let cos_light = dot(w, wi, splat3(w, light.light.n));
        let cos_point = dot(w, wi, batch.ng.load(w));
        let active = active & batch.lit(w, wi) & w.bits(w.lt(zero, d2)) as LaneMask;
        let (value, weight) = match part.directions {
            None => {
                let at = PointGeometry { wi, inv_d2, active };
                self.point_value(w, light, part, batch, at)
            }
            Some(count) => {
                let value = match &self.samples[b] {
                    Some(samples) => {
                        let sphere = SphereConnection {
                            batch,
                            emission: &light.emission,
                            light_lobe: light.lobe.as_ref(),
                            cone: DirectionCone::of(w, wi, inv_d2, light.radius),
                            active,
                        };
                        samples.integrate(w, &sphere, count)
                    }
                    None => [zero; 3],
                };
                (value, w.splat(1.0))
            }
        };
        let flux_factor = self.flux_factor(light.id, batch);
        let factor = w.mul(w.load(&flux_factor), w.splat(part.weight));
        let value = scale3(w, value, factor);
        let values = scale3(w, value, weight);
        let lit = active & is_lit(w, values);
        let counts = w.mask(u32::from(lit));
        let unclamped = w.select(counts, luminance(w, value), zero);
        let clamped = w.mul(unclamped, w.sub(w.splat(1.0), weight));
        add_lanes(w, &mut self.unclamped[b], unclamped);
        add_lanes(w, &mut self.clamped[b], w.select(counts, clamped, zero));
        self.values[b] = Lanes3::store(w, values);
        LitPoints {
            lit,
            front_of_point: w.bits(w.le(zero, cos_point)) as LaneMask,
            front_of_light: w.bits(w.le(cos_light, zero)) as LaneMask,
        }
    }

    /// `f |w·n| I(-w) / d²` of a point, for the active lanes, and the clamping weight.
    #[inline(always)]
    fn point_value<W: Sixteen>(
        &self,
        w: W,
        light: &ConnectedLight,
        part: LightPoint,
        batch: &Batch,
        at: PointGeometry<W>,
    ) -> ([W::F; 3], W::F) {
        let PointGeometry { wi, inv_d2, active } = at;
        let directions = Lanes3::store(w, wi);
        let intensity = light.emission.intensities(w, &directions, active);
        let active = active & is_lit(w, intensity.load(w));
        if active == 0 {
            return ([w.splat(0.0); 3], w.splat(1.0));
        }
        let f_cos = batch.receivers.f_cos_wi(w, &directions, active);
        let connections = ClampedConnections {
            batch,
            w: &directions,
            inv_d2: &w.store(inv_d2),
            f_cos: &f_cos,
            n: light.light.n,
            area: part.area * self.gather.area_factor(batch.lights),
        };
        let weights = connections.weights(self.gather.clamp);
        let value = mul3(w, f_cos.load(w), scale3(w, intensity.load(w), inv_d2));
        (only(w, active, value), w.load(&weights))
    }

    /// Factor on light `id` at each point: the fraction of its flux that fits the path limits, times the number of lights that it
    /// represents.
    #[inline(always)]
    fn flux_factor(&self, id: LightId, batch: &Batch) -> Lanes {
        let mut fraction = [self.gather.lights_per_term(batch.lights); LANES];
        if let Some(depths) = &batch.depths {
            for (fraction, depth) in fraction.iter_mut().zip(depths) {
                *fraction *= depth.map_or(1.0, |depth| self.lights.set.share_up_to(id, depth));
            }
        }
        fraction
    }

    /// Traces the shadow rays that wait.
    #[inline(always)]
    pub(super) fn flush<W: Sixteen>(&mut self, w: W, sums: &mut [Gathered]) {
        for block in &mut self.blocks {
            block.flush(w, self.scene, self.batches, sums, &mut self.gathered);
        }
    }

    /// Adds the clamped and unclamped light to the statistics of the sums.
    pub(super) fn count_clamped(&self, sums: &mut [Gathered]) {
        for (b, batch) in self.batches.iter().enumerate() {
            for (i, &member) in batch.members.iter().enumerate() {
                sums[member].clamped += self.clamped[b][i];
                sums[member].unclamped += self.unclamped[b][i];
            }
        }
    }
}

/// The geometry of the connections of one batch with a point.
#[derive(Clone, Copy)]
struct PointGeometry<W: Sixteen> {
    /// Unit directions to the point.
    wi: [W::F; 3],
    /// Inverse of the squared distances, in 1/m².
    inv_d2: W::F,
    active: LaneMask,
}

/// The lanes of each batch. A loop: `array::map` would not become part of the kernel.
#[inline(always)]
fn by_batch<T>(of: &[T; BATCHES], lanes: impl Fn(&T) -> LaneMask) -> [LaneMask; BATCHES] {
    let mut all = [0; BATCHES];
    for (all, of) in all.iter_mut().zip(of) {
        *all = lanes(of);
    }
    all
}

#[inline(always)]
fn add_lanes<W: Sixteen>(w: W, sum: &mut Lanes, x: W::F) {
    *sum = w.store(w.add(w.load(sum), x));
}

/// The lanes with some light in a channel, none of which is negative.
#[inline(always)]
fn is_lit<W: Sixteen>(w: W, light: [W::F; 3]) -> LaneMask {
    let sum = w.add(w.add(light[0], light[1]), light[2]);
    w.bits(w.lt(w.splat(0.0), sum)) as LaneMask
}
