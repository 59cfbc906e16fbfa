//! What a light shines in a direction: one at a time, and for sixteen directions at once.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over lanes read like what they become: vector instructions"
)]

use super::tables::Packed;
use super::{Emission, LightField};
use crate::bsdf::{Exit, interpolate_lanes};
use crate::color::Rgb;
use crate::ids::LightId;
use crate::lanes::vectors::{dot, mul3, scale3, splat3};
use crate::lanes::{LANES, LaneMask, Lanes3, lanes_of};
use crate::math::Vec3;
use crate::math::octahedral::bilinear_corners;
use crate::simd::Wide;
use std::f32::consts::FRAC_1_PI;

impl LightField<'_> {
    /// Radiant intensity of light `id` towards the unit vector `w` pointing away from it, emission cosine included, in W/sr.
    #[inline]
    pub fn intensity(&self, id: LightId, w: Vec3) -> Rgb {
        let light = &self.lights()[id.index()];
        match &light.emission {
            Emission::Single(index) => self.reflection(*index).intensity(w),
            Emission::Rich {
                diffuse,
                exit,
                table,
            } => {
                let (cos, cos_s) = (w.dot(light.n), w.dot(light.ns));
                let mut sum = Rgb::BLACK;
                if cos > 0.0 && cos_s > 0.0 {
                    sum += *diffuse * (exit.eval(cos_s) * cos * FRAC_1_PI);
                }
                if let Some(table) = table
                    && (cos > 0.0 || !light.one_sided)
                {
                    sum += self.table(*table).lookup(w);
                }
                sum
            }
        }
    }

    /// [`LightField::intensity`] towards the points that see the light in the unit directions `wi`, in each active lane; other
    /// lanes hold anything.
    #[inline(always)]
    pub(crate) fn intensities<W: Wide>(
        &self,
        w: W,
        id: LightId,
        wi: &Lanes3,
        active: LaneMask,
    ) -> Lanes3 {
        let light = &self.lights()[id.index()];
        match &light.emission {
            Emission::Single(index) => {
                let reflection = self.reflection(*index);
                let mut out = Lanes3::ZERO;
                for i in lanes_of(active) {
                    out.set(i, reflection.intensity(-wi.vec(i)));
                }
                out
            }
            Emission::Rich {
                diffuse,
                exit,
                table,
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
                if let Some(table) = table {
                    let glossy = self.lookups(w, *table, wi, active).load(w);
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

    /// Bilinear lookups in one table, in the opposite directions.
    #[inline(always)]
    fn lookups<W: Wide>(&self, w: W, table: u32, wi: &Lanes3, active: LaneMask) -> Lanes3 {
        let side = self.side() as i32;
        let (mut texels, mut weights) = ([[0; LANES]; 4], [[0.0; LANES]; 4]);
        for i in 0..LANES {
            let [a, b, c, d] = bilinear_corners(-wi.vec(i), side);
            (texels[0][i], weights[0][i]) = a;
            (texels[1][i], weights[1][i]) = b;
            (texels[2][i], weights[2][i]) = c;
            (texels[3][i], weights[3][i]) = d;
        }
        let table = self.table(table);
        let mut sum = [w.splat(0.0); 3];
        for (texels, weights) in texels.iter().zip(&weights) {
            let mut fetched = [Packed::BLACK; LANES];
            for i in lanes_of(active) {
                fetched[i] = table.texels[texels[i] as usize];
            }
            let mut values = Lanes3::ZERO;
            for i in 0..LANES {
                values.set(i, fetched[i].rgb());
            }
            let weight = w.load(weights);
            for (sum, value) in sum.iter_mut().zip(values.load(w)) {
                *sum = w.mul_add(value, weight, *sum);
            }
        }
        let scale = splat3(w, Vec3::from(table.scale.to_array()));
        Lanes3::store(w, mul3(w, sum, scale))
    }
}

/// What lets the diffuse part out, at the cosines to the shading normal.
#[inline(always)]
fn exits<W: Wide>(w: W, exit: &Exit, cos: W::F) -> W::F {
    let mut out = w.store(w.max(cos, w.splat(0.0)));
    match exit {
        Exit::Lambert => return w.splat(1.0),
        Exit::Fresnel { eta } => {
            for cos in &mut out {
                *cos = Exit::Fresnel { eta: *eta }.eval(*cos);
            }
        }
        Exit::Coated(table) => out = interpolate_lanes(&[table; LANES], &out),
    }
    w.load(&out)
}
