//! Reflection on the front of the principled model, without branches.

use super::layers::Layers;
use super::terms::{ggx_masking, gtr1, schlick_weight};
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::models::fresnel;
use crate::bsdf::models::microfacet::Microfacets;
use crate::lanes::{Color, Float, Mask, One, Vector, Width, lanewise};
use crate::math::Vec3;

/// Roughness alpha of the masking of the clear coat (Burley 2012).
const CLEARCOAT_MASKING_ALPHA: f32 = 0.25;
/// Reflectance of the clear coat at normal incidence.
const CLEARCOAT_R0: f32 = 0.04;

/// The terms at a point. Lobes that are not requested have weight 0.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct PrincipledFront<S: Width> {
    /// Relative index of refraction.
    pub(in crate::bsdf) eta: Float<S>,
    /// Its inverse.
    pub(in crate::bsdf) inv_eta: Float<S>,
    /// Weight of the Fresnel reflectance of a dielectric.
    pub(in crate::bsdf) plain: Float<S>,
    /// Weight of Schlick's term (1 - cos)⁵.
    pub(in crate::bsdf) schlick: Float<S>,
    /// Weight of one minus Schlick's term: reflectance at normal incidence.
    pub(in crate::bsdf) schlick_r0: Color<S>,
    /// Diffuse albedo over π.
    pub(in crate::bsdf) base: Color<S>,
    pub(in crate::bsdf) sheen: Color<S>,
    pub(in crate::bsdf) roughness: Float<S>,
    pub(in crate::bsdf) flatness: Float<S>,
    pub(in crate::bsdf) clearcoat: Float<S>,
    /// Parameters of the clear coat's distribution; see [`gtr1`].
    pub(in crate::bsdf) clearcoat_excess: Float<S>,
    pub(in crate::bsdf) clearcoat_norm: Float<S>,
    /// The layers of glTF 2.0.
    pub(in crate::bsdf) layers: Layers<S>,
}

/// Reflection by the parts of a front.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrontParts<S: Width> {
    /// The microfacets of the main interface.
    pub(super) interface: Color<S>,
    /// The diffuse part with sheen.
    pub(super) diffuse: Color<S>,
    /// The clear coat, in all channels.
    pub(super) clearcoat: Float<S>,
    /// The clear coat of the layers, in all channels.
    pub(super) coat: Float<S>,
}

/// Fresnel reflectance of the clear coat by Schlick's term.
#[inline(always)]
fn clearcoat_fresnel<S: Width>(s: Float<S>) -> Float<S> {
    s + (1.0 - s) * CLEARCOAT_R0
}

impl<S: Width> PrincipledFront<S> {
    /// Whether there is a clear coat, sheen, flatness, or a diffuse lobe under the interface.
    #[inline(always)]
    pub(in crate::bsdf) fn has_extras(&self) -> Mask<S> {
        !(self.clearcoat.equals(0.0)
            & self.sheen.is_black()
            & self.flatness.equals(0.0)
            & self.layers.present.equals(0.0))
    }

    /// Reflectance of the main interface at the cosine `cos` to a facet. Schlick's term is at least
    /// `least`.
    #[inline(always)]
    pub(in crate::bsdf) fn interface_reflectance(&self, cos: Float<S>, least: f32) -> Color<S> {
        let (r, s) = self.fresnel_terms(cos);
        let mut sum = self.reflectance(r, s.max(least)) + self.layers.tinted(r);
        if self.layers.film.is_present().any() {
            let (reflected, _) = self.layers.film.reflection(cos, least);
            sum += reflected;
        }
        sum
    }

    /// Reflectance of a plain dielectric, and Schlick's term, at the cosine `cos` to a facet.
    #[inline(always)]
    fn fresnel_terms(&self, cos: Float<S>) -> (Float<S>, Float<S>) {
        let refracted = fresnel::refracted_cosine(cos, self.inv_eta);
        let r = fresnel::reflectance(cos, refracted, self.eta);
        // From the denser side, Schlick's approximation uses the angle of the refracted direction.
        let s = schlick_weight(self.eta.gt(1.0).select(cos, refracted));
        (r, s)
    }

    /// Reflectance of the main interface by [`PrincipledFront::fresnel_terms`].
    #[inline(always)]
    fn reflectance(&self, r: Float<S>, s: Float<S>) -> Color<S> {
        self.schlick_r0 * (1.0 - s) + Color::grey(self.plain * r + self.schlick * s)
    }

    /// Reflectance of the clear coat, with its weight, at the cosine `cos` to a facet.
    #[inline(always)]
    pub(in crate::bsdf) fn clearcoat_reflectance(&self, cos: Float<S>) -> Float<S> {
        self.clearcoat * clearcoat_fresnel(schlick_weight(cos))
    }

