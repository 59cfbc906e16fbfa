//! The compensation of the clamp by photons: light that the sum over lights lacks, from photons that bring it.
//!
//! All of it with `--compensation photons`; else directions look for it, and photons bring what is found rarely: light of emitters that narrow
//! lobes reflect, as the sun on metal.
//!
//! A photon that went on from a smooth surface at `z` to `y` is a path that the virtual light at `z` stands for, too. Of the light from `z`,
//! the clamp takes a share away at `x`; a density estimate at `x` gives it back, in which each photon counts by that share.
//! The estimate spreads light over its radius, which is small beside the surface that a light stands for: what the clamp takes
//! changes little over it.
//!
//! Source: Sriwasansak, Gruson, Hachisuka, "Efficient Energy-Compensated VPLs Using Photon Splatting", I3D 2018; here for lights that
//! stand for many photons, so that the clamp asks whose a photon at `z` is.

use super::eye_path::GatherPoint;
use super::light_set::{Compensation, PreparedPasses};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::gather::{Assignment, Gather, LightIndex, Subset, Viewpoint};
use crate::maps::{KdTree, Located, Neighbors};
use crate::math::Vec3;
use crate::particles::{Photon, parent};
use crate::sampling::rng;
use crate::scene::Scene;
use crate::virtual_lights::{NearestLights, SurfaceLocation};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// Neighbors in an estimate.
pub(super) const CARRIED_NEIGHBORS: usize = 48;

/// What a surface reflects by a greater `f cosθ` than this is narrow, in 1/sr. Diffuse surfaces stay below `1/π`.
const BROAD: f32 = 1.0;

/// Up to which `f cosθ` at `y`, in 1/sr, directions from `x` bring all that `y` reflects from emitters, if `f_cos` is that at `x`: narrow
/// lobes at `x` find narrow lobes at `y`.
pub(super) fn broad(f_cos: Rgb) -> f32 {
    f_cos.max_channel().max(BROAD)
}

/// Of the light of an emitter that `y` reflects with `f_cos`, the share that belongs to directions; the rest is that of photons.
/// So directions find no more than `broad` times what arrives.
pub(super) fn share_of_directions(broad: f32, f_cos: Rgb) -> f32 {
    (broad / f_cos.max_channel()).min(1.0)
}

/// Photons are kept with so many times the share of their light that the clamp takes at a white surface where they are,
const EFFORT: f32 = 8.0;
/// but one in so many of them at least.
const LEAST_CHANCE: f32 = 1.0 / 32.0;

/// A photon that came from a smooth surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReflectedPhoton {
    photon: Photon,
    /// Where it came from.
    from: SurfaceLocation,
    /// `f cosθ` with which that surface reflected light of an emitter, in 1/sr; infinite where directions bring nothing.
    f_cos: Rgb,
}

/// The same, with the light that stands for light from where it came.
#[derive(Clone, Copy, Debug)]
pub(super) struct CompensationPhoton {
    reflected: ReflectedPhoton,
    owner: Assignment,
}

impl Located for CompensationPhoton {
    #[inline]
    fn position(&self) -> Vec3 {
        self.reflected.photon.p
    }
}

impl AsRef<Photon> for CompensationPhoton {
    fn as_ref(&self) -> &Photon {
        &self.reflected.photon
    }
}

/// The photons among `photons`, in path order, that bring some of what the clamp takes.
pub(super) fn carried(
    scene: &Scene,
    photons: &[Photon],
    compensation: Compensation,
) -> Vec<ReflectedPhoton> {
    let of = |j: usize| {
        let before = &photons[parent(photons, j)?];
        let f_cos = match compensation {
            Compensation::None => return None,
            Compensation::KolligKeller => narrow(scene, before, -photons[j].wi)?,
        };
        Some(ReflectedPhoton {
            photon: photons[j],
            from: SurfaceLocation::of_photon(before, scene),
            f_cos,
        })
    };
    (0..photons.len()).into_par_iter().filter_map(of).collect()
}

/// `f cosθ` with which a photon was reflected towards `wo`, if it came from an emitter and directions do not bring all of that.
fn narrow(scene: &Scene, photon: &Photon, wo: Vec3) -> Option<Rgb> {
    if photon.origin != Lobes::NONE {
        return None;
    }
    let bsdf = scene.bsdf(&scene.surface_point(photon.at));
    let f_cos = bsdf.f_cos_wi(photon.wi, wo, Lobes::NON_SPECULAR);
    (f_cos.max_channel() > BROAD).then_some(f_cos)
}

/// The photons with their owners, ready to be asked for. Far from where they come from the clamp takes little: there, few stand for many.
pub(super) fn owned(
    scene: &Scene,
    gather: &Gather,
    lights: &LightIndex,
    claims: &NearestLights,
    selection: Subset,
    reflected: Vec<ReflectedPhoton>,
) -> KdTree<CompensationPhoton> {
    let own = |mut reflected: ReflectedPhoton| {
        let owner = lights.owner(claims.light(scene, &reflected.from), &reflected.from);
        let at = Viewpoint {
            p: reflected.photon.p,
            n: reflected.photon.n,
            u: 0.5,
            lights: selection,
        };
        let white = |w: Vec3| Rgb::splat(FRAC_1_PI * w.dot(at.n).abs());
        let missing = gather.missing(lights, &at, &reflected.from, owner, white);
        let chance = (EFFORT * missing).clamp(LEAST_CHANCE, 1.0);
        reflected.photon.flux /= chance;
        (rng::unit(rng::key(at.p.to_array())) < chance)
            .then_some(CompensationPhoton { reflected, owner })
    };
    KdTree::build_ordered(reflected.into_par_iter().filter_map(own).collect())
}

impl PreparedPasses<'_> {
    /// What photons bring of the light that the clamp takes away at a gathering point.
    pub(super) fn carried_radiance(&self, point: &GatherPoint, found: &mut Neighbors) -> Rgb {
        let at = &point.at;
        self.density_estimate(
            &self.carried,
            point,
            found,
            |carried: &CompensationPhoton| {
                let CompensationPhoton { reflected, owner } = *carried;
                let wi = reflected.photon.wi;
                let broad = broad(at.bsdf.f_cos_wi(wi, at.wo, Lobes::NON_SPECULAR));
                let share = 1.0 - share_of_directions(broad, reflected.f_cos);
                if share == 0.0 {
                    return Rgb::BLACK;
                }
                let (gather, lights) = (&self.gather, &self.lights);
                let missing = gather.missing(lights, &at.into(), &reflected.from, owner, |w| {
                    at.bsdf.f_cos_wi(w, at.wo, Lobes::NON_SPECULAR)
                });
                at.bsdf.f(wi, at.wo, Lobes::NON_SPECULAR) * (share * missing)
            },
        )
    }
}
