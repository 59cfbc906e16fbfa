//! Environment maps: lookup, and sampling in proportion to the interpolated luminance.

use super::environment_tiles::{CellCorners, CellPoint, EnvironmentTiles};
use crate::color::Rgb;
use crate::emitters::Environment;
use crate::emitters::unit_interval::sample_linear;
use crate::math::float::{floor, safe_sqrt};
use crate::math::trig::{atan2_turns, sin_cos_turns};
use crate::math::{Mat3, Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// Bilinear interpolation at `at` in [0, 1]².
#[inline]
fn interpolate(corners: &CellCorners, at: Vec2) -> Rgb {
    let [c00, c10, c01, c11] = *corners;
    c00.lerp(c10, at.x).lerp(c01.lerp(c11, at.x), at.y)
}

/// Luminances, with negative ones set to 0.
#[inline]
fn luminances(corners: &CellCorners) -> [f32; 4] {
    corners.map(|c| c.luminance().max(0.0))
}

/// Sine of the angle to the y axis.
#[inline]
fn sin_polar(d: Vec3) -> f32 {
    safe_sqrt(d.x * d.x + d.z * d.z)
}

/// An environment map, prepared for lookup and sampling.
#[derive(Clone, Debug)]
pub(in crate::emitters) struct EnvironmentSampler {
    world_from_emitter: Mat3,
    /// Choice of a cell in proportion to mean luminance times solid angle.
    tiles: EnvironmentTiles,
    /// By row of cells: density per solid angle, times sinθ, over luminance.
    density_per_luminance: Vec<f32>,
    /// ∫ L dω in W/m².
    total: Rgb,
}

/// A direction towards the environment.
#[derive(Clone, Copy, Debug)]
pub(in crate::emitters) struct EnvironmentSample {
    /// Unit direction in world space.
    pub(in crate::emitters) wi: Vec3,
    /// Density of [`EnvironmentSampler::sample`] per solid angle.
    pub(in crate::emitters) pdf: f32,
    /// Radiance from that direction.
    pub(in crate::emitters) radiance: Rgb,
}

impl EnvironmentSampler {
    /// `None` if the map is black.
    pub(in crate::emitters) fn new(environment: &Environment) -> Option<Self> {
        let (width, height) = (environment.image.width, environment.image.height);
        let rows = height.max(2) - 1;
        let polar = |row: usize| (row as f32 / rows as f32 * PI).cos();
        let solid_angles: Vec<f32> = (0..rows)
            .map(|row| TAU / width as f32 * (polar(row) - polar(row + 1)))
            .collect();
        let luminance = |corners: &CellCorners| luminances(corners).iter().sum::<f32>();
        let tiles = EnvironmentTiles::new(environment, |row, corners| {
            luminance(corners) * solid_angles[row]
        })?;
        let row_sums: Vec<(Rgb, f64)> = (0..rows)
            .into_par_iter()
            .map(|row| {
                let (mut sum, mut weight) = (Rgb::BLACK, 0.0f64);
                for column in 0..width {
                    let corners = tiles.corners(column, row);
                    sum += interpolate(&corners, Vec2::splat(0.5));
                    weight += f64::from(luminance(&corners) * solid_angles[row]);
                }
                (sum * solid_angles[row], weight)
            })
            .collect();
        let (mut total, mut weight) = (Rgb::BLACK, 0.0f64);
        for (row_total, row_weight) in row_sums {
            total += row_total;
            weight += row_weight;
        }
        // Within a cell the density is proportional to the luminance. Its mean is a quarter of the sum over the corners.
        // dω = 2π² sinθ du dv.
        let scale = 4.0 * (width * rows) as f64 / (weight * 2.0 * std::f64::consts::PI.powi(2));
        let density_per_luminance = solid_angles
            .iter()
            .map(|&s| (f64::from(s) * scale) as f32)
            .collect();
        Some(EnvironmentSampler {
            world_from_emitter: environment.world_from_emitter,
            tiles,
            density_per_luminance,
            total,
        })
    }

    /// Radiance integrated over all directions, ∫ L dω, in W/m².
    pub(in crate::emitters) fn total(&self) -> Rgb {
        self.total
    }

    /// A direction with density proportional to the interpolated luminance.
    #[inline]
    pub(in crate::emitters) fn sample(&self, u: Vec2) -> EnvironmentSample {
        let (row, u) = self.tiles.choose_row(u);
        let (tile, u) = self.tiles.choose_tile(row, u);
        self.sample_within(self.tiles.choose_cell(tile, u))
    }

    /// For the stages of [`EnvironmentSampler::sample`] one by one: row of tiles, tile, cell, then [`EnvironmentSampler::sample_within`].
    pub(super) fn tiles(&self) -> &EnvironmentTiles {
        &self.tiles
    }

    /// A direction within the cell of `p`, with density proportional to the luminance there. `p` is uniform in the cell.
    #[inline]
    pub(super) fn sample_within(&self, p: CellPoint) -> EnvironmentSample {
        let corners = self.tiles.corners(p.column, p.row);
        let [w00, w10, w01, w11] = luminances(&corners);
        let y = sample_linear(p.within.y, w00 + w10, w01 + w11);
        let x = sample_linear(p.within.x, w00 + (w01 - w00) * y, w10 + (w11 - w10) * y);
        let at = CellPoint {
            within: Vec2::new(x, y),
            ..p
        };
        let d = self.direction(at);
        EnvironmentSample {
            wi: (self.world_from_emitter * d).normalize(),
            pdf: self.density(&corners, at, d),
            radiance: interpolate(&corners, at.within),
        }
    }

    /// The point of the map that belongs to the unit direction `d` in the emitter's frame.
    #[inline]
    fn locate(&self, d: Vec3) -> CellPoint {
        let (width, height) = (self.tiles.width as f32, self.tiles.height as f32);
        let x = atan2_turns(d.x, -d.z) * width - 0.5;
        // More accurate near the poles than acos.
        let y = 2.0 * atan2_turns(sin_polar(d), d.y) * height;
        let (left, row) = (floor(x).0, (y as usize).min(self.tiles.height - 1));
        // `x` covers half a turn in either direction: wraps the negative half.
        let column = if left < 0.0 { left + width } else { left };
        CellPoint {
            column: (column as usize).min(self.tiles.width - 1),
            row,
            within: Vec2::new(x - left, y - row as f32),
        }
    }

    /// The inverse of [`EnvironmentSampler::locate`].
    #[inline]
    fn direction(&self, at: CellPoint) -> Vec3 {
        let (width, height) = (self.tiles.width as f32, self.tiles.height as f32);
        let (sin_phi, cos_phi) = sin_cos_turns((at.column as f32 + at.within.x + 0.5) / width);
        let (sin_theta, cos_theta) = sin_cos_turns(0.5 * (at.row as f32 + at.within.y) / height);
        Vec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta)
    }

    /// Radiance from the unit direction `wi` in world space, and the density of sampling that direction.
    #[inline]
    pub(in crate::emitters) fn look_up(&self, wi: Vec3) -> EnvironmentSample {
        let d = self.world_from_emitter.transpose() * wi;
        let at = self.locate(d);
        let corners = self.tiles.corners(at.column, at.row);
        EnvironmentSample {
            wi,
            pdf: self.density(&corners, at, d),
            radiance: interpolate(&corners, at.within),
        }
    }

    /// Density per solid angle at `at`, a point with the given corners and the direction `d` in the emitter's frame.
    #[inline]
    fn density(&self, corners: &CellCorners, at: CellPoint, d: Vec3) -> f32 {
        let [w00, w10, w01, w11] = luminances(corners);
        let (x, y) = (at.within.x, at.within.y);
        let here = (w00 * (1.0 - x) + w10 * x) * (1.0 - y) + (w01 * (1.0 - x) + w11 * x) * y;
        // The lower bound of the sine keeps the density finite at the poles.
        here * self.density_per_luminance[at.row] / sin_polar(d).max(1e-6)
    }
}