    /// `f |wi·n|` for local directions above the surface. `EXTRAS` is
    /// [`PrincipledFront::has_extras`], `seen` is [`Microfacets::seen`] of `wo`.
    #[inline(always)]
    pub(in crate::bsdf) fn eval<const EXTRAS: bool>(
        &self,
        facets: &Microfacets<S>,
        wi: Vector<S>,
        wo: Vector<S>,
        seen: Float<S>,
    ) -> Color<S> {
        let parts = self.parts::<EXTRAS>(facets, wi, wo, seen);
        let sum = parts.interface + parts.diffuse;
        if EXTRAS {
            sum + Color::grey(parts.clearcoat + parts.coat)
        } else {
            sum
        }
    }

    /// [`PrincipledFront::eval`] by parts.
    #[inline(always)]
    pub(super) fn parts<const EXTRAS: bool>(
        &self,
        facets: &Microfacets<S>,
        wi: Vector<S>,
        wo: Vector<S>,
        seen: Float<S>,
    ) -> FrontParts<S> {
        let half = wi + wo;
        // |wi + wo| = 2 wo·m for unit vectors.
        let cos = 0.5 * half.length();
        let (r, s) = self.fresnel_terms(cos);
        let clearcoat = if EXTRAS {
            self.clearcoat(s, half.z / (2.0 * cos), wi.z, wo.z) * wi.z
        } else {
            cos.same(0.0)
        };
        let facing = facets.visible_density(wi, half) * seen;
        let mut interface = self.reflectance(r, s);
        let mut kept = r;
        if EXTRAS && self.layers.film.is_present().any() {
            let (reflected, reflectance) = self.layers.film.reflection(cos, 0.0);
            interface += reflected;
            kept = self.layers.film.kept(r, reflectance);
        }
        let mut parts = FrontParts {
            interface: interface * facing,
            diffuse: self.diffuse::<EXTRAS>(wi, wo, cos, kept) * wi.z,
            clearcoat,
            coat: cos.same(0.0),
        };
        if EXTRAS {
            parts.interface += self.layers.tinted(r) * facing;
            if self.layers.has_coat().any() {
                let passing = self.layers.passing(wi.z) * self.layers.passing(wo.z);
                parts.interface = parts.interface * passing;
                parts.diffuse = parts.diffuse * passing;
                parts.coat = self.layers.coat_lobe(wi, wo, half, cos);
            }
        }
        parts
    }

    /// The clear coat, without the cosine of `wi`.
    #[inline(always)]
    fn clearcoat(
        &self,
        s: Float<S>,
        cos_m: Float<S>,
        cos_i: Float<S>,
        cos_o: Float<S>,
    ) -> Float<S> {
        let f = clearcoat_fresnel(s);
        let masking = ggx_masking(cos_i, CLEARCOAT_MASKING_ALPHA)
            * ggx_masking(cos_o, CLEARCOAT_MASKING_ALPHA);
        self.clearcoat * f * gtr1(self.clearcoat_excess, self.clearcoat_norm, cos_m) * masking
    }

    /// Diffuse reflection with retro-reflection, flatness and sheen, without the cosine of `wi`.
    /// `r` is the reflectance of the interface over the diffuse lobe of the layers.
    #[inline(always)]
    fn diffuse<const EXTRAS: bool>(
        &self,
        wi: Vector<S>,
        wo: Vector<S>,
        cos_d: Float<S>,
        r: Float<S>,
    ) -> Color<S> {
        let (fi, fo) = (schlick_weight(wi.z), schlick_weight(wo.z));
        let lambert = (1.0 - 0.5 * fi) * (1.0 - 0.5 * fo);
        let rr = 2.0 * self.roughness * cos_d * cos_d;
        let full = lambert + rr * (fi + fo + fi * fo * (rr - 1.0));
        if !EXTRAS {
            return self.base * full;
        }
        let f90 = 0.5 * rr;
        let fss = (1.0 + (f90 - 1.0) * fi) * (1.0 + (f90 - 1.0) * fo);
        let flat = 1.25 * (fss * ((wi.z + wo.z).recip() - 0.5) + 0.5);
        let shape = full + (flat - full) * self.flatness;
        let shape = shape + (1.0 - r - shape) * self.layers.present;
        self.base * shape + self.sheen * schlick_weight(cos_d)
    }
}

lanewise!(PrincipledFront {
    eta,
    inv_eta,
    plain,
    schlick,
    schlick_r0,
    base,
    sheen,
    roughness,
    flatness,
    clearcoat,
    clearcoat_excess,
    clearcoat_norm,
    layers,
});

