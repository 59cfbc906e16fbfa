//! The eye paths of the many-light methods: from the camera through specular events, with the emission on the way, to the points
//! where lights are summed. There `smooth_light.rs` takes over.

use super::carried::share_of_directions;
use super::first_surface;
use super::light_set::PreparedPasses;
use super::partition::Stage;
use super::smooth_light::{Branch, DIRECTIONS, Directions};
use crate::bsdf::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::film::{Layer, TileSamples};
use crate::gather::{ShadingPoint, Strategy, Subset};
use crate::maps::{INCIDENT_NEIGHBORS, Neighbors};
use crate::math::Vec3;
use crate::sampling::{LowDiscrepancySequence, Pass, Sampler, Stream};
use crate::transport::direct::{
    EmitterPlan, EmitterSample, emitted_with_mis, environment_with_mis,
};
use crate::transport::{Step, Vertex, Walk};

/// Eye paths that a pixel starts with, each with that part of its lights and directions: edges and textures are noise otherwise. Cuts are
/// made for each point, so that one must do.
const STARTS: u32 = 4;
/// Those that it has after the first specular event: narrow lobes and the choice between reflection and refraction are noise otherwise.
const SPLIT: u32 = 8;
/// A specular branch goes on with probability `throughput x this`, at most 1: the weakest are followed rarely.
const BRANCH_SURVIVAL: f32 = 64.0;
/// Specular chains longer than this end.
pub(super) const MAX_CHAIN: u32 = 64;

/// A vertex of an eye path where virtual lights and caustic photons are summed.
pub(super) struct GatherPoint<'s> {
    pub(super) pixel: usize,
    pub(super) throughput: Rgb,
    pub(super) segments: u32,
    pub(super) at: ShadingPoint<'s>,
    /// Before the smooth event here.
    pub(super) stage: Stage,
    /// Largest radius of a caustic estimate, in m.
    pub(super) reach: f32,
    /// See [`Branch::broad`].
    pub(super) broad: f32,
    /// How many times density estimates count here: photons change little within a pixel, so that one of its eye paths asks for them.
    pub(super) photons: f32,
}

/// One in so many lights is enough where a small part of the light is looked for.
const FEW: u32 = 8;
/// Which ones is a choice among so many in turn, the same in all tiles of a pass: points of the same choice go through lights together.
const FEW_CHOICES: u32 = 4;

/// Squared distance in parts of the surface per light within which that is taken for the same.
const NEAR_SURFACE: f32 = 0.1;

/// Hands out few lights.
struct Few {
    /// The first choice.
    first: u32,
    /// How many choices there are.
    choices: u32,
    /// How many times some were handed out.
    given: u32,
}

impl Few {
    fn next(&mut self, lights: Subset) -> Subset {
        let choice = self.given % self.choices;
        self.given += 1;
        lights.part(self.first + choice * (FEW / self.choices), FEW)
    }
}

/// What the eye paths of a tile bring.
pub(super) struct CameraPaths<'s, 'o, 't> {
    pub(super) out: &'o mut TileSamples<'t>,
    pub(super) points: Vec<GatherPoint<'s>>,
    /// Visibility tests.
    pub(super) shadow_rays: u64,
    pub(super) found: Neighbors,
    /// Where the surface per light was last asked for, and what it was, in m².
    asked: Option<(Vec3, f32)>,
    few: Few,
}

impl<'s, 'o, 't> CameraPaths<'s, 'o, 't> {
    /// None so far, of a pass with the lights of `set`.
    pub(super) fn new(set: &PreparedPasses, pass: Pass, out: &'o mut TileSamples<'t>) -> Self {
        let u = pass.sampler(Stream::Selection, 2).next_1d();
        let choices = match set.gather.strategy {
            Strategy::All => FEW_CHOICES,
            // A selection says nothing but the size of a cut.
            Strategy::Cuts(_) => 1,
        };
        CameraPaths {
            few: Few {
                first: (u * FEW as f32) as u32,
                choices,
                given: 0,
            },
            out,
            points: Vec::new(),
            shadow_rays: 0,
            found: Neighbors::new(INCIDENT_NEIGHBORS),
            asked: None,
        }
    }
}

