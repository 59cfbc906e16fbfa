//! Upper bounds of what the lights of a node send by way of receivers.

use super::Node;
use crate::bsdf::Receivers;
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3};
use crate::math::{Spread, Vec3};

impl Node {
    /// For an inner node: upper bounds of the luminance of `Σ f |w·n| I(-w) V / d²` over the lights below, for receivers at `p`, in each active lane; other lanes
    /// hold anything. The receivers' and the lights' bounds over the cone of directions to the bounding sphere, at the nearest point of the
    /// box; infinite within the box.
    #[inline(always)]
    pub(crate) fn bounds(&self, p: &Lanes3, receivers: &Receivers, active: LaneMask) -> Lanes {
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
        let mut bounds = receivers.bounds(&towards, &spreads, active);
        let intensities = self.intensity.luminances(&back, &spreads);
        for i in 0..LANES {
            // Either may be infinite.
            let none = bounds[i] == 0.0 || intensities[i] == 0.0;
            let bound = bounds[i] * intensities[i] / nearest2[i];
            bounds[i] = if none { 0.0 } else { bound };
        }
        bounds
    }
}
