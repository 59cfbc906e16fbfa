//! All virtual lights of a pass, ready to be gathered.

use super::glossy::{Glossy, Profile, ProfileMaker, Profiles};
use super::moments::{Extent, spread_points};
use super::sources::{Range, Source};
use super::{Emission, GlossyForm, PhotonClusters, Reflection, Site, VirtualLight};
use crate::bsdf::{Bsdf, ExitTransmittance, Lobes};
use crate::color::Rgb;
use crate::geometry::SurfacePoint;
use crate::ids::LightId;
use crate::maps::{KdTree, Neighbors};
use crate::math::Vec3;
use crate::particles::Photon;
use crate::sampling::rng::{self, Pcg, mix};
use crate::sampling::systematic::{inclusion_probabilities, systematic};
use crate::scene::{PathLimits, Scene};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Photons whose lobes a glossy part shows, when those are wide. Every light and every pass draws others.
const WIDE_SOURCES: usize = 8;
/// And when they are narrow: such lobes take less time, and more of them must meet to be smooth.
const NARROW_SOURCES: usize = 16;
/// Roughness between the two.
const NARROW: f32 = 0.3;
/// Path lengths told apart by [`VirtualLights::share_up_to`]; longer limits are treated as none.
const DEPTHS: usize = 16;
/// Bound of `|wi·ns| / |wi·ng|` in glossy parts. The ratio has no bound where light grazes the geometric surface under a tilted
/// shading normal: rare photons would make parts of many times the flux that fell on them.
const MAX_TILT: f32 = 2.0;
/// Lights that are made at a time: profiles on their way into the field take memory, too.
const BATCH: usize = 4096;
/// Purposes of random numbers.
const POINT_NUMBERS: u64 = 1;
const PROFILE_NUMBERS: u64 = 2;
/// Neighbors that tell the surface per light; the light itself is among them.
const AREA_NEIGHBORS: usize = 9;

/// All virtual lights of one pass with their profiles: those that reflect, sorted along a space-filling curve, then those on emitters.
#[derive(Debug)]
pub struct VirtualLights<'s> {
    lights: Vec<VirtualLight<'s>>,
    reflections: Vec<Reflection<'s>>,
    /// Glossy radiant intensity in W/sr, cosine included.
    profiles: Profiles,
    /// For each light the shares of its flux from photons of depth 1, up to 2, up to 3, ...; empty without a limit.
    shares_by_depth: Vec<[f32; DEPTHS]>,
    /// Where the lights stand.
    places: KdTree<Vec3>,
    /// See [`PhotonClusters::stray_surface`].
    stray_surface: f32,
    energy: EnergyAccount,
}

/// Where the flux of a pass went. W per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyAccount {
    /// All photons.
    pub photons: [f64; 3],
    /// What the lights represent.
    pub lights: [f64; 3],
    /// Photons that no light took, before they were thinned.
    pub residual: [f64; 3],
    /// Flux that the glossy parts should hold.
    pub reflected: [f64; 3],
    /// Flux that they hold.
    pub glossy: [f64; 3],
}

fn add(sum: &mut [f64; 3], flux: Rgb, scale: f64) {
    for (s, f) in sum.iter_mut().zip(flux.to_array()) {
        *s += f64::from(f) * scale;
    }
}

fn rgb(sum: [f64; 3]) -> Rgb {
    Rgb::new(sum[0] as f32, sum[1] as f32, sum[2] as f32)
}

impl<'s> VirtualLights<'s> {
    /// Plain VPLs: each site shines as its one photon, with flux `Φ / probability`.
    pub fn plain(scene: &'s Scene, limits: PathLimits, photons: &[Photon], sites: &[Site]) -> Self {
        VirtualLights::single(scene, limits, photons, &PhotonClusters::own(sites))
    }

    /// Each light shines as the photon that it stands on, with the flux of its share.
    pub fn single(
        scene: &'s Scene,
        limits: PathLimits,
        photons: &[Photon],
        shares: &PhotonClusters,
    ) -> Self {
        VirtualLights::build(scene, limits, photons, shares, None, |_| true)
    }

    /// Rich-VPLs: each light shines as all photons of its share, the diffuse part exactly, the glossy part as `form`
    /// says. A light of one photon shines as that.
    pub fn rich(
        scene: &'s Scene,
        limits: PathLimits,
        photons: &[Photon],
        shares: &PhotonClusters,
        form: GlossyForm,
    ) -> Self {
        VirtualLights::build(scene, limits, photons, shares, Some(form), |_| true)
    }

