//! From photon clusters to virtual lights: position, extent, diffuse and glossy emission of each
//! light.

use super::areas::LightAreas;
use super::clusters::PhotonClusters;
use super::depth_limits::DepthFractions;
use super::glossy::{GlossyForm, Profile, ProfileMaker};
use super::light::{Emission, VirtualLight};
use super::moments::{Extent, spread_points};
use super::reflection::{EmissionDomain, Reflection};
use super::select::WEIGHT_FLOOR;
use super::set::{ProfileFlux, VirtualLights};
use crate::bsdf::{Bsdf, ExitTransmittance, Lobes};
use crate::color::Rgb;
use crate::geometry::SurfacePoint;
use crate::math::Vec3;
use crate::particles::Photon;
use crate::sampling::rng::{self, Pcg, mix};
use crate::sampling::systematic::{inclusion_probabilities, systematic};
use crate::scene::{PathLimits, Scene};
use rayon::prelude::*;

/// Number of photons of a cluster that make a glossy profile, for lobes of roughness
/// [`WIDE_ROUGHNESS`] and more. Other photons are drawn for every light and pass, so that the mean
/// over lights converges to all photons. Measured with [`PATHS_OF_NARROW_LOBES`] against a quarter
/// of both, over 24 passes: the variance of virtual lights falls from 0.00029 to 0.00016 of relMSE
/// in the CBox, for 6 % more time.
const PATHS_OF_WIDE_LOBES: usize = 32;
/// Number of photons of a cluster that make a glossy profile, for narrower lobes: each takes less
/// time, and more must overlap for a smooth profile. See [`PATHS_OF_WIDE_LOBES`].
const PATHS_OF_NARROW_LOBES: usize = 64;
/// Roughness below which lobes count as narrow. At 0.15 and 0.6 (2 passes of 128 lights at 72x40, 3
/// seeds; Kitchen, Glossy Room): relMSE +0.5 and 0 %.
const WIDE_ROUGHNESS: f32 = 0.3;
/// Largest ratio `|wi·ns| / |wi·ng|` of a photon in a glossy profile; the flux of photons beyond is
/// reduced to it. The ratio is unbounded where light grazes the geometric surface under a tilted
/// shading normal: a rare photon would make a profile of many times its flux.
/// At 1.4 and 4 (2 passes of 128 lights at 72x40, 6 seeds; Kitchen, Glossy Room, U-Shape): the same
/// picture.
const MAX_TILT: f32 = 2.0;
/// Number of lights that are made at a time: profiles that are not stored yet take memory, too.
const LIGHTS_AT_A_TIME: usize = 4096;
/// Key of the random numbers for points; see [`LightBuilder::numbers`].
const POINT_NUMBERS: u64 = 1;
/// Key of the random numbers for glossy profiles; see [`LightBuilder::numbers`].
const PROFILE_NUMBERS: u64 = 2;

/// The lights of `clusters`. Without a `form`, lights of one light path each (VPLs): light `k` has
/// the flux of its cluster and emits like the photon at its site. With a `form`, Rich-VPLs: each
/// light emits like all photons of its cluster, the diffuse part exactly, the glossy part in that
/// form; a light of one photon is a VPL. Lights for which `is_used` is false have position and flux
/// but no emission.
pub fn build_lights<'s>(
    scene: &'s Scene,
    limits: PathLimits,
    photons: &[Photon],
    clusters: &PhotonClusters,
    form: Option<GlossyForm>,
    is_used: impl Fn(usize) -> bool + Sync,
) -> VirtualLights<'s> {
    let builder = |k: usize| LightBuilder {
        scene,
        photons,
        clusters,
        k,
        site: &photons[clusters.sites()[k].photon as usize],
    };
    let mut set = VirtualLights {
        lights: Vec::with_capacity(clusters.len()),
        reflections: Vec::new(),
        profiles: form.map(GlossyForm::store).unwrap_or_default(),
        depths: DepthFractions::new(photons, clusters, limits),
        areas: LightAreas::new(
            (0..clusters.len()).map(|k| builder(k).site.p).collect(),
            clusters.unassigned_surface(),
        ),
        surfaces: (0..clusters.len()).map(|k| builder(k).site.at).collect(),
        profile_flux: ProfileFlux::default(),
    };
    if form.is_some() {
        let has_profile = |&k: &usize| is_used(k) && builder(k).has_profile();
        let lights = (0..clusters.len()).into_par_iter();
        set.profiles.reserve(lights.filter(has_profile).count());
    }
    let profile_maker = form.map(GlossyForm::maker);
    for first in (0..clusters.len()).step_by(LIGHTS_AT_A_TIME) {
        let batch = first..(first + LIGHTS_AT_A_TIME).min(clusters.len());
        let built: Vec<BuiltLight<'s>> = batch
            .into_par_iter()
            .map(|k| match is_used(k) {
                true => builder(k).build(profile_maker.as_ref()),
                false => builder(k).build_dark(),
            })
            .collect();
        built.into_iter().for_each(|light| push(&mut set, light));
    }
    for (light, area) in set.lights.iter_mut().zip(set.areas.of_lights(clusters)) {
        light.area = area;
    }
    set
}

