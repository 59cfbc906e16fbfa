//! The part of a direct sample of infinite lights that does not depend on the receiver.

use super::environment::{CellPoints, EnvironmentSampler, EnvironmentSamples};
use super::environment_tiles::CellPoint;
use crate::lanes::One;
use crate::math::Vec2;

/// A chosen infinite light, and how far the choice of its direction has gone.
#[derive(Clone, Copy, Debug)]
pub struct InfiniteLightPlan {
    /// Index of the light.
    pub(super) light: usize,
    /// A number in [0, 1) that the choice of the light has left uniform.
    pub(super) u_left: f32,
    pub(super) direction: PlannedDirection,
}

/// Stages of the choice of a direction. Environment maps go through all of them; for other lights it stays at the first.
#[derive(Clone, Copy, Debug)]
pub(super) enum PlannedDirection {
    /// The random numbers.
    Numbers(Vec2),
    /// A row of tiles, and the numbers that its choice has left uniform.
    Row(usize, Vec2),
    /// A tile, and the numbers that its choice has left uniform.
    Tile(usize, Vec2),
    /// A uniform point in a cell of the environment map.
    Cell(CellPoint),
    /// The complete sample.
    Sample(EnvironmentSamples<One>),
}

impl PlannedDirection {
    /// The next stage. Each stage reads memory that the stage before has prefetched.
    #[inline]
    pub(super) fn next(self, sampler: &EnvironmentSampler) -> Self {
        match self {
            PlannedDirection::Numbers(u) => {
                let (row, u) = sampler.tiles().choose_row(u);
                PlannedDirection::Row(row, u)
            }
            PlannedDirection::Row(row, u) => {
                let (tile, u) = sampler.tiles().choose_tile(row, u);
                PlannedDirection::Tile(tile, u)
            }
            PlannedDirection::Tile(tile, u) => {
                PlannedDirection::Cell(sampler.tiles().choose_cell(tile, u))
            }
            PlannedDirection::Cell(point) => {
                let points = CellPoints::load(One, &[point]);
                PlannedDirection::Sample(sampler.sample_within(&points))
            }
            PlannedDirection::Sample(_) => self,
        }
    }

    /// The sample, after all remaining stages.
    #[inline]
    pub(super) fn finish(mut self, sampler: &EnvironmentSampler) -> EnvironmentSamples<One> {
        loop {
            match self {
                PlannedDirection::Sample(sample) => return sample,
                _ => self = self.next(sampler),
            }
        }
    }
}
