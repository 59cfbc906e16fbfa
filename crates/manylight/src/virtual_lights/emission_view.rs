//! What a light shines in a direction: one at a time, and for sixteen directions at once.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over lanes read like what they become: vector instructions"
)]

use super::glossy::Glossy;
use super::tables::{Table, Texel, Texels};
use super::von_mises_fisher::Mixture;
use super::{Emission, Reflection, VirtualLight, VirtualLights};
use crate::bsdf::{ExitTransmittance, FixedWi, Lobes, interpolate_lanes};
use crate::color::Rgb;
use crate::ids::LightId;
use crate::lanes::vectors::{add3, dot, mul3, scale3, splat3};
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3, exp};
use crate::math::octahedral::Place;
use crate::math::{Vec2, Vec3};
use crate::simd::Wide;
use std::f32::consts::FRAC_1_PI;

impl VirtualLights<'_> {
    /// Radiant intensity of light `id` towards the unit vector `w` pointing away from it, emission cosine included, in W/sr.
    #[inline]
    pub fn intensity(&self, id: LightId, w: Vec3) -> Rgb {
        let light = &self.lights()[id.index()];
        match &light.emission {
            Emission::Single(index) => self.reflection(*index).intensity(w),
            Emission::Rich {
                diffuse,
                exit,
                glossy,
            } => {
                let (cos, cos_s) = (w.dot(light.n), w.dot(light.ns));
                let mut sum = Rgb::BLACK;
                if cos > 0.0 && cos_s > 0.0 {
                    sum += *diffuse * (exit.eval(cos_s) * cos * FRAC_1_PI);
                }
                if let Some(glossy) = glossy
                    && (cos > 0.0 || !light.one_sided)
                {
                    sum += self.glossy(*glossy).lookup(w);
                }
                sum
            }
        }
    }

    /// The light `id`, made ready for many directions.
    #[inline(always)]
    pub(crate) fn emission_view(&self, id: LightId) -> EmissionView<'_, '_> {
        let light = &self.lights()[id.index()];
        match &light.emission {
            Emission::Single(index) => {
                let Reflection { wi, flux, bsdf } = self.reflection(*index);
                EmissionView::Single {
                    flux: *flux,
                    reflection: bsdf.with_wi(*wi, Lobes::NON_SPECULAR),
                }
            }
            Emission::Rich {
                diffuse,
                exit,
                glossy,
            } => EmissionView::Rich {
                light,
                diffuse: *diffuse,
                exit,
                glossy: glossy.map(|index| self.glossy(index)),
            },
        }
    }
}

/// A light that many points ask for its intensity.
pub(crate) enum EmissionView<'f, 's> {
    /// See [`Emission::Single`].
    Single {
        flux: Rgb,
        reflection: FixedWi<'f, 's>,
    },
    /// See [`Emission::Rich`].
    Rich {
        light: &'f VirtualLight<'s>,
        diffuse: Rgb,
        exit: &'f ExitTransmittance<'s>,
        glossy: Option<Glossy<'f>>,
    },
}

impl EmissionView<'_, '_> {
    /// [`VirtualLights::intensity`] towards the points that see the light in the unit directions `wi`, in each active lane; other
    /// lanes hold anything.
    #[inline(always)]
    pub(crate) fn intensities<W: Wide>(&self, w: W, wi: &Lanes3, active: LaneMask) -> Lanes3 {
        match self {
            EmissionView::Single { flux, reflection } => {
                let wo = scale3(w, wi.load(w), w.splat(-1.0));
                let values = reflection.f_cos_wo_lanes(w, &Lanes3::store(w, wo), active);
                let flux = splat3(w, Vec3::from(flux.to_array()));
                Lanes3::store(w, mul3(w, values.load(w), flux))
            }
            EmissionView::Rich {
                light,
                diffuse,
                exit,
                glossy,
            } => {
                let away = wi.load(w);
                let zero = w.splat(0.0);
                let cos = dot(w, away, splat3(w, -light.n));
                let cos_s = dot(w, away, splat3(w, -light.ns));
                let before = w.lt(zero, cos);
                let exits = exits(w, exit, cos_s);
                let share = w.mul(w.mul(exits, cos), w.splat(FRAC_1_PI));
                let share = w.select(w.and(before, w.lt(zero, cos_s)), share, zero);
                let mut sum = scale3(w, splat3(w, Vec3::from(diffuse.to_array())), share);
                if let Some(glossy) = glossy {
                    let glossy = glossy.lookups(w, wi, active).load(w);
                    let counts = if light.one_sided {
                        before
                    } else {
                        w.lanes(u32::MAX)
                    };
                    for (sum, glossy) in sum.iter_mut().zip(glossy) {
                        *sum = w.add(*sum, w.select(counts, glossy, zero));
                    }
                }
                Lanes3::store(w, sum)
            }
        }
    }
}

impl Mixture<'_> {
    /// [`Mixture::lookup`] in the directions opposite to `wi`.
    #[inline(always)]
    pub(super) fn lookups<W: Wide>(&self, w: W, wi: &Lanes3) -> Lanes3 {
        let wi = wi.load(w);
        let mut sum = [w.splat(0.0); 3];
        for lobe in self.lobes {
            let apart = add3(w, wi, splat3(w, lobe.axis()));
            let exponent = w.mul(dot(w, apart, apart), w.splat(-0.5 * lobe.kappa()));
            let value = exp(w, exponent);
            let peak = splat3(w, Vec3::from(lobe.peak().to_array()));
            for (sum, peak) in sum.iter_mut().zip(peak) {
                *sum = w.mul_add(peak, value, *sum);
            }
        }
        Lanes3::store(w, sum)
    }
}

