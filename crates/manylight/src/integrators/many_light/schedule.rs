//! The schedule of passes: which passes share a set of virtual lights, how the lights are divided
//! among passes and pixels, and how far the lights are refined.
//!
//! Passes 0, 1, 2-3, 4-7 and then each 8 form a group. The lights of a group are made together and
//! divided evenly along the space-filling curve. A group of 8 passes has 8 times the lights, each
//! of which represents an 8th of the photons. Such lights differ less from each other, so that an
//! 8th of them has less noise than a set that is made for one pass. In a walkthrough groups have
//! many passes from the first one on, so that every pixel of every frame has all lights.
//!
//! The pixels of a pattern are shaded by different subsets of the lights, so that the noise of
//! neighbors is independent: interleaved sampling. From pass to pass of a group every pixel goes on
//! to another subset. A group of few passes has as many subsets as the pattern has pixels. The
//! pattern is shuffled in each of its repetitions: a filter takes a regular one for a texture.
//!
//! Source: Keller, Heidrich, "Interleaved Sampling", EGWR 2001; for virtual lights: Wald, Kollig,
//! Benthin, Keller, Slusallek, "Interactive Global Illumination using Fast Ray Tracing", EGWR 2002.
//!
//! With progressive resampling, the area that a light represents falls as `1/√(1 + i/16)`, with `i`
//! the first pass of the group. The bias of the mean over `n` passes falls as `1/√n`, as does its
//! noise.

use super::{ManyLight, Resampling};
use crate::film::Half;
use crate::film::blocks::BLOCK_STEP;
use crate::gather::{Strategy, Subset};
use crate::integrators::context::PassContext;
use crate::math::UVec2;
use crate::sampling::{Stream, rng};
use crate::scene::{PathLimits, Scene};
use std::ops::Range;

/// Most passes that share one set of lights; memory grows with it. At 4 and 16 (32 passes of 32
/// lights at 72x40, 2 seeds; Kitchen): relMSE -6.1 and -0.7 % (standard error 1 %), shadow rays +18
/// and -6 %, mean -0.4 and +0.3 %.
const MAX_GROUP_PASSES: u32 = 8;
const _: () = assert!(
    BLOCK_STEP.is_multiple_of(MAX_GROUP_PASSES),
    "sets end with a block"
);
/// Most lights of a group of several passes, where no lights are interleaved: bounds its memory.
const MAX_GROUP_LIGHTS: u32 = 32_768;
/// Most photon paths of a group of several passes: bounds its memory.
pub(super) const MAX_GROUP_PHOTON_PATHS: u32 = 1 << 22;
/// Passes after which the area that a light represents has shrunk by `1/√2`: the first 16 passes,
/// the default of a render, are hardly refined. At 8 and 32 (32 passes of 32 lights at 72x40, 2
/// seeds; Kitchen): relMSE +3.1 and -1.7 % (standard error 3 %), shadow rays -6 and +5 %.
const UNREFINED_PASSES: f32 = 16.0;
/// Most lights that are placed in a group for the sake of refinement: bounds its memory.
const MAX_REFINED_LIGHTS: u32 = 1 << 18;

/// Passes that share one set of virtual lights, and how the set is made.
#[derive(Clone, Debug, PartialEq)]
pub struct PassGroup {
    /// The passes.
    pub passes: Range<u32>,
    /// Factor of progressive refinement, at least 1: the area that a light represents is divided by
    /// it, up to the rounding of `placed_per_shaded`.
    pub refinement: f32,
    /// Number of subsets of the lights with which some pixel is shaded in some pass.
    pub subsets: u32,
    /// Emitted photon paths.
    pub photon_paths: u32,
    /// Importon paths.
    pub importon_paths: u32,
    /// Placed lights per light that some pass sums. The others represent their part of the flux,
    /// but are not evaluated.
    pub placed_per_shaded: u32,
    /// Lights that are placed.
    pub placed_lights: u32,
    /// Photons that make up the emission of a light, under the density rule.
    pub neighbors: u32,
}

impl ManyLight {
    /// The method for frames of a walkthrough, of `passes` passes each.
    pub fn of_frames(&self, passes: Option<u32>) -> Self {
        ManyLight {
            first_passes: passes.unwrap_or(MAX_GROUP_PASSES),
            ..*self
        }
    }

