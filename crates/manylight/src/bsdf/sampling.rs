//! Sampling of a scattering function.

use super::leaf::{Given, Leaf};
use super::model_sample::ModelSample;
use super::response::{ByClass, CLASSES, Response};
use super::{Bsdf, LARGEST, Lobes};
use crate::color::Rgb;
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::{rng, warp};

/// The random numbers of one BSDF sample, each in [0, 1).
#[derive(Clone, Copy, Debug)]
pub struct BsdfNumbers {
    /// Choice of the lobe.
    pub lobe: f32,
    /// Choice of the direction.
    pub direction: Vec2,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// The sampled unit direction: `wi` of [`Bsdf::sample_wi`], `wo` of [`Bsdf::sample_wo`].
    pub w: Vec3,
    /// `f |cos| / pdf`, with the geometric cosine of the sampled direction; for delta lobes the limit of that.
    pub weight: Rgb,
    /// Density per solid angle of all requested lobes ([`Bsdf::pdf_wi`], [`Bsdf::pdf_wo`]); 0 for delta lobes.
    pub pdf: f32,
    /// The class of the sampled lobe (one bit).
    pub lobe: Lobes,
    /// Index of refraction on the far side over that on the near side; 1 for reflection. For Russian roulette.
    pub eta: f32,
}

/// Largest probability of defensive sampling. It bounds the weight of photons on surfaces with tilted shading normals by about
/// 1 / 0.5 = 2. Not measured.
pub(super) const MAX_DEFENSIVE_PROBABILITY: f32 = 0.5;

/// A sampled direction without its weight.
pub(super) enum SampledDirection {
    /// A complete sample of a delta lobe.
    Delta(BsdfSample),
    /// A direction of a finite lobe, in world space and in the shading frame.
    Finite { w: Vec3, local: Vec3, eta: f32 },
}

