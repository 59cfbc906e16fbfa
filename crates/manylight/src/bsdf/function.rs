//! The scattering function at a point: its leaves, their values and densities, and upper bounds
//! over cones of directions, for cuts through a tree of lights.

use super::Lobes;
use super::exit_transmittance::ExitTransmittance;
use super::incident_cone::IncidentCone;
use super::lambert::Lambert;
use super::leaf::{Given, Leaf};
use super::lobes::Classes;
use super::model::Model;
use super::response::{ByClass, Response};
use crate::color::Rgb;
use crate::geometry::SurfacePoints;
use crate::lanes::{Axes, Color, Float, Mask, One, Vector, Width};
use crate::math::{Cone, Spread, Vec3};
use crate::simd::outlined;
use std::f32::consts::FRAC_1_PI;

/// Most leaves of a material at a point; see [`Materials::bsdf`].
pub(super) const MAX_LEAVES: usize = 4;

/// Absolute cosine between shading normal and geometric normal from which they count as equal:
/// rounding of interpolated normals.
pub(super) const ALIGNED_COSINE: f32 = 0.9998;

/// The scattering function at a point, or at a point of one material in each lane. It is `Copy`,
/// and borrows only precomputed tables of the scene.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'s, S: Width = One> {
    /// Geometric normal.
    pub(super) ng: Vector<S>,
    /// Shading frame.
    pub(super) frame: Axes<S>,
    /// The leaves, followed by `None`.
    pub(super) leaves: [Option<Leaf<'s, S>>; MAX_LEAVES],
    /// Fraction of light that passes straight through masks and null materials, by side: that of
    /// the shading normal, the other.
    pub(super) pass_through: [Float<S>; 2],
    /// Whether any light passes straight through, thin dielectrics included.
    pub(super) is_transparent: bool,
    /// The lanes in which a finite lobe transmits.
    pub(super) transmits: Mask<S>,
    /// The classes of all lobes with positive weight.
    pub(super) classes: Classes<S>,
    /// The lanes in which photon walks need defensive sampling: some normal in use is not the
    /// geometric one.
    pub(super) is_defensive: Mask<S>,
}

/// What next-event estimation needs for given `wi` and `wo`, per lane; black where nothing is
/// scattered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DirectResponses<S: Width> {
    /// `f |wi·ng|` of the `NON_SPECULAR` lobes.
    pub(crate) non_specular: Color<S>,
    /// `f |wi·ng|` of the `NEAR_DELTA` lobes.
    pub(crate) near_delta: Color<S>,
    /// Density of [`Bsdf::sample_wi`] for all lobes, per solid angle.
    pub(crate) pdf: Float<S>,
}

// Compiled once for each instruction set, because every caller would otherwise have a copy of every
// model.
outlined! {
    fn direct_responses<S: Width>(
        bsdf: &Bsdf<'_, S>, wi: Vector<S>, wo: Vector<S>,
    ) -> DirectResponses<S> { bsdf.width() => bsdf.direct_responses_inlined(wi, wo) }

    fn f_cos_wo_each<S: Width>(
        bsdf: &Bsdf<'_, S>, wi: Vector<S>, wo: Vector<S>, lobes: Lobes,
    ) -> Color<S> { bsdf.width() => bsdf.f_cos_wo_each_inlined(wi, wo, lobes) }

    fn responses<S: Width>(
        bsdf: &Bsdf<'_, S>, wi: Vector<S>, wo: Vector<S>, lobes: Lobes,
    ) -> (Color<S>, Float<S>) { bsdf.width() => bsdf.responses_inlined(wi, wo, lobes) }
}