impl<S: Width> PrincipledFront<S> {
    /// The front with all its light times `weight`.
    #[inline(always)]
    fn weighted(self, weight: Float<S>) -> Self {
        PrincipledFront {
            plain: self.plain * weight,
            schlick: self.schlick * weight,
            schlick_r0: self.schlick_r0 * weight,
            base: self.base * weight,
            sheen: self.sheen * weight,
            clearcoat: self.clearcoat * weight,
            layers: self.layers.weighted(weight),
            ..self
        }
    }

    /// The front times `weight`, with the `facets` of its main interface, for a local `wo` above
    /// the surface.
    #[inline(always)]
    pub(super) fn with_wo(
        self,
        facets: Microfacets<S>,
        wo: Vector<S>,
        weight: Float<S>,
    ) -> PrincipledToWo<S> {
        PrincipledToWo {
            front: self.weighted(weight),
            facets,
            seen: facets.seen(wo),
        }
    }
}

/// [`PrincipledFront`] with a fixed `wo`.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct PrincipledToWo<S: Width> {
    front: PrincipledFront<S>,
    facets: Microfacets<S>,
    /// [`Microfacets::seen`].
    seen: Float<S>,
}

lanewise!(PrincipledToWo {
    front,
    facets,
    seen
});

impl<S: Width> PrincipledToWo<S> {
    /// [`PrincipledFront::has_extras`].
    #[inline(always)]
    pub(in crate::bsdf) fn has_extras(&self) -> Mask<S> {
        self.front.has_extras()
    }

    /// `f cosθ_i` for local directions. `EXTRAS` is [`PrincipledToWo::has_extras`].
    #[inline(always)]
    pub(in crate::bsdf) fn f_cos_wi<const EXTRAS: bool>(
        &self,
        wi: Vector<S>,
        wo: Vector<S>,
    ) -> Color<S> {
        let values = self.front.eval::<EXTRAS>(&self.facets, wi, wo, self.seen);
        values.within(wi.z.gt(0.0))
    }
}

impl PrincipledToWo<One> {
    /// Upper bound of all channels of [`PrincipledToWo::f_cos_wi`] over a cone of `wi`.
    #[inline(always)]
    pub(in crate::bsdf) fn bound(&self, incident: &IncidentCone, wo: Vec3) -> f32 {
        (self.front).bound(&self.facets, incident, wo, self.seen.get())
    }
}

impl PrincipledFront<One> {
    /// Upper bound of all channels of [`PrincipledFront::eval`] over a cone of `wi`.
    #[inline(always)]
    pub(in crate::bsdf) fn bound(
        &self,
        facets: &Microfacets<One>,
        incident: &IncidentCone,
        wo: Vec3,
        seen: f32,
    ) -> f32 {
        let weight = |cos: f32| schlick_weight::<One>(cos.into()).get();
        let [lowest, highest] = incident.cosines();
        let halves = incident.halves(wo);
        let [cos_d, most_cos_d] = halves.cosines;
        // All reflectances increase with the angle.
        let (r, s) = self.fresnel_terms(cos_d.into());
        let plain = self.plain * r + self.schlick * s;
        let tinted = self.layers.tinted_bound();
        let film = self.layers.film.bound(cos_d);
        let reflectance = self.schlick_r0.max_channel().get() + plain.get() + tinted + film;
        let interface = facets.projected_bound(halves.highest, incident) * seen;
        let projection = incident.projection(highest);

        // Retro-reflection increases with θ_i, the rest of the diffuse lobe decreases.
        let (least_fi, fi) = (weight(highest), weight(lowest.max(0.0)));
        let fo = weight(wo.z);
        let rr = 2.0 * self.roughness.get() * most_cos_d * most_cos_d;
        let lambert = (1.0 - 0.5 * least_fi) * (1.0 - 0.5 * fo);
        let full = (lambert + rr * (fi + fo + fi * fo * (rr - 1.0))) * projection;
        let flat = match incident.projected {
            None => 1.25 * highest / (highest + wo.z),
            Some(projected) => 1.25 * projected / (lowest.max(0.0) + wo.z),
        };
        let flatness = self.flatness.get();
        let base = full * (1.0 - flatness) + flat * flatness;
        let base = base + (projection - base) * self.layers.present.get();
        let sheen = self.sheen.max_channel().get() * weight(cos_d);
        let highest_m = halves.highest.max(0.0).into();
        let clearcoat = self.clearcoat(s, highest_m, highest.into(), wo.z.into());
        let rest = self.base.max_channel().get() * base + (sheen + clearcoat.get()) * projection;
        if highest > 0.0 {
            let passing = self.layers.passing_bound(highest, wo);
            let coat = (self.layers).coat_bound(incident, wo, halves.highest, cos_d);
            (reflectance * interface + rest) * passing + coat
        } else {
            0.0
        }
    }
}
