//! The innermost loop: up to 64 points, sixteen at a time, with one light after the other.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over lanes read like what they become: vector instructions"
)]

use super::block::Block;
use super::clamping::ClampedConnection;
use super::points::{BATCHES, Batch};
use super::sphere::{Cone, LightLobe, Samples, only, sphere_radius};
use super::{Clamp, Gather, Gathered, Kernel, LightIndex, Viewpoint};
use crate::ids::LightId;
use crate::lanes::vectors::{dot, luminance, mul3, scale3, splat3};
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3};
use crate::math::Vec3;
use crate::scene::Scene;
use crate::simd::{self, Isa, Simd, Wide};
use crate::virtual_lights::moments::POINTS;
use crate::virtual_lights::{EmissionView, VirtualLight};
use std::f32::consts::PI;

/// A disc is all its points nearer than the first number of its radii, four of them nearer than the second, and one beyond.
/// Both are stretched by a random factor, so that no ring shows where the number changes.
const SIXTEEN_POINTS_WITHIN: f32 = 1.5;
const FOUR_POINTS_WITHIN: f32 = 4.0;
/// As many samples are taken of the field of view of a sphere.
const SIXTEEN_SAMPLES_WITHIN: f32 = 2.0;
const FOUR_SAMPLES_WITHIN: f32 = 8.0;
const REACH_SPREAD: f32 = 0.25;

/// A disc is at least this share of the surface per light.
const SMALLEST_DISC: f32 = 0.25;

/// A piece of a light that is connected with as a point.
#[derive(Clone, Copy, Debug)]
struct Part {
    p: Vec3,
    /// Of the surface that it stands for, in m².
    area: f32,
    /// Share of the light's intensity.
    weight: f32,
    /// Samples of a sphere; none of a point.
    samples: Option<usize>,
}

/// How many parts a light is made of, as seen from the points of one batch.
#[derive(Clone, Copy, Debug, Default)]
struct Views {
    one: LaneMask,
    four: LaneMask,
    sixteen: LaneMask,
}

/// The loops over lanes in here and in all that it calls become vectors of the chosen instructions.
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
        let lights = self.batches[0]
            .lights
            .indices(self.lights.set.lights().len());
        let connections = lights.len();
        let mut sum = Sum::new(w, self.gather, self.scene, self.lights, self.batches, 1);
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

impl Views {
    fn are_empty(&self) -> bool {
        self.one | self.four | self.sixteen == 0
    }
}

impl Gather {
    /// Adds the lights that up to [`BATCHES`] batches have in common to their points.
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

    /// Of how many parts or samples `light`, a sphere of the given radius, is made as seen from those of the points in `facing`, which
    /// are at the vectors `to` from it.
    #[inline(always)]
    fn views<W: Wide>(
        &self,
        w: W,
        light: &VirtualLight,
        radius: f32,
        to: [W::F; 3],
        u: &Lanes,
        facing: LaneMask,
    ) -> Views {
        let [sixteen, four] = match self.kernel {
            Kernel::Disc if self.is_disc(light) => [
                SIXTEEN_POINTS_WITHIN * light.radius,
                FOUR_POINTS_WITHIN * light.radius,
            ],
            Kernel::Sphere => [
                SIXTEEN_SAMPLES_WITHIN * radius,
                FOUR_SAMPLES_WITHIN * radius,
            ],
            _ => {
                return Views {
                    one: facing,
                    ..Views::default()
                };
            }
        };
        let d2 = dot(w, to, to);
        let stretch = w.mul_add(w.load(u), w.splat(REACH_SPREAD), w.splat(1.0));
        let near = facing & within(w, d2, stretch, four);
        let sixteen = near & within(w, d2, stretch, sixteen);
        Views {
            one: facing & !near,
            four: near & !sixteen,
            sixteen,
        }
    }

    /// The area of the parts of `light` as seen from `at`, in m².
    pub(super) fn part_area(&self, at: &Viewpoint, light: &VirtualLight) -> f32 {
        let within = |radii: f32| self.is_disc(light) && is_within(radii, light, at.p, at.u);
        if within(SIXTEEN_POINTS_WITHIN) {
            piece(light, 0, 1.0 / POINTS as f32).area
        } else if within(FOUR_POINTS_WITHIN) {
            piece(light, 0, 0.25).area
        } else {
            self.whole(light).area
        }
    }

    /// Whether a light has parts. A share dominated by one strong photon has hardly a radius, yet stands for as much surface as
    /// its neighbors: a point.
    #[inline(always)]
    fn is_disc(&self, light: &VirtualLight) -> bool {
        self.kernel == Kernel::Disc && disc(light) > SMALLEST_DISC * light.area
    }

