//! How surfaces scatter light. [`Material`] is what a file describes, [`Bsdf`] what it is at one point.
//!
//! Directions are physical: light arrives from `wi` and leaves along `wo`, both unit, both away from the surface.
//! A camera walk knows `wo` and samples `wi`; a photon walk knows `wi` and samples `wo`.
//! Every lobe has a class, and every function here takes the classes that it shall see, because the path partition
//! (docs/path_partition.md) is by scattering event: one surface may have lobes of several classes.

pub mod material;

pub use material::Material;

use crate::color::Rgb;
use crate::geometry::SurfacePoint;
use crate::math::{Vec2, Vec3};
use crate::texture::Texture;

/// Classes of lobes, as a set.
///
/// `DIFFUSE` and `GLOSSY` together are the "n" events of the path partition (virtual lights stand there and are summed there),
/// `NEAR_DELTA` are microfacet lobes too narrow for virtual lights, `DELTA` are mirrors and smooth glass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobes(pub u8);

impl Lobes {
    /// Nothing.
    pub const NONE: Lobes = Lobes(0);
    /// Lobes of the form `a(wi) b(wo) / π`: Lambert, and the base of plastics.
    pub const DIFFUSE: Lobes = Lobes(1);
    /// Everything else that is not narrow: microfacets with alpha >= [`NEAR_DELTA_ALPHA`], sheen, Oren-Nayar, Phong, ...
    pub const GLOSSY: Lobes = Lobes(2);
    /// Microfacet lobes with alpha < [`NEAR_DELTA_ALPHA`] (or as narrow).
    pub const NEAR_DELTA: Lobes = Lobes(4);
    /// Dirac lobes, straight-through transmission excluded (that is [`Bsdf::transmittance`]).
    pub const DELTA: Lobes = Lobes(8);
    /// Where virtual lights stand and are summed.
    pub const SMOOTH: Lobes = Lobes(1 | 2);
    /// Where camera paths are continued and caustic photons come from.
    pub const SPECULAR: Lobes = Lobes(4 | 8);
    /// All that `f` can be asked for: everything but `DELTA`.
    pub const FINITE: Lobes = Lobes(1 | 2 | 4);
    /// Everything.
    pub const ALL: Lobes = Lobes(15);

    /// Set union.
    #[inline]
    pub const fn or(self, o: Lobes) -> Lobes {
        Lobes(self.0 | o.0)
    }

    /// Set intersection.
    #[inline]
    pub const fn and(self, o: Lobes) -> Lobes {
        Lobes(self.0 & o.0)
    }

    /// Whether the sets share an element.
    #[inline]
    pub const fn has(self, o: Lobes) -> bool {
        self.0 & o.0 != 0
    }
}

/// Roughness below which a microfacet lobe counts as near-delta: narrower than a texel of a 32 x 32 octahedral table
/// can show (ERRATA E8). A fixed number: the class of a lobe must not depend on who asks.
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
pub enum Exit<'s> {
    /// `b = 1`.
    Lambert,
    /// Transmittance of a dielectric coat, tabulated over the cosine on [0, 1].
    Coated(&'s [f32]),
}

impl Exit<'_> {
    /// `b` at the cosine to the shading normal, in [0, 1].
    #[inline]
    pub fn eval(&self, _cos: f32) -> f32 {
        todo!()
    }
}

/// A scattering function at a point: small, `Copy`, borrowing only precomputed tables of the scene.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'s> {
    _tables: std::marker::PhantomData<&'s ()>,
}

impl<'s> Bsdf<'s> {
    /// `f(wi → wo)`, 1/sr, for light that arrives from `wi`: `f = f_s |wi·ns| / |wi·ng|` with `f_s` the model in the shading
    /// frame, so that all other formulas use geometric cosines (docs: shading normals; checked by the adjoint test).
    /// Reflection and transmission are told apart by `ns` alone, as Mitsuba's path tracer does. Radiance is scaled by η² in transmission.
    #[inline]
    pub fn f(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let _ = (wi, wo, lobes);
        todo!()
    }

    /// `f |wi·ng|`: what a receiver multiplies incident radiance by. Computed without the quotient.
    #[inline]
    pub fn f_cos_wi(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let _ = (wi, wo, lobes);
        todo!()
    }

