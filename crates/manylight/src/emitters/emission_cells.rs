//! Cells of emission: groups of neighboring elements of emitters, among which a guide divides the
//! photons.

use super::Emitters;
use crate::geometry::SurfaceRef;
use crate::ids::EmitterId;
use crate::math::Aabb;
use crate::math::hilbert::HilbertCurve;
use crate::sampling::alias::Alias;
use std::ops::Range;

/// Fraction of all power from which on a group of elements is a cell: there are at most twice as
/// many cells as its inverse, and the infinite lights. At 1/128 and 1/32 the guide gains too little
/// to be used in Disco and Garage (`MIN_GAIN` of `integrators/emission_guiding`), where the pixel
/// variance of 128 lights of 20,000 photon paths is 1.09 and .90 times that with it (16 seeds); at
/// 1/32 it is 1.04 times in a scene with a lamp behind a door.
const CELL_POWER: f32 = 1.0 / 64.0;

/// What emission chooses first: an element, or an infinite light.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmissionUnit {
    pub(super) emitter: EmitterId,
    /// Index of the element; `None` for an infinite light.
    pub(super) element: Option<u32>,
    /// In proportion to the probability of unguided emission.
    weight: f32,
}

/// The elements and infinite lights that emit, in cells.
#[derive(Clone, Debug)]
pub struct EmissionCells {
    units: Vec<EmissionUnit>,
    cells: Vec<Range<usize>>,
    /// By element; `None` without power.
    of_element: Vec<Option<u32>>,
}

/// A choice among elements and infinite lights.
#[derive(Clone, Debug)]
pub(super) struct UnitChoice {
    units: Vec<EmissionUnit>,
    choice: Alias,
}

impl EmissionCells {
    /// Cells of `emitters`, which have these `weights` in unguided emission.
    pub(super) fn new(emitters: &Emitters, weights: &[f32]) -> Self {
        let mut units = elements_along_curve(emitters);
        let local = units.len();
        let infinite = emitters.infinite.powers().map(|(emitter, _)| EmissionUnit {
            emitter,
            element: None,
            weight: weights[emitter.index()],
        });
        units.extend(infinite.filter(|unit| unit.weight > 0.0));
        let least = CELL_POWER * units.iter().map(|unit| unit.weight).sum::<f32>();
        let (mut cells, mut start, mut total) = (Vec::new(), 0, 0.0);
        for (i, unit) in units.iter().enumerate() {
            // One large emitter, or an infinite light, is a cell alone.
            if (unit.weight >= least || i >= local) && start < i {
                cells.push(start..i);
                (start, total) = (i, 0.0);
            }
            total += unit.weight;
            if total >= least || i >= local {
                cells.push(start..i + 1);
                (start, total) = (i + 1, 0.0);
            }
        }
        if start < units.len() {
            cells.push(start..units.len());
        }
        let mut of_element = vec![None; emitters.element_weights.len()];
        for (k, cell) in cells.iter().enumerate() {
            for element in units[cell.clone()].iter().filter_map(|unit| unit.element) {
                of_element[element as usize] = Some(k as u32);
            }
        }
        EmissionCells {
            units,
            cells,
            of_element,
        }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Whether nothing emits.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The probability of each cell in unguided emission.
    pub fn probabilities(&self) -> Vec<f32> {
        let weight = |cell: &Range<usize>| {
            let units = &self.units[cell.clone()];
            units.iter().map(|unit| f64::from(unit.weight)).sum::<f64>()
        };
        let weights: Vec<f64> = self.cells.iter().map(weight).collect();
        let total: f64 = weights.iter().sum();
        weights.iter().map(|w| (w / total) as f32).collect()
    }

    /// The emitter that has the largest part of the power of `cell`.
    pub fn emitter(&self, cell: usize) -> EmitterId {
        let units = &self.units[self.cells[cell].clone()];
        let largest = units.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
        largest.map_or(EmitterId::from(0), |unit| unit.emitter)
    }

    /// The cell of the element at a surface point.
    pub fn cell_at(&self, emitters: &Emitters, at: SurfaceRef) -> Option<usize> {
        let element = emitters.elements.index_at(at)?;
        self.of_element[element].map(|cell| cell as usize)
    }

    /// A choice within one cell.
    pub(super) fn choice_within(&self, cell: usize) -> Option<UnitChoice> {
        let units = self.units[self.cells[cell].clone()].to_vec();
        let weights: Vec<f32> = units.iter().map(|unit| unit.weight).collect();
        let choice = Alias::new(&weights)?;
        Some(UnitChoice { units, choice })
    }

    /// A choice among all units, in which each cell has the probability that `shares` has for it.
    pub(super) fn choice(&self, shares: &[f32]) -> Option<UnitChoice> {
        let mut weights = vec![0.0; self.units.len()];
        let scales = shares.iter().zip(self.probabilities());
        for (cell, (share, probability)) in self.cells.iter().zip(scales) {
            for k in cell.clone() {
                weights[k] = self.units[k].weight * (share / probability);
            }
        }
        let (units, choice) = (self.units.clone(), Alias::new(&weights)?);
        Some(UnitChoice { units, choice })
    }
}

impl UnitChoice {
    /// The probability of each of `count` emitters.
    pub(super) fn probabilities(&self, count: usize) -> Vec<f32> {
        let mut probabilities = vec![0.0; count];
        for (i, unit) in self.units.iter().enumerate() {
            probabilities[unit.emitter.index()] += self.choice.pmf(i);
        }
        probabilities
    }

    /// A unit, and its probability.
    pub(super) fn sample(&self, u: f32) -> (EmissionUnit, f32) {
        let (index, pmf) = self.choice.sample(u);
        (self.units[index], pmf)
    }
}

/// The elements with power along a Hilbert curve, so that neighbors in space are neighbors in the
/// list.
fn elements_along_curve(emitters: &Emitters) -> Vec<EmissionUnit> {
    let weights = &emitters.element_weights;
    let centers = weights.iter().map(|&(center, _)| center);
    let curve = HilbertCurve::through(Aabb::from_points(centers));
    let mut keyed: Vec<(u64, u32)> = (weights.iter().enumerate())
        .filter(|&(_, &(_, weight))| weight > 0.0)
        .map(|(i, &(center, _))| (curve.index(center), i as u32))
        .collect();
    keyed.sort_unstable();
    let unit = |(_, element): (u64, u32)| EmissionUnit {
        emitter: emitters.elements.element(element as usize).emitter,
        element: Some(element),
        weight: weights[element as usize].1,
    };
    keyed.into_iter().map(unit).collect()
}
