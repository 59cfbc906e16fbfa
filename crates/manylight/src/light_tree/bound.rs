//! Upper bounds of what the lights of a node send by way of receivers.

use super::Node;
use crate::bsdf::FixedWoLanes;
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3};
use crate::math::{Spread, Vec3};

/// What the lights of a node may send to some points, luminance; lane by lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sent {
    /// Upper bounds.
    pub(crate) bounds: Lanes,
    /// About as much, if the lights are spread over the node: what is near is not all at the nearest point.
    pub(crate) likely: Lanes,
}

impl Sent {
    pub(crate) const NOTHING: Sent = Sent {
        bounds: [0.0; LANES],
        likely: [0.0; LANES],
    };
}

impl Node {
    /// For an inner node: upper bounds of the luminance of `Σ f |w·n| I(-w) V / d²` over the lights below, for receivers at `p`, in each active lane; other lanes
    /// hold anything. The receivers' and the lights' bounds over the cone of directions to the bounding sphere, at the nearest point of the
    /// box; infinite within the box.
    #[inline(always)]
    pub(crate) fn sent(&self, p: &Lanes3, receivers: &FixedWoLanes, active: LaneMask) -> Sent {
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
        let reflected = receivers.bounds(&towards, &spreads, active);
        let intensities = self.intensity.luminances(&back, &spreads);
        let mut sent = Sent::NOTHING;
        for i in 0..LANES {
            // Either may be infinite.
            if reflected[i] > 0.0 && intensities[i] > 0.0 {
                let product = reflected[i] * intensities[i];
                sent.bounds[i] = product / nearest2[i];
                sent.likely[i] = product / (nearest2[i] + radius * radius);
            }
        }
        sent
    }
}
