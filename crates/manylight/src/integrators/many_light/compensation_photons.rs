//! Compensation of clamping by photons: light of emitters that low-roughness lobes reflect, such as
//! the sun on metal.
//!
//! A photon that was reflected at `y` by non-specular lobes and arrived at `x` is a path that the
//! virtual light at `y` represents, too. Clamping removes a fraction of the light from `y` at `x`.
//! A density estimate at `x`, in which each photon counts by that fraction, restores it. Directions
//! sampled at `x` compensate clamping as well (`compensation.rs`); but they would rarely find what
//! a low-roughness lobe at `y` reflects from an emitter. Both share that light by
//! [`direction_fraction`].
//!
//! The estimate blurs light over its radius. The radius is small beside the area that a light
//! represents, over which the clamped fraction changes.
//!
//! Source: Sriwasansak, Gruson, Hachisuka, "Efficient Energy-Compensated VPLs Using Photon
//! Splatting", I3D 2018. Here a light represents many photons, so that the clamped fraction is that
//! of the light to which a photon at `y` is assigned.

use super::Compensation;
use super::schedule::{GroupContext, LightSubsets};
use crate::arrays::{Fields, Record};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::gather::{Assignment, ClampReceiver, Gather, LightIndex};
use crate::ids::MaterialId;
use crate::lanes::{Color, Float, One, Width};
use crate::maps::density::OnSurface;
use crate::maps::{KdTree, Located};
use crate::math::{UVec2, Vec3};
use crate::particles::{Photon, parent};
use crate::sampling::rng;
use crate::scene::Scene;
use crate::virtual_lights::SurfaceLocation;
use crate::virtual_lights::light_groups::NearestLightsOfGroups;
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// Least direction limit, in 1/sr: see [`direction_limit`]. Diffuse surfaces reflect at most `f
/// cosθ = 1/π`. Measured against no limit: relMSE of 8 passes 7.05 to 0.039 on classroom, where
/// metal in the sun made single bright pixels.
const MIN_DIRECTION_LIMIT: f32 = 1.0;
/// Survival probability of a photon, divided by the clamped fraction of its light at a white
/// surface. A larger factor makes the map larger; with this one, photons that are thinned count
/// with at most an eighth of their flux. At 4 and 16 (2 passes of 128 lights at 72x40, 2 seeds;
/// Kitchen): pictures differ by at most 0.1 % (RMS).
const SURVIVAL_PER_CLAMPED_FRACTION: f32 = 8.0;
/// Least survival probability of a photon: bounds the flux of photons by 32 times their own. At
/// 0.015625 and 0.0625 (2 passes of 128 lights at 72x40, 2 seeds; Kitchen): pictures differ by at
/// most 0.5 % (RMS).
const MIN_SURVIVAL: f32 = 1.0 / 32.0;

/// Direction limit at a vertex `y` that a direction from `x` found, in 1/sr: the largest `f cosθ`
/// of the lobes at `y` up to which directions account for the light of emitters. `f_cos` is `f
/// cosθ` of the lobes at `x` in that direction: low-roughness lobes at `x` find low-roughness lobes
/// at `y`.
pub(super) fn direction_limit(f_cos: Rgb) -> f32 {
    f_cos.max_channel().max(MIN_DIRECTION_LIMIT)
}

/// Fraction of the light of an emitter for which directions account, where the lobes reflect it
/// with `f_cos`, in 1/sr. Photons account for the rest, so that a direction finds no more than
/// `direction_limit` times the arriving radiance.
pub(super) fn direction_fraction(direction_limit: f32, f_cos: Rgb) -> f32 {
    direction_fractions::<One>(direction_limit.into(), f_cos.into()).get()
}

/// [`direction_fraction`] in each lane.
#[inline(always)]
pub(super) fn direction_fractions<S: Width>(
    direction_limit: Float<S>,
    f_cos: Color<S>,
) -> Float<S> {
    (direction_limit / f_cos.max_channel()).min(1.0)
}

/// A photon from an emitter, last reflected by low-roughness, non-specular lobes.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReflectedPhoton {
    pub(super) photon: Photon,
    /// The location of that reflection, `y`.
    pub(super) from: SurfaceLocation,
    /// `f cosθ` of the reflection, in 1/sr.
    pub(super) f_cos: Rgb,
}

/// A reflected photon with the light that represents light from `y`.
#[derive(Clone, Copy, Debug)]
pub(super) struct CompensationPhoton {
    pub(super) reflected: ReflectedPhoton,
    pub(super) assignment: Assignment,
}

