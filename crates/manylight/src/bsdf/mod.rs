//! How surfaces scatter light. [`Material`] is what a file describes, [`Bsdf`] what it is at one point.
//!
//! Directions are physical: light arrives from `wi` and leaves along `wo`, both unit, both away from the surface.
//! A camera walk knows `wo` and samples `wi`; a photon walk knows `wi` and samples `wo`.
//! Every lobe has a class, and every function here takes the classes that it shall see, because the path partition
//! (docs/path_partition.md) is by scattering event: one surface may have lobes of several classes.

mod bound;
mod coat;
mod conductor;
mod dielectric;
mod diffuse;
mod flatten;
mod fresnel;
mod leaf;
mod lobes;
pub mod material;
mod materials;
mod microfacet;
mod model;
mod outgoing;
mod phong;
mod plastic;
mod principled;
mod principled_front;
mod receiver;
mod receivers;
mod response;
mod rough_diffuse;
#[cfg(test)]
mod tests;
mod thin_dielectric;
mod ward;

pub use lobes::Lobes;
pub use material::Material;
pub use materials::Materials;
pub use outgoing::Outgoing;
pub use plastic::{COSINES, interpolate_lanes};
pub use receiver::Receiver;
pub use receivers::{Form, Receivers};

use crate::color::Rgb;
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::{rng, warp};
use leaf::{Given, Lambert, Leaf};
use model::{Model, ModelSample};
use response::{ByClass, CLASSES, Response};
use std::f32::consts::FRAC_1_PI;

/// Roughness below which a microfacet lobe counts as near-delta: narrower than a texel of a 32 x 32 octahedral table
/// can show. A fixed number: the class of a lobe must not depend on who asks.
pub const NEAR_DELTA_ALPHA: f32 = 0.1;

/// The numbers one BSDF sample needs, by name.
#[derive(Clone, Copy, Debug)]
pub struct BsdfNumbers {
    /// Chooses the lobe.
    pub lobe: f32,
    /// Chooses the direction.
    pub direction: Vec2,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// The sampled direction: `wi` of [`Bsdf::sample_wi`], `wo` of [`Bsdf::sample_wo`].
    pub w: Vec3,
    /// `f |cos| / pdf` with the geometric cosine on the sampled side; for delta lobes the same limit.
    pub weight: Rgb,
    /// Per solid angle, over all lobes that were asked for (as `pdf_wi` / `pdf_wo` give it); 0 for delta lobes.
    pub pdf: f32,
    /// The class of the lobe that was sampled (one bit).
    pub lobe: Lobes,
    /// Index of refraction on the far side over that on the near side; 1 for reflection. For Russian roulette.
    pub eta: f32,
}

/// The shape of a `DIFFUSE` lobe over its exit direction: `b(cosθ_o)` with θ_o from the shading normal.
/// Kept by virtual lights.
#[derive(Clone, Copy, Debug)]
pub enum ExitTransmittance<'s> {
    /// `b = 1`.
    Lambert,
    /// Transmittance of a smooth dielectric coat.
    Fresnel {
        /// Index of the coat over that of its outside.
        eta: f32,
    },
    /// Transmittance of a dielectric coat, tabulated over the cosine on [0, 1].
    Coated(&'s [f32; COSINES]),
}

impl ExitTransmittance<'_> {
    /// `b` at the cosine to the shading normal, in [0, 1].
    #[inline(always)]
    pub fn eval(&self, cos: f32) -> f32 {
        match *self {
            ExitTransmittance::Lambert => 1.0,
            ExitTransmittance::Fresnel { eta } => fresnel::coat_transmittance(cos, eta),
            ExitTransmittance::Coated(table) => plastic::interpolate(table, cos),
        }
    }
}

/// See [`Bsdf::seen_by_width`].
#[derive(Clone, Copy, Debug)]
pub struct SeenByWidth {
    /// `f |wi·ng|` of the `SMOOTH` lobes.
    pub smooth: Rgb,
    /// `f |wi·ng|` of the `NEAR_DELTA` lobes.
    pub narrow: Rgb,
    /// Per solid angle.
    pub pdf: f32,
}

