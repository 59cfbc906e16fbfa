//! One function with a fixed outgoing direction, for many directions of incidence: photons around a point.

use super::{FixedWoLanes, LaneModel};
use crate::bsdf::{Bsdf, Lobes};
use crate::color::Rgb;
use crate::lanes::{LANES, LaneMask, Lanes3};
use crate::math::Vec3;
use crate::simd::{Isa, Simd, SimdKernel};

/// Fewest directions for which the preparation of lanes pays. Unmeasured: preparation costs about as much as four single values.
const FEWEST_IN_LANES: usize = 6;

impl Bsdf<'_> {
    /// Replaces the contents of `out` by [`Bsdf::f_cos_wi`] for each of the unit directions `wi`, for the `NON_SPECULAR` ones of `lobes`.
    pub fn f_cos_each_wi(&self, wi: &[Vec3], wo: Vec3, lobes: Lobes, out: &mut Vec<Rgb>) {
        out.clear();
        let model = self.lane_model();
        if model == LaneModel::Any || wi.len() < FEWEST_IN_LANES {
            let function = self.with_wo(wo, lobes.and(Lobes::NON_SPECULAR));
            out.extend(wi.iter().map(|&wi| function.f_cos_wi(wi)));
            return;
        }
        let functions = FixedWoLanes::alike(model, lobes, self, wo);
        Isa::best().run(EachInLanes(&functions, wi, out));
    }
}

struct EachInLanes<'a>(&'a FixedWoLanes<'a, 'a>, &'a [Vec3], &'a mut Vec<Rgb>);

impl SimdKernel for EachInLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let EachInLanes(functions, directions, out) = self;
        for chunk in directions.chunks(LANES) {
            let wi = Lanes3::from_fn(|i| chunk[i.min(chunk.len() - 1)]);
            let values = functions.f_cos_wi(s.wide(), &wi, LaneMask::MAX);
            out.extend((0..chunk.len()).map(|i| values.rgb(i)));
        }
    }
}