/// How many eye paths a pixel starts with.
pub(super) fn starts(strategy: Strategy) -> u32 {
    match strategy {
        Strategy::All => STARTS,
        Strategy::Cuts(_) => 1,
    }
}

/// The random numbers that the eye paths of a pixel share, so that all together fill their domains evenly.
#[derive(Clone, Copy)]
pub(super) struct PixelNumbers {
    events: LowDiscrepancySequence,
    pub(super) emitters: LowDiscrepancySequence,
    pub(super) directions: LowDiscrepancySequence,
}

impl PixelNumbers {
    pub(super) fn draw(sampler: &mut Sampler) -> Self {
        PixelNumbers {
            events: sampler.next_sequence(),
            emitters: sampler.next_sequence(),
            directions: sampler.next_sequence(),
        }
    }
}

/// One of the eye paths of a pixel.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub(super) index: u32,
    /// How many there are.
    pub(super) of: u32,
}

/// One eye path.
pub(super) struct CameraPath<'p, 's, 'o, 't> {
    pub(super) set: &'p PreparedPasses<'s>,
    /// The lights of this pass.
    pub(super) lights: Subset,
    pub(super) walk: Walk<'s>,
    pub(super) sampler: &'p mut Sampler,
    pub(super) numbers: PixelNumbers,
    /// Of the tile.
    pub(super) pixel: usize,
    pub(super) paths: &'p mut CameraPaths<'s, 'o, 't>,
    /// In m.
    pub(super) length: f32,
    pub(super) part: Part,
}

/// What a walk counts for roulette: its throughput, freed of the η² that refraction puts into radiance.
pub(super) fn weight(walk: &Walk) -> f32 {
    walk.throughput().max_channel() * walk.eta_squared()
}

impl<'p, 's, 'o, 't> CameraPath<'p, 's, 'o, 't> {
    /// Follows specular events; every vertex with smooth lobes becomes a gathering point with those lobes alone.
    pub(super) fn trace(&mut self) {
        let (scene, limits) = (self.set.scene, self.set.limits);
        loop {
            let v = match self.walk.advance() {
                Step::Hidden => return,
                Step::Escaped(wi) => {
                    let found = environment_with_mis(scene, self.walk.previous(), wi);
                    return self.add(Layer::Emission, self.walk.throughput() * found);
                }
                Step::Hit(v) => v,
            };
            self.length += v.distance;
            if v.segments == 1 {
                self.first_surface(&v);
            }
            let found = emitted_with_mis(scene, self.walk.previous(), &v.x, v.w_prev);
            self.add(Layer::Emission, self.walk.throughput() * found);
            if !limits.allow(v.segments + 1) {
                return;
            }
            if self.walk.pass_through(&v, self.sampler.next_1d()) {
                continue;
            }
            self.narrow_emission(&v);
            if v.bsdf.lobes().has(Lobes::NON_SPECULAR) {
                let Part { index, of } = self.part;
                let lights = self.lights.divided(index, of);
                let directions = Directions::of_part(index, DIRECTIONS / of, self.numbers);
                self.smooth_light(&v, self.branch(), lights, &directions);
            }
            if self.part.of < SPLIT {
                return self.split(&v);
            }
            let numbers = self.sampler.next_bsdf();
            if !self.follow_specular(&v, numbers) {
                return;
            }
        }
    }

    /// The layers that describe the first surface are means over the starts of a pixel.
    fn first_surface(&mut self, v: &Vertex) {
        let share = 1.0 / self.part.of as f32;
        first_surface(v, share, self.sampler, self.pixel, self.paths.out);
    }

    /// Goes on from `v` on several paths.
    fn split(&mut self, v: &Vertex<'s>) {
        if !v.bsdf.lobes().has(Lobes::SPECULAR) {
            return;
        }
        let branches = SPLIT / self.part.of;
        self.walk.scale(1.0 / branches as f32);
        let (walk, length) = (self.walk.clone(), self.length);
        let first = self.part.index * branches;
        for index in first..first + branches {
            (self.walk, self.length) = (walk.clone(), length);
            self.part = Part { index, of: SPLIT };
            let (lobe, direction) = self.numbers.events.triple(index);
            if self.follow_specular(v, BsdfNumbers { lobe, direction }) {
                self.trace();
            }
        }
    }

