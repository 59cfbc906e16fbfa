//! Light on smooth lobes at a point of an eye path: emitters, the sum over lights, and what the sum lacks.
//!
//! Some light is looked for by directions from the point `x`, drawn from its smooth lobes and from where photons of emitters beyond
//! the scene arrive. Where one runs into an emitter, it is the other half of direct light. Where it meets a surface at `y`, it may go on as **the compensation of the clamp**: the sum over
//! virtual lights at `x` keeps a share of the light that the smooth lobes at `y` reflect towards `x`, and the clamp takes the rest
//! away. So the direction goes on with the probability of what the clamp takes away from a photon at `y`, and everything that
//! lights `y` is looked up there: emitters, caustic photons, and virtual lights, whose sum is clamped and completed in the same
//! way. What `y` emits by itself is direct light at `x`.
//!
//! Of what narrow lobes at `y` reflect from emitters, directions would rarely find a lot: photons bring it (`carried.rs`).
//!
//! Where a glossy lobe at `x` meets a specular surface, the direction also goes on by specular events, and the method starts again
//! at the surface behind: photons that come from there are counted by diffuse lobes alone.
//!
//! Source: Kollig, Keller, "Illumination in the Presence of Weak Singularities", MCQMC 2004; here for lights that stand for
//! many photons, so that the clamp asks whose a photon at `y` would be.

use super::carried::{broad, share_of_directions};
use super::eye_path::{CameraPath, GatherPoint, MAX_CHAIN, PixelNumbers, weight};
use super::guided::{draw_direction, guide_at, guided_pdf};
use super::light_set::Compensation;
use super::partition::Stage;
use crate::bsdf::{BsdfNumbers, BsdfSample, Lobes};
use crate::color::Rgb;
use crate::gather::{Assignment, ShadingPoint, Subset};
use crate::maps::IncidentGuide;
use crate::math::Vec3;
use crate::sampling::{Sampler, Spread};
use crate::transport::direct::{EmitterPlan, emitted_with_mis, environment_with_mis};
use crate::transport::{Step, Vertex, Walk};
use crate::virtual_lights::SurfaceLocation;

/// Directions drawn where the eye paths of a pixel end, and samples of emitters there: cheap beside the sum over all lights,
/// and without them their noise would show.
pub(super) const DIRECTIONS: u32 = 16;
/// Of the directions, so many may go on by specular events: they find bright things in narrow lobes.
const MIRRORED: f32 = 0.5;
/// Each with this many times the share of light that it stands for, at most that.
const MIRRORED_EFFORT: f32 = 16.0;
/// The first vertex after a gathering point goes on with the share of light that it stands for as its probability; vertices after
/// that with at most this.
const MAX_SURVIVAL: f32 = 0.95;
/// Whose a surface is takes a search. So first a share is guessed: as if its light stood for so many times the surface of those around the gathering
/// point; the roulette for that goes on with one in so many at least.
const ASKED_SURFACE: f32 = 16.0;
const LEAST_ASKED: f32 = 1.0 / 8.0;
/// The surface of those around takes a search of its own, which pays for so many directions.
const ASKING_DIRECTIONS: u32 = 4;
/// Caustics that are seen by way of a smooth surface may be blurred by this angle more.
const INDIRECT_REACH: f32 = 0.02;

/// A path that looks for light beyond a gathering point.
#[derive(Clone)]
pub(super) struct Branch<'s> {
    pub(super) walk: Walk<'s>,
    pub(super) stage: Stage,
    /// If given, only light from the side of this normal counts at its end.
    pub(super) lit_from: Option<Vec3>,
    /// Weight of the compensations of its eye path.
    pub(super) full: f32,
    /// Largest radius of a caustic estimate at its end, in m.
    pub(super) reach: f32,
    /// Of the light that emitters send to its end, photons bring what is reflected by more than this `f cosθ`, in 1/sr; see
    /// [`share_of_directions`]. Infinite if the branch stands for all of it.
    pub(super) broad: f32,
    /// On the way to a surface: share of the branch that counts for emitters found.
    pub(super) found: f32,
    /// See [`GatherPoint::photons`].
    pub(super) photons: f32,
}

/// Directions that look for light at a gathering point.
pub(super) struct Directions {
    count: u32,
    /// Numbers for emitters and for lobes are those from this index on.
    first: u32,
    emitters: Spread,
    lobes: Spread,
}

