//! Environment maps: lookup, and sampling in proportion to the interpolated luminance.

use super::environment_tiles::{CellCorners, CellPoint, EnvironmentTiles};
use crate::color::Rgb;
use crate::emitters::Environment;
use crate::lanes::{Color, Float, Mask, Pair, Vector, Width, sample_linear};
use crate::math::Mat3;
use crate::simd::outlined;
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// The texels at the corners (0,0), (1,0), (0,1), (1,1) of a cell, in lanes.
type CornersOfCells<S> = [Color<S>; 4];

/// Bilinear interpolation at `at` in [0, 1]².
#[inline(always)]
fn interpolate<S: Width>(corners: &CornersOfCells<S>, at: Pair<S>) -> Color<S> {
    let [c00, c10, c01, c11] = *corners;
    c00.lerp(c10, at.x).lerp(c01.lerp(c11, at.x), at.y)
}

/// Luminances, with negative ones set to 0.
#[inline(always)]
fn luminances<S: Width>(corners: &CornersOfCells<S>) -> [Float<S>; 4] {
    let [c00, c10, c01, c11] = *corners;
    [
        c00.luminance().max(0.0),
        c10.luminance().max(0.0),
        c01.luminance().max(0.0),
        c11.luminance().max(0.0),
    ]
}

/// Sum of the luminances at the corners of a cell.
fn sum_of_luminances(corners: &CellCorners) -> f32 {
    corners.map(|c| c.luminance().max(0.0)).iter().sum()
}

/// Sine of the angle to the y axis.
#[inline(always)]
fn sin_polar<S: Width>(d: Vector<S>) -> Float<S> {
    (d.x * d.x + d.z * d.z).safe_sqrt()
}

/// The product of a matrix and a vector.
#[inline(always)]
fn product<S: Width>(m: &Mat3, v: Vector<S>) -> Vector<S> {
    let s = v.x.width();
    Vector::splat(s, m.x_axis) * v.x
        + Vector::splat(s, m.y_axis) * v.y
        + Vector::splat(s, m.z_axis) * v.z
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

/// A direction towards the environment per lane.
#[derive(Clone, Copy, Debug)]
pub(in crate::emitters) struct EnvironmentSamples<S: Width> {
    /// Unit direction in world space.
    pub(in crate::emitters) wi: Vector<S>,
    /// Density of [`EnvironmentSampler::sample`] per solid angle.
    pub(in crate::emitters) pdf: Float<S>,
    /// Radiance from that direction.
    pub(in crate::emitters) radiance: Color<S>,
}

/// A [`CellPoint`] per lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellPoints<S: Width> {
    column: S::Each<u32>,
    row: S::Each<u32>,
    within: Pair<S>,
}

impl<S: Width> CellPoints<S> {
    #[inline(always)]
    pub(super) fn load(s: S, points: &S::Each<CellPoint>) -> Self {
        let points = points.as_ref();
        CellPoints {
            column: s.each(|i| points[i].column as u32),
            row: s.each(|i| points[i].row as u32),
            within: Pair::from_fn(s, |i| points[i].within),
        }
    }
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
        let tiles = EnvironmentTiles::new(environment, |row, corners| {
            sum_of_luminances(corners) * solid_angles[row]
        })?;
        let row_sums: Vec<(Rgb, f64)> = (0..rows)
            .into_par_iter()
            .map(|row| {
                let (mut sum, mut weight) = (Rgb::BLACK, 0.0f64);
                for column in 0..width {
                    let corners = tiles.corners(column, row);
                    let [c00, c10, c01, c11] = corners;
                    sum += c00.lerp(c10, 0.5).lerp(c01.lerp(c11, 0.5), 0.5);
                    weight += f64::from(sum_of_luminances(&corners) * solid_angles[row]);
                }
                (sum * solid_angles[row], weight)
            })
            .collect();
        let (mut total, mut weight) = (Rgb::BLACK, 0.0f64);
        for (row_total, row_weight) in row_sums {
            total += row_total;
            weight += row_weight;
        }
        // Within a cell the density is proportional to the luminance. Its mean is a quarter of the
        // sum over the corners. dω = 2π² sinθ du dv.
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

    outlined! {
        /// Directions in the lanes of `lanes` with density proportional to the interpolated
        /// luminance; elsewhere any.
        pub(in crate::emitters) fn sample<S: Width>(
            sampler: &EnvironmentSampler, u: Pair<S>, lanes: Mask<S>,
        ) -> EnvironmentSamples<S> { lanes.width() => sampler.sample_inlined(u, lanes) }

        /// Radiance from the unit directions `wi` (pointing away from the scene), and their
        /// densities.
        pub(in crate::emitters) fn look_up<S: Width>(
            sampler: &EnvironmentSampler, wi: Vector<S>,
        ) -> EnvironmentSamples<S> { wi.x.width() => sampler.look_up_inlined(wi) }
    }