/// Appends a light to `set` and stores its emission.
fn push<'s>(set: &mut VirtualLights<'s>, built: BuiltLight<'s>) {
    let BuiltLight {
        mut light,
        emission,
    } = built;
    match emission {
        EmissionPart::Reflection(reflection) => {
            set.reflections.push(*reflection);
            light.emission = Emission::Single((set.reflections.len() - 1) as u32);
        }
        EmissionPart::Profile(profile) => {
            add(&mut set.profile_flux.scattered, profile.target, 1.0);
            add(&mut set.profile_flux.emitted, profile.flux, 1.0);
            if let Emission::Rich { glossy, .. } = &mut light.emission {
                *glossy = Some(set.profiles.push(&profile));
            }
        }
        EmissionPart::Diffuse => {}
    }
    set.lights.push(light);
}

/// A light with emission that is not stored in the set yet.
struct BuiltLight<'s> {
    light: VirtualLight<'s>,
    emission: EmissionPart<'s>,
}

/// The part of the emission to store in the set.
enum EmissionPart<'s> {
    /// None: the light has all of its emission, which is diffuse.
    Diffuse,
    /// The glossy part beside the diffuse one.
    Profile(Profile),
    /// All of the emission.
    Reflection(Box<Reflection<'s>>),
}

/// Builds one light.
struct LightBuilder<'s, 'p> {
    scene: &'s Scene,
    photons: &'p [Photon],
    clusters: &'p PhotonClusters,
    /// Index of the cluster and the light.
    k: usize,
    /// The photon at the light's position.
    site: &'p Photon,
}

impl<'s, 'p> LightBuilder<'s, 'p> {
    /// The photons of the cluster with the factors on their flux.
    fn cluster(&self) -> impl ExactSizeIterator<Item = (&'p Photon, f32)> + Clone + use<'s, 'p> {
        let photons = self.photons;
        let cluster = self.clusters.of(self.k);
        cluster.map(move |(j, weight)| (&photons[j as usize], weight))
    }

    /// Whether a rich light has a glossy profile: several photons on a glossy surface.
    fn has_profile(&self) -> bool {
        let glossy = || {
            let bsdf = self.scene.bsdf(&self.scene.surface_point(self.site.at));
            bsdf.lobes().has(Lobes::GLOSSY)
        };
        self.cluster().len() > 1 && glossy()
    }

    /// Incident flux, and the part scattered by diffuse lobes; both in W.
    fn fluxes(&self) -> [[f64; 3]; 2] {
        let (mut flux, mut diffuse) = ([0.0; 3], [0.0; 3]);
        for (photon, weight) in self.cluster() {
            add(&mut flux, photon.flux, f64::from(weight));
            add(&mut diffuse, photon.diffuse_flux, f64::from(weight));
        }
        [flux, diffuse]
    }

