//! A dielectric coat over a Lambertian base, with all interreflection between the two.

use super::bound::Arriving;
use super::fresnel::{self, reflect};
use super::microfacet::Microfacets;
use super::model::{ModelSample, microfacet_class};
use super::response::Response;
use super::{BsdfNumbers, Lobes};
use crate::color::Rgb;
use crate::lanes::{LANES, Lanes};
use crate::math::Vec3;
use crate::math::float::floor;
use crate::sampling::warp;
use std::f32::consts::FRAC_1_PI;

/// Whether the base's colour shifts by scattering under the coat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorShift {
    /// Each channel by its own albedo.
    Nonlinear,
    /// None: the average loss is made up for.
    Linear,
}

/// Albedo of the base seen through the coat but for both transmittances: ρ / (η² (1 - ρ r)), `internal` r being the
/// reflectance of the coat from inside.
fn base_through_coat(reflectance: Rgb, eta: f32, internal: f32, shift: ColorShift) -> Rgb {
    let trapped = match shift {
        ColorShift::Nonlinear => reflectance * internal,
        ColorShift::Linear => Rgb::splat(internal),
    };
    reflectance.zip(trapped, |rho, t| rho / (eta * eta * (1.0 - t)))
}

/// How likely the coat is sampled rather than the base, at the coat's reflectance `r`.
#[inline]
fn coat_probability(r: f32, coat_share: f32) -> f32 {
    let (coat, base) = (r * coat_share, (1.0 - r) * (1.0 - coat_share));
    if coat + base > 0.0 {
        coat / (coat + base)
    } else {
        1.0
    }
}

/// How much of the light a tint reflects next to that of the base.
fn coat_share(tint: Rgb, reflectance: Rgb) -> f32 {
    let (s, d) = (tint.mean(), reflectance.mean());
    if s + d > 0.0 { s / (s + d) } else { 0.5 }
}

/// A smooth coat.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plastic {
    pub eta: f32,
    /// ρ / (η² (1 - ρ r)).
    pub base: Rgb,
    tint: Rgb,
    coat_share: f32,
}

impl Plastic {
    pub(super) fn new(eta: f32, reflectance: Rgb, tint: Rgb, shift: ColorShift) -> Self {
        let base = base_through_coat(
            reflectance,
            eta,
            fresnel::diffuse_reflectance(1.0 / eta),
            shift,
        );
        Plastic {
            eta,
            base,
            tint,
            coat_share: coat_share(tint, reflectance),
        }
    }

    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE.or(Lobes::DELTA)
    }

    #[inline]
    fn coat_probability(&self, r: f32, lobes: Lobes) -> f32 {
        match (lobes.has(Lobes::DELTA), lobes.has(Lobes::DIFFUSE)) {
            (true, true) => coat_probability(r, self.coat_share),
            (true, false) => 1.0,
            _ => 0.0,
        }
    }

    #[inline]
    pub(super) fn diffuse_weight(&self, wi: Vec3) -> Rgb {
        if wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        self.base * fresnel::coat_transmittance(wi.z, self.eta)
    }

    #[inline]
    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if !lobes.has(Lobes::DIFFUSE) || wi.z <= 0.0 || wo.z <= 0.0 {
            return Rgb::BLACK;
        }
        self.diffuse_weight(wi) * (fresnel::coat_transmittance(wo.z, self.eta) * wi.z * FRAC_1_PI)
    }

    #[inline]
    pub(super) fn bound(&self, arriving: &Arriving, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = arriving.cosines();
        if !lobes.has(Lobes::DIFFUSE) || wo.z <= 0.0 || cos <= 0.0 {
            return 0.0;
        }
        let [enters, leaves] = [cos, wo.z].map(|cos| fresnel::coat_transmittance(cos, self.eta));
        let projection = arriving.projection(cos);
        self.base.max_channel() * (enters * leaves * projection * FRAC_1_PI)
    }

    #[inline]
    pub(super) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        if given.z <= 0.0 || other.z <= 0.0 || !lobes.has(Lobes::DIFFUSE) {
            return 0.0;
        }
        let r = fresnel::dielectric(given.z, self.eta).reflectance;
        (1.0 - self.coat_probability(r, lobes)) * warp::cosine_hemisphere_pdf(other.z)
    }

    pub(super) fn sample(&self, given: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<ModelSample> {
        if given.z <= 0.0 {
            return None;
        }
        let r = fresnel::dielectric(given.z, self.eta).reflectance;
        let probability = self.coat_probability(r, lobes);
        if u.lobe < probability {
            return Some(ModelSample::mirror(given, self.tint * r, probability));
        }
        Some(ModelSample::finite(warp::cosine_hemisphere(u.direction)))
    }
}

/// A rough coat.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughPlastic<'s> {
    pub facets: Microfacets,
    pub eta: f32,
    /// Transmittance of the coat from outside, over the cosine on [0, 1].
    pub transmittance: &'s [f32; COSINES],
    /// ρ / (η² (1 - ρ r)).
    pub base: Rgb,
    pub tint: Rgb,
    coat_share: f32,
}

/// What is precomputed about a rough coat.
#[derive(Debug)]
pub(super) struct Coat {
    /// Transmittance from outside, over the cosine on [0, 1].
    pub transmittance: [f32; COSINES],
    /// Reflectance from inside, averaged over diffuse light.
    pub internal_reflectance: f32,
}

impl<'s> RoughPlastic<'s> {
    pub(super) fn new(
        facets: Microfacets,
        eta: f32,
        coat: &'s Coat,
        colors: (Rgb, Rgb),
        shift: ColorShift,
    ) -> Self {
        let (reflectance, tint) = colors;
        RoughPlastic {
            facets,
            eta,
            transmittance: &coat.transmittance,
            base: base_through_coat(reflectance, eta, coat.internal_reflectance, shift),
            tint,
            coat_share: coat_share(tint, reflectance),
        }
    }

