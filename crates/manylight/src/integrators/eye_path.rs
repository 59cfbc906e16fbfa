//! The eye paths of the many-light methods: emission and direct light on the way, and the points where lights are summed.
//!
//! Some light is looked for by directions from such a point `x`, drawn from its smooth lobes and from where photons of emitters beyond
//! the scene arrive. Where one runs into an emitter, it is
//! the other half of direct light. Where it meets a surface at `y`, it may go on as **the complement of the clamp**: the sum over
//! virtual lights at `x` keeps a share of the light that the smooth lobes at `y` reflect towards `x`, and the clamp takes the rest
//! away. So the direction goes on with the probability of what the clamp takes away from a photon at `y`, and everything that
//! lights `y` is looked up there: emitters, caustic photons, and virtual lights, whose sum is clamped and completed in the same
//! way. What `y` emits by itself is direct light at `x`.
//!
//! Where a glossy lobe at `x` meets a specular surface, the direction also goes on by specular events, and the method starts again
//! at the surface behind: photons that come from there are counted by diffuse lobes alone.
//!
//! Source: Kollig, Keller, "Illumination in the Presence of Weak Singularities", MCQMC 2004; here for lights that stand for
//! many photons, so that the clamp asks whose a photon at `y` would be.

use super::first_surface;
use super::light_set::{Complement, LightSet};
use super::partition::Stage;
use crate::bsdf::{BsdfNumbers, BsdfSample, Lobes};
use crate::color::Rgb;
use crate::film::{Layer, TileSamples};
use crate::gather::{Selection, ShadingPoint};
use crate::maps::{INCIDENT_NEIGHBORS, IncidentGuide, Neighbors};
use crate::math::Vec3;
use crate::sampling::Sampler;
use crate::transport::direct::{EmitterSample, LightPlan, found_environment, found_radiance};
use crate::transport::{Step, Vertex, Walk};
use crate::virtual_lights::Spot;

/// Directions drawn at each gathering point of an eye path, and samples of its emitters: cheap beside the sum over all lights,
/// and without them their noise would show.
const DIRECTIONS: u32 = 16;
/// Of the directions, those that may go on as the complement: sums over lights cost much more than rays to emitters.
const COMPLEMENTS: u32 = 4;
/// Share of the directions that look where light from afar comes from, if that is known.
const GUIDED: f32 = 0.5;
/// The complement is a small part of the light: one in so many lights is enough for it.
const FEW: u32 = 8;
/// The first specular event of an eye path splits it in so many, each with that part of the lights and directions: narrow lobes
/// and the choice between reflection and refraction are noise otherwise.
const SPLIT: u32 = 8;
/// A specular branch goes on with probability `throughput x this`, at most 1: the weakest are followed rarely.
const BRANCH_SURVIVAL: f32 = 64.0;
/// Of the directions, so many may go on by specular events: they find bright things in narrow lobes.
const MIRRORED: f32 = 0.5;
/// Each with this many times the share of light that it stands for, at most that.
const MIRRORED_EFFORT: f32 = 16.0;
/// Specular chains longer than this end.
const MAX_CHAIN: u32 = 64;
/// The first vertex after a gathering point may go on with this many times the share of light that it stands for, at most 1.
const SURVIVAL: f32 = 2.0;
/// Vertices after that, with that share; at most this.
const MAX_SURVIVAL: f32 = 0.95;
/// Caustics that are seen by way of a smooth surface may be blurred by this angle more.
const INDIRECT_REACH: f32 = 0.02;

/// A vertex of an eye path where virtual lights and caustic photons are summed.
pub(super) struct Gathering<'s> {
    pub(super) pixel: usize,
    pub(super) throughput: Rgb,
    pub(super) segments: u32,
    pub(super) at: ShadingPoint<'s>,
    /// Before the smooth event here.
    pub(super) stage: Stage,
    /// Largest radius of a caustic estimate, in m.
    pub(super) reach: f32,
}

/// What the eye paths of a tile bring.
pub(super) struct EyePaths<'s, 'o, 't> {
    pub(super) out: &'o mut TileSamples<'t>,
    pub(super) points: Vec<Gathering<'s>>,
    /// Visibility tests.
    pub(super) shadow_rays: u64,
    found: Neighbors,
}

