//! Sampling of a scattering function, and its albedo.

use super::function::MAX_LEAVES;
use super::leaf::Given;
use super::lobes::Classes;
use super::model_sample::{ModelSample, Numbers};
use super::response::{ByClass, Response};
use super::samples::{BsdfNumbers, BsdfSample, BsdfSamples};
use super::{Bsdf, ExitTransmittance, Lobes};
use crate::color::Rgb;
use crate::lanes::{Axes, Color, Float, Mask, Vector, Width, Word, cosine_hemisphere};
use crate::math::Vec3;
use crate::math::float::ONE_MINUS_EPSILON;
use crate::sampling::{LowDiscrepancySequence, rng};
use crate::simd::outlined;

/// Largest probability of defensive sampling. It bounds the weight of photons on surfaces with
/// tilted shading normals by about 1 / 0.5 = 2. In photon maps of rooms with normal maps on diffuse
/// and rough metal surfaces, at 0.25 and 0.75: pixel variance 1.01, .99 and .99, 1.24 times; in the
/// third-party classroom .98 and 1.06.
pub(super) const MAX_DEFENSIVE_PROBABILITY: f32 = 0.5;

/// Points of the quadrature of albedos, for an error of about one percent.
const ALBEDO_SAMPLES: u32 = 1024;

/// A sampled direction in each lane, without the weight of finite lobes.
pub(super) struct Drawn<S: Width> {
    /// In world space.
    pub(super) w: Vector<S>,
    /// In the shading frame.
    local: Vector<S>,
    eta: Float<S>,
    /// The lanes of delta lobes.
    pub(super) is_delta: Mask<S>,
    /// Weight of the samples of delta lobes.
    delta_weight: Color<S>,
    /// The lanes with a sample.
    pub(super) valid: Mask<S>,
}

/// A leaf's sample, and how the leaf was chosen.
struct LeafSample<S: Width> {
    sample: ModelSample<S>,
    /// Probability of the choice.
    share: Float<S>,
    /// Weight of the leaf.
    weight: Float<S>,
}

// Compiled once for each instruction set, because every caller would otherwise have a copy of every
// model.
outlined! {
    fn sample_wi<S: Width>(
        bsdf: &Bsdf<'_, S>, wo: Vector<S>, u: Numbers<S>, lobes: Lobes,
    ) -> BsdfSamples<S> { bsdf.width() => bsdf.sample_each_wi_inlined(wo, u, lobes) }

    fn sample_wo<S: Width>(
        bsdf: &Bsdf<'_, S>, wi: Vector<S>, u: Numbers<S>, lobes: Lobes,
    ) -> BsdfSamples<S> { bsdf.width() => bsdf.sample_each_wo_inlined(wi, u, lobes) }
}