/// The most models that one material may consist of at a point; see [`Materials::bsdf`].
const MAX_LEAVES: usize = 4;

/// How often a photon that meets a tilted shading normal is sampled about the geometric one, at most.
const DEFENSIVE_SHARE: f32 = 0.5;

/// Cosine between shading and geometric normal above which they count as equal.
const ALIGNED: f32 = 0.9998;

/// A scattering function at a point: small, `Copy`, borrowing only precomputed tables of the scene.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'s> {
    ng: Vec3,
    frame: Frame,
    /// The used ones come first.
    leaves: [Option<Leaf<'s>>; MAX_LEAVES],
    /// What passes straight through, seen from the side of the shading normal and from the other.
    open: [f32; 2],
    /// Whether anything passes straight through.
    is_open: bool,
    /// Whether a finite lobe carries light to the other side.
    transmits: bool,
    lobes: Lobes,
    exit: ExitTransmittance<'s>,
    glossy_width: f32,
    /// Whether a photon walk needs defensive sampling: a normal in use is not the geometric one.
    defensive: bool,
}

impl<'s> Bsdf<'s> {
    /// `f(wi → wo)`, 1/sr, for light that arrives from `wi`: `f = f_s |wi·ns| / |wi·ng|` with `f_s` the model in the shading
    /// frame, so that all other formulas use geometric cosines (docs: shading normals; checked by the adjoint test).
    /// Reflection and transmission are told apart by `ns` alone, as Mitsuba's path tracer does. Radiance is scaled by η² in transmission.
    #[inline]
    pub fn f(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let cos = wi.dot(self.ng).abs();
        if cos == 0.0 {
            return Rgb::BLACK;
        }
        self.f_cos_wi(wi, wo, lobes) / cos
    }

    /// `f |wi·ng|`: what a receiver multiplies incident radiance by. Computed without the quotient.
    #[inline]
    pub fn f_cos_wi(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if !self.lobes.has(lobes.and(Lobes::FINITE)) {
            return Rgb::BLACK;
        }
        self.eval_local(self.frame.to_local(wi), self.frame.to_local(wo), lobes)
    }

    /// What next-event estimation asks for at once: [`Bsdf::f_cos_wi`] of the `SMOOTH` lobes and of the `NEAR_DELTA` lobes, which
    /// it adds to two terms, and [`Bsdf::pdf_wi`] of all. `None` if nothing is reflected.
    #[inline]
    pub fn seen_by_width(&self, wi: Vec3, wo: Vec3) -> Option<SeenByWidth> {
        let (wi, wo) = (self.frame.to_local(wi), self.frame.to_local(wo));
        if let Some(lambert) = self.plain_lambert(wo) {
            let pdf = lambert.pdf(wi);
            return (pdf > 0.0).then_some(SeenByWidth {
                smooth: lambert.albedo * pdf,
                narrow: Rgb::BLACK,
                pdf,
            });
        }
        let Response { values, pdf } = self.respond_local(wi, wo, Lobes::ALL);
        let smooth = values[Lobes::DIFFUSE] + values[Lobes::GLOSSY];
        let narrow = values[Lobes::NEAR_DELTA];
        (!smooth.is_black() || !narrow.is_black()).then_some(SeenByWidth {
            smooth,
            narrow,
            pdf,
        })
    }

    /// `f |wo·ng|`: times incident flux this is radiant intensity towards `wo`.
    #[inline]
    pub fn f_cos_wo(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        self.f(wi, wo, lobes) * wo.dot(self.ng).abs()
    }

