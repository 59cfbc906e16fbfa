//! Virtual lights: where they stand, how much flux each carries, and what it shines.
//!
//! select (placement) → assign (flux) → moments (extent) → profile (emission) → [`LightField`].

use crate::bsdf::{Bsdf, Exit};
use crate::color::Rgb;
use crate::ids::LightId;
use crate::math::Vec3;
use crate::particles::Photon;
use crate::scene::Scene;

/// A photon that was chosen to become a light.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    /// Index of the photon.
    pub photon: u32,
    /// Probability with which it was kept.
    pub probability: f32,
}

/// A source that stands for light leaving a small piece of surface.
#[derive(Clone, Copy, Debug)]
pub struct VirtualLight<'s> {
    /// Centre on the surface: the photon's position for plain lights, the projected flux centroid for rich ones.
    pub p: Vec3,
    /// Four points on the surface with the second moments of the light's photons (ERRATA E10); all equal `p` at radius 0.
    pub points: [Vec3; 4],
    /// Geometric normal on the lit side, unit.
    pub n: Vec3,
    /// Shading normal on the lit side, unit: the axis of the diffuse emission.
    pub ns: Vec3,
    /// Radius of the disc with the same second moment, in m; 0 for a point.
    pub radius: f32,
    /// Distance by which shadow rays start off the surface, in m.
    pub offset: f32,
    /// Flux represented, in W.
    pub flux: Rgb,
    /// What it shines.
    pub emission: Emission<'s>,
}

/// What a virtual light shines.
#[derive(Clone, Copy, Debug)]
pub enum Emission<'s> {
    /// One light path: `I(w) = Φ f(wi → w) |w·n|` over the smooth lobes.
    Single {
        /// Unit direction of incidence.
        wi: Vec3,
        /// W.
        flux: Rgb,
        /// Scattering function.
        bsdf: Bsdf<'s>,
    },
    /// Many light paths: `I(w) = diffuse b(|w·ns|) |w·n| / π` on the lit side, plus the table of the glossy part.
    Rich {
        /// Σ Φ a(wi) over its photons. W.
        diffuse: Rgb,
        /// b.
        exit: Exit<'s>,
        /// Which table, if the surface has glossy lobes.
        table: Option<u32>,
    },
}

/// All virtual lights of one pass with their tables, sorted along a space-filling curve.
#[derive(Debug)]
pub struct LightField<'s> {
    lights: Vec<VirtualLight<'s>>,
    /// Octahedral tables one after the other, `side`² texels each: glossy radiant intensity in W/sr, cosine included.
    tables: Vec<Rgb>,
    side: usize,
}

impl<'s> LightField<'s> {
    /// Plain VPLs: each site shines as its one photon, with flux `Φ / probability` (ALGORITHMS 1.6, option 0).
    pub fn plain(_scene: &'s Scene, _photons: &[Photon], _sites: &[Site]) -> Self {
        todo!()
    }

    /// The lights.
    pub fn lights(&self) -> &[VirtualLight<'s>] {
        &self.lights
    }

    /// Radiant intensity of light `id` towards the unit vector `w` pointing away from it, emission cosine included, in W/sr.
    #[inline]
    pub fn intensity(&self, _id: LightId, _w: Vec3) -> Rgb {
        todo!()
    }

    /// Bytes of lights and tables.
    pub fn bytes(&self) -> usize {
        todo!()
    }
}
