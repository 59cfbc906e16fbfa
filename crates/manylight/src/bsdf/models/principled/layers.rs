//! The layers of glTF 2.0: a tinted dielectric interface over the diffuse part, perhaps with a thin
//! film, and a clear coat over both.
//!
//! Sources: "glTF 2.0 Specification", appendix B; KHR_materials_specular; KHR_materials_clearcoat.
//! The coat is weighted by Fresnel's equations, and what is below by the light that passes it on
//! both ways, so that the model is reciprocal; the specification has the way to the viewer alone.

use super::film::{Film, FilmParameters};
use crate::bsdf::incident_cone::IncidentCone;
use crate::bsdf::lobes::Classes;
use crate::bsdf::material::{CoatReflection, Distribution};
use crate::bsdf::models::fresnel;
use crate::bsdf::models::microfacet::Microfacets;
use crate::lanes::{Color, Float, Mask, One, Vector, Width, lanewise};
use crate::math::Vec3;

/// Index of refraction of the clear coat.
const COAT_ETA: f32 = 1.5;
/// Smallest roughness alpha of the clear coat: that of the main interface.
const MIN_ALPHA: f32 = 1e-3;

/// Parameters at a point; names as in
/// [`PrincipledLayers`](crate::bsdf::material::PrincipledLayers).
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct LayerParameters<S: Width> {
    pub specular_tint: Color<S>,
    /// Weight of the coat.
    pub coat: Float<S>,
    pub coat_roughness: Float<S>,
    pub coat_reflection: CoatReflection,
    pub diffuse: Float<S>,
    pub film: Option<FilmParameters<S>>,
}

impl<S: Width> LayerParameters<S> {
    /// What the tint adds to the reflectance `r` of an interface of index `eta`, over `1 - r`: the
    /// sum is `c r0` at normal incidence for the tint `c`, and 1 at grazing angles.
    #[inline(always)]
    pub(super) fn added(&self, eta: f32) -> Color<S> {
        let r0 = ((eta - 1.0) / (eta + 1.0)).powi(2);
        let per_tint = r0 / (1.0 - r0);
        self.specular_tint.map(|c| ((c - 1.0) * per_tint).min(1.0))
    }

    /// Roughness alpha of the coat.
    #[inline(always)]
    pub(super) fn coat_alpha(&self) -> Float<S> {
        (self.coat_roughness * self.coat_roughness).max(MIN_ALPHA)
    }
}

/// The layers at a point.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Layers<S: Width> {
    /// 1 if the diffuse lobe is Lambertian under the main interface, else 0.
    pub(super) present: Float<S>,
    /// [`LayerParameters::added`]; in [`PrincipledFront`](super::PrincipledFront) with the weight
    /// of the dielectric.
    tint: Color<S>,
    /// Weight of the coat where it keeps light from what is below.
    coat: Float<S>,
    /// Weight of the coat where it reflects.
    reflecting: Float<S>,
    facets: Microfacets<S>,
    /// The film over the main interface.
    pub(super) film: Film<S>,
}

lanewise!(Layers {
    present,
    tint,
    coat,
    reflecting,
    facets,
    film,
});

impl<S: Width> Layers<S> {
    /// Layers with this [`LayerParameters::added`], and a coat of this weight and roughness alpha
    /// that reflects with the weight `reflecting`.
    #[inline(always)]
    pub(super) fn new(
        tint: Color<S>,
        coat: Float<S>,
        reflecting: Float<S>,
        alpha: Float<S>,
        film: Film<S>,
    ) -> Self {
        Layers {
            present: coat.same(1.0),
            tint,
            coat,
            reflecting,
            facets: Microfacets::new(Distribution::Ggx, alpha, alpha),
            film,
        }
    }

    /// No layers.
    #[inline(always)]
    pub(super) fn none(s: S) -> Self {
        let zero = Float::splat(s, 0.0);
        let one = Float::splat(s, 1.0);
        Layers {
            present: zero,
            tint: Color::grey(zero),
            coat: zero,
            reflecting: zero,
            facets: Microfacets::new(Distribution::Ggx, one, one),
            film: Film::new(FilmParameters::none(s), Color::grey(zero)),
        }
    }