    /// Draws `wi` for a camera walk that looks along `-wo`. `None`: absorbed.
    ///
    /// Where several finite classes were asked for, the class of the event is drawn in proportion to their luminance at the
    /// sampled direction and `weight` is of that class alone, divided by its probability: sums over events of one class converge
    /// to that class.
    pub fn sample_wi(&self, wo: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<BsdfSample> {
        let given = self.frame.to_local(wo);
        if let Some(lambert) = self
            .plain_lambert(given)
            .filter(|_| lobes.has(Lobes::DIFFUSE))
        {
            return lambert.sample(&self.frame, u.direction);
        }
        match self.draw_wi(given, u, lobes)? {
            Drawn::Delta(sample) => Some(sample),
            Drawn::Finite { w, local, eta } => {
                let Response { values, pdf } = self.respond_local(local, given, lobes);
                let (weight, lobe) = choose_class(&values, u)?;
                complete(w, weight, pdf, lobe, eta)
            }
        }
    }

    /// Draws `wo` for a photon that arrives from `wi`. `None`: absorbed. Classes as in [`Bsdf::sample_wi`].
    pub fn sample_wo(&self, wi: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<BsdfSample> {
        let given = self.frame.to_local(wi);
        match self.draw_wo(wi, given, u, lobes)? {
            Drawn::Delta(sample) => Some(sample),
            Drawn::Finite { w, local, eta } => {
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

    /// Density of [`Bsdf::sample_wi`] per solid angle, delta lobes left out.
    #[inline]
    pub fn pdf_wi(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> f32 {
        self.pdf_local(
            Given::Wo,
            self.frame.to_local(wo),
            self.frame.to_local(wi),
            lobes,
        )
    }

    /// Density of [`Bsdf::sample_wo`] per solid angle, delta lobes left out.
    #[inline]
    pub fn pdf_wo(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> f32 {
        self.pdf_wo_local(self.frame.to_local(wi), wo, self.frame.to_local(wo), lobes)
    }

    #[inline]
    fn pdf_wo_local(&self, given: Vec3, wo: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        let pdf = self.pdf_local(Given::Wi, given, other, lobes);
        let defensive = self.defensive_share(given, lobes);
        if defensive == 0.0 {
            return pdf;
        }
        let about_ng = if given.z * other.z > 0.0 {
            wo.dot(self.ng).abs() * FRAC_1_PI
        } else {
            0.0
        };
        (1.0 - defensive) * pdf + defensive * about_ng
    }

    /// The classes present with positive weight.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        self.lobes
    }

    /// Whether a finite lobe carries light to the other side.
    #[inline]
    pub fn transmits(&self) -> bool {
        self.transmits
    }

    /// Fraction of light that passes straight through along `w` as if there were no surface (mask, null, thin glass).
    /// The lobes carry the rest: their weights already contain the opacity.
    #[inline]
    pub fn transmittance(&self, w: Vec3) -> Rgb {
        if !self.is_open {
            return Rgb::BLACK;
        }
        let local = self.frame.to_local(w);
        let mut sum = Rgb::splat(self.open[usize::from(local.z < 0.0)]);
        for leaf in self.leaves.iter().flatten() {
            if let Model::Pane(pane) = &leaf.model {
                sum += pane.transmittance(local.z) * leaf.weight;
            }
        }
        sum
    }

    /// `a(wi)` of the `DIFFUSE` lobes: incident flux `Φ` leaves with intensity `Φ a(wi) b(wo) |wo·ng| / π`
    /// on the side of the surface that `wi` is on.
    #[inline]
    pub fn diffuse_weight(&self, wi: Vec3) -> Rgb {
        let cos = wi.dot(self.ng).abs();
        if cos == 0.0 || !self.lobes.has(Lobes::DIFFUSE) {
            return Rgb::BLACK;
        }
        let local = self.frame.to_local(wi);
        let sum: Rgb = self
            .leaves
            .iter()
            .flatten()
            .map(|leaf| leaf.diffuse_weight(local))
            .sum();
        sum * (local.z.abs() / cos)
    }

    /// `b` of the `DIFFUSE` lobes.
    #[inline]
    pub fn exit(&self) -> ExitTransmittance<'s> {
        self.exit
    }

    /// Smallest roughness among the `GLOSSY` lobes (1 without any): the width of what must be resolved, in radians roughly.
    #[inline]
    pub fn glossy_width(&self) -> f32 {
        self.glossy_width
    }

    /// The normal that a receiver chooses emitters with: the shading normal on the side of `wo`. `None` if some lobe
    /// transmits: then light matters from both sides.
    #[inline]
    pub fn receiving_normal(&self, wo: Vec3) -> Option<Vec3> {
        if self.transmits {
            return None;
        }
        Some(self.frame.n * 1.0f32.copysign(wo.dot(self.frame.n)))
    }

    /// Fraction of flux from `wi` that leaves through `lobes` (delta ones included, straight-through not): in closed form for Lambert's
    /// model, else by deterministic quadrature over [`Bsdf::sample_wo`], good to about one percent.
    pub fn albedo(&self, wi: Vec3, lobes: Lobes) -> Rgb {
        if self.lobes.and(lobes) == Lobes::DIFFUSE
            && matches!(self.exit, ExitTransmittance::Lambert)
        {
            // |wo·ng| / π integrates to one over any hemisphere, that about ns included.
            return self.diffuse_weight(wi);
        }
        // Additive recurrence on the plastic number's powers: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences".
        const STEPS: [f64; 3] = [
            0.819_172_513_396_164_4,
            0.671_043_606_703_789_2,
            0.549_700_477_901_971,
        ];
        const COUNT: u32 = 1024;
        let sum: Rgb = (0..COUNT)
            .filter_map(|i| {
                let [a, b, c] = STEPS.map(|step| ((0.5 + step * f64::from(i + 1)) % 1.0) as f32);
                let u = BsdfNumbers {
                    lobe: a.min(LARGEST),
                    direction: Vec2::new(b.min(LARGEST), c.min(LARGEST)),
                };
                self.sample_wo(wi, u, lobes)
            })
            .map(|sample| sample.weight)
            .sum();
        sum / COUNT as f32
    }

    /// The shortcut for what most surfaces are: Lambert's model alone. `None` for others, and on a side that is black.
    #[inline]
    fn plain_lambert(&self, wo: Vec3) -> Option<Lambert> {
        match &self.leaves {
            [Some(leaf), None, ..] => leaf.plain_lambert(wo),
            _ => None,
        }
    }

    #[inline]
    fn eval_local(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let mut sum = Rgb::BLACK;
        for leaf in self.leaves.iter().map_while(Option::as_ref) {
            sum += leaf.eval(wi, wo, lobes);
        }
        sum
    }

    #[inline]
    fn pdf_local(&self, end: Given, given: Vec3, other: Vec3, lobes: Lobes) -> f32 {
        if let [Some(leaf), None, ..] = &self.leaves {
            return if leaf.answers(given, lobes) {
                leaf.pdf(end, given, other, lobes)
            } else {
                0.0
            };
        }
        let (mut sum, mut total) = (0.0, 0.0);
        for leaf in self.answering(given, lobes) {
            sum += leaf.weight * leaf.pdf(end, given, other, lobes);
            total += leaf.weight;
        }
        if total > 0.0 { sum / total } else { 0.0 }
    }

    /// `f |wi·ns|` and the density of sampling from `wo`, both by `lobes`. Local directions.
    #[inline]
    fn respond_local(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Response {
        let mut sum = Response::NONE;
        let mut total = 0.0;
        for leaf in self.answering(wo, lobes) {
            let Response { values, pdf } = leaf.respond(wi, wo, lobes);
            sum.values.add(&values, leaf.weight);
            sum.pdf += pdf * leaf.weight;
            total += leaf.weight;
        }
        if total > 0.0 {
            sum.pdf /= total;
        }
        sum
    }

    /// The leaves that can be sampled from `given`.
    #[inline]
    fn answering(&self, given: Vec3, lobes: Lobes) -> impl Iterator<Item = &Leaf<'s>> {
        self.leaves
            .iter()
            .map_while(Option::as_ref)
            .filter(move |leaf| leaf.answers(given, lobes))
    }

    /// A leaf in proportion to its weight, its probability, and `u` made uniform again.
    #[inline]
    fn choose_leaf(&self, given: Vec3, u: f32, lobes: Lobes) -> Option<(&Leaf<'s>, f32, f32)> {
        if let [Some(leaf), None, ..] = &self.leaves {
            return leaf.answers(given, lobes).then_some((leaf, 1.0, u));
        }
        let total: f32 = self.answering(given, lobes).map(|leaf| leaf.weight).sum();
        let mut left = u * total;
        let mut chosen = None;
        for leaf in self.answering(given, lobes) {
            chosen = Some((leaf, leaf.weight / total, (left / leaf.weight).min(LARGEST)));
            if left < leaf.weight {
                break;
            }
            left -= leaf.weight;
        }
        chosen
    }

    /// How often [`Bsdf::sample_wo`] samples about the geometric normal: only for wide lobes, in proportion to their leaves.
    #[inline]
    fn defensive_share(&self, given: Vec3, lobes: Lobes) -> f32 {
        if !self.defensive || !self.lobes.has(lobes.and(Lobes::NON_SPECULAR)) {
            return 0.0;
        }
        let weight = |lobes| {
            self.answering(given, lobes)
                .map(|leaf| leaf.weight)
                .sum::<f32>()
        };
        let (wide, all) = (weight(lobes.and(Lobes::NON_SPECULAR)), weight(lobes));
        if all > 0.0 {
            DEFENSIVE_SHARE * wide / all
        } else {
            0.0
        }
    }

    /// Draws `wi`; the density of the finite directions is [`Bsdf::pdf_wi`].
    #[inline]
    fn draw_wi(&self, local: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<Drawn> {
        let (leaf, share, lobe) = self.choose_leaf(local, u.lobe, lobes)?;
        let ModelSample { w, eta, delta } =
            leaf.sample(Given::Wo, local, BsdfNumbers { lobe, ..u }, lobes)?;
        let wi = self.frame.to_world(w);
        let Some(delta) = delta else {
            return Some(Drawn::Finite {
                w: wi,
                local: w,
                eta,
            });
        };
        // Radiance is scaled by the square of the index on its own side over that on the side it comes from.
        let weight = delta.fraction * (leaf.weight / (share * delta.probability * eta * eta));
        complete(wi, weight, 1.0, Lobes::DELTA, eta)
            .map(|sample| Drawn::Delta(BsdfSample { pdf: 0.0, ..sample }))
    }

    /// Draws `wo`; the density of the finite directions is [`Bsdf::pdf_wo`].
    fn draw_wo(&self, wi: Vec3, local: Vec3, mut u: BsdfNumbers, lobes: Lobes) -> Option<Drawn> {
        let defensive = self.defensive_share(local, lobes);
        if u.lobe < defensive {
            // Cosine-distributed about the geometric normal, on the side that the shading normal calls reflection: this bounds the
            // weight |wo·ng| / pdf. What falls on the other side is put through the surface, where it is missing.
            let w = Frame::from_normal(self.ng).to_world(warp::cosine_hemisphere(u.direction));
            let same_side = w.dot(self.frame.n) * local.z > 0.0;
            let w = if same_side { w } else { -w };
            return Some(Drawn::Finite {
                w,
                local: self.frame.to_local(w),
                eta: 1.0,
            });
        }
        u.lobe = ((u.lobe - defensive) / (1.0 - defensive)).min(LARGEST);
        let (leaf, share, lobe) = self.choose_leaf(local, u.lobe, lobes)?;
        let ModelSample { w, eta, delta } =
            leaf.sample(Given::Wi, local, BsdfNumbers { lobe, ..u }, lobes)?;
        let wo = self.frame.to_world(w);
        let Some(delta) = delta else {
            return Some(Drawn::Finite {
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
            .map(|sample| Drawn::Delta(BsdfSample { pdf: 0.0, ..sample }))
    }
}

/// The largest number below one.
const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;

/// A direction before its weight is known.
enum Drawn {
    Delta(BsdfSample),
    Finite { w: Vec3, local: Vec3, eta: f32 },
}

/// One finite class in proportion to its luminance, and its value over its probability.
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

/// A number for the choice of a class that does not follow the choice of the direction: that has used up the leading digits.
fn class_number(u: BsdfNumbers) -> f32 {
    rng::unit(rng::key([u.lobe, u.direction.x, u.direction.y]))
}

/// A sample unless it carries nothing; `weight` is not yet divided by `pdf`.
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
