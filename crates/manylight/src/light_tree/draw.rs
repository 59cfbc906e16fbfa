//! One light stands for all of a cluster: drawn by what they may send to a place, from the cluster down to the light.
//!
//! Source: Yuksel, "Stochastic Lightcuts", HPG 2019; here by bounds of what lights shine towards the place, and never far from their flux.

use super::{Content, LightTree};
use crate::ids::LightId;
use crate::math::Vec3;
use crate::sampling::rng::Pcg;
use crate::virtual_lights::VirtualLights;

/// Lights are drawn to this share by their flux alone, so that none counts for much more than its own.
const BY_FLUX: f32 = 0.2;

/// A light that was drawn from all below some node.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// Which.
    pub id: LightId,
    /// Index of its node.
    pub leaf: usize,
    /// With what probability, in (0, 1]; 1 for the light itself.
    pub probability: f32,
}

impl LightTree {
    /// A light below `node`, by what its lights may send to `place`.
    pub fn draw(&self, field: &VirtualLights, node: usize, place: Vec3, rng: &mut Pcg) -> Drawn {
        let (mut leaf, mut probability) = (node, 1.0);
        loop {
            let children = match self.nodes[leaf].content {
                Content::Light(id) => {
                    return Drawn {
                        id,
                        leaf,
                        probability,
                    };
                }
                Content::Nodes { second } => [leaf + 1, second as usize],
            };
            let first = self.chance_of_first(field, children, place);
            let k = usize::from(rng.next_f32() >= first);
            leaf = children[k];
            probability *= [first, 1.0 - first][k];
        }
    }

    /// What is known of a light that was drawn from a node, in terms of the child of that which it is below: the child, by its index among
    /// both, and the light as if it had been drawn from there.
    pub fn inherit(
        &self,
        field: &VirtualLights,
        children: [usize; 2],
        drawn: Drawn,
        place: Vec3,
    ) -> (usize, Drawn) {
        let first = self.chance_of_first(field, children, place);
        // All below the first child comes before the second.
        let k = usize::from(drawn.leaf >= children[1]);
        let probability = if drawn.leaf == children[k] {
            1.0
        } else {
            (drawn.probability / [first, 1.0 - first][k]).min(1.0)
        };
        let drawn = Drawn {
            probability,
            ..drawn
        };
        (k, drawn)
    }

    /// Probability that a light of a node is drawn from the first of its children.
    fn chance_of_first(&self, field: &VirtualLights, children: [usize; 2], place: Vec3) -> f32 {
        let [first, second] = children;
        let (a, b) = (self.nodes[first].flux, self.nodes[second].flux);
        let by_flux = a / (a + b);
        let a = self.expected(field, first, place);
        let sum = a + self.expected(field, second, place);
        // Bounds may be infinite, and nothing may be known in the middle of a node.
        if !(sum > 0.0 && sum < f32::INFINITY) {
            return by_flux;
        }
        BY_FLUX * by_flux + (1.0 - BY_FLUX) * (a / sum)
    }

    /// About what the lights of a node send to `place`, in W/m².
    #[inline(always)]
    fn expected(&self, field: &VirtualLights, node: usize, place: Vec3) -> f32 {
        let node = &self.nodes[node];
        let to = place - node.bounds.center();
        let d2 = to.length_squared();
        let w = to * d2.sqrt().recip();
        let radius = 0.5 * node.bounds.diagonal();
        let intensity = match node.content {
            Content::Light(id) => field.intensity(id, w).luminance(),
            Content::Nodes { .. } => node.intensity.luminance(w),
        };
        intensity / (d2 + radius * radius)
    }
}