impl<'s> Bsdf<'s> {
    /// Samples `wi` for a camera walk that arrives along `-wo`. `None` if the walk is absorbed.
    ///
    /// If `lobes` contains several finite classes, the class of the event is chosen in proportion to the luminance of each class in
    /// the sampled direction. `weight` is that of the chosen class, divided by the probability of the choice. So the sum over
    /// the events of one class is an estimate of that class.
    pub fn sample_wi(&self, wo: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<BsdfSample> {
        let given = self.frame.to_local(wo);
        if let Some(lambert) = self
            .plain_lambert(given)
            .filter(|_| lobes.has(Lobes::DIFFUSE))
        {
            return lambert.sample(&self.frame, u.direction);
        }
        match self.draw_wi(given, u, lobes)? {
            SampledDirection::Delta(sample) => Some(sample),
            SampledDirection::Finite { w, local, eta } => {
                let Response { values, pdf } = self.respond_local(local, given, lobes);
                let (weight, lobe) = choose_class(&values, u)?;
                complete(w, weight, pdf, lobe, eta)
            }
        }
    }

    /// Samples `wo` for a photon that arrives from `wi`. `None` if it is absorbed. Classes as in [`Bsdf::sample_wi`].
    pub fn sample_wo(&self, wi: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<BsdfSample> {
        let given = self.frame.to_local(wi);
        match self.draw_wo(wi, given, u, lobes)? {
            SampledDirection::Delta(sample) => Some(sample),
            SampledDirection::Finite { w, local, eta } => {
                let present = self.lobes.and(lobes);
                let values = ByClass::of(present, |class| self.eval_local(given, local, class));
                let (value, lobe) = choose_class(&values, u)?;
                let weight = value * (w.dot(self.ng) / wi.dot(self.ng)).abs();
                complete(
                    w,
                    weight,
                    self.pdf_wo_local(given, w, local, lobes),
                    lobe,
                    eta,
                )
            }
        }
    }

    /// A leaf in proportion to the light that it returns, the probability of the choice, and a number that is uniform in [0, 1) given the choice.
    #[inline]
    fn choose_leaf(&self, given: Vec3, u: f32, lobes: Lobes) -> Option<(&Leaf<'s>, f32, f32)> {
        if let [Some(leaf), None, ..] = &self.leaves {
            return leaf.can_sample(given, lobes).then_some((leaf, 1.0, u));
        }
        let total: f32 = self
            .weighted_leaves(given, lobes)
            .map(|(_, weight)| weight)
            .sum();
        let mut left = u * total;
        let mut chosen = None;
        for (leaf, weight) in self.weighted_leaves(given, lobes) {
            if weight > 0.0 {
                chosen = Some((leaf, weight / total, (left / weight).min(LARGEST)));
                if left < weight {
                    break;
                }
                left -= weight;
            }
        }
        chosen
    }

    /// Probability with which [`Bsdf::sample_wo`] samples the cosine to the geometric normal: [`MAX_DEFENSIVE_PROBABILITY`] times the
    /// share of the light that non-specular lobes return.
    #[inline]
    pub(super) fn defensive_probability(&self, given: Vec3, lobes: Lobes) -> f32 {
        if !self.is_defensive || !self.lobes.has(lobes.and(Lobes::NON_SPECULAR)) {
            return 0.0;
        }
        let weight = |lobes| {
            self.sampleable_leaves(given, lobes)
                .map(|leaf| leaf.sampling_weight(given, lobes))
                .sum::<f32>()
        };
        let (non_specular, all) = (weight(lobes.and(Lobes::NON_SPECULAR)), weight(lobes));
        if all > 0.0 {
            MAX_DEFENSIVE_PROBABILITY * non_specular / all
        } else {
            0.0
        }
    }

    /// Samples a direction `wi` given `wo` in the shading frame. Finite directions have the density [`Bsdf::pdf_wi`].
    #[inline]
    pub(super) fn draw_wi(
        &self,
        local: Vec3,
        u: BsdfNumbers,
        lobes: Lobes,
    ) -> Option<SampledDirection> {
        let (leaf, share, lobe) = self.choose_leaf(local, u.lobe, lobes)?;
        let ModelSample { w, eta, delta } =
            leaf.sample(Given::Wo, local, BsdfNumbers { lobe, ..u }, lobes)?;
        let wi = self.frame.to_world(w);
        let Some(delta) = delta else {
            return Some(SampledDirection::Finite {
                w: wi,
                local: w,
                eta,
            });
        };
        // Transmission scales radiance by the squared index of its own side over that of the side it comes from.
        let weight = delta.fraction * (leaf.weight / (share * delta.probability * eta * eta));
        complete(wi, weight, 1.0, Lobes::DELTA, eta)
            .map(|sample| SampledDirection::Delta(BsdfSample { pdf: 0.0, ..sample }))
    }

    /// Samples a direction `wo` given `wi` in world space and in the shading frame (`local`). Finite directions have the density
    /// [`Bsdf::pdf_wo`].
    pub(super) fn draw_wo(
        &self,
        wi: Vec3,
        local: Vec3,
        mut u: BsdfNumbers,
        lobes: Lobes,
    ) -> Option<SampledDirection> {
        let defensive = self.defensive_probability(local, lobes);
        if u.lobe < defensive {
            return Some(self.draw_defensive(local, u));
        }
        u.lobe = ((u.lobe - defensive) / (1.0 - defensive)).min(LARGEST);
        let (leaf, share, lobe) = self.choose_leaf(local, u.lobe, lobes)?;
        let ModelSample { w, eta, delta } =
            leaf.sample(Given::Wi, local, BsdfNumbers { lobe, ..u }, lobes)?;
        let wo = self.frame.to_world(w);
        let Some(delta) = delta else {
            return Some(SampledDirection::Finite {
                w: wo,
                local: w,
                eta,
            });
        };
        // f |wo·ng| = f_s |wi·ns| |wo·ng| / |wi·ng|, and f_s |wo·ns| integrates to the fraction.
        let cosines = (local.z * wo.dot(self.ng) / (wi.dot(self.ng) * w.z)).abs();
        let weight = delta.fraction
            * (leaf.weight * cosines / (share * delta.probability * (1.0 - defensive)));
        complete(wo, weight, 1.0, Lobes::DELTA, eta)
            .map(|sample| SampledDirection::Delta(BsdfSample { pdf: 0.0, ..sample }))
    }

    /// A direction `wo` of reflection, cosine-distributed around the geometric normal; this bounds the weight `|wo·ng| / pdf`.
    fn draw_defensive(&self, local: Vec3, u: BsdfNumbers) -> SampledDirection {
        let w = Frame::from_normal(self.ng).to_world(warp::cosine_hemisphere(u.direction));
        // The shading normal decides the side of reflection. Of two opposite directions exactly one is on that side.
        let same_side = w.dot(self.frame.n) * local.z > 0.0;
        let w = if same_side { w } else { -w };
        SampledDirection::Finite {
            w,
            local: self.frame.to_local(w),
            eta: 1.0,
        }
    }
}

/// A finite class in proportion to its luminance, and its value over the probability of the choice.
#[inline]
fn choose_class(values: &ByClass, u: BsdfNumbers) -> Option<(Rgb, Lobes)> {
    let luminances = CLASSES.map(|class| values[class].luminance());
    let total: f32 = luminances.iter().sum();
    let alone = luminances.iter().position(|&l| l > 0.0 && l == total);
    if let Some(class) = alone.map(|i| CLASSES[i]) {
        return Some((values[class], class));
    }
    let mut left = class_number(u) * total;
    let mut chosen = None;
    for (luminance, class) in luminances.into_iter().zip(CLASSES) {
        if luminance > 0.0 {
            chosen = Some((values[class] * (total / luminance), class));
            if left < luminance {
                break;
            }
            left -= luminance;
        }
    }
    chosen
}

/// A number for the choice of a class, independent of the direction: hashed from all digits of `u`, because the direction depends
/// on the leading ones.
fn class_number(u: BsdfNumbers) -> f32 {
    rng::unit(rng::key([u.lobe, u.direction.x, u.direction.y]))
}

/// A sample, with `weight` divided by `pdf`; `None` without a positive density and weight.
fn complete(w: Vec3, weight: Rgb, pdf: f32, lobe: Lobes, eta: f32) -> Option<BsdfSample> {
    let weight = weight / pdf;
    let valid = pdf > 0.0 && weight.is_finite() && !weight.is_black();
    valid.then_some(BsdfSample {
        w,
        weight,
        pdf,
        lobe,
        eta,
    })
}