impl<'s> Bsdf<'s> {
    /// The classes of all lobes with positive weight.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        self.classes.get()
    }

    /// Whether a finite lobe transmits light to the other side.
    #[inline]
    pub fn transmits(&self) -> bool {
        self.transmits.any()
    }

    /// `b(wo)` of the `DIFFUSE` lobes; see [`Bsdf::diffuse_weight`].
    #[inline]
    pub fn exit_transmittance(&self) -> ExitTransmittance<'s> {
        let diffuse = self.leaves().find(|leaf| leaf.lobes.diffuse.any());
        diffuse.map_or(ExitTransmittance::Lambert, |leaf| {
            leaf.model.exit_transmittance()
        })
    }

    /// Smallest roughness alpha of the `GLOSSY` lobes; 1 without such lobes. It is roughly the
    /// width of the lobe in radians.
    #[inline]
    pub fn glossy_roughness(&self) -> f32 {
        self.glossy_roughnesses().get()
    }

    /// The normal for sampling emitters: the shading normal on the side of `wo`. `None` if some
    /// lobe transmits, because then light from both sides contributes.
    #[inline]
    pub fn receiving_normal(&self, wo: Vec3) -> Option<Vec3> {
        let (n, is_one_sided) = self.receiving_normals(wo.into());
        is_one_sided.any().then(|| n.into())
    }

    /// The function in all lanes.
    #[inline(always)]
    pub(crate) fn in_lanes<S: Width>(&self, s: S) -> Bsdf<'s, S> {
        let mut leaves = [None; MAX_LEAVES];
        for (all, leaf) in leaves.iter_mut().zip(self.leaves()) {
            *all = Some(leaf.in_lanes(s));
        }
        let [front, back] = &self.pass_through;
        Bsdf {
            ng: self.ng.in_lanes(s),
            frame: self.frame.in_lanes(s),
            leaves,
            pass_through: [front.in_lanes(s), back.in_lanes(s)],
            is_transparent: self.is_transparent,
            transmits: self.transmits.in_lanes(s),
            classes: self.classes.in_lanes(s),
            is_defensive: self.is_defensive.in_lanes(s),
        }
    }

    /// Whether a bump or normal map tilts the normal of some leaf.
    pub(super) fn is_tilted(&self) -> bool {
        self.leaves().any(|leaf| leaf.tilted().is_some())
    }

    /// `f(wi → wo)` in 1/sr: `f_s |wi·ns| / |wi·ng|`, where `f_s` is the model in the shading
    /// frame. With this definition all other formulas use geometric cosines. Whether `wi` and `wo`
    /// are on the same side is decided by the shading normal `ns`, as in Mitsuba's path tracer.
    /// Transmission scales radiance by η².
    pub fn f(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let cos = wi.dot(self.ng.into()).abs();
        if cos == 0.0 {
            return Rgb::BLACK;
        }
        self.f_cos_wi(wi, wo, lobes) / cos
    }

    /// `f |wi·ng|`, the factor of incident radiance. Computed without a division by the cosine.
    pub fn f_cos_wi(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        if !self.lobes().has(lobes.and(Lobes::FINITE)) {
            return Rgb::BLACK;
        }
        let (wi, wo) = (
            self.frame.to_local(wi.into()),
            self.frame.to_local(wo.into()),
        );
        self.values_local(wi, wo, lobes.into()).sum().into()
    }

    /// `f |wo·ng|`: radiant intensity towards `wo` over incident flux.
    #[inline]
    pub fn f_cos_wo(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        self.f(wi, wo, lobes) * wo.dot(self.ng.into()).abs()
    }

    /// Density of [`Bsdf::sample_wi`] per solid angle, without delta lobes.
    pub fn pdf_wi(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> f32 {
        let (wi, wo) = (
            self.frame.to_local(wi.into()),
            self.frame.to_local(wo.into()),
        );
        self.pdf_local(Given::Wo, wo, wi, lobes.into()).get()
    }

    /// Density of [`Bsdf::sample_wo`] per solid angle, without delta lobes.
    pub fn pdf_wo(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> f32 {
        let (given, wo) = (self.frame.to_local(wi.into()), wo.into());
        let other = self.frame.to_local(wo);
        self.pdf_wo_local(given, wo, other, lobes.into()).get()
    }

    /// Fraction of light that passes straight through along `w`, as if there were no surface (mask,
    /// null, thin dielectric). The weights of the lobes contain the opacity.
    pub fn transmittance(&self, w: Vec3) -> Rgb {
        self.transmittances(w.into()).map_or(Rgb::BLACK, Rgb::from)
    }

    /// `a(wi)` of the `DIFFUSE` lobes, `f = a(wi) b(wo) / π` on the side of `wi`: incident flux Φ
    /// gives the radiant intensity `Φ a(wi) b(wo) |wo·ng| / π`.
    pub fn diffuse_weight(&self, wi: Vec3) -> Rgb {
        self.diffuse_weights(wi.into()).into()
    }

    /// Upper bound of all channels of [`Bsdf::f_cos_wi`] over a cone of `wi`, with directions in
    /// the shading frame. Infinite for rough dielectrics of index 1.
    pub(super) fn bound_local(&self, incident: &IncidentCone, wo: Vec3, lobes: Lobes) -> f32 {
        self.leaves()
            .map(|leaf| leaf.bound(incident, wo, lobes))
            .sum()
    }

    /// Upper bound of all channels of [`Bsdf::f_cos_wo`] of the `NON_SPECULAR` lobes over the
    /// directions `wo` in `cone`. It is found from the reciprocity of the models, with the cosine
    /// of `wo` to the geometric normal. Infinite for surfaces that transmit.
    pub fn bound_f_cos_wo(&self, wi: Vec3, cone: &Cone) -> f32 {
        if self.transmits() {
            return f32::INFINITY;
        }
        let spread = Spread::new(cone.half_angle);
        let (ng, ns) = (Vec3::from(self.ng), Vec3::from(self.frame.n));
        let [lowest, highest] = spread.cosines(cone.axis.dot(ng));
        let is_untilted = ns == ng || ns == -ng;
        let leaving = IncidentCone {
            axis: self.frame.to_local(cone.axis.into()).into(),
            spread,
            projected: (!is_untilted).then_some(highest.max(-lowest)),
        };
        let local = Vec3::from(self.frame.to_local(wi.into()));
        let sum: f32 = self
            .leaves()
            .map(|leaf| leaf.bound_leaving(local, &leaving, Lobes::NON_SPECULAR))
            .sum();
        sum / wi.dot(ng).abs()
    }
}

impl<'s, S: Width> Bsdf<'s, S> {
    /// The scattering functions of a material at `x` before its leaves are known.
    #[inline(always)]
    pub(crate) fn without_leaves(x: &SurfacePoints<S>) -> Self {
        let s = x.offset.width();
        Bsdf {
            ng: x.ng,
            frame: x.frame,
            leaves: [None; MAX_LEAVES],
            pass_through: [Float::splat(s, 0.0); 2],
            is_transparent: false,
            transmits: Mask::splat(s, false),
            classes: Classes::splat(s, Lobes::NONE),
            is_defensive: x.frame.n.dot(x.ng).abs().lt(ALIGNED_COSINE),
        }
    }

    /// The instruction set of the lanes.
    #[inline(always)]
    pub(super) fn width(&self) -> S {
        self.ng.x.width()
    }

    /// [`Bsdf::f_cos_wo`] in each lane.
    #[inline(always)]
    pub(super) fn f_cos_wo_each(&self, wi: Vector<S>, wo: Vector<S>, lobes: Lobes) -> Color<S> {
        f_cos_wo_each(self, wi, wo, lobes)
    }

    #[inline(always)]
    fn f_cos_wo_each_inlined(&self, wi: Vector<S>, wo: Vector<S>, lobes: Lobes) -> Color<S> {
        let cos = wi.dot(self.ng).abs();
        let (local, to) = (self.frame.to_local(wi), self.frame.to_local(wo));
        let values = self.values_local(local, to, Classes::splat(self.width(), lobes));
        (values.sum() * (wo.dot(self.ng).abs() / cos)).within(cos.gt(0.0))
    }

    /// [`Bsdf::receiving_normal`], and the lanes in which there is one.
    #[inline(always)]
    pub(crate) fn receiving_normals(&self, wo: Vector<S>) -> (Vector<S>, Mask<S>) {
        let n = self.frame.n;
        (n * wo.dot(n).sign(), !self.transmits)
    }

    /// [`Bsdf::glossy_roughness`] in each lane.
    #[inline(always)]
    pub(crate) fn glossy_roughnesses(&self) -> Float<S> {
        let mut least = Float::splat(self.width(), 1.0);
        for leaf in self.leaves() {
            least = least.min(leaf.model.glossy_roughness());
        }
        least
    }

    /// [`Bsdf::lobes`] of each lane.
    #[inline(always)]
    pub(crate) fn lobes_each(&self) -> S::Each<Lobes> {
        self.classes.each()
    }

    /// The lanes in which a finite lobe transmits.
    #[inline(always)]
    pub(crate) fn transmitting(&self) -> Mask<S> {
        self.transmits
    }

    /// The lanes with lobes of the classes `lobes`.
    #[inline(always)]
    pub(crate) fn has(&self, lobes: Lobes) -> Mask<S> {
        self.classes.has(Classes::splat(self.width(), lobes))
    }

    #[inline(always)]
    pub(super) fn leaves(&self) -> impl Iterator<Item = &Leaf<'s, S>> {
        self.leaves.iter().map_while(Option::as_ref)
    }

    /// The only leaf, if there is one.
    #[inline(always)]
    pub(super) fn only_leaf(&self) -> Option<&Leaf<'s, S>> {
        match &self.leaves {
            [Some(leaf), None, ..] => Some(leaf),
            _ => None,
        }
    }

    /// The weight of a leaf in the choice among several: 0 where `lobes` cannot be sampled given
    /// the local direction `given`.
    #[inline(always)]
    pub(super) fn choice_weight(
        &self,
        leaf: &Leaf<'s, S>,
        given: Vector<S>,
        lobes: Classes<S>,
    ) -> Float<S> {
        let can_sample = leaf.can_sample(given, lobes);
        can_sample.select(leaf.sampling_weight(given, lobes), 0.0)
    }

    /// [`Bsdf::f_cos_wi`] of the `NON_SPECULAR` and of the `NEAR_DELTA` lobes, and [`Bsdf::pdf_wi`]
    /// of all lobes, at the cost of one evaluation.
    #[inline(always)]
    pub(crate) fn direct_responses(&self, wi: Vector<S>, wo: Vector<S>) -> DirectResponses<S> {
        direct_responses(self, wi, wo)
    }

    /// [`Bsdf::f_cos_wi`] and [`Bsdf::pdf_wi`] of `lobes` in each lane.
    #[inline(always)]
    pub(crate) fn responses(
        &self,
        wi: Vector<S>,
        wo: Vector<S>,
        lobes: Lobes,
    ) -> (Color<S>, Float<S>) {
        responses(self, wi, wo, lobes)
    }

    #[inline(always)]
    fn direct_responses_inlined(&self, wi: Vector<S>, wo: Vector<S>) -> DirectResponses<S> {
        let (wi, wo) = (self.frame.to_local(wi), self.frame.to_local(wo));
        if let Some(lambert) = self.plain_lambert(wo) {
            let pdf = lambert.pdf(wi);
            return DirectResponses {
                non_specular: lambert.albedo * pdf,
                near_delta: Color::black(self.width()),
                pdf,
            };
        }
        let all = Classes::splat(self.width(), Lobes::ALL);
        let Response { values, pdf } = self.respond_local(wi, wo, all);
        DirectResponses {
            non_specular: values.diffuse + values.glossy,
            near_delta: values.near_delta,
            pdf,
        }
    }

    #[inline(always)]
    fn responses_inlined(
        &self,
        wi: Vector<S>,
        wo: Vector<S>,
        lobes: Lobes,
    ) -> (Color<S>, Float<S>) {
        let (wi, wo) = (self.frame.to_local(wi), self.frame.to_local(wo));
        if lobes.has(Lobes::DIFFUSE)
            && let Some(lambert) = self.plain_lambert(wo)
        {
            let pdf = lambert.pdf(wi);
            return (lambert.albedo * pdf, pdf);
        }
        let lobes = Classes::splat(self.width(), lobes);
        let Response { values, pdf } = self.respond_local(wi, wo, lobes);
        (values.sum(), pdf)
    }

    /// [`Bsdf::diffuse_weight`] in each lane.
    #[inline(always)]
    pub(crate) fn diffuse_weights(&self, wi: Vector<S>) -> Color<S> {
        let cos = wi.dot(self.ng).abs();
        let mut sum = Color::black(self.width());
        let defined = cos.gt(0.0) & self.classes.diffuse;
        if defined.none() {
            return sum;
        }
        let local = self.frame.to_local(wi);
        for leaf in self.leaves() {
            sum += leaf.diffuse_weight(local);
        }
        (sum * (local.z.abs() / cos)).within(defined)
    }

    /// [`Bsdf::transmittance`] in each lane; `None` if no light passes straight through in any.
    #[inline(always)]
    pub(crate) fn transmittances(&self, w: Vector<S>) -> Option<Color<S>> {
        if !self.is_transparent {
            return None;
        }
        let local = self.frame.to_local(w);
        let [front, back] = self.pass_through;
        let mut sum = Color::grey(local.z.lt(0.0).select(back, front));
        for leaf in self.leaves() {
            if let Model::ThinDielectric(thin) = &leaf.model {
                sum += thin.transmittance(local.z) * leaf.weight;
            }
        }
        Some(sum)
    }

    /// [`Bsdf::pdf_wo`] with `wi` and `wo` in the shading frame as `given` and `other`.
    #[inline(always)]
    pub(super) fn pdf_wo_local(
        &self,
        given: Vector<S>,
        wo: Vector<S>,
        other: Vector<S>,
        lobes: Classes<S>,
    ) -> Float<S> {
        let pdf = self.pdf_local(Given::Wi, given, other, lobes);
        let defensive = self.defensive_probability(given, lobes);
        if defensive.gt(0.0).none() {
            return pdf;
        }
        let same_side = (given.z * other.z).gt(0.0);
        let about_ng = same_side.select(wo.dot(self.ng).abs() * FRAC_1_PI, 0.0);
        (1.0 - defensive) * pdf + defensive * about_ng
    }

    /// The surface as Lambert's model alone, for the shortcuts of the most frequent material.
    /// `None` for other materials.
    #[inline(always)]
    pub(super) fn plain_lambert(&self, wo: Vector<S>) -> Option<Lambert<S>> {
        self.only_leaf()?.plain_lambert(wo)
    }

    /// `f |wi·ns|` of `lobes` by class. Directions in the shading frame.
    #[inline(always)]
    pub(super) fn values_local(
        &self,
        wi: Vector<S>,
        wo: Vector<S>,
        lobes: Classes<S>,
    ) -> ByClass<S> {
        let mut sum = ByClass::black(self.width());
        for leaf in self.leaves() {
            sum.add(&leaf.respond(wi, wo, lobes).values, leaf.weight);
        }
        sum
    }

    /// Density of sampling `other` given `given`, both in the shading frame, without defensive
    /// sampling.
    #[inline(always)]
    fn pdf_local(
        &self,
        end: Given,
        given: Vector<S>,
        other: Vector<S>,
        lobes: Classes<S>,
    ) -> Float<S> {
        if let Some(leaf) = self.only_leaf() {
            let can_sample = leaf.can_sample(given, lobes);
            return can_sample.select(leaf.pdf(end, given, other, lobes), 0.0);
        }
        let zero = Float::splat(self.width(), 0.0);
        let (mut sum, mut total) = (zero, zero);
        for leaf in self.leaves() {
            let weight = self.choice_weight(leaf, given, lobes);
            let pdf = leaf.pdf(end, given, other, lobes);
            sum += weight.gt(0.0).select(weight * pdf, 0.0);
            total += weight;
        }
        total.gt(0.0).select(sum / total, 0.0)
    }

    /// `f |wi·ns|` of `lobes` by class, and the density of sampling `wi` given `wo`. Directions in
    /// the shading frame.
    #[inline(always)]
    pub(super) fn respond_local(
        &self,
        wi: Vector<S>,
        wo: Vector<S>,
        lobes: Classes<S>,
    ) -> Response<S> {
        if let Some(leaf) = self.only_leaf() {
            let Response { values, pdf } = leaf.respond(wi, wo, lobes);
            return Response {
                values: values.map(|v| v * leaf.weight),
                pdf: leaf.can_sample(wo, lobes).select(pdf, 0.0),
            };
        }
        let mut sum = Response::none(self.width());
        let mut total = sum.pdf;
        for leaf in self.leaves() {
            let weight = self.choice_weight(leaf, wo, lobes);
            let Response { values, pdf } = leaf.respond(wi, wo, lobes);
            sum.values.add(&values, leaf.weight);
            sum.pdf += weight.gt(0.0).select(weight * pdf, 0.0);
            total += weight;
        }
        sum.pdf = total.gt(0.0).select(sum.pdf / total, 0.0);
        sum
    }
}
