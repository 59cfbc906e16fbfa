//! Virtual lights: where they stand, how much flux each carries, and what it shines.
//!
//! select, relax (placement) → assign, neighborhood (flux, as [`PhotonClusters`]) → moments (extent) → glossy (emission) → [`VirtualLights`]. The
//! steps are independent: any placement goes with any flux rule and with any emission.

pub mod assign;
pub(crate) mod candidates;
mod clusters;
pub mod curve;
pub mod density;
mod emission_view;
mod glossy;
mod intensity_bound;
mod lobe_fit;
mod max_mips;
pub mod moments;
pub mod nearest_light;
mod octahedral_grid;
mod octahedral_profile;
pub mod relax;
pub mod select;
mod set;
mod sources;
mod tables;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;
mod von_mises_fisher;

pub use assign::assign;
pub use clusters::PhotonClusters;
pub(crate) use emission_view::EmissionView;
pub use glossy::GlossyForm;
pub use intensity_bound::IntensityBound;
pub use nearest_light::{NearestLights, SurfaceLocation};
pub use select::select;
pub use set::{EnergyAccount, VirtualLights};
pub use tables::TableStorage;

use crate::bsdf::{Bsdf, ExitTransmittance, Lobes};
use crate::color::Rgb;
use crate::math::Vec3;
use moments::POINTS;

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
    /// The photon that the light stands on.
    pub p: Vec3,
    /// Positions of photons of the light, drawn in proportion to flux and spread over the disc; see [`moments::spread_points`].
    pub points: [Vec3; POINTS],
    /// Geometric normal on the lit side, unit.
    pub n: Vec3,
    /// Shading normal on the lit side, unit: the axis of the diffuse emission.
    pub ns: Vec3,
    /// Radius of the disc with the same second moment, in m; 0 for a point.
    pub radius: f32,
    /// Surface that it stands for, in m², from the spacing of lights around it: what bounds the geometry term of points. 0 for a lone light.
    pub area: f32,
    /// Distance by which shadow rays start off the surface, in m.
    pub offset: f32,
    /// Flux represented, in W.
    pub flux: Rgb,
    /// Whether nothing leaves on the side that `n` points away from.
    pub one_sided: bool,
    /// What it shines.
    pub emission: Emission<'s>,
}

/// What a virtual light shines.
#[derive(Clone, Copy, Debug)]
pub enum Emission<'s> {
    /// One light path: the index of a [`Reflection`].
    Single(u32),
    /// Many light paths: `I(w) = diffuse b(|w·ns|) |w·n| / π` on the lit side, plus the glossy part.
    Rich {
        /// Σ Φ a(wi) over its photons. W.
        diffuse: Rgb,
        /// b.
        exit: ExitTransmittance<'s>,
        /// Which profile, if the surface has glossy lobes.
        glossy: Option<u32>,
    },
}

/// One light path: `I(w) = Φ f(wi → w) |w·n|` over the smooth lobes.
#[derive(Clone, Copy, Debug)]
pub struct Reflection<'s> {
    /// Unit direction of incidence.
    pub wi: Vec3,
    /// W.
    pub flux: Rgb,
    /// Scattering function.
    pub bsdf: Bsdf<'s>,
}

impl Reflection<'_> {
    /// Radiant intensity towards the unit vector `w`, in W/sr.
    #[inline]
    fn intensity(&self, w: Vec3) -> Rgb {
        self.bsdf.f_cos_wo(self.wi, w, Lobes::NON_SPECULAR) * self.flux
    }
}