    /// The one point that stands for all of `light` from far away.
    #[inline(always)]
    fn whole(&self, light: &VirtualLight) -> Part {
        let (p, area) = match self.kernel {
            Kernel::Point | Kernel::Sphere => (light.p, light.area),
            Kernel::Disc => (light.points[0], disc(light).max(light.area)),
        };
        Part {
            p,
            area,
            weight: 1.0,
            samples: None,
        }
    }
}

/// [`Clamp::kept`] in each lane.
#[inline(always)]
fn kept(
    clamp: Clamp,
    batch: &Batch,
    f_cos: &Lanes3,
    w: &Lanes3,
    inv_d2: &Lanes,
    n: Vec3,
    area: f32,
) -> Lanes {
    let lane = |clamp: Clamp, i: usize| {
        clamp.kept(&ClampedConnection {
            w: w.vec(i),
            inv_d2: inv_d2[i],
            f_cos: f_cos.rgb(i),
            n_x: batch.ng.vec(i),
            n_y: n,
            area,
        })
    };
    let mut kept = [1.0; LANES];
    // One loop for each kind: the choice must not be made in every lane.
    match clamp {
        Clamp::None => {}
        Clamp::Auto(strength) => {
            for i in 0..LANES {
                kept[i] = lane(Clamp::Auto(strength), i);
            }
        }
        Clamp::Value(limit) => {
            for i in 0..LANES {
                kept[i] = lane(Clamp::Value(limit), i);
            }
        }
    }
    kept
}

#[inline(always)]
fn add_lanes<W: Wide>(w: W, sum: &mut Lanes, x: W::F) {
    *sum = w.store(w.add(w.load(sum), x));
}

/// The lanes in which the squared distance `d2` is within `reach`, stretched.
#[inline(always)]
fn within<W: Wide>(w: W, d2: W::F, stretch: W::F, reach: f32) -> LaneMask {
    let reach = w.mul(stretch, w.splat(reach));
    w.bits(w.lt(d2, w.mul(reach, reach))) as LaneMask
}

/// Area of the disc with the second moment of a light's photons, in m².
#[inline(always)]
fn disc(light: &VirtualLight) -> f32 {
    PI * light.radius * light.radius
}

/// The lanes with some light in a channel, none of which is negative.
#[inline(always)]
fn is_lit<W: Wide>(w: W, light: [W::F; 3]) -> LaneMask {
    let sum = w.add(w.add(light[0], light[1]), light[2]);
    w.bits(w.lt(w.splat(0.0), sum)) as LaneMask
}

/// Whether the point `p` with the random number `u` is within so many radii of `light`.
#[inline(always)]
fn is_within(radii: f32, light: &VirtualLight, p: Vec3, u: f32) -> bool {
    let reach = radii * light.radius * (1.0 + REACH_SPREAD * u);
    (light.p - p).length_squared() < reach * reach
}

/// A quarter, or a sixteenth, of a light.
#[inline(always)]
fn piece(light: &VirtualLight, point: usize, share: f32) -> Part {
    Part {
        p: light.points[point],
        area: disc(light) * share,
        weight: share,
        samples: None,
    }
}

/// The light that is being added.
struct Source<'f, 's> {
    id: LightId,
    light: &'f VirtualLight<'s>,
    emission_view: EmissionView<'f, 's>,
    /// As a sphere, in m.
    radius: f32,
    /// The glossy lobe of a light that shines as one photon, for the samples of a sphere.
    lobe: Option<LightLobe>,
}

/// Which points of a batch one part of a light sends something to.
#[derive(Clone, Copy, Default)]
struct Connected {
    lit: LaneMask,
    /// Points whose shadow ray leaves on the side of the geometric normal.
    in_front: LaneMask,
    /// Points before the light, on the side of its normal.
    before: LaneMask,
}

impl Connected {
    /// The points with a connection that leaves and arrives on these sides.
    #[inline(always)]
    fn lanes(&self, in_front: bool, before: bool) -> LaneMask {
        let side = |mask: LaneMask, wanted: bool| if wanted { mask } else { !mask };
        self.lit & side(self.in_front, in_front) & side(self.before, before)
    }
}