impl Record for CompensationPhoton {
    const EMPTY: Self = CompensationPhoton {
        reflected: ReflectedPhoton {
            photon: Photon::EMPTY,
            from: SurfaceLocation {
                p: Vec3::ZERO,
                n: Vec3::ZERO,
                material: MaterialId(0),
            },
            f_cos: Rgb::BLACK,
        },
        assignment: Assignment::Unassigned { area: 0.0 },
    };

    fn fields(&mut self, f: &mut impl Fields) {
        let ReflectedPhoton {
            photon,
            from,
            f_cos,
        } = &mut self.reflected;
        photon.fields(f);
        f.vec3("from_p", &mut from.p);
        f.vec3("from_n", &mut from.n);
        f.word("from_material", &mut from.material.0);
        f.rgb("f_cos", f_cos);
        let (mut light, mut area) = match self.assignment {
            Assignment::Light(light) => (Some(light), 0.0),
            Assignment::Unassigned { area } => (None, area),
        };
        f.light("light", &mut light);
        f.extended("area", &mut area);
        self.assignment = match light {
            None => Assignment::Unassigned { area },
            Some(light) => Assignment::Light(light),
        };
    }
}

impl Located for CompensationPhoton {
    #[inline]
    fn position(&self) -> Vec3 {
        self.reflected.photon.p
    }
}

impl OnSurface for CompensationPhoton {
    #[inline]
    fn normal(&self) -> Vec3 {
        self.reflected.photon.normal()
    }
    #[inline]
    fn wi(&self) -> Vec3 {
        self.reflected.photon.wi()
    }
    #[inline]
    fn depth(&self) -> u32 {
        self.reflected.photon.depth()
    }
}

/// The photons, of a list in path order, that compensate clamping; none without compensation.
pub(super) fn reflected(
    scene: &Scene,
    photons: &[Photon],
    compensation: Compensation,
) -> Vec<ReflectedPhoton> {
    let reflected = |j: usize| {
        let before = &photons[parent(photons, j)?];
        Some(ReflectedPhoton {
            photon: photons[j],
            from: SurfaceLocation::of_photon(before, scene),
            f_cos: low_roughness_reflection(scene, before, -photons[j].wi)?,
        })
    };
    match compensation {
        Compensation::None => Vec::new(),
        Compensation::KolligKeller => {
            let indices = (0..photons.len()).into_par_iter();
            indices.filter_map(reflected).collect()
        }
    }
}

/// `f cosθ` with which a photon was reflected towards the unit vector `wo`, in 1/sr, if its light
/// came from an emitter and photons account for a part of it.
fn low_roughness_reflection(scene: &Scene, photon: &Photon, wo: Vec3) -> Option<Rgb> {
    if photon.origin != Lobes::NONE {
        return None;
    }
    let bsdf = scene.bsdf(&scene.surface_point(photon.at));
    let f_cos = bsdf.f_cos_wi(photon.wi, wo, Lobes::NON_SPECULAR);
    (f_cos.max_channel() > MIN_DIRECTION_LIMIT).then_some(f_cos)
}

/// Assigns the photons to lights. The clamped fraction is that of points that sum the lights of one
/// pixel in the first pass. Photons survive in proportion to it, with their flux divided by the
/// probability.
pub(super) fn assigned(
    cx: &GroupContext,
    reflected: Vec<ReflectedPhoton>,
    (gather, subsets): (&Gather, &LightSubsets),
    lights: &LightIndex,
    nearest: &NearestLightsOfGroups,
) -> KdTree<CompensationPhoton> {
    let scene = cx.scene;
    let subset = subsets.of_pixel(cx.group.passes.start, UVec2::ZERO, 0);
    let assigned = |mut reflected: ReflectedPhoton| {
        let from = reflected.from;
        let group = reflected.photon.group;
        let assignment = lights.assignment(nearest.light(group, scene, &from), from.p);
        let at = ClampReceiver {
            p: reflected.photon.p,
            n: reflected.photon.n,
            u: 0.5,
            lights: subset,
        };
        let white = |w: Vec3| Rgb::splat(FRAC_1_PI * w.dot(at.n).abs());
        let clamped = gather.clamped_fraction(lights, &at, &from, assignment, white);
        let survival = (SURVIVAL_PER_CLAMPED_FRACTION * clamped).clamp(MIN_SURVIVAL, 1.0);
        reflected.photon.flux /= survival;
        let photon = CompensationPhoton {
            reflected,
            assignment,
        };
        (rng::unit(rng::key(at.p.to_array())) < survival).then_some(photon)
    };
    cx.run.stats.time("maps", || {
        KdTree::build_ordered(reflected.into_par_iter().filter_map(assigned).collect())
    })
}
