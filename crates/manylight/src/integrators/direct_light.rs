//! Direct light where gather points look, by cells of emission, as next-event estimation finds it.

use crate::emitters::EmissionCells;
use crate::geometry::Ray;
use crate::particles::Importon;
use crate::sampling::{Pass, Sampler, Stream};
use crate::scene::Scene;

/// Importons from which emitters are sampled.
const SAMPLED_IMPORTONS: usize = 4096;
/// Distance by which rays start off their surface, relative to the diagonal of the scene.
const OFFSET: f32 = 1e-5;
/// Distance to a sampled point, relative to all of it, up to which surfaces occlude: the sampled
/// surface does not.
const OCCLUDED: f32 = 0.999;

/// Irradiance times importance, in W, by cell of emission.
pub(super) struct DirectLight {
    /// Of the cells of surfaces.
    of_cells: Vec<f64>,
    /// Of points, spots and infinite lights.
    rest: f64,
}

impl DirectLight {
    /// Direct light at `importons`. Surfaces that let light through straight occlude, so that light
    /// behind them is left out.
    pub(super) fn around(
        scene: &Scene,
        cells: &EmissionCells,
        importons: &[Importon],
        seed: u64,
    ) -> Self {
        let mut light = DirectLight {
            of_cells: vec![0.0; cells.len()],
            rest: 0.0,
        };
        let step = importons.len().div_ceil(SAMPLED_IMPORTONS).max(1);
        let pass = Pass { seed, index: 0 };
        for (k, importon) in importons.iter().enumerate().step_by(step) {
            let numbers = pass.sampler(Stream::DirectLight, k as u64);
            if let Some((cell, irradiance)) = sampled(scene, cells, importon, numbers) {
                let value = f64::from(irradiance * importon.importance) * step as f64;
                *cell.map_or(&mut light.rest, |cell| &mut light.of_cells[cell]) += value;
            }
        }
        light
    }

    /// Of all emitters.
    pub(super) fn total(&self) -> f64 {
        self.of_cells.iter().sum::<f64>() + self.rest
    }

    /// The cells of surfaces, with their light.
    pub(super) fn of_surfaces(&self) -> impl Iterator<Item = (usize, f64)> {
        self.of_cells.iter().copied().enumerate()
    }
}

/// Irradiance from one sample of the emitters, in W/m², and its cell; `None` for the cell of a
/// point or an infinite light.
fn sampled(
    scene: &Scene,
    cells: &EmissionCells,
    importon: &Importon,
    mut numbers: Sampler,
) -> Option<(Option<usize>, f32)> {
    let Importon { p, n, .. } = *importon;
    let u = (numbers.next_1d(), numbers.next_2d());
    let (geometry, emitters) = (&scene.geometry, &scene.emitters);
    let sample = emitters.sample(geometry, &scene.textures, (p, Some(n)), u, None)?;
    let irradiance = sample.weight.selection_weight() * n.dot(sample.wi).max(0.0);
    if irradiance == 0.0 {
        return None;
    }
    let o = p + n * (OFFSET * geometry.bounds().diagonal());
    let distance = o.distance(sample.target);
    match geometry.intersect(&Ray::new(o, sample.wi)) {
        Some(hit) if hit.t < OCCLUDED * distance => None,
        Some(hit) if sample.pdf > 0.0 => Some((cells.cell_at(emitters, hit.at), irradiance)),
        _ => Some((None, irradiance)),
    }
}