/// Sums for some batches on their way.
pub(super) struct Sum<'a, 'b, 's> {
    gather: &'a Gather,
    scene: &'a Scene,
    lights: &'a LightIndex<'s>,
    batches: &'a [Batch<'b, 's>],
    /// What has arrived, by slot.
    pub(super) gathered: Vec<[Lanes3; BATCHES]>,
    /// The slot for lights that are being added.
    pub(super) slot: usize,
    /// What one part of a light sends to the points of each batch; of lanes without a connection, anything.
    values: [Lanes3; BATCHES],
    /// Shadow rays that leave on the side of the geometric normal, and on the other.
    blocks: [Block; 2],
    /// For spheres.
    samples: [Option<Samples>; BATCHES],
    clamped: [Lanes; BATCHES],
    unclamped: [Lanes; BATCHES],
}

impl<'a, 'b, 's> Sum<'a, 'b, 's> {
    /// Nothing yet, in so many slots.
    #[inline(always)]
    pub(super) fn new<W: Wide>(
        w: W,
        gather: &'a Gather,
        scene: &'a Scene,
        lights: &'a LightIndex<'s>,
        batches: &'a [Batch<'b, 's>],
        slots: usize,
    ) -> Self {
        Sum {
            gather,
            scene,
            lights,
            batches,
            gathered: vec![[Lanes3::ZERO; BATCHES]; slots],
            slot: 0,
            values: [Lanes3::ZERO; BATCHES],
            blocks: [Block::new(0), Block::new(1)],
            samples: std::array::from_fn(|b| {
                let batch = batches.get(b)?;
                (gather.kernel == Kernel::Sphere).then(|| Samples::of(w, batch))
            }),
            clamped: [[0.0; LANES]; BATCHES],
            unclamped: [[0.0; LANES]; BATCHES],
        }
    }

    /// Adds what one light sends to the slot; it may wait for its visibility test.
    #[inline(always)]
    pub(super) fn add_light<W: Wide>(&mut self, w: W, id: LightId, sums: &mut [Gathered]) {
        let light = &self.lights.set.lights()[id.index()];
        let reach = &self.lights.reaches[id.index()];
        let is_sphere = self.gather.kernel == Kernel::Sphere;
        let radius = sphere_radius(light, self.gather.surfaces(self.batches[0].lights));
        let mut views = [Views::default(); BATCHES];
        for (views, batch) in views.iter_mut().zip(self.batches) {
            let to = batch.towards(w, light.p);
            let facing = batch.facing(w, to, light, reach);
            if facing != 0 {
                *views = self.gather.views(w, light, radius, to, &batch.u, facing);
            }
        }
        if views.iter().all(Views::are_empty) {
            return;
        }
        let source = Source {
            id,
            light,
            emission_view: self.lights.set.emission_view(id),
            radius,
            lobe: if is_sphere {
                // The random numbers of the points are others in every pass.
                LightLobe::of(&self.lights.set, id, self.batches[0].u[0].to_bits())
            } else {
                None
            },
        };
        let by_count = [
            (1, views.map(|v| v.one)),
            (4, views.map(|v| v.four)),
            (POINTS, views.map(|v| v.sixteen)),
        ];
        for (count, active) in by_count {
            if active == [0; BATCHES] {
                continue;
            }
            if is_sphere {
                let whole = Part {
                    samples: Some(count),
                    ..self.gather.whole(light)
                };
                self.add_part(w, &source, whole, active, sums);
                continue;
            }
            for k in 0..count {
                let part = match count {
                    1 => self.gather.whole(light),
                    _ => piece(light, k * (POINTS / count), 1.0 / count as f32),
                };
                self.add_part(w, &source, part, active, sums);
            }
        }
    }