    /// Lights with glossy parts as `form` says, or single ones. Lights that `is_used` denies have their places, but shine nothing.
    pub fn build(
        scene: &'s Scene,
        limits: PathLimits,
        photons: &[Photon],
        shares: &PhotonClusters,
        form: Option<GlossyForm>,
        is_used: impl Fn(usize) -> bool + Sync,
    ) -> Self {
        let profile_maker = form.map(GlossyForm::maker);
        let mut field = VirtualLights {
            lights: Vec::with_capacity(shares.len()),
            reflections: Vec::new(),
            profiles: form.map(GlossyForm::store).unwrap_or_default(),
            shares_by_depth: Vec::new(),
            places: KdTree::build(Vec::new()),
            stray_surface: shares.stray_surface(),
            energy: EnergyAccount {
                residual: shares.residual(),
                ..EnergyAccount::default()
            },
        };
        for photon in photons {
            add(&mut field.energy.photons, photon.flux, 1.0);
        }
        let maker = |k: usize| Maker {
            scene,
            photons,
            shares,
            k,
            site: &photons[shares.sites()[k].photon as usize],
        };
        if form.is_some() {
            let has_profile = |&k: &usize| is_used(k) && maker(k).has_profile();
            let lights = (0..shares.len()).into_par_iter();
            field.profiles.reserve(lights.filter(has_profile).count());
        }
        for first in (0..shares.len()).step_by(BATCH) {
            let batch = first..(first + BATCH).min(shares.len());
            let made: Vec<Made<'s>> = batch
                .into_par_iter()
                .map(|k| {
                    if is_used(k) {
                        maker(k).make(profile_maker.as_ref())
                    } else {
                        maker(k).dark()
                    }
                })
                .collect();
            for light in made {
                field.push(light);
            }
        }
        if limits.max_depth.is_some_and(|max| max as usize <= DEPTHS) {
            let shares = (0..shares.len())
                .into_par_iter()
                .map(|k| shares_by_depth(photons, shares.of(k)));
            field.shares_by_depth = shares.collect();
        }
        field.measure_areas(shares);
        field
    }

    fn push(&mut self, made: Made<'s>) {
        let Made {
            mut light,
            flux,
            shines,
        } = made;
        for (sum, f) in self.energy.lights.iter_mut().zip(flux) {
            *sum += f;
        }
        match shines {
            EmissionPart::Reflection(reflection) => {
                self.reflections.push(*reflection);
                light.emission = Emission::Single((self.reflections.len() - 1) as u32);
            }
            EmissionPart::Profile(profile) => {
                add(&mut self.energy.reflected, profile.target, 1.0);
                add(&mut self.energy.glossy, profile.flux, 1.0);
                if let Emission::Rich { glossy, .. } = &mut light.emission {
                    *glossy = Some(self.profiles.push(&profile));
                }
            }
            EmissionPart::Diffuse => {}
        }
        self.lights.push(light);
    }

    fn measure_areas(&mut self, shares: &PhotonClusters) {
        self.places = KdTree::build(
            self.lights
                .iter()
                .map(|light| light.p)
                .collect::<Vec<Vec3>>(),
        );
        let areas: Vec<f32> = self
            .lights
            .par_iter()
            .map_init(
                || Neighbors::new(AREA_NEIGHBORS),
                // The light itself is the nearest.
                |found, light| self.area_per_light(light.p, 1, found),
            )
            .collect();
        for (k, (light, area)) in self.lights.iter_mut().zip(areas).enumerate() {
            light.area = area * shares.surface(k);
        }
    }

    /// Surface in m² that a light would speak for if a photon at `p`, which no light takes, had become one.
    pub fn stray_area(&self, p: Vec3) -> f32 {
        self.stray_surface * self.surface_per_light(p)
    }

    /// Surface in m² for each of the lights around `p`.
    pub fn surface_per_light(&self, p: Vec3) -> f32 {
        self.area_per_light(p, 0, &mut Neighbors::new(AREA_NEIGHBORS - 1))
    }

    /// Median of the surface that lights stand for, in m²; 0 without lights.
    pub fn median_area(&self) -> f32 {
        let mut areas: Vec<f32> = self.lights.iter().map(|light| light.area).collect();
        let middle = areas.len() / 2;
        areas.sort_unstable_by(f32::total_cmp);
        areas.get(middle).copied().unwrap_or(0.0)
    }

    /// The disc that reaches to the last neighbor over the number of lights in it, the first `own` of which stand at `p`.
    fn area_per_light(&self, p: Vec3, own: usize, found: &mut Neighbors) -> f32 {
        self.places.nearest(p, f32::INFINITY, found);
        let others = (found.len() as f32 - own as f32).max(1.0);
        PI * found.radius_squared() / others
    }

    /// The lights.
    pub fn lights(&self) -> &[VirtualLight<'s>] {
        &self.lights
    }

