//! Subsets of the lights: every n-th along the space-filling curve.

use crate::virtual_lights::moments::POINTS;

/// The lights that are summed at a point: every n-th along the space-filling curve, each of which
/// represents n lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Subset {
    first: u32,
    step: u32,
    /// Number of points among which the lights are divided, and with results that are averaged.
    points: u32,
    /// Of the points of each light, the one that stands for it from far.
    far_point: u32,
}

impl Subset {
    /// All lights.
    pub const ALL: Subset = Subset {
        first: 0,
        step: 1,
        points: 1,
        far_point: 0,
    };

    /// Subset `k` (modulo `step`) of `step` subsets that together are this one.
    pub fn part(self, k: u32, step: u32) -> Self {
        Subset {
            first: self.first + self.step * (k % step),
            step: self.step * step,
            ..self
        }
    }

    /// As [`Subset::part`], for point `k` of `points` points with results that are averaged.
    /// Clamping sees a light with its own area then, as if all points summed all lights.
    pub fn divided(self, k: u32, points: u32) -> Self {
        Subset {
            points: self.points * points,
            ..self.part(k, points)
        }
    }

    /// The same lights, for each of which point `k` (modulo their number) stands from far.
    pub fn from_point(self, k: u32) -> Self {
        Subset {
            far_point: k % POINTS as u32,
            ..self
        }
    }

    /// The index of that point.
    #[inline]
    pub(super) fn far_point(self) -> usize {
        self.far_point as usize
    }

    /// Indices of the subset's lights among `lights` lights.
    #[inline]
    pub fn indices(self, lights: usize) -> impl ExactSizeIterator<Item = usize> {
        (self.first as usize..lights).step_by(self.step as usize)
    }

    /// Number of the subset's lights among `lights` lights.
    pub fn count(self, lights: usize) -> usize {
        self.indices(lights).len()
    }

    /// Number of lights that each light of the subset represents: the factor on its emission.
    #[inline]
    pub fn lights_per_member(self) -> f32 {
        self.step as f32
    }

    /// Factor on the area of a light, as clamping sees it.
    #[inline]
    pub(super) fn area_factor(self) -> f32 {
        self.step as f32 / self.points as f32
    }
}