    /// Connects the active points with one part of a light.
    #[inline(always)]
    fn add_part<W: Wide>(
        &mut self,
        w: W,
        source: &Source,
        part: Part,
        active: [LaneMask; BATCHES],
        sums: &mut [Gathered],
    ) {
        let mut connected = [Connected::default(); BATCHES];
        for (b, batch) in self.batches.iter().enumerate() {
            if active[b] != 0 {
                connected[b] = self.connect(w, source, part, b, batch, active[b]);
            }
        }
        for (side, towards) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
            let lanes = connected
                .each_ref()
                .map(|c| c.lanes(side == 0, towards > 0.0));
            if lanes == [0; BATCHES] {
                continue;
            }
            let block = &mut self.blocks[side];
            if block.is_full() {
                block.flush(w, self.scene, self.batches, sums, &mut self.gathered);
            }
            let light = source.light;
            block.open(part.p + light.n * (light.offset * towards), self.slot);
            for (b, &lanes) in lanes.iter().enumerate().filter(|(_, lanes)| **lanes != 0) {
                block.put(b, lanes, &self.values[b]);
            }
        }
    }

    /// Sets the values of one batch: what one part sends to the active points, clamped.
    #[inline(always)]
    fn connect<W: Wide>(
        &mut self,
        w: W,
        source: &Source,
        part: Part,
        b: usize,
        batch: &Batch,
        active: LaneMask,
    ) -> Connected {
        let zero = w.splat(0.0);
        let light = source.light;
        let to = batch.towards(w, part.p);
        let d2 = dot(w, to, to);
        let inv_d = w.div(w.splat(1.0), w.sqrt(d2));
        let inv_d2 = w.mul(inv_d, inv_d);
        let wi = scale3(w, to, inv_d);
        let cos_light = dot(w, wi, splat3(w, light.n));
        let cos_point = dot(w, wi, batch.ng.load(w));
        let active = active & batch.lit(w, wi) & w.bits(w.lt(zero, d2)) as LaneMask;
        let (value, kept) = match part.samples {
            None => self.point_value(w, source, part, batch, wi, inv_d2, active),
            Some(count) => {
                let cone = Cone::of(w, wi, inv_d2, source.radius);
                let lobe = source.lobe.as_ref();
                let value = match &self.samples[b] {
                    Some(samples) => {
                        samples.sphere(w, batch, &source.emission_view, lobe, &cone, count, active)
                    }
                    None => [zero; 3],
                };
                (value, w.splat(1.0))
            }
        };
        let share = w.mul(w.load(&self.share(source.id, batch)), w.splat(part.weight));
        let value = scale3(w, value, share);
        let values = scale3(w, value, kept);
        let lit = active & is_lit(w, values);
        let counts = w.lanes(u32::from(lit));
        let full = w.select(counts, luminance(w, value), zero);
        let removed = w.mul(full, w.sub(w.splat(1.0), kept));
        add_lanes(w, &mut self.unclamped[b], full);
        add_lanes(w, &mut self.clamped[b], w.select(counts, removed, zero));
        self.values[b] = Lanes3::store(w, values);
        Connected {
            lit,
            in_front: w.bits(w.le(zero, cos_point)) as LaneMask,
            before: w.bits(w.le(cos_light, zero)) as LaneMask,
        }
    }

    /// `f |w·n| I(-w) / d²` of a point, for the active lanes, and what the clamp keeps of it.
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "the values of a connection, in registers"
    )]
    fn point_value<W: Wide>(
        &self,
        w: W,
        source: &Source,
        part: Part,
        batch: &Batch,
        wi: [W::F; 3],
        inv_d2: W::F,
        active: LaneMask,
    ) -> ([W::F; 3], W::F) {
        let directions = Lanes3::store(w, wi);
        let intensity = source.emission_view.intensities(w, &directions, active);
        let active = active & is_lit(w, intensity.load(w));
        if active == 0 {
            return ([w.splat(0.0); 3], w.splat(1.0));
        }
        let f_cos = batch.receivers.f_cos_wi(w, &directions, active);
        let area = part.area * self.gather.surfaces(batch.lights);
        let kept = kept(
            self.gather.clamp,
            batch,
            &f_cos,
            &directions,
            &w.store(inv_d2),
            source.light.n,
            area,
        );
        let value = mul3(w, f_cos.load(w), scale3(w, intensity.load(w), inv_d2));
        (only(w, active, value), w.load(&kept))
    }

    /// The share of a light's flux that fits the path limits of each point, times the number of lights that it stands for.
    #[inline(always)]
    fn share(&self, id: LightId, batch: &Batch) -> Lanes {
        let mut share = [self.gather.stands_for(batch.lights); LANES];
        if let Some(depths) = &batch.depths {
            for (share, depth) in share.iter_mut().zip(depths) {
                *share *= depth.map_or(1.0, |depth| self.lights.set.share_up_to(id, depth));
            }
        }
        share
    }

    /// Tests what waits.
    #[inline(always)]
    pub(super) fn flush<W: Wide>(&mut self, w: W, sums: &mut [Gathered]) {
        for block in &mut self.blocks {
            block.flush(w, self.scene, self.batches, sums, &mut self.gathered);
        }
    }

    /// Adds what the clamp took, and of how much.
    pub(super) fn count_clamped(&self, sums: &mut [Gathered]) {
        for (b, batch) in self.batches.iter().enumerate() {
            for (i, &member) in batch.members.iter().enumerate() {
                sums[member].clamped += self.clamped[b][i];
                sums[member].unclamped += self.unclamped[b][i];
            }
        }
    }
}
