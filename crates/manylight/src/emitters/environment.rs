//! Light from far away, given by an image.

use super::environment_tiles::{Corners, Place, Tiles};
use super::warp_within::sample_linear;
use crate::color::Rgb;
use crate::image::Image;
use crate::math::float::{floor, safe_sqrt};
use crate::math::trig::{atan2_turns, sin_cos_turns};
use crate::math::{Mat3, Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// An image in latitude-longitude form. As in Mitsuba's `envmap`: with `d` the direction in the emitter's own frame (y up),
/// `u = atan2(d.x, -d.z) / 2π`, `v = acos(d.y) / π`. Lookup is bilinear. Columns have their centers at half-integers of
/// `u · width` and wrap; rows reach from pole to pole: row 0 lies at v = 0 (the pole +y), the last row at v = 1.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Linear RGB radiance.
    pub image: Image,
    /// Times this.
    pub scale: f32,
    /// Rotation (or reflection) from the emitter's frame to the world.
    pub world_from_emitter: Mat3,
}

/// Between the values at (0,0), (1,0), (0,1), (1,1).
#[inline]
fn interpolate(corners: &Corners, at: Vec2) -> Rgb {
    let [c00, c10, c01, c11] = *corners;
    c00.lerp(c10, at.x).lerp(c01.lerp(c11, at.x), at.y)
}

#[inline]
fn luminances(corners: &Corners) -> [f32; 4] {
    corners.map(|c| c.luminance().max(0.0))
}

/// Sine of the angle to the y axis.
#[inline]
fn sin_polar(d: Vec3) -> f32 {
    safe_sqrt(d.x * d.x + d.z * d.z)
}

/// The picture, prepared: radiance by direction, and directions in proportion to the interpolated luminance.
#[derive(Clone, Debug)]
pub(super) struct EnvironmentSampler {
    world_from_emitter: Mat3,
    /// Cells are chosen by mean luminance times solid angle.
    tiles: Tiles,
    /// Per row of cells: density over the unit square per luminance, over 2π².
    density_per_luminance: Vec<f32>,
    /// Radiance over all directions.
    total: Rgb,
}

/// What is known of a direction to the surroundings.
#[derive(Clone, Copy, Debug)]
pub(super) struct EnvironmentSample {
    /// Unit, in the world.
    pub(super) wi: Vec3,
    /// Per solid angle, of [`EnvironmentSampler::sample`].
    pub(super) pdf: f32,
    /// From there.
    pub(super) radiance: Rgb,
}

impl EnvironmentSampler {
    /// `None` if the picture is black.
    pub(super) fn new(environment: &Environment) -> Option<Self> {
        let (width, height) = (environment.image.width, environment.image.height);
        let rows = height.max(2) - 1;
        let polar = |row: usize| (row as f32 / rows as f32 * PI).cos();
        let solid_angles: Vec<f32> = (0..rows)
            .map(|row| TAU / width as f32 * (polar(row) - polar(row + 1)))
            .collect();
        let luminance = |corners: &Corners| luminances(corners).iter().sum::<f32>();
        let tiles = Tiles::new(environment, |row, corners| {
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
        // Within a cell the density follows the luminance, whose mean is a quarter of the sum over corners; dω = 2π² sinθ du dv.
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

    /// Radiance over all directions: ∫ L dω.
    pub(super) fn total(&self) -> Rgb {
        self.total
    }

    /// Draws a direction towards the surroundings.
    #[inline]
    pub(super) fn sample(&self, u: Vec2) -> EnvironmentSample {
        let (row, u) = self.tiles.choose_row(u);
        let (tile, u) = self.tiles.choose_tile(row, u);
        self.sample_within(self.tiles.choose_cell(tile, u))
    }

    /// The steps of [`EnvironmentSampler::sample`].
    pub(super) fn tiles(&self) -> &Tiles {
        &self.tiles
    }

    /// A direction towards the cell of a uniform point in it, in proportion to the luminance there.
    #[inline]
    pub(super) fn sample_within(&self, p: Place) -> EnvironmentSample {
        let corners = self.tiles.corners(p.column, p.row);
        let [w00, w10, w01, w11] = luminances(&corners);
        let y = sample_linear(p.within.y, w00 + w10, w01 + w11);
        let x = sample_linear(p.within.x, w00 + (w01 - w00) * y, w10 + (w11 - w10) * y);
        let at = Place {
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

    /// The cell that the unit vector `d` of the emitter's frame points to.
    #[inline]
    fn locate(&self, d: Vec3) -> Place {
        let (width, height) = (self.tiles.width as f32, self.tiles.height as f32);
        let x = atan2_turns(d.x, -d.z) * width - 0.5;
        // More exact at the poles than an arc cosine.
        let y = 2.0 * atan2_turns(sin_polar(d), d.y) * height;
        let (left, row) = (floor(x).0, (y as usize).min(self.tiles.height - 1));
        // Half a turn either way: only the left half is below 0.
        let column = if left < 0.0 { left + width } else { left };
        Place {
            column: (column as usize).min(self.tiles.width - 1),
            row,
            within: Vec2::new(x - left, y - row as f32),
        }
    }

    #[inline]
    fn direction(&self, at: Place) -> Vec3 {
        let (width, height) = (self.tiles.width as f32, self.tiles.height as f32);
        let (sin_phi, cos_phi) = sin_cos_turns((at.column as f32 + at.within.x + 0.5) / width);
        let (sin_theta, cos_theta) = sin_cos_turns(0.5 * (at.row as f32 + at.within.y) / height);
        Vec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta)
    }

    /// What a ray along the unit vector `wi`, pointing away from the scene, finds.
    #[inline]
    pub(super) fn look_up(&self, wi: Vec3) -> EnvironmentSample {
        let d = self.world_from_emitter.transpose() * wi;
        let at = self.locate(d);
        let corners = self.tiles.corners(at.column, at.row);
        EnvironmentSample {
            wi,
            pdf: self.density(&corners, at, d),
            radiance: interpolate(&corners, at.within),
        }
    }

    #[inline]
    fn density(&self, corners: &Corners, at: Place, d: Vec3) -> f32 {
        let [w00, w10, w01, w11] = luminances(corners);
        let (x, y) = (at.within.x, at.within.y);
        let here = (w00 * (1.0 - x) + w10 * x) * (1.0 - y) + (w01 * (1.0 - x) + w11 * x) * y;
        // The floor keeps the density finite at the poles.
        here * self.density_per_luminance[at.row] / sin_polar(d).max(1e-6)
    }
}