    /// Some of the lights of this pass.
    pub(super) fn few_lights(&mut self) -> Subset {
        self.paths.few.next(self.lights)
    }

    /// The surface per light around `p`, about, in m²; what it is nearby will do.
    pub(super) fn surface_per_light(&mut self, p: Vec3) -> f32 {
        if let Some((place, area)) = self.paths.asked
            && place.distance_squared(p) < NEAR_SURFACE * area
        {
            return area;
        }
        let area = self.set.lights.set.surface_per_light(p);
        self.paths.asked = Some((p, area));
        area
    }

    /// What follows from the end of the eye path.
    fn branch(&self) -> Branch<'s> {
        Branch {
            walk: self.walk.clone(),
            stage: Stage::BeforeX,
            lit_from: None,
            full: weight(&self.walk) * self.part.of as f32 / DIRECTIONS as f32,
            reach: self.set.caustic_reach(self.length),
            broad: f32::INFINITY,
            found: 1.0,
            photons: self.photons(),
        }
    }

    /// Before the first specular event the first of the eye paths of a pixel asks for photons, for all.
    fn photons(&self) -> f32 {
        match self.part {
            Part { of: SPLIT, .. } => 1.0,
            Part { index: 0, of } => of as f32,
            Part { .. } => 0.0,
        }
    }

    pub(super) fn add(&mut self, layer: Layer, radiance: Rgb) {
        self.paths.out.add(self.pixel, layer, radiance);
    }

    /// The direct light of near-delta lobes belongs to the emission: the walk that follows them is the other half of it.
    fn narrow_emission(&mut self, v: &Vertex) {
        if v.bsdf.lobes().has(Lobes::NEAR_DELTA) {
            let plan = EmitterPlan::draw(self.set.scene, self.sampler);
            let pdf_walk = |wi| v.bsdf.pdf_wi(wi, v.w_prev, Lobes::SPECULAR);
            if let Some(radiance) = self.emitter_light(v, Lobes::NEAR_DELTA, None, &plan, pdf_walk)
            {
                self.add(Layer::Emission, self.walk.throughput() * radiance);
            }
        }
    }

    /// Light from a chosen emitter that `lobes` at `v` reflect, weighted against a walk that goes on with density `pdf_walk`; of
    /// it, what belongs to the branch that ends there.
    pub(super) fn emitter_light(
        &mut self,
        v: &Vertex,
        lobes: Lobes,
        branch: Option<&Branch>,
        plan: &EmitterPlan,
        pdf_walk: impl FnOnce(Vec3) -> f32,
    ) -> Option<Rgb> {
        let (scene, wo) = (self.set.scene, v.w_prev);
        let light = EmitterSample::planned(scene, &v.x, v.bsdf.receiving_normal(wo), plan)?;
        let f_cos = v.bsdf.f_cos_wi(light.wi, wo, lobes);
        let lit_from = branch.and_then(|branch| branch.lit_from);
        if f_cos.is_black() || lit_from.is_some_and(|n| light.wi.dot(n) <= 0.0) {
            return None;
        }
        let share = branch.map_or(1.0, |branch| share_of_directions(branch.broad, f_cos));
        self.paths.shadow_rays += 1;
        let crossings = self.set.limits.left_after(v.segments + 1);
        let arriving = light.weight * light.transmittance(scene, crossings);
        Some(arriving * f_cos * (share * light.mis_weight(pdf_walk(light.wi))))
    }

    /// Continues by a specular event; the weakest branches only sometimes.
    fn follow_specular(&mut self, v: &Vertex, numbers: BsdfNumbers) -> bool {
        if v.segments >= MAX_CHAIN
            || !v.bsdf.lobes().has(Lobes::SPECULAR)
            || !self.walk.scatter(v, numbers, Lobes::SPECULAR)
        {
            return false;
        }
        let survival = (BRANCH_SURVIVAL * weight(&self.walk)).min(1.0);
        survival > 0.0 && self.walk.survive(survival, self.sampler.next_1d())
    }
}