impl<'s, 'o, 't> EyePaths<'s, 'o, 't> {
    /// None so far.
    pub(super) fn new(out: &'o mut TileSamples<'t>) -> Self {
        EyePaths {
            out,
            points: Vec::new(),
            shadow_rays: 0,
            found: Neighbors::new(INCIDENT_NEIGHBORS),
        }
    }
}

/// One eye path.
pub(super) struct EyePath<'p, 's, 'o, 't> {
    set: &'p LightSet<'s>,
    /// The lights of this pass.
    lights: Selection,
    walk: Walk<'s>,
    sampler: Sampler,
    pixel: usize,
    paths: &'p mut EyePaths<'s, 'o, 't>,
    /// In m.
    length: f32,
    /// Whether this is one of [`SPLIT`] paths.
    is_split: bool,
}

/// A path that looks for light beyond a gathering point.
#[derive(Clone)]
struct Branch<'s> {
    walk: Walk<'s>,
    stage: Stage,
    /// If given, only light from the side of this normal counts at its end.
    lit_from: Option<Vec3>,
    /// Weight of the complements of its eye path.
    full: f32,
    /// Largest radius of a caustic estimate at its end, in m.
    reach: f32,
}

/// What a walk counts for roulette: its throughput, freed of the η² that refraction puts into radiance.
fn weight(walk: &Walk) -> f32 {
    walk.throughput().max_channel() * walk.eta_squared()
}

/// Density of [`EyePath::draw_direction`] per solid angle.
fn smooth_pdf(v: &Vertex, guide: Option<&IncidentGuide>, w: Vec3) -> f32 {
    let lobes = v.bsdf.pdf_wi(w, v.w_prev, Lobes::SMOOTH);
    guide.map_or(lobes, |guide| lobes + GUIDED * (guide.pdf(w) - lobes))
}

/// A direction in which smooth lobes reflect, from the mixture of them and the guide, which of both by `u` in [0, 1).
fn draw_direction(
    v: &Vertex,
    guide: Option<&IncidentGuide>,
    numbers: BsdfNumbers,
    u: f32,
) -> Option<BsdfSample> {
    let Some(guide) = guide else {
        return v.bsdf.sample_wi(v.w_prev, numbers, Lobes::SMOOTH);
    };
    let (w, lobe, eta) = if u < GUIDED {
        let w = guide.sample(numbers.lobe, numbers.direction);
        (w, Lobes::DIFFUSE, 1.0)
    } else {
        let drawn = v.bsdf.sample_wi(v.w_prev, numbers, Lobes::SMOOTH)?;
        (drawn.w, drawn.lobe, drawn.eta)
    };
    let pdf = smooth_pdf(v, Some(guide), w);
    Some(BsdfSample {
        w,
        weight: v.bsdf.f_cos_wi(w, v.w_prev, Lobes::SMOOTH) / pdf,
        pdf,
        lobe,
        eta,
    })
}

impl<'p, 's, 'o, 't> EyePath<'p, 's, 'o, 't> {
    /// The path that `walk` starts, for one pixel of the tile.
    pub(super) fn new(
        set: &'p LightSet<'s>,
        lights: Selection,
        walk: Walk<'s>,
        sampler: Sampler,
        pixel: usize,
        paths: &'p mut EyePaths<'s, 'o, 't>,
    ) -> Self {
        EyePath {
            set,
            lights,
            walk,
            sampler,
            pixel,
            paths,
            length: 0.0,
            is_split: false,
        }
    }