    #[inline]
    pub(super) fn alpha(&self) -> f32 {
        self.facets.min_alpha()
    }

    /// Largest transmittance of the coat from outside.
    #[inline]
    pub(super) fn most_transmitted(&self) -> f32 {
        self.transmittance.iter().copied().fold(0.0, f32::max)
    }

    /// The class of the coat's own reflection.
    #[inline]
    pub(super) fn coat_class(&self) -> Lobes {
        microfacet_class(self.alpha())
    }

    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE.or(self.coat_class())
    }

    /// At a transmittance of the coat.
    #[inline]
    fn coat_probability(&self, transmittance: f32, lobes: Lobes) -> f32 {
        match (lobes.has(self.coat_class()), lobes.has(Lobes::DIFFUSE)) {
            (true, true) => coat_probability(1.0 - transmittance, self.coat_share),
            (true, false) => 1.0,
            _ => 0.0,
        }
    }

    #[inline]
    pub(super) fn diffuse_weight(&self, wi: Vec3) -> Rgb {
        if wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        self.base * interpolate(self.transmittance, wi.z)
    }

    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        self.respond(wi, wo, lobes).values.sum()
    }

    /// See [`Model::respond`](super::model::Model::respond).
    pub(super) fn respond(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Response {
        let mut response = Response::NONE;
        if wi.z <= 0.0 || wo.z <= 0.0 || !lobes.has(self.lobes()) {
            return response;
        }
        let into_eye = interpolate(self.transmittance, wo.z);
        let coat = self.coat_probability(into_eye, lobes);
        if lobes.has(self.coat_class()) {
            let m = (wi + wo).normalize();
            let f = fresnel::dielectric(wo.dot(m), self.eta).reflectance;
            let pdf = self.facets.reflected_pdf(wo, m);
            response.values[self.coat_class()] = self.tint * (f * pdf * self.facets.masking(wi, m));
            response.pdf = coat * pdf;
        }
        if lobes.has(Lobes::DIFFUSE) {
            let cosine = warp::cosine_hemisphere_pdf(wi.z);
            response.values[Lobes::DIFFUSE] = self.diffuse_weight(wi) * (into_eye * cosine);
            response.pdf += (1.0 - coat) * cosine;
        }
        response
    }

    pub(super) fn bound(&self, arriving: &Arriving, wo: Vec3, lobes: Lobes) -> f32 {
        let [_, cos] = arriving.cosines();
        if wo.z <= 0.0 || cos <= 0.0 {
            return 0.0;
        }
        let mut bound = 0.0;
        if lobes.has(self.coat_class()) {
            let halves = arriving.halves(wo);
            let f = fresnel::dielectric(halves.cosines[0], self.eta).reflectance;
            let visible = self.facets.projected_bound(halves.highest, arriving);
            bound += self.tint.max_channel() * f * visible * self.facets.seen(wo);
        }
        if lobes.has(Lobes::DIFFUSE) {
            let enters = self.most_transmitted();
            let leaves = interpolate(self.transmittance, wo.z);
            let projection = arriving.projection(cos);
            bound += self.base.max_channel() * (enters * leaves * projection * FRAC_1_PI);
        }
        bound
    }

    pub(super) fn pdf(&self, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        if given.z <= 0.0 || other.z <= 0.0 || !lobes.has(self.lobes()) {
            return 0.0;
        }
        let coat = self.coat_probability(interpolate(self.transmittance, given.z), lobes);
        let mut pdf = (1.0 - coat) * warp::cosine_hemisphere_pdf(other.z);
        if coat > 0.0 {
            pdf += coat
                * self
                    .facets
                    .reflected_pdf(given, (given + other).normalize());
        }
        pdf
    }

    pub(super) fn sample(&self, given: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<ModelSample> {
        if given.z <= 0.0 {
            return None;
        }
        let transmittance = interpolate(self.transmittance, given.z);
        if u.lobe >= self.coat_probability(transmittance, lobes) {
            return Some(ModelSample::finite(warp::cosine_hemisphere(u.direction)));
        }
        let w = reflect(given, self.facets.sample(given, u.direction));
        (w.z > 0.0).then(|| ModelSample::finite(w))
    }
}

/// Entries of tables over the cosine on [0, 1], between which is interpolated linearly.
pub const COSINES: usize = 64;

/// Where in a table a cosine from 0 to 1 lies: the entry below and the weight of the one above.
#[inline(always)]
fn place(cos: f32) -> (i32, f32) {
    // At 1 exactly, the last two entries with all weight on the second.
    let at = cos * (COSINES - 1) as f32 * (1.0 - f32::EPSILON);
    let (below, i) = floor(at);
    (i, at - below)
}

/// Linear interpolation.
#[inline(always)]
pub(super) fn interpolate(table: &[f32; COSINES], cos: f32) -> f32 {
    let (i, w) = place(cos.clamp(0.0, 1.0));
    table[i as usize] * (1.0 - w) + table[i as usize + 1] * w
}

/// Linear interpolation in each lane, for cosines from 0 to 1.
#[inline(always)]
pub fn interpolate_lanes(tables: &[&[f32; COSINES]; LANES], cos: &Lanes) -> Lanes {
    let (mut i, mut w) = ([0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        (i[lane], w[lane]) = place(cos[lane]);
    }
    let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let i = i[lane] as usize % COSINES;
        low[lane] = tables[lane][i];
        high[lane] = tables[lane][(i + 1) % COSINES];
    }
    std::array::from_fn(|lane| low[lane] * (1.0 - w[lane]) + high[lane] * w[lane])
}
