//! Upper bounds of the radiant intensity of a set of lights within a cone of directions, for
//! lightcuts. Each form of emission has one.

use super::glossy::Glossy;
use super::light::Emission;
use super::max_mips::{MaxMips, TEXEL_CONES, largest_in_texels};
use super::reflection::Reflection;
use super::set::VirtualLights;
use super::tables::OctahedralTable;
use super::von_mises_fisher::{VmfLobe, VmfMixture};
use crate::ids::LightId;
use crate::lanes::{LANES, Lanes, Lanes3};
use crate::math::{Cone, Spread, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Bounds of the luminance of the summed radiant intensity of a set of lights, in W/sr, with
/// another direction for each light.
#[derive(Clone, Debug)]
pub struct IntensityBound {
    /// Sum of the diffuse parts, each along its normal.
    diffuse: f32,
    /// Bounding cone of the normals of the diffuse parts.
    normals: Cone,
    /// Spread of that cone, cached because every draw of a light needs its sine and cosine.
    spread: Spread,
    /// Sum of the bounds of all other emission; `None` without any.
    glossy: Option<Box<MaxMips>>,
}

impl IntensityBound {
    /// The bound of no lights: 0.
    pub const NONE: IntensityBound = IntensityBound {
        diffuse: 0.0,
        normals: Cone::EMPTY,
        spread: Spread::EVERYWHERE,
        glossy: None,
    };

    /// The bound of [`VirtualLights::intensity`] of light `id`.
    pub fn of(lights: &VirtualLights, id: LightId) -> Self {
        let light = &lights.lights()[id.index()];
        match &light.emission {
            Emission::Single(index) => IntensityBound {
                glossy: Some(Box::new(lights.reflection(*index).max_mips())),
                ..IntensityBound::NONE
            },
            Emission::Rich {
                diffuse, glossy, ..
            } => IntensityBound {
                diffuse: diffuse.luminance() * FRAC_1_PI,
                normals: Cone::from_axis(light.n),
                spread: Spread::new(0.0),
                glossy: glossy.map(|index| {
                    Box::new(match lights.glossy(index) {
                        Glossy::Table(table) => table.max_mips(),
                        Glossy::Lobes(mixture) => mixture.max_mips(),
                    })
                }),
            },
        }
    }

    /// Adds the bound of other lights.
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

    /// Heap bytes of a bound of lights that are not all diffuse.
    pub const GLOSSY_BYTES: usize = size_of::<MaxMips>();

    /// The bound in W/sr for the single unit direction `axis`, common to all lights.
    #[inline(always)]
    pub(crate) fn luminance(&self, axis: Vec3) -> f32 {
        let [_, cos] = self.spread.cosines(axis.dot(self.normals.axis));
        let glossy = self.glossy.as_ref().map_or(0.0, |mips| mips.along(axis));
        self.diffuse * cos.max(0.0) + glossy
    }

    /// The bound in W/sr for directions within the angle of `spread` from the unit vector `axis`.
    pub(crate) fn luminance_within(&self, axis: Vec3, spread: Spread) -> f32 {
        let glossy = (self.glossy.as_ref()).map_or(0.0, |mips| mips.within(axis, spread));
        self.diffuse_within(axis, spread) + glossy
    }

    /// The bounds in W/sr, lane by lane, for directions within the angle of `spreads` from the unit
    /// vectors `axes`.
    #[inline(always)]
    pub(crate) fn luminances(&self, axes: &Lanes3, spreads: &[Spread; LANES]) -> Lanes {
        let mut bounds = [0.0; LANES];
        for i in 0..LANES {
            bounds[i] = self.diffuse_within(axes.vec(i), spreads[i]);
        }
        if let Some(mips) = &self.glossy {
            let glossy = mips.bounds(axes, spreads);
            for i in 0..LANES {
                bounds[i] += glossy[i];
            }
        }
        bounds
    }

    /// The bound of the diffuse parts within a cone, in W/sr.
    #[inline(always)]
    fn diffuse_within(&self, axis: Vec3, spread: Spread) -> f32 {
        let [_, cos] = spread
            .plus(self.spread)
            .cosines(axis.dot(self.normals.axis));
        self.diffuse * cos.max(0.0)
    }
}

impl OctahedralTable<'_> {
    /// The bound of [`OctahedralTable::lookup`].
    fn max_mips(&self) -> MaxMips {
        let luminance = |t: usize| (self.texel(t) * self.scale).luminance();
        MaxMips::new(largest_in_texels(self.side, luminance))
    }
}

impl VmfMixture<'_> {
    /// The bound of [`VmfMixture::lookup`].
    fn max_mips(&self) -> MaxMips {
        MaxMips::new(std::array::from_fn(|t| {
            let cone = &TEXEL_CONES[t];
            let of_lobe = |lobe: &VmfLobe| {
                let nearest = (cone.angle_to_axis(lobe.axis()) - cone.half_angle).max(0.0);
                lobe.peak().luminance() * (lobe.kappa() * (nearest.cos() - 1.0)).exp()
            };
            self.lobes.iter().map(of_lobe).sum()
        }))
    }
}

impl Reflection<'_> {
    /// The bound of [`Reflection::intensity`].
    fn max_mips(&self) -> MaxMips {
        MaxMips::new(std::array::from_fn(|t| {
            self.bsdf.bound_f_cos_wo(self.wi, &TEXEL_CONES[t]) * self.flux.luminance()
        }))
    }
}