    /// Follows specular events; every vertex with smooth lobes becomes a gathering point with those lobes alone.
    pub(super) fn trace(&mut self) {
        let (scene, limits) = (self.set.scene, self.set.limits);
        loop {
            let v = match self.walk.advance() {
                Step::Hidden => return,
                Step::Escaped(wi) => {
                    let found = found_environment(scene, self.walk.previous(), wi);
                    return self.add(Layer::Emission, self.walk.throughput() * found);
                }
                Step::Hit(v) => v,
            };
            self.length += v.distance;
            if v.segments == 1 {
                first_surface(&v, &mut self.sampler, self.pixel, self.paths.out);
            }
            let found = found_radiance(scene, self.walk.previous(), &v.x, v.w_prev);
            self.add(Layer::Emission, self.walk.throughput() * found);
            if !limits.allow(v.segments + 1) {
                return;
            }
            if self.walk.pass_through(&v, self.sampler.next_1d()) {
                continue;
            }
            self.narrow_emission(&v);
            if v.bsdf.lobes().has(Lobes::SMOOTH) {
                let branch = self.branch();
                if self.is_split {
                    let lights = self.lights.one_in(SPLIT, self.sampler.next_1d());
                    self.smooth_light(&v, branch, lights, DIRECTIONS / SPLIT);
                } else {
                    self.smooth_light(&v, branch, self.lights, DIRECTIONS);
                }
            }
            if !self.is_split {
                return self.split(&v);
            }
            let numbers = self.sampler.next_bsdf();
            if !self.follow_specular(&v, numbers) {
                return;
            }
        }
    }

    /// Goes on from `v` on several paths.
    fn split(&mut self, v: &Vertex<'s>) {
        if !v.bsdf.lobes().has(Lobes::SPECULAR) {
            return;
        }
        self.is_split = true;
        self.walk.scale(1.0 / SPLIT as f32);
        let (walk, length) = (self.walk.clone(), self.length);
        let numbers = self.sampler.next_spread();
        for i in 0..SPLIT {
            (self.walk, self.length) = (walk.clone(), length);
            let (lobe, direction) = numbers.triple(i);
            if self.follow_specular(v, BsdfNumbers { lobe, direction }) {
                self.trace();
            }
        }
    }

    fn add(&mut self, layer: Layer, radiance: Rgb) {
        self.paths.out.add(self.pixel, layer, radiance);
    }

