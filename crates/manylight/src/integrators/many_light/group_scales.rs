//! Factors by light group on what a camera path carries.
//!
//! The clamp removes a fraction of the light from a surface that depends on the virtual light that
//! represents it. Groups have their own lights. So a camera path that goes on to restore that light
//! has a factor for each group.

use crate::ids::LightGroup;

/// The factors of a camera path: an index into [`GroupScales`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ScaleRow(u32);

impl ScaleRow {
    /// A factor of one for all groups.
    pub(super) const ONE: ScaleRow = ScaleRow(0);
}

/// The factors of the camera paths of a tile.
#[derive(Clone, Debug)]
pub(super) struct GroupScales {
    groups: usize,
    /// Of the rows after [`ScaleRow::ONE`]; the groups of a row follow each other.
    factors: Vec<f32>,
}

impl GroupScales {
    /// Without rows. `groups` is 0 if groups are not told apart.
    pub(super) fn new(groups: usize) -> Self {
        GroupScales {
            groups,
            factors: Vec::new(),
        }
    }

    /// The factor of a row on light of `group`.
    #[inline]
    pub(super) fn of(&self, row: ScaleRow, group: LightGroup) -> f32 {
        match row {
            ScaleRow::ONE => 1.0,
            ScaleRow(row) => self.factors[(row as usize - 1) * self.groups + group.index()],
        }
    }

    /// The row `row` times `factors`, one for each group.
    pub(super) fn times(&mut self, row: ScaleRow, factors: impl Iterator<Item = f32>) -> ScaleRow {
        for (group, factor) in (0..self.groups).zip(factors) {
            let before = self.of(row, LightGroup(group as u8));
            self.factors.push(before * factor);
        }
        ScaleRow((self.factors.len() / self.groups) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_multiply() {
        let mut scales = GroupScales::new(2);
        let first = scales.times(ScaleRow::ONE, [0.5, 1.0].into_iter());
        let second = scales.times(first, [0.5, 0.0].into_iter());
        let of = |row| [0, 1].map(|group| scales.of(row, LightGroup(group)));
        assert_eq!(of(ScaleRow::ONE), [1.0, 1.0]);
        assert_eq!((of(first), of(second)), ([0.5, 1.0], [0.25, 0.0]));
    }
}
