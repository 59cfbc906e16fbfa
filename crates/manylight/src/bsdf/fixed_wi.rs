//! A scattering function with a fixed incident direction, for tables of radiant intensity.

use super::{Bsdf, FixedWoLanes, LaneModel, Lobes};
use crate::lanes::{Color, Mask, Sixteen, Vector};
use crate::math::Vec3;

/// A scattering function with a fixed `wi` and a fixed set of lobes: a function of `wo`.
pub(crate) struct FixedWi<'b, 's, S: Sixteen> {
    bsdf: &'b Bsdf<'s>,
    wi: Vec3,
    lobes: Lobes,
    lanes: FixedWiLanes<'b, 's, S>,
}

/// The same function in all lanes.
enum FixedWiLanes<'b, 's, S: Sixteen> {
    /// By reciprocity: the function of the other direction for `wi` in the place of `wo`.
    Reciprocal(FixedWoLanes<'b, 's>),
    /// On the heap, because it is many times as large as what a reciprocal function needs.
    Any(Box<Bsdf<'s, S>>),
}

impl<'b, 's, S: Sixteen> FixedWi<'b, 's, S> {
    /// `bsdf` for a fixed `wi` and set of lobes.
    #[inline(always)]
    pub(crate) fn new(s: S, bsdf: &'b Bsdf<'s>, wi: Vec3, lobes: Lobes) -> Self {
        // The frame of a tilted leaf depends on `wo`, so that it is not reciprocal.
        let is_reciprocal = LaneModel::of(bsdf) != LaneModel::Any && !bsdf.is_tilted();
        FixedWi {
            bsdf,
            wi,
            lobes,
            lanes: match is_reciprocal {
                true => FixedWiLanes::Reciprocal(FixedWoLanes::alike(lobes, bsdf, wi)),
                false => FixedWiLanes::Any(Box::new(bsdf.in_lanes(s))),
            },
        }
    }

    /// [`Bsdf::f_cos_wo`] in each active lane, for unit directions `wo`. Other lanes are
    /// unspecified.
    #[inline(always)]
    pub(crate) fn f_cos_wo_each(&self, wo: Vector<S>, active: Mask<S>) -> Color<S> {
        let s = wo.z.width();
        let lanes = match &self.lanes {
            FixedWiLanes::Reciprocal(lanes) => lanes,
            FixedWiLanes::Any(function) => {
                return function.f_cos_wo_each(Vector::splat(s, self.wi), wo, self.lobes);
            }
        };
        let values = lanes.f_cos_wi(wo, active);
        // The reciprocal model is f_s |wi·ns|; f multiplies it by |wi·ns| / |wi·ng|, also for the
        // swapped directions.
        let (ng, ns) = (Vec3::from(self.bsdf.ng), Vec3::from(self.bsdf.frame.n));
        let incident = (self.wi.dot(ns) / self.wi.dot(ng)).abs();
        let (by_ng, by_ns) = (wo.dot(Vector::splat(s, ng)), wo.dot(Vector::splat(s, ns)));
        // Where `by_ns` is zero, the value is zero as well.
        values * (by_ng.abs() * incident / by_ns.abs().max(f32::MIN_POSITIVE))
    }
}