impl Table<'_> {
    /// Bilinear lookups in the directions opposite to `wi`.
    #[inline(always)]
    pub(super) fn lookups<W: Wide>(&self, w: W, wi: &Lanes3, active: LaneMask) -> Lanes3 {
        let corners = Corners::of(w, wi, self.side as i32, active);
        let sum = match self.texels {
            Texels::Float(texels) => corners.sum(w, texels),
            Texels::Shared(texels) => corners.sum(w, texels),
        };
        let scale = splat3(w, Vec3::from(self.scale.to_array()));
        Lanes3::store(w, mul3(w, sum, scale))
    }
}

/// The four texels that each lane's lookup is made of, and their weights; of lanes that are not active, anything.
struct Corners {
    texels: [[i32; LANES]; 4],
    weights: [Lanes; 4],
}

impl Corners {
    /// For lookups in the directions opposite to `wi`.
    #[inline(always)]
    fn of<W: Wide>(w: W, wi: &Lanes3, side: i32, active: LaneMask) -> Self {
        let (mut columns, mut rows) = ([0; LANES], [0; LANES]);
        let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let place = Place::of(-wi.vec(i), side);
            (columns[i], rows[i]) = (place.column, place.row);
            (x[i], y[i]) = (place.fraction.x, place.fraction.y);
        }
        let place = |i: usize| Place {
            column: columns[i],
            row: rows[i],
            fraction: Vec2::new(x[i], y[i]),
        };
        let mut corners = Corners {
            texels: [[0; LANES]; 4],
            weights: [[0.0; LANES]; 4],
        };
        for i in 0..LANES {
            let weights = place(i).weights();
            for k in 0..4 {
                corners.weights[k][i] = weights[k];
            }
        }
        if active & !inside(w, &columns, &rows, side) == 0 {
            for i in 0..LANES {
                let first = rows[i].wrapping_mul(side).wrapping_add(columns[i]);
                corners.texels[0][i] = first;
                corners.texels[1][i] = first.wrapping_add(1);
                corners.texels[2][i] = first.wrapping_add(side);
                corners.texels[3][i] = first.wrapping_add(side + 1);
            }
        } else {
            for i in 0..LANES {
                let texels = place(i).texels(side);
                for k in 0..4 {
                    corners.texels[k][i] = texels[k];
                }
            }
        }
        corners
    }

    /// The weighted sums of texels.
    #[inline(always)]
    fn sum<W: Wide, T: Texel>(&self, w: W, table: &[T]) -> [W::F; 3] {
        let mut sum = [w.splat(0.0); 3];
        for (texels, weights) in self.texels.iter().zip(&self.weights) {
            let fetched = fetch(table, texels);
            let mut values = Lanes3::ZERO;
            for i in 0..LANES {
                values.set(i, fetched[i].rgb());
            }
            let weight = w.load(weights);
            for (sum, value) in sum.iter_mut().zip(values.load(w)) {
                *sum = w.mul_add(value, weight, *sum);
            }
        }
        sum
    }
}

/// The lanes whose four texels no edge of the map divides, so that they are neighbors in memory too.
#[inline(always)]
fn inside<W: Wide>(w: W, columns: &[i32; LANES], rows: &[i32; LANES], side: i32) -> LaneMask {
    let (mut lowest, mut highest) = ([0.0; LANES], [0.0; LANES]);
    for i in 0..LANES {
        let (column, row) = (columns[i] as f32, rows[i] as f32);
        lowest[i] = column.min(row);
        highest[i] = column.max(row);
    }
    let (first, last) = (w.splat(0.0), w.splat((side - 1) as f32));
    let inside = w.and(w.le(first, w.load(&lowest)), w.lt(w.load(&highest), last));
    w.bits(inside) as LaneMask
}

/// The texels with these indices; the last for an index that is none.
#[inline(always)]
fn fetch<T: Texel>(table: &[T], texels: &[i32; LANES]) -> [T; LANES] {
    let mut out = [T::zeroed(); LANES];
    if let Some(last) = table.len().checked_sub(1) {
        let texels = texels.map(|t| (t as u32).min(last as u32));
        for i in 0..LANES {
            out[i] = table[texels[i] as usize];
        }
    }
    out
}

/// What lets the diffuse part out, at the cosines to the shading normal.
#[inline(always)]
fn exits<W: Wide>(w: W, exit: &ExitTransmittance, cos: W::F) -> W::F {
    let mut out = w.store(w.max(cos, w.splat(0.0)));
    match exit {
        ExitTransmittance::Lambert => return w.splat(1.0),
        ExitTransmittance::Fresnel { eta } => {
            for cos in &mut out {
                *cos = ExitTransmittance::Fresnel { eta: *eta }.eval(*cos);
            }
        }
        ExitTransmittance::Coated(table) => out = interpolate_lanes(&[table; LANES], &out),
    }
    w.load(&out)
}
