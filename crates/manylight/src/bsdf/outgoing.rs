//! A scattering function whose incident direction is fixed: what fills a table of radiant intensity.

use super::{Bsdf, Form, Lobes, Receivers};
use crate::color::Rgb;
use crate::lanes::vectors::{dot, scale3, splat3};
use crate::lanes::{LANES, LaneMask, Lanes3, lanes_of};
use crate::math::Vec3;
use crate::simd::{Isa, Simd, SimdKernel, Wide};

/// A scattering function lit from one direction, to be asked for many exit directions.
#[derive(Clone, Debug)]
pub struct Outgoing<'b, 's> {
    bsdf: &'b Bsdf<'s>,
    wi: Vec3,
    lobes: Lobes,
    /// Values are reciprocal: the function as a receiver whose viewer stands where the light comes from, the same in all lanes.
    lanes: Option<Box<Receivers<'b, 's>>>,
}

impl<'s> Bsdf<'s> {
    /// The function of `wo` that is left when the incident direction is fixed.
    pub fn outgoing(&self, wi: Vec3, lobes: Lobes) -> Outgoing<'_, 's> {
        let form = self.form();
        let lanes = || Box::new(Receivers::alike(form, lobes, self, wi));
        Outgoing {
            bsdf: self,
            wi,
            lobes,
            lanes: (form != Form::Any).then(lanes),
        }
    }
}

impl Outgoing<'_, '_> {
    /// [`Bsdf::f_cos_wo`] in each of the unit directions; replaces what was in `out`.
    pub fn f_cos_wo(&self, directions: &[Vec3], out: &mut Vec<Rgb>) {
        out.clear();
        Isa::best().run(InLanes(self, directions, out));
    }

    /// [`Bsdf::f_cos_wo`] in each active lane, for unit directions `wo`; other lanes hold anything.
    #[inline(always)]
    pub(crate) fn f_cos_wo_lanes<W: Wide>(&self, w: W, wo: &Lanes3, active: LaneMask) -> Lanes3 {
        let Some(lanes) = &self.lanes else {
            let mut out = Lanes3::ZERO;
            for i in lanes_of(active) {
                out.set(i, self.bsdf.f_cos_wo(self.wi, wo.vec(i), self.lobes));
            }
            return out;
        };
        let values = lanes.f_cos_wi(w, wo, active).load(w);
        // f has the cosine of wi to ns over that to ng, whichever way light goes.
        let (ng, ns) = (self.bsdf.ng, self.bsdf.frame.n);
        let incident = (self.wi.dot(ns) / self.wi.dot(ng)).abs();
        let wo = wo.load(w);
        let (by_ng, by_ns) = (dot(w, wo, splat3(w, ng)), dot(w, wo, splat3(w, ns)));
        // Nothing is reflected where both are zero.
        let by_ns = w.max(w.abs(by_ns), w.splat(f32::MIN_POSITIVE));
        let tilt = w.div(w.mul(w.abs(by_ng), w.splat(incident)), by_ns);
        Lanes3::store(w, scale3(w, values, tilt))
    }
}

struct InLanes<'a>(&'a Outgoing<'a, 'a>, &'a [Vec3], &'a mut Vec<Rgb>);

impl SimdKernel for InLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let InLanes(outgoing, directions, out) = self;
        for chunk in directions.chunks(LANES) {
            let wo = Lanes3::from_fn(|i| chunk[i.min(chunk.len() - 1)]);
            let used = LaneMask::MAX >> (LANES - chunk.len());
            let values = outgoing.f_cos_wo_lanes(s.wide(), &wo, used);
            out.extend((0..chunk.len()).map(|i| values.rgb(i)));
        }
    }
}