    /// A branch that has not left the eye path.
    fn branch(&self) -> Branch<'s> {
        Branch {
            walk: self.walk.clone(),
            stage: Stage::BeforeX,
            lit_from: None,
            full: weight(&self.walk) / COMPLEMENTS as f32,
            reach: self.set.caustic_reach(self.length),
        }
    }

    /// Everything that the smooth lobes at the end `v` of a branch reflect: emitters and what lacks in the sum over lights, looked
    /// for in some directions, and that sum.
    fn smooth_light(
        &mut self,
        v: &Vertex<'s>,
        mut branch: Branch<'s>,
        lights: Selection,
        directions: u32,
    ) {
        let at = self.gather_at(v, &branch, lights);
        let guide = self.guide_at(v);
        branch.walk.scale(1.0 / directions as f32);
        let (for_emitters, for_directions) =
            (self.sampler.next_spread(), self.sampler.next_spread());
        for i in 0..directions {
            let (u_choice, u) = for_emitters.triple(i);
            let plan = LightPlan::new(self.set.scene, u_choice, u);
            self.emitters_at(v, &branch, guide.as_ref(), &plan);
            let (lobe, direction) = for_directions.triple(i);
            let u = (i as f32 + self.sampler.next_1d()) / directions as f32;
            let sample = draw_direction(v, guide.as_ref(), BsdfNumbers { lobe, direction }, u);
            self.follow_smooth(v, sample, branch.clone(), &at);
        }
    }

    /// Where light from afar comes from at `v`, if anything is known.
    fn guide_at(&mut self, v: &Vertex) -> Option<IncidentGuide> {
        // A surface that is lit from both sides would need two guides.
        v.bsdf.receiving_normal(v.w_prev)?;
        let n = v.x.normal_towards(v.w_prev);
        self.set.incident.around(v.x.p, n, &mut self.paths.found)
    }

    /// The direct light of near-delta lobes belongs to the emission: the walk that follows them is the other half of it.
    fn narrow_emission(&mut self, v: &Vertex) {
        if v.bsdf.lobes().has(Lobes::NEAR_DELTA) {
            let plan = LightPlan::draw(self.set.scene, &mut self.sampler);
            let pdf_walk = |wi| v.bsdf.pdf_wi(wi, v.w_prev, Lobes::SPECULAR);
            if let Some(radiance) = self.emitter_light(v, Lobes::NEAR_DELTA, None, &plan, pdf_walk)
            {
                self.add(Layer::Emission, self.walk.throughput() * radiance);
            }
        }
    }

    /// Light from a chosen emitter that `lobes` at `v` reflect, weighted against a walk that goes on with density `pdf_walk`.
    fn emitter_light(
        &mut self,
        v: &Vertex,
        lobes: Lobes,
        lit_from: Option<Vec3>,
        plan: &LightPlan,
        pdf_walk: impl FnOnce(Vec3) -> f32,
    ) -> Option<Rgb> {
        let (scene, wo) = (self.set.scene, v.w_prev);
        let light = EmitterSample::planned(scene, &v.x, v.bsdf.receiving_normal(wo), plan)?;
        let f_cos = v.bsdf.f_cos_wi(light.wi, wo, lobes);
        if f_cos.is_black() || lit_from.is_some_and(|n| light.wi.dot(n) <= 0.0) {
            return None;
        }
        self.paths.shadow_rays += 1;
        let crossings = self
            .set
            .limits
            .max_depth
            .map_or(u32::MAX, |max| max - (v.segments + 1));
        let arriving = light.weight * light.transmittance(scene, crossings);
        Some(arriving * f_cos * light.mis_weight(pdf_walk(light.wi)))
    }

    /// Light from emitters that smooth lobes reflect at the end `v` of a branch; directions drawn there are the other half of it.
    fn emitters_at(
        &mut self,
        v: &Vertex,
        branch: &Branch,
        guide: Option<&IncidentGuide>,
        plan: &LightPlan,
    ) {
        let pdf_walk = |wi| smooth_pdf(v, guide, wi);
        if let Some(radiance) =
            self.emitter_light(v, Lobes::SMOOTH, branch.lit_from, plan, pdf_walk)
        {
            let layer = branch.stage.after(Lobes::DIFFUSE).layer();
            self.add(layer, branch.walk.throughput() * radiance);
        }
    }

    /// The end `v` of a branch becomes a gathering point.
    fn gather_at(
        &mut self,
        v: &Vertex<'s>,
        branch: &Branch<'s>,
        lights: Selection,
    ) -> ShadingPoint<'s> {
        let limits = self.set.limits;
        let at = ShadingPoint {
            x: v.x,
            wo: v.w_prev,
            bsdf: v.bsdf,
            max_photon_depth: limits.max_depth.map(|max| max - (v.segments + 1)),
            u: self.sampler.next_1d(),
            lights,
            lit_from: branch.lit_from,
        };
        self.paths.points.push(Gathering {
            pixel: self.pixel,
            throughput: branch.walk.throughput(),
            segments: v.segments,
            at,
            stage: branch.stage,
            reach: branch.reach,
        });
        at
    }

    /// Goes on from the gathering point `x` on `v` in a direction drawn there: adds the emitter there, or the complement of the
    /// sum at `x`.
    fn follow_smooth(
        &mut self,
        v: &Vertex<'s>,
        sample: Option<BsdfSample>,
        mut branch: Branch<'s>,
        x: &ShadingPoint<'s>,
    ) {
        let Some(wi) = sample.map(|sample| sample.w) else {
            return;
        };
        if !branch.walk.follow(v, sample) {
            return;
        }
        branch.stage = branch.stage.after(Lobes::DIFFUSE);
        let Some(y) = self.next_surface(&mut branch, true) else {
            return;
        };
        if v.bsdf.lobes().has(Lobes::GLOSSY) && y.bsdf.lobes().has(Lobes::SPECULAR) {
            let of = |lobes| v.bsdf.f(wi, v.w_prev, lobes);
            let share =
                of(Lobes::GLOSSY).zip(
                    of(Lobes::SMOOTH),
                    |part, all| if all > 0.0 { part / all } else { 0.0 },
                );
            self.mirrored(y.clone(), branch.clone(), share);
        }
        if y.bsdf.lobes().has(Lobes::SMOOTH) && self.set.complement != Complement::None {
            self.complement(&y, branch, x);
        }
    }

    /// What the sum over lights at `x` lacks of the light that the smooth lobes at `y` reflect into the branch. A surface that
    /// transmits is lit from both sides, and one is chosen: the lights of each side are others, and the clamp with them.
    fn complement(&mut self, y: &Vertex<'s>, mut branch: Branch<'s>, x: &ShadingPoint<'s>) {
        let seen = y.x.normal_towards(y.w_prev);
        let transmits = y.bsdf.receiving_normal(y.w_prev).is_none();
        let lit_from = if transmits && self.sampler.next_1d() >= 0.5 {
            -seen
        } else {
            seen
        };
        branch.lit_from = transmits.then_some(lit_from);
        let missing = self.missing(x, y, lit_from);
        branch
            .walk
            .scale(if transmits { 2.0 * missing } else { missing });
        if self.survive(&mut branch, missing) {
            let few = self.lights.one_in(FEW, self.sampler.next_1d());
            self.smooth_light(y, branch, few, 1);
        }
    }

    /// Roulette for a branch that goes on with `share` of its light, already counted.
    fn survive(&mut self, branch: &mut Branch, share: f32) -> bool {
        let survival = if branch.stage == Stage::AfterX {
            (SURVIVAL * share).min(1.0) * (COMPLEMENTS as f32 / DIRECTIONS as f32)
        } else {
            (weight(&branch.walk) / branch.full).min(MAX_SURVIVAL)
        };
        survival > 0.0 && branch.walk.survive(survival, self.sampler.next_1d())
    }

    /// Adds what surfaces shine by way of specular events from `y` on, of which `share` of the branch's light is reflected by
    /// glossy lobes. Photons would show one by one there. Emitters themselves may be small: photons bring their light.
    fn mirrored(&mut self, mut y: Vertex<'s>, mut branch: Branch<'s>, share: Rgb) {
        let (mut most, mut strength) = (MAX_SURVIVAL, 1.0);
        if branch.stage == Stage::AfterX {
            (most, strength) = (MIRRORED, MIRRORED_EFFORT);
        }
        branch.lit_from = None;
        branch.stage = branch.stage.after(Lobes::SPECULAR);
        branch.walk.tint(share);
        while y.bsdf.lobes().has(Lobes::SPECULAR) && y.segments < MAX_CHAIN {
            if !branch
                .walk
                .scatter(&y, self.sampler.next_bsdf(), Lobes::SPECULAR)
            {
                return;
            }
            let survival = (strength * weight(&branch.walk) / branch.full).min(most);
            if !branch.walk.survive(survival, self.sampler.next_1d()) {
                return;
            }
            (most, strength) = (MAX_SURVIVAL, 1.0);
            match self.next_surface(&mut branch, false) {
                Some(next) => y = next,
                None => return,
            }
            if y.bsdf.lobes().has(Lobes::SMOOTH) {
                let few = self.lights.one_in(FEW, self.sampler.next_1d());
                self.smooth_light(&y, branch.clone(), few, 1);
            }
        }
    }

    /// Follows a branch to the next surface where it must scatter, and adds the emitters that it meets on the way, if they count.
    /// `None`: it ends.
    fn next_surface(
        &mut self,
        branch: &mut Branch<'s>,
        emitters_count: bool,
    ) -> Option<Vertex<'s>> {
        let (scene, limits) = (self.set.scene, self.set.limits);
        loop {
            let walk = &mut branch.walk;
            let (w, found, hit) = match walk.advance() {
                Step::Hidden => return None,
                Step::Escaped(wi) => (wi, found_environment(scene, walk.previous(), wi), None),
                Step::Hit(y) => {
                    let found = found_radiance(scene, walk.previous(), &y.x, y.w_prev);
                    (-y.w_prev, found, Some(y))
                }
            };
            if branch.lit_from.is_some_and(|n| w.dot(n) <= 0.0) {
                return None;
            }
            if emitters_count {
                let radiance = walk.throughput() * found;
                self.add(branch.stage.layer(), radiance);
            }
            let y = hit?;
            branch.reach += INDIRECT_REACH * y.distance;
            if !limits.allow(y.segments + 1) {
                return None;
            }
            if !branch.walk.pass_through(&y, self.sampler.next_1d()) {
                return Some(y);
            }
        }
    }

    /// Share of the light from the given side of `y` that the sum over lights at `x` lacks.
    fn missing(&self, x: &ShadingPoint, y: &Vertex, lit_from: Vec3) -> f32 {
        let set = self.set;
        let spot = Spot::on(set.scene, &y.x, lit_from);
        let owner = set.claims.light(set.scene, &spot);
        set.gather.missing(&set.lights, x, &spot, owner)
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
