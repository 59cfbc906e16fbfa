//! Upper bounds of what a light, or several, shine into a cone of directions: the other half of a cluster's bound. Every form of emission has
//! its own beside its value.

use super::glossy::Glossy;
use super::max_mips::{MaxMips, TEXEL_CONES, largest_in_texels};
use super::tables::Table;
use super::von_mises_fisher::{Lobe, Mixture};
use super::{Emission, Reflection, VirtualLights};
use crate::ids::LightId;
use crate::lanes::{LANES, Lanes, Lanes3};
use crate::math::{Cone, Spread, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Bounds of the luminance of radiant intensity, in W/sr; those of several lights add up.
#[derive(Clone, Debug)]
pub struct IntensityBound {
    /// Of the diffuse parts along their normals.
    diffuse: f32,
    /// Holds the normals of all diffuse parts.
    normals: Cone,
    /// How far those are from their axis; kept, as every draw through a tree asks for its sine and cosine.
    spread: Spread,
    glossy: Option<Box<MaxMips>>,
}

impl IntensityBound {
    /// Of no light.
    pub const NONE: IntensityBound = IntensityBound {
        diffuse: 0.0,
        normals: Cone::EMPTY,
        spread: Spread::EVERYWHERE,
        glossy: None,
    };

    /// Adds the bounds of other lights.
    pub fn add(&mut self, other: &IntensityBound) {
        self.diffuse += other.diffuse;
        self.normals = self.normals.union(other.normals);
        self.spread = Spread::new(self.normals.half_angle.max(0.0));
        match (&mut self.glossy, &other.glossy) {
            (Some(own), Some(other)) => own.add(other),
            (None, Some(other)) => self.glossy = Some(other.clone()),
            (_, None) => {}
        }
    }

    /// Becomes one number for all directions.
    #[cfg(any(test, feature = "testing"))]
    pub fn forget_directions(&mut self) {
        self.normals = Cone::FULL;
        self.spread = Spread::EVERYWHERE;
        if let Some(mips) = &mut self.glossy {
            mips.forget_directions();
        }
    }

    /// Bytes beside its own where some light is not diffuse.
    pub const GLOSSY_BYTES: usize = size_of::<MaxMips>();

    /// About the luminance of what all lights shine along the unit vector `axis`: a bound, as if all stood at one place.
    #[inline(always)]
    pub(crate) fn luminance(&self, axis: Vec3) -> f32 {
        let [_, cos] = self.spread.cosines(axis.dot(self.normals.axis));
        let glossy = self.glossy.as_ref().map_or(0.0, |mips| mips.along(axis));
        self.diffuse * cos.max(0.0) + glossy
    }

    /// Upper bounds of the sum over lights of the luminance that each shines in some direction so far from the unit vector in `axes`,
    /// another for each; lane by lane.
    #[inline(always)]
    pub(crate) fn luminances(&self, axes: &Lanes3, spreads: &[Spread; LANES]) -> Lanes {
        let n = self.normals.axis;
        let mut bounds = [0.0; LANES];
        for i in 0..LANES {
            let [_, cos] = spreads[i].plus(self.spread).cosines(axes.vec(i).dot(n));
            bounds[i] = self.diffuse * cos.max(0.0);
        }
        if let Some(mips) = &self.glossy {
            let glossy = mips.bounds(axes, spreads);
            for i in 0..LANES {
                bounds[i] += glossy[i];
            }
        }
        bounds
    }
}

impl VirtualLights<'_> {
    /// Bounds of [`VirtualLights::intensity`] of light `id`.
    pub fn intensity_bound(&self, id: LightId) -> IntensityBound {
        let light = &self.lights()[id.index()];
        match &light.emission {
            Emission::Single(index) => IntensityBound {
                glossy: Some(Box::new(self.reflection(*index).max_mips())),
                ..IntensityBound::NONE
            },
            Emission::Rich {
                diffuse, glossy, ..
            } => IntensityBound {
                diffuse: diffuse.luminance() * FRAC_1_PI,
                normals: Cone::from_axis(light.n),
                spread: Spread::new(0.0),
                glossy: glossy.map(|index| {
                    Box::new(match self.glossy(index) {
                        Glossy::Table(table) => table.max_mips(),
                        Glossy::Lobes(mixture) => mixture.max_mips(),
                    })
                }),
            },
        }
    }
}

impl Table<'_> {
    /// Bounds of [`Table::lookup`].
    fn max_mips(&self) -> MaxMips {
        let luminance = |t: usize| (self.texels.get(t) * self.scale).luminance();
        MaxMips::new(largest_in_texels(self.side, luminance))
    }
}

impl Mixture<'_> {
    /// Bounds of [`Mixture::lookup`].
    fn max_mips(&self) -> MaxMips {
        MaxMips::new(std::array::from_fn(|t| {
            let cone = &TEXEL_CONES[t];
            let of_lobe = |lobe: &Lobe| {
                let nearest = (cone.angle_to_axis(lobe.axis()) - cone.half_angle).max(0.0);
                lobe.peak().luminance() * (lobe.kappa() * (nearest.cos() - 1.0)).exp()
            };
            self.lobes.iter().map(of_lobe).sum()
        }))
    }
}

impl Reflection<'_> {
    /// Bounds of [`Reflection::intensity`].
    fn max_mips(&self) -> MaxMips {
        MaxMips::new(std::array::from_fn(|t| {
            self.bsdf.bound_f_cos_wo(self.wi, &TEXEL_CONES[t]) * self.flux.luminance()
        }))
    }
}
