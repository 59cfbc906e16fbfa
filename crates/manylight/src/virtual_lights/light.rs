//! A virtual light: where it is, how much flux it represents, and the form of its emission.

use super::moments::POINTS;
use crate::bsdf::ExitTransmittance;
use crate::color::Rgb;
use crate::ids::LightGroup;
use crate::math::Vec3;

/// A light that represents the reflection of one cluster of photons.
#[derive(Clone, Copy, Debug)]
pub struct VirtualLight<'s> {
    /// Position: that of the site's photon.
    pub p: Vec3,
    /// Positions of photons of the cluster, drawn in proportion to flux and spread over the disc;
    /// see [`spread_points`](super::moments::spread_points).
    pub points: [Vec3; POINTS],
    /// Geometric normal on the lit side, unit.
    pub n: Vec3,
    /// Shading normal on the lit side, unit: the axis of the diffuse emission.
    pub ns: Vec3,
    /// Radius of the uniform disc with the second moment of the cluster, in m; 0 for one photon.
    pub radius: f32,
    /// [`radius`](Self::radius) of a light of all light groups together, in m: in its units, the
    /// distance decides how many points stand for the light.
    pub radius_of_all: f32,
    /// Surface represented, in m², from the spacing of the lights around it: bounds the geometry
    /// term of points. 0 for the only light.
    pub area: f32,
    /// Distance from the surface at which shadow rays start, in m.
    pub offset: f32,
    /// Flux represented, in W.
    pub flux: Rgb,
    /// Light group of the photons that it represents.
    pub group: LightGroup,
    /// Whether nothing is emitted below the horizon of `n`.
    pub one_sided: bool,
    /// Radiant intensity.
    pub emission: Emission<'s>,
}

/// Radiant intensity of a virtual light.
#[derive(Clone, Copy, Debug)]
pub enum Emission<'s> {
    /// That of one light path: the index of a [`Reflection`](super::Reflection).
    Single(u32),
    /// That of many light paths: `I(w) = diffuse b(|w·ns|) |w·n| / π` above the horizon, plus the
    /// glossy part.
    Rich {
        /// `Σ Φ_j a(wi_j)` over the photons with their weights, with the diffuse albedo `a` before
        /// the exit transmittance `b`. W.
        diffuse: Rgb,
        /// `b`.
        exit: ExitTransmittance<'s>,
        /// Index of the glossy profile, if the surface has glossy lobes.
        glossy: Option<u32>,
    },
}