    /// The layers in a front with `lobes`, in which the interface has the weight `interface`, and
    /// the dielectric without a film the weight `plain`.
    #[inline(always)]
    pub(super) fn requested(
        &self,
        interface: Float<S>,
        plain: Float<S>,
        lobes: Classes<S>,
    ) -> Self {
        Layers {
            tint: self.tint * plain,
            film: self.film.requested(interface),
            reflecting: lobes.has(self.coat_class()).select(self.reflecting, 0.0),
            ..*self
        }
    }

    /// With all its light times `weight`.
    #[inline(always)]
    pub(super) fn weighted(self, weight: Float<S>) -> Self {
        Layers {
            tint: self.tint * weight,
            reflecting: self.reflecting * weight,
            film: self.film.weighted(weight),
            ..self
        }
    }

    /// What the tint adds to the plain reflectance `r`.
    #[inline(always)]
    pub(super) fn tinted(&self, r: Float<S>) -> Color<S> {
        self.tint * (1.0 - r)
    }

    #[inline(always)]
    pub(super) fn has_coat(&self) -> Mask<S> {
        self.coat.gt(0.0)
    }

    #[inline(always)]
    pub(super) fn coat_facets(&self) -> &Microfacets<S> {
        &self.facets
    }

    #[inline(always)]
    fn coat_class(&self) -> Classes<S> {
        self.facets.class()
    }

    /// Light that the coat reflects at the cosine `cos` to a facet.
    #[inline(always)]
    pub(super) fn coat_reflectance(&self, cos: Float<S>) -> Float<S> {
        self.reflecting * coat_fresnel(cos)
    }

    /// Fraction of light that passes the coat at the cosine `cos` to the surface normal.
    #[inline(always)]
    pub(super) fn passing(&self, cos: Float<S>) -> Float<S> {
        1.0 - self.coat * coat_fresnel(cos)
    }

    /// The reflection of the coat times the cosine of `wi`; `cos` is that of both directions to
    /// `half`, which need not have unit length.
    #[inline(always)]
    pub(super) fn coat_lobe(
        &self,
        wi: Vector<S>,
        wo: Vector<S>,
        half: Vector<S>,
        cos: Float<S>,
    ) -> Float<S> {
        let facets = self.facets.visible_density(wi, half) * self.facets.seen(wo);
        let value = self.reflecting * coat_fresnel(cos) * facets;
        self.reflecting.gt(0.0).select(value, 0.0)
    }
}

/// Fresnel reflectance of the coat at the cosine `cos`.
#[inline(always)]
fn coat_fresnel<S: Width>(cos: Float<S>) -> Float<S> {
    let (eta, inv_eta) = (cos.same(COAT_ETA), cos.same(COAT_ETA.recip()));
    fresnel::coat_reflectance(cos.max(0.0), eta, inv_eta)
}

impl Layers<One> {
    /// Upper bound of the light that passes the coat, for cosines of `wi` of at most `highest`.
    pub(super) fn passing_bound(&self, highest: f32, wo: Vec3) -> f32 {
        let passing = self.passing(highest.into()) * self.passing(wo.z.into());
        passing.get()
    }

    /// Upper bound of [`Layers::tinted`].
    pub(super) fn tinted_bound(&self) -> f32 {
        self.tint.max_channel().get().max(0.0)
    }

    /// Upper bound of [`Layers::coat_lobe`] over a cone of `wi`, given the bound of the cosine to
    /// the surface normal of half vectors, and the smallest cosine to them.
    pub(super) fn coat_bound(
        &self,
        incident: &IncidentCone,
        wo: Vec3,
        highest_half: f32,
        least_cos: f32,
    ) -> f32 {
        if self.reflecting.get() <= 0.0 {
            return 0.0;
        }
        let density = self.facets.projected_bound(highest_half, incident);
        let fresnel = coat_fresnel::<One>(least_cos.into()).get();
        self.reflecting.get() * fresnel * density * self.facets.seen(wo.into()).get()
    }
}
