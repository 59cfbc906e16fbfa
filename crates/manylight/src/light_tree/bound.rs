//! Upper bounds of the light reflected at receivers from the lights of a node.

use super::LightNode;
use crate::bsdf::FixedWoLanes;
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3, Sixteen};
use crate::math::{Spread, Vec3};

/// Luminance of the light of a node reflected at receivers, lane by lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReflectedBounds {
    /// Upper bounds.
    pub(crate) most: Lanes,
    /// Heuristic estimates for the order of refinement: with lights spread over the node instead of
    /// all at its nearest point.
    pub(crate) likely: Lanes,
}

impl ReflectedBounds {
    /// No light at any point.
    pub(crate) const NOTHING: ReflectedBounds = ReflectedBounds {
        most: [0.0; LANES],
        likely: [0.0; LANES],
    };
}

impl LightNode {
    /// Upper bound of the sum of the radiant intensities of all lights, luminance in W/sr. Each
    /// light has a direction within `spread` of the unit vector `axis`.
    pub(crate) fn intensity_within(&self, axis: Vec3, spread: Spread) -> f32 {
        self.intensity.luminance_within(axis, spread)
    }

    /// Upper bounds of the luminance of `Σ f |w·n| I(-w) V / d²` over the lights of an inner node,
    /// for receivers at `p`; inactive lanes hold any value.
    ///
    /// The product of the maxima of `f |w·n|` and `Σ I` over the cone of directions to the bounding
    /// sphere, with `V = 1` and the distance to the nearest point of the box (Walter et al. 2005,
    /// section 4). Infinite for receivers in the box.
    #[inline(always)]
    pub(crate) fn reflected_bounds<S: Sixteen>(
        &self,
        s: S,
        p: &Lanes3,
        receivers: &FixedWoLanes,
        active: LaneMask,
    ) -> ReflectedBounds {
        let (center, radius) = (self.bounds.center(), 0.5 * self.bounds.diagonal());
        let (low, high) = (self.bounds.min, self.bounds.max);
        let (mut towards, mut back) = (Lanes3::ZERO, Lanes3::ZERO);
        let (mut distances, mut nearest2) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let p = p.vec(i);
            let to = center - p;
            let distance = to.length_squared().sqrt();
            let outside = (low - p).max(p - high).max(Vec3::ZERO);
            nearest2[i] = outside.length_squared();
            distances[i] = distance;
            let inverse = distance.recip();
            towards.set(i, to * inverse);
            back.set(i, to * -inverse);
        }
        let mut spreads = [Spread::EVERYWHERE; LANES];
        for i in 0..LANES {
            spreads[i] = Spread::to_ball(radius, distances[i]);
        }
        let reflected = receivers.bounds(s, &towards, &spreads, active);
        let intensities = self.intensity.luminances(&back, &spreads);
        let mut bounds = ReflectedBounds::NOTHING;
        for i in 0..LANES {
            // Avoids 0 · ∞.
            if reflected[i] > 0.0 && intensities[i] > 0.0 {
                let product = reflected[i] * intensities[i];
                bounds.most[i] = product / nearest2[i];
                bounds.likely[i] = product / (nearest2[i] + radius * radius);
            }
        }
        bounds
    }
}
