//! Where light from afar gets in: a density over the four numbers that place a photon of a distant emitter.
//!
//! Photons that start anywhere on the scene's bounding sphere mostly die on the outside of a building that is lit through
//! windows. A pilot walks from the camera, asks at each of its points for light from afar, and notes the numbers
//! (direction and place on a disc across it) of what is visible. A tree over [0,1]⁴ learns their density.
//! Emission draws from it, mixed with the unguided density, and divides the exact density out (see `distant.rs`).
//!
//! Source of the idea of guiding in the space of random numbers: Guo et al., "Primary Sample Space Path Guiding", 2018.
//! Here the space has only the four dimensions of emission.

use super::warp_within::split;

/// Direction (two numbers), then place on the disc (two numbers).
pub(super) type Point4 = [f32; 4];

/// Numbers that led to something visible, and how much light they stand for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lesson {
    pub(super) at: Point4,
    pub(super) weight: f32,
}

/// Cells with fewer lessons are not split.
const LEAST_LESSONS: usize = 12;

/// Cells are not smaller than 2^-24 of the whole.
const DEEPEST: usize = 24;

/// The share of a half lies between this and one minus this.
const LEAST_SHARE: f32 = 0.02;

/// Splits with less information than this (per lesson, in nats) are made in the dimension that was split least.
const LEAST_GAIN: f32 = 1e-3;

#[derive(Clone, Copy, Debug)]
struct Node {
    axis: u8,
    /// Probability of the lower half.
    share: f32,
    /// First of two neighboring children; 0 for leaves.
    children: u32,
}

/// A density on [0,1]⁴, positive everywhere.
#[derive(Clone, Debug)]
pub(super) struct Guide {
    nodes: Vec<Node>,
}

impl Guide {
    /// `None` without lessons.
    pub(super) fn learn(lessons: &mut [Lesson]) -> Option<Self> {
        let total: f64 = lessons.iter().map(|l| f64::from(l.weight)).sum();
        if !(total.is_finite() && total > 0.0) {
            return None;
        }
        let mut guide = Guide {
            nodes: vec![Node::LEAF],
        };
        guide.grow(0, lessons, Cell::WHOLE);
        Some(guide)
    }

    /// Density of [`Guide::warp`].
    pub(super) fn density(&self, point: Point4) -> f32 {
        let mut node = self.nodes[0];
        let mut cell = Cell::WHOLE;
        let mut density = 1.0;
        while node.children != 0 {
            let axis = node.axis as usize;
            let upper = cell.halve(axis, point[axis]);
            density *= 2.0 * if upper { 1.0 - node.share } else { node.share };
            node = self.nodes[node.children as usize + usize::from(upper)];
        }
        density
    }

    /// Uniform numbers to numbers with the learned density, cell by cell along each axis.
    pub(super) fn warp(&self, mut u: Point4) -> Point4 {
        let mut node = self.nodes[0];
        let mut cell = Cell::WHOLE;
        while node.children != 0 {
            let axis = node.axis as usize;
            let (lower, rest) = split(u[axis], node.share);
            u[axis] = rest;
            cell.take(axis, !lower);
            node = self.nodes[node.children as usize + usize::from(!lower)];
        }
        std::array::from_fn(|axis| {
            (cell.low[axis] + u[axis] * cell.size[axis]).min(1.0 - f32::EPSILON)
        })
    }

    fn grow(&mut self, index: usize, lessons: &mut [Lesson], cell: Cell) {
        let depth: usize = cell.splits.iter().map(|&s| usize::from(s)).sum();
        if lessons.len() < LEAST_LESSONS || depth >= DEEPEST {
            return;
        }
        let axis = cell.best_axis(lessons);
        let middle = cell.low[axis] + 0.5 * cell.size[axis];
        let mut count = 0;
        for k in 0..lessons.len() {
            if lessons[k].at[axis] < middle {
                lessons.swap(k, count);
                count += 1;
            }
        }
        let (lower, upper) = lessons.split_at_mut(count);
        // One average lesson on each side: an empty half may only have been unlucky.
        let (a, b) = (weight(lower), weight(upper));
        let prior = (a + b) / (lower.len() + upper.len()) as f32;
        let share = ((a + prior) / (a + b + 2.0 * prior)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE);
        let children = self.nodes.len();
        self.nodes[index] = Node {
            axis: axis as u8,
            share,
            children: children as u32,
        };
        self.nodes.extend([Node::LEAF; 2]);
        for (k, side) in [lower, upper].into_iter().enumerate() {
            let mut half = cell;
            half.take(axis, k == 1);
            self.grow(children + k, side, half);
        }
    }
}