    #[inline(always)]
    fn sample_inlined<S: Width>(&self, u: Pair<S>, lanes: Mask<S>) -> EnvironmentSamples<S> {
        let p = CellPoints::load(lanes.width(), &self.tiles.choose_cells(u, lanes));
        let corners = self.corners(&p);
        let [w00, w10, w01, w11] = luminances(&corners);
        let y = sample_linear(p.within.y, w00 + w10, w01 + w11);
        let x = sample_linear(p.within.x, w00 + (w01 - w00) * y, w10 + (w11 - w10) * y);
        let at = CellPoints {
            within: Pair::new(x, y),
            ..p
        };
        let d = self.direction(&at);
        EnvironmentSamples {
            wi: product(&self.world_from_emitter, d).normalize(),
            pdf: self.density(&corners, &at, d),
            radiance: interpolate(&corners, at.within),
        }
    }

    /// The points of the map that belong to the unit directions `d` in the emitter's frame.
    #[inline(always)]
    fn locate<S: Width>(&self, d: Vector<S>) -> CellPoints<S> {
        let (width, height) = (self.tiles.width as f32, self.tiles.height as f32);
        let x = d.x.atan2_turns(-d.z) * width - 0.5;
        // More accurate near the poles than acos.
        let y = sin_polar(d).atan2_turns(d.y) * (2.0 * height);
        let left = x.floor();
        let row = y.min(height - 1.0).floor();
        let rows = row.to_word();
        // `x` covers half a turn in either direction: wraps the negative half.
        let column = left.lt(0.0).select(left + width, left);
        let columns = column.min(width - 1.0).floor().to_word();
        CellPoints {
            column: columns.store(),
            row: rows.store(),
            within: Pair::new(x - left, y - row),
        }
    }

    /// The inverse of [`EnvironmentSampler::locate`].
    #[inline(always)]
    fn direction<S: Width>(&self, at: &CellPoints<S>) -> Vector<S> {
        let s = at.within.x.width();
        let column = Float::from_fn(s, |i| at.column.as_ref()[i] as f32);
        let row = Float::from_fn(s, |i| at.row.as_ref()[i] as f32);
        let (width, height) = (self.tiles.width as f32, self.tiles.height as f32);
        let turn = (column + at.within.x + 0.5) / width;
        let polar = (row + at.within.y) * 0.5 / height;
        let (sin_phi, cos_phi) = turn.sin_cos_turns();
        let (sin_theta, cos_theta) = polar.sin_cos_turns();
        Vector::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta)
    }

    #[inline(always)]
    fn look_up_inlined<S: Width>(&self, wi: Vector<S>) -> EnvironmentSamples<S> {
        let d = product(&self.world_from_emitter.transpose(), wi);
        let at = self.locate(d);
        let corners = self.corners(&at);
        EnvironmentSamples {
            wi,
            pdf: self.density(&corners, &at, d),
            radiance: interpolate(&corners, at.within),
        }
    }

    #[inline(always)]
    fn corners<S: Width>(&self, at: &CellPoints<S>) -> CornersOfCells<S> {
        let s = at.within.x.width();
        let (columns, rows) = (at.column.as_ref(), at.row.as_ref());
        let corners = s.each(|i| (self.tiles).corners(columns[i] as usize, rows[i] as usize));
        let corners = corners.as_ref();
        // Without `std::array::from_fn`, which is not always inlined.
        [
            Color::from_fn(s, |i| corners[i][0]),
            Color::from_fn(s, |i| corners[i][1]),
            Color::from_fn(s, |i| corners[i][2]),
            Color::from_fn(s, |i| corners[i][3]),
        ]
    }

    /// Density per solid angle at `at`, points with the given corners and the directions `d` in the
    /// emitter's frame.
    #[inline(always)]
    fn density<S: Width>(
        &self,
        corners: &CornersOfCells<S>,
        at: &CellPoints<S>,
        d: Vector<S>,
    ) -> Float<S> {
        let [w00, w10, w01, w11] = luminances(corners);
        let (x, y) = (at.within.x, at.within.y);
        let here = (w00 * (1.0 - x) + w10 * x) * (1.0 - y) + (w01 * (1.0 - x) + w11 * x) * y;
        let of_row = |i: usize| self.density_per_luminance[at.row.as_ref()[i] as usize];
        // The lower bound of the sine keeps the density finite at the poles.
        here * Float::from_fn(x.width(), of_row) / sin_polar(d).max(1e-6)
    }
}
