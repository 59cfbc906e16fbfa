//! A scattering function with a fixed incident direction, for tables of radiant intensity.

use super::{Bsdf, FixedWoLanes, LaneModel, Lobes};
use crate::color::Rgb;
use crate::lanes::{LANES, LaneMask, Lanes3, Sixteen, Vector, lanes_of};
use crate::math::Vec3;
use crate::simd::{Isa, Simd, SimdKernel};

/// A scattering function with a fixed `wi` and a fixed set of lobes: a function of `wo`.
#[derive(Clone, Debug)]
pub struct FixedWi<'b, 's> {
    bsdf: &'b Bsdf<'s>,
    wi: Vec3,
    lobes: Lobes,
    /// By reciprocity: the function of the other direction for `wi` in the place of `wo`, the same in all lanes.
    lanes: Option<Box<FixedWoLanes<'b, 's>>>,
}

impl<'s> Bsdf<'s> {
    /// The function of `wo` for a fixed `wi` and set of lobes.
    pub fn with_wi(&self, wi: Vec3, lobes: Lobes) -> FixedWi<'_, 's> {
        let model = self.lane_model();
        let lanes = || Box::new(FixedWoLanes::alike(model, lobes, self, wi));
        FixedWi {
            bsdf: self,
            wi,
            lobes,
            lanes: (model != LaneModel::Any).then(lanes),
        }
    }
}

impl FixedWi<'_, '_> {
    /// Replaces the contents of `out` by [`Bsdf::f_cos_wo`] in each of the unit directions.
    pub fn f_cos_wo(&self, directions: &[Vec3], out: &mut Vec<Rgb>) {
        out.clear();
        Isa::best().run(DirectionsInLanes(self, directions, out));
    }

    /// [`Bsdf::f_cos_wo`] in each active lane, for unit directions `wo`. Other lanes are unspecified.
    #[inline(always)]
    pub(crate) fn f_cos_wo_lanes<W: Sixteen>(&self, w: W, wo: &Lanes3, active: LaneMask) -> Lanes3 {
        let Some(lanes) = &self.lanes else {
            let mut out = Lanes3::ZERO;
            for i in lanes_of(active) {
                out.set(i, self.bsdf.f_cos_wo(self.wi, wo.vec(i), self.lobes));
            }
            return out;
        };
        let s = w;
        let values = lanes.f_cos_wi(w, wo, active).colors(s);
        // The reciprocal model is f_s |wi·ns|; f multiplies it by |wi·ns| / |wi·ng|, also for the swapped directions.
        let (ng, ns) = (Vec3::from(self.bsdf.ng), Vec3::from(self.bsdf.frame.n));
        let incident = (self.wi.dot(ns) / self.wi.dot(ng)).abs();
        let wo = wo.vectors(s);
        let (by_ng, by_ns) = (wo.dot(Vector::splat(s, ng)), wo.dot(Vector::splat(s, ns)));
        // Where `by_ns` is zero, the value is zero as well.
        let tilt = by_ng.abs() * incident / by_ns.abs().max(f32::MIN_POSITIVE);
        Lanes3::of_colors(values * tilt)
    }
}

struct DirectionsInLanes<'a>(&'a FixedWi<'a, 'a>, &'a [Vec3], &'a mut Vec<Rgb>);

impl SimdKernel for DirectionsInLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let DirectionsInLanes(fixed, directions, out) = self;
        for chunk in directions.chunks(LANES) {
            let wo = Lanes3::from_fn(|i| chunk[i.min(chunk.len() - 1)]);
            let used = LaneMask::MAX >> (LANES - chunk.len());
            let values = fixed.f_cos_wo_lanes(s.wide(), &wo, used);
            out.extend((0..chunk.len()).map(|i| values.rgb(i)));
        }
    }
}