impl Node {
    const LEAF: Node = Node {
        axis: 0,
        share: 0.5,
        children: 0,
    };
}

fn weight(lessons: &[Lesson]) -> f32 {
    lessons.iter().map(|l| l.weight).sum()
}

/// A box of the tree. Its corners are sums of powers of two, so that both ways down agree on them exactly.
#[derive(Clone, Copy)]
struct Cell {
    low: Point4,
    size: Point4,
    splits: [u8; 4],
}

impl Cell {
    const WHOLE: Cell = Cell {
        low: [0.0; 4],
        size: [1.0; 4],
        splits: [0; 4],
    };

    /// Shrinks to one half.
    fn take(&mut self, axis: usize, upper: bool) {
        self.size[axis] *= 0.5;
        self.splits[axis] += 1;
        if upper {
            self.low[axis] += self.size[axis];
        }
    }

    /// Shrinks to the half that holds `x`; whether it is the upper one.
    fn halve(&mut self, axis: usize, x: f32) -> bool {
        let upper = x >= self.low[axis] + 0.5 * self.size[axis];
        self.take(axis, upper);
        upper
    }

    /// The axis whose halves differ most in weight.
    fn best_axis(&self, lessons: &[Lesson]) -> usize {
        let total = weight(lessons);
        let gain = |axis: usize| {
            let middle = self.low[axis] + 0.5 * self.size[axis];
            let lower: f32 = lessons
                .iter()
                .filter(|l| l.at[axis] < middle)
                .map(|l| l.weight)
                .sum();
            // Relative entropy of the halves to even halves.
            [lower / total, 1.0 - lower / total]
                .iter()
                .map(|&s| if s > 0.0 { s * (2.0 * s).ln() } else { 0.0 })
                .sum::<f32>()
        };
        let gains: [f32; 4] = std::array::from_fn(gain);
        let best = (0..4).fold(0, |best, axis| {
            if gains[axis] > gains[best] {
                axis
            } else {
                best
            }
        });
        if gains[best] > LEAST_GAIN {
            return best;
        }
        (0..4).fold(0, |least, axis| {
            if self.splits[axis] < self.splits[least] {
                axis
            } else {
                least
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Sampler, Stream};

    fn uniform(sampler: &mut Sampler) -> Point4 {
        std::array::from_fn(|_| sampler.next_1d())
    }

    /// Lessons inside a small box and along a diagonal.
    fn guide() -> Guide {
        let mut sampler = Sampler::new(1, 0, Stream::Test, 0);
        let mut lessons: Vec<Lesson> = (0..4000)
            .map(|i| {
                let u = uniform(&mut sampler);
                let at = if i % 4 == 0 {
                    [u[0], u[0], u[2], u[3]]
                } else {
                    u.map(|x| 0.6 + 0.1 * x)
                };
                Lesson {
                    at,
                    weight: 0.5 + sampler.next_1d(),
                }
            })
            .collect();
        Guide::learn(&mut lessons).unwrap()
    }

    #[test]
    fn samples_follow_the_density_and_weights_are_exact() {
        let guide = guide();
        let mut sampler = Sampler::new(2, 0, Stream::Test, 0);
        let n = 200_000;
        let (mut integral, mut mass) = (0.0f64, 0.0f64);
        let inside = |x: Point4| x.iter().all(|v| (0.5..0.75).contains(v));
        let f = |x: Point4| f64::from(x[0] * x[1] * x[2] * x[3]);
        for _ in 0..n {
            let x = guide.warp(uniform(&mut sampler));
            mass += f64::from(u8::from(inside(x))) / f64::from(n);
            if inside(x) {
                integral += f(x) / f64::from(guide.density(x)) / f64::from(n);
            }
        }
        let exact = ((0.75f64.powi(2) - 0.5f64.powi(2)) / 2.0).powi(4);
        assert!(
            (integral / exact - 1.0).abs() < 0.02,
            "{integral} for {exact}"
        );
        assert!(
            (0.7..0.85).contains(&mass),
            "three quarters of the lessons are there, {mass} of the samples"
        );
    }

    #[test]
    fn there_is_no_guide_without_lessons() {
        assert!(Guide::learn(&mut []).is_none());
        assert!(
            Guide::learn(&mut [Lesson {
                at: [0.5; 4],
                weight: 0.0
            }])
            .is_none()
        );
        let mut same = [Lesson {
            at: [0.3; 4],
            weight: 1.0,
        }; 1000];
        let guide = Guide::learn(&mut same).unwrap();
        assert!(guide.density([0.3; 4]) > 1e3 && guide.density([0.9; 4]) > 0.0);
    }
}