    /// The one light path with the given index.
    #[inline(always)]
    pub(crate) fn reflection(&self, index: u32) -> &Reflection<'s> {
        &self.reflections[index as usize]
    }

    /// The glossy part with the given index.
    #[inline(always)]
    pub(super) fn glossy(&self, index: u32) -> Glossy<'_> {
        self.profiles.get(index)
    }

    /// Share of the flux of light `id` that has come over at most `depth` segments: all of an emitter's. Only told apart in scenes that
    /// limit paths to no more than 16 segments; elsewhere, and for greater depths, 1.
    #[inline]
    pub fn share_up_to(&self, id: LightId, depth: u32) -> f32 {
        if depth == 0 {
            return 0.0;
        }
        let shares = self.shares_by_depth.get(id.index());
        shares
            .and_then(|shares| shares.get(depth as usize - 1))
            .copied()
            .unwrap_or(1.0)
    }

    /// Where the flux went.
    pub fn energy(&self) -> &EnergyAccount {
        &self.energy
    }

    /// Bytes of a light on average, where a share `glossy` of them has a glossy part of `form`, or emits as single photons.
    pub fn bytes_per_light(form: Option<GlossyForm>, glossy: f64, limits: PathLimits) -> f64 {
        let depths = if limits.max_depth.is_some() {
            size_of::<[f32; DEPTHS]>()
        } else {
            0
        };
        let all = size_of::<VirtualLight>() + size_of::<Vec3>() + size_of::<u32>() + depths;
        let of_glossy = form.map_or(size_of::<Reflection>(), GlossyForm::bytes);
        all as f64 + glossy * of_glossy as f64
    }

    /// Bytes of lights and what they shine.
    pub fn bytes(&self) -> usize {
        size_of_val(self.lights.as_slice())
            + size_of_val(self.reflections.as_slice())
            + self.profiles.bytes()
            + size_of_val(self.shares_by_depth.as_slice())
    }
}

/// A light on its way into the field.
struct Made<'s> {
    light: VirtualLight<'s>,
    /// In full precision, for the ledger.
    flux: [f64; 3],
    shines: EmissionPart<'s>,
}

/// What a light shines beside its diffuse part.
enum EmissionPart<'s> {
    Diffuse,
    Profile(Profile),
    /// All of what it shines.
    Reflection(Box<Reflection<'s>>),
}

/// Makes one light.
struct Maker<'s, 'p> {
    scene: &'s Scene,
    photons: &'p [Photon],
    shares: &'p PhotonClusters,
    k: usize,
    site: &'p Photon,
}

impl<'s, 'p> Maker<'s, 'p> {
    /// The photons of the light, with the factors on their flux.
    fn own(&self) -> impl ExactSizeIterator<Item = (&'p Photon, f32)> + Clone + use<'s, 'p> {
        let photons = self.photons;
        let share = self.shares.of(self.k);
        share.map(move |(j, weight)| (&photons[j as usize], weight))
    }

    /// Whether there is a glossy part that one photon does not tell.
    fn has_profile(&self) -> bool {
        let glossy = || {
            let bsdf = self.scene.bsdf(&self.scene.surface_point(self.site.at));
            bsdf.lobes().has(Lobes::GLOSSY)
        };
        self.own().len() > 1 && glossy()
    }

    /// Flux, and what of it the diffuse lobes send out; in W.
    fn fluxes(&self) -> [[f64; 3]; 2] {
        let (mut flux, mut diffuse) = ([0.0; 3], [0.0; 3]);
        for (photon, weight) in self.own() {
            add(&mut flux, photon.flux, f64::from(weight));
            add(&mut diffuse, photon.diffuse_flux, f64::from(weight));
        }
        [flux, diffuse]
    }