    /// The light without emission.
    fn build_dark(&self) -> BuiltLight<'s> {
        let [flux, _] = self.fluxes();
        let site_point = self.scene.surface_point(self.site.at);
        BuiltLight {
            light: self.dark_light(&site_point, rgb(flux)),
            emission: EmissionPart::Diffuse,
        }
    }

    /// The light, rich if there is a `profile_maker` and more than one photon.
    fn build(&self, profile_maker: Option<&ProfileMaker>) -> BuiltLight<'s> {
        let [flux, diffuse] = self.fluxes();
        let profile_maker = profile_maker.filter(|_| self.cluster().len() > 1);
        let site_point = self.scene.surface_point(self.site.at);
        let bsdf = self.scene.bsdf(&site_point);
        let reflection = Reflection {
            wi: self.site.wi,
            flux: rgb(flux),
            bsdf,
        };
        let mut light = self.dark_light(&site_point, rgb(flux));
        light.emission = Emission::Rich {
            diffuse: rgb(diffuse),
            exit: bsdf.exit_transmittance(),
            glossy: None,
        };
        let is_diffuse = bsdf.lobes().and(Lobes::NON_SPECULAR) == Lobes::DIFFUSE;
        let emission = match profile_maker {
            Some(profile_maker) if bsdf.lobes().has(Lobes::GLOSSY) => {
                let profile = self.profile(profile_maker, &light, &bsdf);
                light.one_sided = profile.domain != EmissionDomain::Sphere;
                EmissionPart::Profile(profile)
            }
            Some(_) => EmissionPart::Diffuse,
            // The diffuse reflection of one path has the form of that of many.
            None if is_diffuse => {
                if let Emission::Rich { diffuse, .. } = &mut light.emission {
                    *diffuse = reflection.flux * bsdf.diffuse_weight(self.site.wi);
                }
                EmissionPart::Diffuse
            }
            None => {
                // A reflection about a shading normal other than the geometric one may pass below
                // the surface.
                light.one_sided = light.n == light.ns && bsdf.receiving_normal(light.n).is_some();
                EmissionPart::Reflection(Box::new(reflection))
            }
        };
        BuiltLight { light, emission }
    }

    /// Position, extent and flux of the light, one-sided and without emission.
    fn dark_light(&self, site_point: &SurfacePoint, flux: Rgb) -> VirtualLight<'s> {
        let site = self.site;
        let extent = Extent::of(self.cluster(), site.n);
        let mut point_numbers = self.numbers(POINT_NUMBERS);
        VirtualLight {
            p: site.p,
            points: spread_points(
                self.cluster(),
                &extent,
                [point_numbers.next_f32(), point_numbers.next_f32()],
            ),
            n: site.n,
            ns: lit_side(site_point.frame.n, site_point, site.n),
            radius: extent.radius,
            radius_of_all: extent.radius,
            area: 0.0,
            offset: site_point.offset,
            flux,
            group: site.group,
            one_sided: true,
            emission: Emission::Rich {
                diffuse: Rgb::BLACK,
                exit: ExitTransmittance::Lambert,
                glossy: None,
            },
        }
    }

    /// Random numbers of this light for one purpose. They are keyed by the direction of incidence,
    /// which differs between passes and does not depend on the scene's unit of length.
    fn numbers(&self, purpose: u64) -> Pcg {
        Pcg::new(mix(mix(self.k as u64) ^ purpose) ^ rng::key(self.site.wi.to_array()))
    }

    /// The glossy profile of the cluster.
    fn profile(
        &self,
        profile_maker: &ProfileMaker,
        light: &VirtualLight,
        bsdf: &Bsdf<'s>,
    ) -> Profile {
        let mut rng = self.numbers(PROFILE_NUMBERS);
        let roughness = bsdf.glossy_roughness();
        let count = if roughness < WIDE_ROUGHNESS {
            PATHS_OF_NARROW_LOBES
        } else {
            PATHS_OF_WIDE_LOBES
        };
        let paths = self.light_paths(count, rng.next_f32());
        profile_maker.make(&paths, roughness, light.n, &mut rng)
    }

    /// Draws `count` photons of the cluster in proportion to flux, without bias in their sum, with
    /// the random number `u`. Each keeps its own direction of incidence and scattering function:
    /// with a common position instead, nearby sources would appear in a wrong direction.
    fn light_paths(&self, count: usize, u: f32) -> Vec<Reflection<'s>> {
        let cluster: Vec<(&Photon, f32)> = self.cluster().collect();
        let weights: Vec<f32> = (cluster.iter())
            .map(|(p, w)| p.flux.luminance() * w)
            .collect();
        let probabilities = inclusion_probabilities(&weights, count, WEIGHT_FLOOR);
        systematic(&probabilities, u)
            .into_iter()
            .map(|i| {
                let (photon, weight) = cluster[i];
                let x = self.scene.surface_point(photon.at);
                let tilt = |w: Vec3| (w.dot(x.frame.n) / w.dot(x.ng)).abs();
                let reduction = (MAX_TILT / tilt(photon.wi)).min(1.0);
                Reflection {
                    bsdf: self.scene.bsdf(&x),
                    wi: photon.wi,
                    flux: photon.flux * (reduction * weight / probabilities[i]),
                }
            })
            .collect()
    }
}

/// Adds `flux * scale` to `sum`.
fn add(sum: &mut [f64; 3], flux: Rgb, scale: f64) {
    for (s, f) in sum.iter_mut().zip(flux.to_array()) {
        *s += f64::from(f) * scale;
    }
}

fn rgb(sum: [f64; 3]) -> Rgb {
    Rgb::new(sum[0] as f32, sum[1] as f32, sum[2] as f32)
}

/// The shading normal `ns` of `x`, turned to the side of the geometric normal `n`.
fn lit_side(ns: Vec3, x: &SurfacePoint, n: Vec3) -> Vec3 {
    ns * 1.0f32.copysign(x.ng.dot(n))
}