impl Bsdf<'_> {
    /// Samples `wi` for a camera walk that arrives along `-wo`. `None` if the walk is absorbed.
    ///
    /// If `lobes` contains several finite classes, the class of the event is chosen in proportion
    /// to the luminance of each class in the sampled direction. `weight` is that of the chosen
    /// class, divided by the probability of the choice. So the sum over the events of one class is
    /// an estimate of that class.
    pub fn sample_wi(&self, wo: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<BsdfSample> {
        self.sample_each_wi(wo.into(), u.into(), lobes).get()
    }

    /// Samples `wo` for a photon that arrives from `wi`. `None` if it is absorbed. Classes as in
    /// [`Bsdf::sample_wi`].
    pub fn sample_wo(&self, wi: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<BsdfSample> {
        self.sample_each_wo(wi.into(), u.into(), lobes).get()
    }

    /// Fraction of flux from `wi` that `lobes` scatter (delta lobes included, straight-through
    /// transmission not). In closed form for Lambert's model, else by deterministic quadrature over
    /// [`Bsdf::sample_wo`] with an error of about one percent.
    pub fn albedo(&self, wi: Vec3, lobes: Lobes) -> Rgb {
        if self.lobes().and(lobes) == Lobes::DIFFUSE
            && matches!(self.exit_transmittance(), ExitTransmittance::Lambert)
        {
            // |wo·ng| / π integrates to 1 over any hemisphere, also over that around ns.
            return self.diffuse_weight(wi);
        }
        let sequence = LowDiscrepancySequence::new([0.5; 3]);
        let sum: Rgb = (1..=ALBEDO_SAMPLES)
            .filter_map(|i| {
                let (lobe, direction) = sequence.triple(i);
                self.sample_wo(wi, BsdfNumbers { lobe, direction }, lobes)
            })
            .map(|sample| sample.weight)
            .sum();
        sum / ALBEDO_SAMPLES as f32
    }
}

impl<S: Width> Bsdf<'_, S> {
    /// [`Bsdf::sample_wi`] in each lane.
    #[inline(always)]
    pub(crate) fn sample_each_wi(
        &self,
        wo: Vector<S>,
        u: Numbers<S>,
        lobes: Lobes,
    ) -> BsdfSamples<S> {
        sample_wi(self, wo, u, lobes)
    }

    /// [`Bsdf::sample_wo`] in each lane.
    #[inline(always)]
    pub(crate) fn sample_each_wo(
        &self,
        wi: Vector<S>,
        u: Numbers<S>,
        lobes: Lobes,
    ) -> BsdfSamples<S> {
        sample_wo(self, wi, u, lobes)
    }

    #[inline(always)]
    fn sample_each_wi_inlined(&self, wo: Vector<S>, u: Numbers<S>, lobes: Lobes) -> BsdfSamples<S> {
        let given = self.frame.to_local(wo);
        if lobes.has(Lobes::DIFFUSE)
            && let Some(lambert) = self.plain_lambert(given)
        {
            return lambert.sample(&self.frame, u.direction);
        }
        let lobes = Classes::splat(self.width(), lobes);
        let drawn = self.draw_wi(given, u, lobes);
        let Response { values, pdf } = if drawn.is_finite().any() {
            self.respond_local(drawn.local, given, lobes)
        } else {
            Response::none(self.width())
        };
        drawn.complete(&values, pdf, u)
    }

    #[inline(always)]
    fn sample_each_wo_inlined(&self, wi: Vector<S>, u: Numbers<S>, lobes: Lobes) -> BsdfSamples<S> {
        let given = self.frame.to_local(wi);
        let lobes = Classes::splat(self.width(), lobes);
        let drawn = self.draw_wo(wi, given, u, lobes);
        if drawn.is_finite().none() {
            let Response { values, pdf } = Response::none(self.width());
            return drawn.complete(&values, pdf, u);
        }
        let cosines = (drawn.w.dot(self.ng) / wi.dot(self.ng)).abs();
        let values = self.values_local(given, drawn.local, lobes);
        let values = values.map(|v| v * cosines);
        let pdf = self.pdf_wo_local(given, drawn.w, drawn.local, lobes);
        drawn.complete(&values, pdf, u)
    }

    /// A direction from a leaf that is chosen in proportion to the light that it returns.
    #[inline(always)]
    fn sample_leaf(
        &self,
        end: Given,
        given: Vector<S>,
        u: Numbers<S>,
        lobes: Classes<S>,
    ) -> LeafSample<S> {
        let zero = Float::splat(self.width(), 0.0);
        if let Some(leaf) = self.only_leaf() {
            let sample = leaf.sample(end, given, u, lobes);
            return LeafSample {
                sample: ModelSample {
                    valid: sample.valid & leaf.can_sample(given, lobes),
                    ..sample
                },
                share: zero.same(1.0),
                weight: leaf.weight,
            };
        }
        let mut weights = [zero; MAX_LEAVES];
        let mut total = zero;
        for (weight, leaf) in weights.iter_mut().zip(self.leaves()) {
            *weight = self.choice_weight(leaf, given, lobes);
            total += *weight;
        }
        let none = Mask::splat(self.width(), false);
        let mut chosen = LeafSample {
            sample: ModelSample::finite(given, none),
            share: zero,
            weight: zero,
        };
        let (mut left, mut undecided) = (u.lobe * total, !none);
        for (i, leaf) in self.leaves().enumerate() {
            let weight = weights[i];
            // Rounding must not end without a leaf.
            let mut beyond = zero;
            for later in &weights[i + 1..] {
                beyond += *later;
            }
            let takes = undecided & weight.gt(0.0) & (left.lt(weight) | beyond.equals(0.0));
            if takes.any() {
                let lobe = (left / weight).min(ONE_MINUS_EPSILON);
                let sample = leaf.sample(end, given, Numbers { lobe, ..u }, lobes);
                chosen = LeafSample {
                    sample: ModelSample::select(takes, &sample, &chosen.sample),
                    share: takes.select(weight / total, chosen.share),
                    weight: takes.select(leaf.weight, chosen.weight),
                };
                undecided = undecided & !takes;
            }
            left -= weight;
        }
        chosen
    }

    /// Probability with which [`Bsdf::sample_wo`] samples the cosine to the geometric normal:
    /// [`MAX_DEFENSIVE_PROBABILITY`] times the share of the light that non-specular lobes return.
    #[inline(always)]
    pub(super) fn defensive_probability(&self, given: Vector<S>, lobes: Classes<S>) -> Float<S> {
        let zero = Float::splat(self.width(), 0.0);
        let of_base = lobes.and(Classes::splat(self.width(), Lobes::NON_SPECULAR));
        let defends = self.is_defensive & self.classes.has(of_base);
        if defends.none() {
            return zero;
        }
        let weight = |lobes: Classes<S>| {
            let weights = self
                .leaves()
                .map(|leaf| self.choice_weight(leaf, given, lobes));
            weights.fold(zero, |sum, weight| sum + weight)
        };
        let (non_specular, all) = (weight(of_base), weight(lobes));
        let share = MAX_DEFENSIVE_PROBABILITY * non_specular / all;
        (defends & all.gt(0.0)).select(share, 0.0)
    }

    /// Samples a direction `wi` given `wo` in the shading frame. Finite directions have the density
    /// [`Bsdf::pdf_wi`].
    #[inline(always)]
    pub(super) fn draw_wi(&self, local: Vector<S>, u: Numbers<S>, lobes: Classes<S>) -> Drawn<S> {
        let LeafSample {
            sample,
            share,
            weight,
        } = self.sample_leaf(Given::Wo, local, u, lobes);
        // Refraction scales radiance by the squared index of the side that it enters over that of
        // the side that it leaves.
        let scale = weight / (share * sample.probability * sample.eta * sample.eta);
        Drawn {
            w: self.frame.to_world(sample.w),
            local: sample.w,
            eta: sample.eta,
            is_delta: sample.is_delta,
            delta_weight: sample.fraction * scale,
            valid: sample.valid,
        }
    }

    /// Samples a direction `wo` given `wi` in world space and in the shading frame (`local`).
    /// Finite directions have the density [`Bsdf::pdf_wo`].
    #[inline(always)]
    pub(super) fn draw_wo(
        &self,
        wi: Vector<S>,
        local: Vector<S>,
        u: Numbers<S>,
        lobes: Classes<S>,
    ) -> Drawn<S> {
        let defensive = self.defensive_probability(local, lobes);
        let defends = u.lobe.lt(defensive);
        let lobe = ((u.lobe - defensive) / (1.0 - defensive)).min(ONE_MINUS_EPSILON);
        let LeafSample {
            sample,
            share,
            weight,
        } = self.sample_leaf(Given::Wi, local, Numbers { lobe, ..u }, lobes);
        let w = self.frame.to_world(sample.w);
        // f |wo·ng| = f_s |wi·ns| |wo·ng| / |wi·ng|, and f_s |wo·ns| integrates to the fraction.
        let cosines = (local.z * w.dot(self.ng) / (wi.dot(self.ng) * sample.w.z)).abs();
        let scale = weight * cosines / (share * sample.probability * (1.0 - defensive));
        let drawn = Drawn {
            w,
            local: sample.w,
            eta: sample.eta,
            is_delta: sample.is_delta,
            delta_weight: sample.fraction * scale,
            valid: sample.valid,
        };
        if defends.none() {
            return drawn;
        }
        let w = self.draw_defensive(local, u);
        Drawn {
            w: Vector::select(defends, w, drawn.w),
            local: Vector::select(defends, self.frame.to_local(w), drawn.local),
            eta: defends.select(1.0, drawn.eta),
            is_delta: drawn.is_delta & !defends,
            delta_weight: drawn.delta_weight,
            valid: drawn.valid | defends,
        }
    }

    /// A direction `wo` of reflection, cosine-distributed around the geometric normal; this bounds
    /// the weight `|wo·ng| / pdf`.
    #[inline(always)]
    fn draw_defensive(&self, local: Vector<S>, u: Numbers<S>) -> Vector<S> {
        let w = Axes::from_normal(self.ng).to_world(cosine_hemisphere(u.direction));
        // The shading normal decides the side of reflection. Of two opposite directions exactly one
        // is on that side.
        let same_side = (w.dot(self.frame.n) * local.z).gt(0.0);
        w * same_side.select(1.0, -1.0)
    }
}