impl Directions {
    /// Those of part `index` of a pixel, each of which has `count`.
    pub(super) fn of_part(index: u32, count: u32, numbers: PixelNumbers) -> Self {
        Directions {
            count,
            first: index * count,
            emitters: numbers.emitters,
            lobes: numbers.directions,
        }
    }

    fn one(sampler: &mut Sampler) -> Self {
        Directions {
            count: 1,
            first: 0,
            emitters: sampler.next_spread(),
            lobes: sampler.next_spread(),
        }
    }
}

/// A gathering point with a direction drawn there.
struct DrawnDirection<'x, 's> {
    x: &'x ShadingPoint<'s>,
    /// `f cosθ` of its smooth lobes in that direction, in 1/sr.
    f_cos: Rgb,
    /// Surface that lights around may stand for, if the share of the compensation is to be guessed by it, in m².
    surface: Option<f32>,
}

impl<'s> CameraPath<'_, 's, '_, '_> {
    /// Everything that the smooth lobes at the end `v` of a branch reflect: emitters and what lacks in the sum over lights, looked
    /// for in some directions, and that sum.
    pub(super) fn smooth_light(
        &mut self,
        v: &Vertex<'s>,
        mut branch: Branch<'s>,
        lights: Subset,
        directions: &Directions,
    ) {
        let at = self.gather_at(v, &branch, lights);
        let completes = self.set.compensation == Compensation::KolligKeller;
        let surface = (completes && directions.count >= ASKING_DIRECTIONS)
            .then(|| ASKED_SURFACE * self.surface_per_light(at.x.p));
        let guide = guide_at(&self.set.incident, v, &mut self.paths.found);
        branch.walk.scale(1.0 / directions.count as f32);
        for i in 0..directions.count {
            let (u_choice, u) = directions.emitters.triple(directions.first + i);
            let plan = EmitterPlan::new(self.set.scene, u_choice, u);
            self.emitters_at(v, &branch, guide.as_ref(), &plan);
            let (lobe, direction) = directions.lobes.triple(directions.first + i);
            let u = (i as f32 + self.sampler.next_1d()) / directions.count as f32;
            let sample = draw_direction(
                v,
                guide.as_ref(),
                Lobes::NON_SPECULAR,
                BsdfNumbers { lobe, direction },
                u,
            );
            self.follow_smooth(v, sample, branch.clone(), &at, surface);
        }
    }

    /// Light from emitters that smooth lobes reflect at the end `v` of a branch; directions drawn there are the other half of it.
    fn emitters_at(
        &mut self,
        v: &Vertex,
        branch: &Branch,
        guide: Option<&IncidentGuide>,
        plan: &EmitterPlan,
    ) {
        let pdf_walk = |wi| guided_pdf(v, guide, Lobes::NON_SPECULAR, wi);
        if let Some(radiance) =
            self.emitter_light(v, Lobes::NON_SPECULAR, Some(branch), plan, pdf_walk)
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
        lights: Subset,
    ) -> ShadingPoint<'s> {
        let limits = self.set.limits;
        let at = ShadingPoint {
            x: v.x,
            wo: v.w_prev,
            bsdf: v.bsdf,
            max_photon_depth: limits.max_depth.map(|max| max - (v.segments + 1)),
            u: self.sampler.next_1d(),
            lights,
            tolerance: 0.0,
            lit_from: branch.lit_from,
        };
        self.paths.points.push(GatherPoint {
            pixel: self.pixel,
            throughput: branch.walk.throughput(),
            segments: v.segments,
            at,
            stage: branch.stage,
            reach: branch.reach,
            broad: branch.broad,
            photons: branch.photons,
        });
        at
    }

    /// Goes on from the gathering point `x` on `v` in a direction drawn there: adds the emitter there, or the compensation of the
    /// sum at `x`, around which lights may stand for so much `surface`.
    fn follow_smooth(
        &mut self,
        v: &Vertex<'s>,
        sample: Option<BsdfSample>,
        mut branch: Branch<'s>,
        x: &ShadingPoint<'s>,
        surface: Option<f32>,
    ) {
        let Some(wi) = sample.map(|sample| sample.w) else {
            return;
        };
        if !branch.walk.follow(v, sample) {
            return;
        }
        branch.stage = branch.stage.after(Lobes::DIFFUSE);
        branch.photons = 1.0;
        let f_cos = v.bsdf.f_cos_wi(wi, v.w_prev, Lobes::NON_SPECULAR);
        branch.found = share_of_directions(branch.broad, f_cos);
        let Some(y) = self.next_surface(&mut branch) else {
            return;
        };
        if v.bsdf.lobes().has(Lobes::GLOSSY) && y.bsdf.lobes().has(Lobes::SPECULAR) {
            let of = |lobes| v.bsdf.f(wi, v.w_prev, lobes);
            let share = of(Lobes::GLOSSY).zip(of(Lobes::NON_SPECULAR), |part, all| {
                if all > 0.0 { part / all } else { 0.0 }
            });
            self.mirrored(y.clone(), branch.clone(), share);
        }
        if y.bsdf.lobes().has(Lobes::NON_SPECULAR)
            && self.set.compensation == Compensation::KolligKeller
        {
            branch.broad = broad(f_cos);
            let from = DrawnDirection { x, f_cos, surface };
            self.compensation(&y, branch, &from);
        }
    }

    /// What the sum over lights at `x` lacks of the light that the smooth lobes at `y` reflect into the branch. A surface that
    /// transmits is lit from both sides, and one is chosen: the lights of each side are others, and the clamp with them.
    fn compensation(
        &mut self,
        y: &Vertex<'s>,
        mut branch: Branch<'s>,
        from: &DrawnDirection<'_, 's>,
    ) {
        let seen = y.x.normal_towards(y.w_prev);
        let transmits = y.bsdf.receiving_normal(y.w_prev).is_none();
        let lit_from = if transmits && self.sampler.next_1d() >= 0.5 {
            -seen
        } else {
            seen
        };
        branch.lit_from = transmits.then_some(lit_from);
        let spot = SurfaceLocation::on_surface(self.set.scene, &y.x, lit_from);
        let asked = from.surface.map_or(1.0, |area| {
            let likely = self.missing(from, &spot, Assignment::Unassigned { area });
            likely.clamp(LEAST_ASKED, 1.0)
        });
        if asked < 1.0 && !branch.walk.survive(asked, self.sampler.next_1d()) {
            return;
        }
        let set = self.set;
        let owner = (set.lights).owner(set.claims.light(set.scene, &spot), &spot);
        let missing = self.missing(from, &spot, owner);
        branch
            .walk
            .scale(if transmits { 2.0 * missing } else { missing });
        if self.survive(&mut branch, missing / asked) {
            let (few, direction) = (self.few_lights(), Directions::one(self.sampler));
            self.smooth_light(y, branch, few, &direction);
        }
    }

    /// Roulette for a branch that goes on with `share` of the light that it stood for, already counted.
    fn survive(&mut self, branch: &mut Branch, share: f32) -> bool {
        let survival = if branch.stage == Stage::AfterX {
            share.min(1.0)
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
        branch.broad = f32::INFINITY;
        branch.stage = branch.stage.after(Lobes::SPECULAR);
        branch.walk.scale(share);
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
            match self.next_surface(&mut branch) {
                Some(next) => y = next,
                None => return,
            }
            if y.bsdf.lobes().has(Lobes::NON_SPECULAR) {
                let (few, direction) = (self.few_lights(), Directions::one(self.sampler));
                self.smooth_light(&y, branch.clone(), few, &direction);
            }
        }
    }

    /// Follows a branch to the next surface where it must scatter, and adds the emitters that it meets on the way. `None`: it ends.
    fn next_surface(&mut self, branch: &mut Branch<'s>) -> Option<Vertex<'s>> {
        let (scene, limits) = (self.set.scene, self.set.limits);
        loop {
            let walk = &mut branch.walk;
            let (w, found, hit) = match walk.advance() {
                Step::Hidden => return None,
                Step::Escaped(wi) => {
                    let found = environment_with_mis(scene, walk.previous(), wi);
                    (wi, found, None)
                }
                Step::Hit(y) => {
                    let found = emitted_with_mis(scene, walk.previous(), &y.x, y.w_prev);
                    (-y.w_prev, found, Some(y))
                }
            };
            if branch.lit_from.is_some_and(|n| w.dot(n) <= 0.0) {
                return None;
            }
            // Photons bring what emitters send by way of specular events.
            if !walk.previous().event.has(Lobes::SPECULAR) {
                let radiance = walk.throughput() * (found * branch.found);
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

    /// Share of the light from `y`, which is `owner`'s, that the sum over lights lacks where a direction came `from`.
    fn missing(&self, from: &DrawnDirection, y: &SurfaceLocation, owner: Assignment) -> f32 {
        let set = self.set;
        (set.gather).missing(&set.lights, &from.x.into(), y, owner, |_| from.f_cos)
    }
}
