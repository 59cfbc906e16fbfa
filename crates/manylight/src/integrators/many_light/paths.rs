//! What each camera path of a tile is followed for: the payload of the walks of its stream.
//!
//! | part of a path | starts | ends | file |
//! |---|---|---|---|
//! | prefix | at the camera | at a gather point, or on an emitter | `prefix.rs` |
//! | sampled direction | at a gather point | by compensation, or on an emitter | `direction.rs` |
//! | chain | where a sampled direction meets specular lobes | at another gather point, or on an emitter | `chain.rs` |

use super::chain_densities::SharedLight;
use crate::color::Rgb;
use crate::ids::LightGroup;
use crate::integrators::camera_round::{CameraPath, FirstPart};
use crate::integrators::first_event::SampleShare;
use crate::integrators::partition::PathStage;
use crate::sampling::{LowDiscrepancySequence, Sampler};

/// Camera paths of a pixel after the first specular event. With fewer of them, low-roughness lobes
/// and the choice between reflection and refraction are noisy. At 4 and 16 (2 passes of 128 lights at
/// 72x40, 6 seeds; Kitchen, Glossy Room, U-Shape): relMSE +1.6 and +0.6 % (standard error 1 %).
pub(super) const SPLIT: u32 = 8;
/// Camera paths that look for emitters, per path that gathers. Lamps that are smaller than a pixel,
/// and their edges and reflections, have much noise, and these paths cost little. Measured at 1, 4
/// and 8, over 4 passes at 160x90: relMSE times time is 1, 0.74 and 0.88 in the Kitchen, 1, 0.67
/// and 0.85 in the Disco, 1, 0.94 and 0.93 in the Garage.
pub(super) const EMISSION_PATHS: u32 = 4;
/// Growth of the largest radius of density estimates per length of segments after a non-specular
/// event, in rad: caustics seen by such events may be blurred more. At 0.01 and 0.04 (2 passes of
/// 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room, Garage): the same picture. In pictures as
/// small as these, the bound by the diagonal is smaller.
const INDIRECT_RADIUS_ANGLE: f32 = 0.02;

/// What a camera path carries.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathState {
    /// Index of the pixel in the tile.
    pub(super) pixel: u32,
    pub(super) stage: PathStage,
    pub(super) part: PathPart,
}

/// The part of a camera path that is followed.
#[derive(Clone, Copy, Debug)]
pub(super) enum PathPart {
    /// From the camera by specular events.
    Prefix(Prefix),
    /// Along a direction that was sampled at a gather point.
    Direction(Direction),
    /// From there by specular events.
    Chain(Chain),
}

/// See [`PathPart::Prefix`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Prefix {
    /// `None`: the path looks for emitters, and does not gather.
    pub(super) number: Option<PathNumber>,
    /// Distance from the camera along the path, in m.
    pub(super) length: f32,
    /// Weight by the reconstruction filter.
    pub(super) filter_weight: f32,
}

/// See [`PathPart::Direction`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction {
    /// Index of the gather point in the tile.
    pub(super) from: u32,
    /// `f cosθ` of its non-specular lobes in the direction, in 1/sr.
    pub(super) f_cos: Rgb,
    /// Largest radius of density estimates at the end of the path, in m.
    pub(super) max_photon_radius: f32,
}

/// See [`PathPart::Chain`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Chain {
    /// By which photons have their share of the light that the chain finds.
    pub(super) shared: SharedLight,
    /// As in [`GatherPath`](super::gather_point::GatherPath), of the point where it starts.
    pub(super) scales: ScaleRow,
    /// See [`GatherPath::first_weight`](super::gather_point::GatherPath::first_weight).
    pub(super) first_weight: f32,
    /// Largest radius of density estimates at the end of the path, in m.
    pub(super) max_photon_radius: f32,
}

/// The number of a camera path among those of its pixel that gather.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathNumber {
    pub(super) index: u32,
    pub(super) count: u32,
}

impl PathState {
    #[inline(always)]
    pub(super) fn prefix(&self) -> Option<&Prefix> {
        match &self.part {
            PathPart::Prefix(prefix) => Some(prefix),
            PathPart::Direction(_) | PathPart::Chain(_) => None,
        }
    }

    #[inline(always)]
    pub(super) fn direction(&self) -> Option<&Direction> {
        match &self.part {
            PathPart::Direction(direction) => Some(direction),
            PathPart::Prefix(_) | PathPart::Chain(_) => None,
        }
    }

    #[inline(always)]
    pub(super) fn chain(&self) -> Option<&Chain> {
        match &self.part {
            PathPart::Chain(chain) => Some(chain),
            PathPart::Prefix(_) | PathPart::Direction(_) => None,
        }
    }

    /// The number of a path on its specular prefix that gathers.
    #[inline(always)]
    pub(super) fn number(&self) -> Option<PathNumber> {
        self.prefix().and_then(|prefix| prefix.number)
    }
}

impl CameraPath for PathState {
    #[inline(always)]
    fn first(&self) -> Option<FirstPart> {
        let prefix = self.prefix()?;
        let share = 1.0 / prefix.number?.count as f32;
        Some(FirstPart {
            pixel: self.pixel,
            hidden: prefix.length,
            event: SampleShare {
                filter_weight: prefix.filter_weight,
                share,
            },
            surface_share: share,
        })
    }

    #[inline(always)]
    fn after_segment(mut self, distance: f32) -> Self {
        match &mut self.part {
            PathPart::Prefix(prefix) => prefix.length += distance,
            PathPart::Direction(direction) => {
                direction.max_photon_radius += INDIRECT_RADIUS_ANGLE * distance;
            }
            PathPart::Chain(chain) => chain.max_photon_radius += INDIRECT_RADIUS_ANGLE * distance,
        }
        self
    }
}

/// Random numbers that the camera paths of a pixel share, so that together they fill their domains
/// evenly.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelNumbers {
    pub(super) events: LowDiscrepancySequence,
    pub(super) emitters: LowDiscrepancySequence,
    pub(super) directions: LowDiscrepancySequence,
}

impl PixelNumbers {
    pub(super) fn draw(sampler: &mut Sampler) -> Self {
        PixelNumbers {
            events: sampler.next_sequence(),
            emitters: sampler.next_sequence(),
            directions: sampler.next_sequence(),
        }
    }
}

/// The factors by light group on what a camera path carries: an index into [`GroupScales`].
///
/// The clamp removes a fraction of the light from a surface that depends on the virtual light that
/// represents it. Groups have their own lights. So a camera path that goes on to restore that light
/// has a factor for each group.
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