    /// The groups of the first `passes` passes, one after the other: a file may claim any number.
    pub(super) fn pass_groups(&self, passes: u32) -> impl Iterator<Item = PassGroup> {
        let next = |group: &PassGroup| PassGroup::of_pass(self, group.passes.end);
        let groups = std::iter::successors(Some(PassGroup::of_pass(self, 0)), move |group| {
            Some(next(group))
        });
        groups.take_while(move |group| group.passes.start < passes)
    }

    /// Number of groups of the first `passes` passes.
    pub(in crate::integrators) fn group_count(&self, passes: u32) -> u32 {
        self.pass_groups(passes).count() as u32
    }

    /// The half of pass `index`, to which whole groups belong in turn, and the number of passes of
    /// this half before it.
    pub(in crate::integrators) fn place_in_half(&self, index: u32) -> (Half, u32) {
        let mut counts = [0; 2];
        let (mut k, mut group) = (0, passes_with(self, 0));
        while group.start < MAX_GROUP_PASSES && !group.contains(&index) {
            counts[Half::of_set(k).index()] += group.len() as u32;
            (k, group) = (k + 1, passes_with(self, group.end));
        }
        // From here on groups have equal numbers of passes.
        let length = group.len() as u32;
        let (groups, place) = (
            (index - group.start) / length,
            (index - group.start) % length,
        );
        let half = Half::of_set(k + groups);
        (half, counts[half.index()] + groups / 2 * length + place)
    }
}

impl PassGroup {
    /// The group of pass `index`. It depends on the settings and the index alone.
    pub(super) fn of_pass(method: &ManyLight, index: u32) -> Self {
        let passes = passes_with(method, index);
        let refinement = match method.resampling {
            Resampling::New => 1.0,
            Resampling::Progressive => (1.0 + passes.start as f32 / UNREFINED_PASSES).sqrt(),
        };
        PassGroup::new(method, passes, refinement)
    }

    /// A group of pass `index` alone, without refinement.
    pub(super) fn single_pass(method: &ManyLight, index: u32) -> Self {
        PassGroup::new(method, index..index + 1, 1.0)
    }

    fn new(method: &ManyLight, passes: Range<u32>, refinement: f32) -> Self {
        let count = passes.len() as u32;
        let subsets = count.max(method.interleaving.pow(2));
        let shaded = u64::from(method.light_count) * u64::from(subsets);
        let most = (u64::from(MAX_REFINED_LIGHTS) / shaded.max(1)).max(1);
        let placed_per_shaded = (refinement.round() as u32).min(most as u32);
        PassGroup {
            passes,
            refinement,
            subsets,
            photon_paths: method.photon_paths * count,
            importon_paths: method.importon_paths * count,
            placed_per_shaded,
            placed_lights: method.light_count * subsets * placed_per_shaded,
            neighbors: ((method.neighbors as f32 / refinement) as u32).max(1),
        }
    }
}

/// The passes that share the lights of pass `index`: a power of two of them, at most
/// [`MAX_GROUP_PASSES`], and no more than came before, beyond [`ManyLight::first_passes`]; one pass
/// with cuts, which are through all lights of a pass. Product cuts are through all lights of a
/// group.
fn passes_with(method: &ManyLight, index: u32) -> Range<u32> {
    if matches!(method.strategy, Strategy::Cuts(_)) {
        return index..index + 1;
    }
    let most = MAX_GROUP_PASSES
        .min(MAX_GROUP_LIGHTS / method.light_count.max(1))
        .min(MAX_GROUP_PHOTON_PATHS / method.photon_paths.max(1))
        .min(index.max(method.first_passes));
    let count = most.checked_ilog2().map_or(1, |log| 1 << log);
    let start = index - index % count;
    start..start + count
}

/// What the stages of the method work with to make the lights of a group.
#[derive(Clone, Copy)]
pub(super) struct GroupContext<'a, 's> {
    pub(super) method: &'a ManyLight,
    pub(super) scene: &'s Scene,
    pub(super) limits: PathLimits,
    pub(super) group: &'a PassGroup,
    /// Of the first pass of the group.
    pub(super) run: PassContext<'a>,
}

/// The division of a group's lights among its passes and the pixels of a pattern.
#[derive(Clone, Debug)]
pub(super) struct LightSubsets {
    /// The first pass of the group.
    start: u32,
    /// Edge of the pattern in pixels.
    interleaving: u32,
    /// Number of subsets with which some pixel is shaded in some pass.
    shaded: u32,
    /// Number of subsets; some may belong to no pass.
    pub(super) count: u32,
    /// The subset of the first pixel in the first pass. It is random, so that the mean over passes
    /// that end in mid-group is right.
    first: u32,
    /// Key of the shuffled patterns.
    key: u64,
}