    /// `f |wo·ng|`: times incident flux this is radiant intensity towards `wo`.
    #[inline]
    pub fn f_cos_wo(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> Rgb {
        let _ = (wi, wo, lobes);
        todo!()
    }

    /// Draws `wi` for a camera walk that looks along `-wo`. `None`: absorbed.
    pub fn sample_wi(&self, wo: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<BsdfSample> {
        let _ = (wo, u, lobes);
        todo!()
    }

    /// Draws `wo` for a photon that arrives from `wi`. `None`: absorbed.
    pub fn sample_wo(&self, wi: Vec3, u: BsdfNumbers, lobes: Lobes) -> Option<BsdfSample> {
        let _ = (wi, u, lobes);
        todo!()
    }

    /// Density of [`Bsdf::sample_wi`] per solid angle, delta lobes left out.
    #[inline]
    pub fn pdf_wi(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> f32 {
        let _ = (wi, wo, lobes);
        todo!()
    }

    /// Density of [`Bsdf::sample_wo`] per solid angle, delta lobes left out.
    #[inline]
    pub fn pdf_wo(&self, wi: Vec3, wo: Vec3, lobes: Lobes) -> f32 {
        let _ = (wi, wo, lobes);
        todo!()
    }

    /// The classes present with positive weight.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        todo!()
    }

    /// Fraction of light that passes straight through along `w` as if there were no surface (mask, null, thin glass).
    /// The lobes carry the rest: their weights already contain the opacity.
    #[inline]
    pub fn transmittance(&self, w: Vec3) -> Rgb {
        let _ = w;
        todo!()
    }

    /// `a(wi)` of the `DIFFUSE` lobes: incident flux `Φ` leaves with intensity `Φ a(wi) b(wo) |wo·ng| / π`
    /// on the side of the surface that `wi` is on.
    #[inline]
    pub fn diffuse_weight(&self, wi: Vec3) -> Rgb {
        let _ = wi;
        todo!()
    }

    /// `b` of the `DIFFUSE` lobes.
    #[inline]
    pub fn exit(&self) -> Exit<'s> {
        todo!()
    }

    /// Smallest roughness among the `GLOSSY` lobes (1 without any): the width of what must be resolved, in radians roughly.
    #[inline]
    pub fn glossy_width(&self) -> f32 {
        todo!()
    }

    /// The normal that a receiver chooses emitters with: the shading normal on the side of `wo`. `None` if some lobe
    /// transmits: then light matters from both sides.
    #[inline]
    pub fn receiving_normal(&self, wo: Vec3) -> Option<Vec3> {
        let _ = wo;
        todo!()
    }

    /// A cheap estimate of [`Bsdf::albedo`] over all lobes, for AOVs and previews: exact for Lambert.
    pub fn quick_albedo(&self, wo: Vec3) -> Rgb {
        let _ = wo;
        todo!()
    }

    /// Fraction of flux from `wi` that leaves through `lobes` (delta ones included, straight-through not), by deterministic quadrature.
    pub fn albedo(&self, wi: Vec3, lobes: Lobes) -> Rgb {
        let _ = (wi, lobes);
        todo!()
    }
}

/// Everything precomputed about the materials of a scene: tables of coat transmittance and the like.
#[derive(Debug)]
pub struct Materials {
    materials: Vec<Material>,
}

impl Materials {
    /// Precomputes the tables. Ids inside must be valid and free of cycles (checked by `Scene::build`).
    pub fn new(materials: Vec<Material>) -> Self {
        Materials { materials }
    }

    /// The descriptions; index by [`MaterialId`](crate::ids::MaterialId).
    pub fn descriptions(&self) -> &[Material] {
        &self.materials
    }

    /// Whether light can pass straight through this material anywhere.
    pub fn is_transparent(&self, _id: crate::ids::MaterialId) -> bool {
        todo!()
    }

    /// The scattering function at a point.
    pub fn bsdf<'s>(&'s self, _id: crate::ids::MaterialId, _x: &SurfacePoint, _textures: &'s [Texture]) -> Bsdf<'s> {
        todo!()
    }
}
