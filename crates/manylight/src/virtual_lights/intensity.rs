//! What a light shines in a direction: one at a time, and for sixteen directions at once.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over lanes read like what they become: vector instructions"
)]

use super::{Emission, LightField};
use crate::bsdf::{Exit, Lobes};
use crate::color::Rgb;
use crate::ids::LightId;
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3, lanes_of};
use crate::math::Vec3;
use crate::math::octahedral::{bilinear, bilinear_corners};
use std::f32::consts::FRAC_1_PI;

impl LightField<'_> {
    /// Radiant intensity of light `id` towards the unit vector `w` pointing away from it, emission cosine included, in W/sr.
    #[inline]
    pub fn intensity(&self, id: LightId, w: Vec3) -> Rgb {
        let light = &self.lights()[id.index()];
        match &light.emission {
            Emission::Single { wi, flux, bsdf } => bsdf.f_cos_wo(*wi, w, Lobes::SMOOTH) * *flux,
            Emission::Rich {
                diffuse,
                exit,
                table,
                transmits,
            } => {
                let (cos, cos_s) = (w.dot(light.n), w.dot(light.ns));
                let mut sum = Rgb::BLACK;
                if cos > 0.0 && cos_s > 0.0 {
                    sum += *diffuse * (exit.eval(cos_s) * cos * FRAC_1_PI);
                }
                if let Some(table) = table
                    && (cos > 0.0 || *transmits)
                {
                    for (t, weight) in bilinear(w, self.side()) {
                        sum += self.table(*table)[t] * weight;
                    }
                }
                sum
            }
        }
    }

    /// [`LightField::intensity`] in each active lane; other lanes hold anything.
    #[inline(always)]
    pub fn intensities(&self, id: LightId, w: &Lanes3, active: LaneMask) -> Lanes3 {
        let light = &self.lights()[id.index()];
        match &light.emission {
            Emission::Single { wi, flux, bsdf } => {
                let mut out = Lanes3::ZERO;
                for i in lanes_of(active) {
                    out.set(i, bsdf.f_cos_wo(*wi, w.vec(i), Lobes::SMOOTH) * *flux);
                }
                out
            }
            Emission::Rich {
                diffuse,
                exit,
                table,
                transmits,
            } => {
                let (mut cos, mut cos_s) = ([0.0; LANES], [0.0; LANES]);
                for i in 0..LANES {
                    cos[i] = w.vec(i).dot(light.n);
                    cos_s[i] = w.vec(i).dot(light.ns);
                }
                let exits = exits(exit, &cos_s);
                let mut out = Lanes3::ZERO;
                for i in 0..LANES {
                    let lit = cos[i] > 0.0 && cos_s[i] > 0.0;
                    let share = exits[i] * cos[i] * FRAC_1_PI;
                    out.set(i, *diffuse * if lit { share } else { 0.0 });
                }
                if let Some(table) = table {
                    let glossy = self.lookups(*table, w, active);
                    for i in 0..LANES {
                        let lit = cos[i] > 0.0 || *transmits;
                        out.set(i, out.rgb(i) + glossy.rgb(i) * if lit { 1.0 } else { 0.0 });
                    }
                }
                out
            }
        }
    }

    /// Bilinear lookups in one table.
    #[inline(always)]
    fn lookups(&self, table: u32, w: &Lanes3, active: LaneMask) -> Lanes3 {
        let side = self.side() as i32;
        let (mut texels, mut weights) = ([[0; LANES]; 4], [[0.0; LANES]; 4]);
        for i in 0..LANES {
            let [a, b, c, d] = bilinear_corners(w.vec(i), side);
            (texels[0][i], weights[0][i]) = a;
            (texels[1][i], weights[1][i]) = b;
            (texels[2][i], weights[2][i]) = c;
            (texels[3][i], weights[3][i]) = d;
        }
        let table = self.table(table);
        let mut fetched = [Lanes3::ZERO; 4];
        for i in lanes_of(active) {
            for (values, texels) in fetched.iter_mut().zip(&texels) {
                values.set(i, table[texels[i] as usize]);
            }
        }
        let mut out = Lanes3::ZERO;
        for i in 0..LANES {
            let sum = fetched[0].rgb(i) * weights[0][i]
                + fetched[1].rgb(i) * weights[1][i]
                + fetched[2].rgb(i) * weights[2][i]
                + fetched[3].rgb(i) * weights[3][i];
            out.set(i, sum);
        }
        out
    }
}

/// What lets the diffuse part out, at the cosines to the shading normal.
#[inline(always)]
fn exits(exit: &Exit, cos: &Lanes) -> Lanes {
    let mut out = [1.0; LANES];
    match exit {
        Exit::Lambert => {}
        Exit::Fresnel { eta } => {
            for i in 0..LANES {
                out[i] = Exit::Fresnel { eta: *eta }.eval(cos[i].max(0.0));
            }
        }
        Exit::Coated(_) => {
            for i in 0..LANES {
                out[i] = exit.eval(cos[i]);
            }
        }
    }
    out
}