impl<S: Width> Drawn<S> {
    /// The lanes with a direction of a finite lobe.
    #[inline(always)]
    fn is_finite(&self) -> Mask<S> {
        self.valid & !self.is_delta
    }

    /// The sample, by the `values` of finite lobes times the cosine and their density.
    #[inline(always)]
    fn complete(&self, values: &ByClass<S>, pdf: Float<S>, u: Numbers<S>) -> BsdfSamples<S> {
        let (value, lobe) = choose_class(values, u);
        let weight = Color::select(self.is_delta, self.delta_weight, value / pdf);
        let delta = Word::splat(pdf.width(), u32::from(Lobes::DELTA.0));
        let is_sampled = (self.is_delta | pdf.gt(0.0)) & weight.is_finite() & !weight.is_black();
        BsdfSamples {
            w: self.w,
            weight,
            pdf: self.is_delta.select(0.0, pdf),
            lobe: self.is_delta.select_words(delta, lobe),
            eta: self.eta,
            valid: self.valid & is_sampled,
        }
    }
}

/// A finite class in proportion to its luminance, and its value over the probability of the choice.
#[inline(always)]
fn choose_class<S: Width>(values: &ByClass<S>, u: Numbers<S>) -> (Color<S>, Word<S>) {
    let ByClass {
        diffuse,
        glossy,
        near_delta,
    } = *values;
    let (d, g, n) = (
        diffuse.luminance(),
        glossy.luminance(),
        near_delta.luminance(),
    );
    let (has_d, has_g, has_n) = (d.gt(0.0), g.gt(0.0), n.gt(0.0));
    let mut takes_d = has_d;
    let mut takes_n = has_n & !has_d;
    let mut value = values.sum();
    let several = (has_d & (has_g | has_n)) | (has_g & has_n);
    if several.any() {
        // Rounding must not choose a class without light.
        let total = d + g + n;
        let left = class_number(u) * total;
        takes_d = has_d & (left.lt(d) | !(has_g | has_n));
        takes_n = has_n & !takes_d & !(has_g & (left - d).lt(g));
        let chosen = Color::select(takes_n, near_delta, glossy);
        let chosen = Color::select(takes_d, diffuse, chosen);
        let luminance = takes_d.select(d, takes_n.select(n, g));
        value = Color::select(several, chosen * (total / luminance), value);
    }
    let word = |class: Lobes| Word::splat(u.lobe.width(), u32::from(class.0));
    let lobe = takes_n.select_words(word(Lobes::NEAR_DELTA), word(Lobes::GLOSSY));
    (value, takes_d.select_words(word(Lobes::DIFFUSE), lobe))
}

/// A number for the choice of a class, independent of the direction: hashed from all digits of `u`,
/// because the direction depends on the leading ones.
#[inline(always)]
fn class_number<S: Width>(u: Numbers<S>) -> Float<S> {
    let (lobe, x, y) = (u.lobe.store(), u.direction.x.store(), u.direction.y.store());
    let (lobe, x, y) = (lobe.as_ref(), x.as_ref(), y.as_ref());
    Float::from_fn(u.lobe.width(), |i| {
        rng::unit(rng::key([lobe[i], x[i], y[i]]))
    })
}
