//! A scattering function whose incident direction is fixed: what fills a table of radiant intensity.

use super::{Bsdf, Form, Lobes, Receivers};
use crate::color::Rgb;
use crate::lanes::{LANES, LaneMask, Lanes3};
use crate::math::Vec3;
use crate::simd::{Isa, Kernel, Simd};

/// A scattering function lit from one direction, for sums over many exit directions.
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
        let functions = std::iter::repeat_n((self, wi), LANES);
        let lanes = || Box::new(Receivers::new(form, lobes, functions));
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
        match &self.lanes {
            Some(lanes) => Isa::best().run(InLanes {
                outgoing: self,
                lanes,
                directions,
                out,
            }),
            None => {
                let value = |&wo: &Vec3| self.bsdf.f_cos_wo(self.wi, wo, self.lobes);
                out.extend(directions.iter().map(value));
            }
        }
    }
}

struct InLanes<'a> {
    outgoing: &'a Outgoing<'a, 'a>,
    lanes: &'a Receivers<'a, 'a>,
    directions: &'a [Vec3],
    out: &'a mut Vec<Rgb>,
}

impl Kernel for InLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Outgoing { bsdf, wi, .. } = self.outgoing;
        let (ng, ns) = (bsdf.ng, bsdf.frame.n);
        // f has the cosine of wi to ns over that to ng, whichever way light goes.
        let incident = (wi.dot(ns) / wi.dot(ng)).abs();
        for chunk in self.directions.chunks(LANES) {
            let wo = Lanes3::from_fn(|i| chunk[i.min(chunk.len() - 1)]);
            let values = self.lanes.f_cos_wi(s.wide(), &wo, LaneMask::MAX);
            self.out.extend(chunk.iter().enumerate().map(|(i, wo)| {
                let value = values.rgb(i);
                if value.is_black() {
                    return Rgb::BLACK;
                }
                value * (incident * (wo.dot(ng) / wo.dot(ns)).abs())
            }));
        }
    }
}