impl LightSubsets {
    /// Divides `lights` lights among the passes of a group. Where few photons arrive, there are
    /// fewer lights than were asked for, and some passes or pixels share a subset.
    pub(super) fn divide(cx: &GroupContext, lights: usize) -> Self {
        let GroupContext { method, group, .. } = *cx;
        let shaded = group.subsets;
        let count = match method.strategy {
            Strategy::Cuts(_) | Strategy::Bidirectional(_) => 1,
            Strategy::All => {
                let is_enough = |count: &u32| lights <= (method.light_count * count) as usize;
                let fewest = (0..=shaded.ilog2()).map(|log| 1 << log).find(is_enough);
                let by_size = lights.div_ceil(method.light_count as usize) as u32;
                fewest.unwrap_or(by_size.clamp(shaded, shaded * group.placed_per_shaded))
            }
        };
        let mut sampler = cx.run.pass.sampler(Stream::Subsets, 0);
        let first = (sampler.next_1d() * count as f32) as u32;
        LightSubsets {
            start: group.passes.start,
            interleaving: method.interleaving,
            shaded,
            count,
            first,
            key: u64::from(sampler.next_1d().to_bits()),
        }
    }

    /// What tells this division from others of the same group: the number of subsets, the first
    /// one, and the key of the patterns.
    pub(super) fn numbers(&self) -> [u32; 3] {
        [self.count, self.first, self.key as u32]
    }

    /// The inverse of [`LightSubsets::numbers`]; `None` for numbers of no division of the group.
    pub(super) fn of_numbers(
        method: &ManyLight,
        group: &PassGroup,
        numbers: &[u32],
    ) -> Option<Self> {
        let &[count, first, key] = numbers else {
            return None;
        };
        let most = group.subsets * group.placed_per_shaded;
        (first < count && count <= most).then(|| LightSubsets {
            start: group.passes.start,
            interleaving: method.interleaving,
            shaded: group.subsets,
            count,
            first,
            key: u64::from(key),
        })
    }

    /// The lights of `pixel` in pass `index`. `frame` changes the order of the patterns, so that
    /// they do not stick to the screen in a walkthrough; 0 outside of one.
    pub(super) fn of_pixel(&self, index: u32, pixel: UVec2, frame: u64) -> Subset {
        let place = place_in_pattern(pixel, self.interleaving, self.key ^ frame);
        let ahead = place * (self.shaded / self.interleaving.pow(2));
        let k = self.first + (index - self.start + ahead) % self.shaded;
        Subset::ALL
            .part(k % self.count, self.count)
            .from_point(index - self.start)
    }

    /// Whether some pass shades with light `k`.
    pub(super) fn is_shaded(&self, k: usize) -> bool {
        (k as u32 + self.count - self.first) % self.count < self.shaded
    }
}

/// The place of a pixel in the order of a pattern of `edge` x `edge` pixels, `edge` a power of two.
/// Pixels that follow each other lie far apart, as in Bayer's matrix; at each level, the quadrants
/// have a random order.
fn place_in_pattern(pixel: UVec2, edge: u32, key: u64) -> u32 {
    let levels = edge.ilog2();
    (0..levels).fold(0, |place, level| {
        let at = pixel >> level;
        let digit = quadrants(at / 2, level, key)[(at.y % 2 * 2 + at.x % 2) as usize];
        place | digit << (2 * (levels - 1 - level))
    })
}

