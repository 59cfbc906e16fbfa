//! Virtual lights: where they stand, how much flux each carries, and what it shines.
//!
//! select (placement) → assign (flux) → moments (extent) → profile (emission) → [`LightField`]. The three middle steps are
//! independent: any placement goes with either flux rule ([`Shares::own`], [`assign`]) and with either emission
//! ([`LightField::single`], [`LightField::rich`]).

pub mod assign;
pub mod claims;
pub mod curve;
mod field;
mod intensity;
pub mod moments;
mod octahedral_grid;
mod octahedral_profile;
pub mod select;
mod tables;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

pub use assign::{Shares, assign};
pub use claims::{Claims, Spot};
pub use field::{Ledger, LightField};
pub use select::select;

use crate::bsdf::{Bsdf, Exit};
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
    /// What it shines.
    pub emission: Emission<'s>,
}

impl VirtualLight<'_> {
    /// Whether nothing leaves on the side that `n` points away from. A single reflection under a shading normal that is not the
    /// geometric one may pass below the surface.
    pub fn shines_one_sided(&self) -> bool {
        match &self.emission {
            Emission::Single { bsdf, .. } => {
                self.n == self.ns && bsdf.receiving_normal(self.n).is_some()
            }
            Emission::Rich { transmits, .. } => !transmits,
        }
    }
}

/// What a virtual light shines.
#[expect(
    clippy::large_enum_variant,
    reason = "there are some thousand lights, read in the innermost loop"
)]
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
        /// Whether the table shines on the other side as well; the diffuse part never does.
        transmits: bool,
    },
}