    /// The light's place and flux alone.
    fn dark(&self) -> Made<'s> {
        let [flux, _] = self.fluxes();
        let site_point = self.scene.surface_point(self.site.at);
        Made {
            light: self.place(&site_point, rgb(flux)),
            flux,
            shines: EmissionPart::Diffuse,
        }
    }

    fn make(&self, profile_maker: Option<&ProfileMaker>) -> Made<'s> {
        let [flux, diffuse] = self.fluxes();
        let profile_maker = profile_maker.filter(|_| self.own().len() > 1);
        let site_point = self.scene.surface_point(self.site.at);
        let bsdf = self.scene.bsdf(&site_point);
        let reflection = Reflection {
            wi: self.site.wi,
            flux: rgb(flux),
            bsdf,
        };
        let mut light = self.place(&site_point, rgb(flux));
        light.emission = Emission::Rich {
            diffuse: rgb(diffuse),
            exit: bsdf.exit_transmittance(),
            glossy: None,
        };
        let is_diffuse = bsdf.lobes().and(Lobes::NON_SPECULAR) == Lobes::DIFFUSE;
        let shines = match profile_maker {
            Some(profile_maker) if bsdf.lobes().has(Lobes::GLOSSY) => {
                let profile = self.profile(profile_maker, &light, &bsdf);
                light.one_sided = profile.range != Range::Sphere;
                EmissionPart::Profile(profile)
            }
            Some(_) => EmissionPart::Diffuse,
            // One reflection off a diffuse surface has the form of many.
            None if is_diffuse => {
                if let Emission::Rich { diffuse, .. } = &mut light.emission {
                    *diffuse = reflection.flux * bsdf.diffuse_weight(self.site.wi);
                }
                EmissionPart::Diffuse
            }
            None => {
                // A single reflection under a shading normal that is not the geometric one may pass below the surface.
                light.one_sided = light.n == light.ns && bsdf.receiving_normal(light.n).is_some();
                EmissionPart::Reflection(Box::new(reflection))
            }
        };
        Made {
            light,
            flux,
            shines,
        }
    }

    /// The light's place and extent; a black one on one side.
    fn place(&self, site_point: &SurfacePoint, flux: Rgb) -> VirtualLight<'s> {
        let site = self.site;
        let extent = Extent::of(self.own(), site.n);
        let mut point_numbers = self.numbers(POINT_NUMBERS);
        VirtualLight {
            p: site.p,
            points: spread_points(
                self.own(),
                &extent,
                [point_numbers.next_f32(), point_numbers.next_f32()],
            ),
            n: site.n,
            ns: lit_side(site_point.frame.n, site_point, site.n),
            radius: extent.radius,
            area: 0.0,
            offset: site_point.offset,
            flux,
            one_sided: true,
            emission: Emission::Rich {
                diffuse: Rgb::BLACK,
                exit: ExitTransmittance::Lambert,
                glossy: None,
            },
        }
    }

    /// Random numbers of this light for one purpose. The direction of incidence names them: it differs in every pass, and not
    /// with the scene's unit of length.
    fn numbers(&self, purpose: u64) -> Pcg {
        Pcg::new(mix(mix(self.k as u64) ^ purpose) ^ rng::key(self.site.wi.to_array()))
    }

    fn profile(
        &self,
        profile_maker: &ProfileMaker,
        light: &VirtualLight,
        bsdf: &Bsdf<'s>,
    ) -> Profile {
        let mut rng = self.numbers(PROFILE_NUMBERS);
        let width = bsdf.glossy_width();
        let count = if width < NARROW {
            NARROW_SOURCES
        } else {
            WIDE_SOURCES
        };
        let sources = self.sources(count, rng.next_f32());
        profile_maker.make(&sources, width, light.n, &mut rng)
    }

    /// Draws `count` of the photons. Each arrives from its own direction: seen from the light's center, what shines from near would come from
    /// elsewhere than to any of its parts.
    fn sources(&self, count: usize, u: f32) -> Vec<Source<'s>> {
        let own: Vec<(&Photon, f32)> = self.own().collect();
        let weights: Vec<f32> = own.iter().map(|(p, w)| p.flux.luminance() * w).collect();
        let probabilities = inclusion_probabilities(&weights, count, super::select::WEIGHT_FLOOR);
        systematic(&probabilities, u)
            .into_iter()
            .map(|i| {
                let (photon, weight) = own[i];
                let x = self.scene.surface_point(photon.at);
                let tilt = |w: Vec3| (w.dot(x.frame.n) / w.dot(x.ng)).abs();
                let kept = (MAX_TILT / tilt(photon.wi)).min(1.0);
                Source {
                    bsdf: self.scene.bsdf(&x),
                    wi: photon.wi,
                    flux: photon.flux * (kept * weight / probabilities[i]),
                }
            })
            .collect()
    }
}

/// Share of the flux of `own` from photons of depth 1, up to 2, ...
fn shares_by_depth(photons: &[Photon], own: impl Iterator<Item = (u32, f32)>) -> [f32; DEPTHS] {
    let mut sums = [0.0f64; DEPTHS];
    let mut total = 0.0;
    for (j, weight) in own {
        let photon = &photons[j as usize];
        let flux = f64::from(photon.flux.luminance() * weight);
        total += flux;
        for sum in sums.iter_mut().skip(photon.depth.max(1) as usize - 1) {
            *sum += flux;
        }
    }
    sums.map(|sum| {
        if total > 0.0 {
            (sum / total) as f32
        } else {
            0.0
        }
    })
}

/// The normal `ns` of `x` on the side that the geometric normal `n` is on.
fn lit_side(ns: Vec3, x: &SurfacePoint, n: Vec3) -> Vec3 {
    ns * 1.0f32.copysign(x.ng.dot(n))
}