/// A random permutation of the quadrants of a cell.
fn quadrants(cell: UVec2, level: u32, key: u64) -> [u32; 4] {
    let at = u64::from(cell.x) << 32 | u64::from(cell.y);
    let word = rng::mix(at ^ rng::mix(key ^ u64::from(level)));
    let mut order = [0, 1, 2, 3];
    for k in 1..4 {
        order.swap(k, (word >> (16 * k) & 0xffff) as usize % (k + 1));
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_hold_whole_runs_of_passes() {
        let method = ManyLight::rich_vpl();
        let mut pass = 0;
        let mut lengths = Vec::new();
        while pass < 40 {
            let passes = method.pass_group(pass).passes;
            assert_eq!(passes.start, pass, "groups follow each other");
            assert!(
                passes
                    .clone()
                    .all(|p| method.pass_group(p).passes == passes)
            );
            lengths.push(passes.len());
            pass = passes.end;
        }
        assert_eq!(lengths, [1, 1, 2, 4, 8, 8, 8, 8]);
        let large = ManyLight {
            light_count: 20_000,
            ..method
        };
        assert_eq!(large.pass_group(11).passes, 11..12);
        let of_frames = |passes| {
            let frames = method.of_frames(Some(passes));
            let groups = (0..passes).map(|pass| frames.pass_group(pass).passes);
            let mut groups: Vec<_> = groups.collect();
            groups.dedup();
            assert_eq!(groups.len() as u32, frames.group_count(passes));
            groups
        };
        assert_eq!(of_frames(20), [0..8, 8..16, 16..24]);
        assert_eq!(of_frames(6), [0..4, 4..8]);
        assert_eq!(of_frames(1).len(), 1);
        let cuts = ManyLight::rich_lightcuts().of_frames(Some(5));
        assert_eq!(cuts.group_count(5), 5);
    }

    #[test]
    fn refinement_leaves_a_neighbor() {
        let method = ManyLight {
            neighbors: 2,
            ..ManyLight::rich_vpl()
        };
        let group = method.pass_group(200);
        assert!(group.refinement > 3.0);
        assert_eq!(group.neighbors, 1);
    }

    /// Whole groups belong to a half, and its passes are counted without gaps.
    #[test]
    fn groups_belong_to_both_halves_in_turn() {
        let method = ManyLight::rich_vpl();
        for (method, groups) in [
            (method, 8),
            (method.of_frames(Some(8)), 5),
            (ManyLight::rich_lightcuts(), 40),
        ] {
            let (mut counts, mut halves) = ([0; 2], Vec::new());
            for pass in 0..40 {
                let (half, place) = method.place_in_half(pass);
                assert_eq!(place, counts[half.index()], "pass {pass}");
                counts[half.index()] += 1;
                if method.pass_group(pass).passes.start == pass {
                    halves.push(half);
                }
            }
            let in_turn: Vec<Half> = (0..groups).map(Half::of_set).collect();
            assert_eq!(halves, in_turn);
        }
    }

    #[test]
    fn the_pixels_of_a_pattern_have_different_lights_and_all_of_them_in_a_group() {
        for (interleaving, passes) in [(1, 8), (2, 1), (2, 2), (2, 8), (4, 1), (4, 8)] {
            let pattern = interleaving * interleaving;
            let shaded = pattern.max(passes);
            let subsets = LightSubsets {
                start: 8,
                interleaving,
                shaded,
                count: shaded,
                first: shaded / 2,
                key: 5,
            };
            let of_pixel = |pass: u32, k: u32| {
                let pixel = UVec2::new(k % interleaving + 8, k / interleaving + 4);
                subsets.of_pixel(8 + pass, pixel, 0)
            };
            let distinct = |all: &mut Vec<Subset>| {
                all.sort();
                all.dedup();
                all.len() as u32
            };
            for pass in 0..passes {
                let mut of_pass = (0..pattern).map(|k| of_pixel(pass, k)).collect();
                assert_eq!(distinct(&mut of_pass), pattern);
            }
            for k in 0..pattern {
                let mut of_passes = (0..passes).map(|pass| of_pixel(pass, k)).collect();
                assert_eq!(distinct(&mut of_passes), passes);
            }
            // A light is seen as another point in each pass.
            let all = (0..pattern).flat_map(|k| (0..passes).map(move |pass| (pass, k)));
            let mut of_all = all.map(|(pass, k)| of_pixel(pass, k)).collect();
            assert_eq!(distinct(&mut of_all), pattern * passes);
            assert!((0..64).all(|k| subsets.is_shaded(k)));
        }
    }

    #[test]
    fn repetitions_of_a_pattern_have_different_orders() {
        for edge in [2, 4] {
            let mut counts = vec![0; (edge * edge) as usize];
            for k in 0..1024 {
                let pixel = UVec2::new(k % 32, k / 32) * edge;
                counts[place_in_pattern(pixel, edge, 7) as usize] += 1;
            }
            // 1024 draws; the tails of five standard deviations.
            let mean = 1024.0 / f64::from(edge * edge);
            let tail = 5.0 * mean.sqrt();
            let is_near = |&count: &i32| (f64::from(count) - mean).abs() < tail;
            assert!(counts.iter().all(is_near), "{counts:?}");
        }
    }
}
