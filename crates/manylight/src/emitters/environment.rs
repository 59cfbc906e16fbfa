//! Light from far away, given by an image.

use super::warp_within::sample_linear;
use crate::color::Rgb;
use crate::image::Image;
use crate::math::{Mat3, Vec2, Vec3, float::safe_sqrt};
use crate::sampling::table_2d::Table2d;
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

impl Environment {
    /// Radiance from the world direction `wi`, pointing away from the scene.
    pub(super) fn radiance(&self, wi: Vec3) -> Rgb {
        let d = self.world_from_emitter.transpose() * wi;
        self.radiance_at(self.locate(d))
    }

    fn radiance_at(&self, at: Place) -> Rgb {
        interpolate(&self.corner_colors(at.cell), at.within) * self.scale
    }

    #[inline]
    fn corner_colors(&self, cell: Cell) -> [Rgb; 4] {
        cell.corners(&self.image).map(|(x, y)| self.image.rgb(x, y))
    }

    /// Cells between texel centers: as many as columns around, one less than rows down.
    fn cells(&self) -> (usize, usize) {
        (self.image.width, (self.image.height - 1).max(1))
    }

    fn locate(&self, d: Vec3) -> Place {
        let (width, height) = self.cells();
        let x = d.x.atan2(-d.z) / TAU * width as f32 - 0.5;
        let y = d.y.clamp(-1.0, 1.0).acos() / PI * height as f32;
        let column = (x.floor() as i64).rem_euclid(width as i64) as usize;
        let row = (y as usize).min(height - 1);
        Place {
            cell: Cell { column, row },
            within: Vec2::new(x - x.floor(), y - row as f32),
        }
    }

    fn direction(&self, at: Place) -> Vec3 {
        let (width, height) = self.cells();
        let phi = (at.cell.column as f32 + at.within.x + 0.5) / width as f32 * TAU;
        let theta = (at.cell.row as f32 + at.within.y) / height as f32 * PI;
        let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (phi.sin_cos(), theta.sin_cos());
        Vec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta)
    }
}

/// Between the values at (0,0), (1,0), (0,1), (1,1).
#[inline]
fn interpolate(corners: &[Rgb; 4], at: Vec2) -> Rgb {
    let [c00, c10, c01, c11] = *corners;
    c00.lerp(c10, at.x).lerp(c01.lerp(c11, at.x), at.y)
}

#[inline]
fn luminances(corners: &[Rgb; 4]) -> [f32; 4] {
    corners.map(|c| c.luminance().max(0.0))
}

/// The rectangle between four texel centers.
#[derive(Clone, Copy, Debug)]
struct Cell {
    column: usize,
    row: usize,
}

impl Cell {
    /// The texels at (0,0), (1,0), (0,1), (1,1).
    fn corners(self, image: &Image) -> [(usize, usize); 4] {
        let right = (self.column + 1) % image.width;
        let below = (self.row + 1).min(image.height - 1);
        [
            (self.column, self.row),
            (right, self.row),
            (self.column, below),
            (right, below),
        ]
    }
}

/// A cell and where in it, in [0, 1]².
#[derive(Clone, Copy, Debug)]
struct Place {
    cell: Cell,
    within: Vec2,
}

/// Draws directions in proportion to the interpolated luminance.
#[derive(Clone, Debug)]
pub(super) struct EnvironmentSampler {
    /// Over cells: mean luminance times solid angle.
    table: Table2d,
    /// Per row of cells: density over the unit square per luminance.
    density_per_luminance: Vec<f32>,
    /// Radiance over all directions.
    total: Rgb,
}

/// A direction to the surroundings, and what is known of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct EnvironmentSample {
    /// Unit, in the world.
    pub(super) wi: Vec3,
    /// Per solid angle.
    pub(super) pdf: f32,
    /// From there.
    pub(super) radiance: Rgb,
}

impl EnvironmentSampler {
    /// `None` if the picture is black.
    pub(super) fn new(environment: &Environment) -> Option<Self> {
        let (width, height) = environment.cells();
        let mut weights = Vec::with_capacity(width * height);
        let mut solid_angles = Vec::with_capacity(height);
        let mut total = Rgb::BLACK;
        for row in 0..height {
            let polar = |row: usize| (row as f32 / height as f32 * PI).cos();
            let solid_angle = TAU / width as f32 * (polar(row) - polar(row + 1));
            let mut row_total = Rgb::BLACK;
            for column in 0..width {
                let cell = Cell { column, row };
                let corners = environment.corner_colors(cell);
                let sum: f32 = luminances(&corners).iter().sum();
                weights.push(sum * solid_angle);
                row_total += interpolate(&corners, Vec2::splat(0.5)) * environment.scale;
            }
            total += row_total * solid_angle;
            solid_angles.push(solid_angle);
        }
        let table = Table2d::new(&weights, width, height)?;
        let all: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        // Within a cell the density follows the luminance, whose mean is a quarter of the sum over corners.
        let scale = 4.0 * (width * height) as f64 / all;
        let density_per_luminance = solid_angles
            .iter()
            .map(|&s| (f64::from(s) * scale) as f32)
            .collect();
        Some(EnvironmentSampler {
            table,
            density_per_luminance,
            total,
        })
    }

    /// Radiance over all directions: ∫ L dω.
    pub(super) fn total(&self) -> Rgb {
        self.total
    }

    /// Draws a direction towards the surroundings.
    pub(super) fn sample(&self, environment: &Environment, u: Vec2) -> EnvironmentSample {
        let (width, height) = environment.cells();
        let (p, _) = self.table.sample(u);
        let scaled = p * Vec2::new(width as f32, height as f32);
        let cell = Cell {
            column: (scaled.x as usize).min(width - 1),
            row: (scaled.y as usize).min(height - 1),
        };
        let v =
            (scaled - Vec2::new(cell.column as f32, cell.row as f32)).clamp(Vec2::ZERO, Vec2::ONE);
        let corners = environment.corner_colors(cell);
        let [w00, w10, w01, w11] = luminances(&corners);
        let y = sample_linear(v.y, w00 + w10, w01 + w11);
        let x = sample_linear(v.x, w00 + (w01 - w00) * y, w10 + (w11 - w10) * y);
        let at = Place {
            cell,
            within: Vec2::new(x, y),
        };
        let d = environment.direction(at);
        EnvironmentSample {
            wi: (environment.world_from_emitter * d).normalize(),
            pdf: self.density(&corners, at, d),
            radiance: interpolate(&corners, at.within) * environment.scale,
        }
    }

    /// Density of [`EnvironmentSampler::sample`] per solid angle.
    pub(super) fn pdf(&self, environment: &Environment, wi: Vec3) -> f32 {
        let d = environment.world_from_emitter.transpose() * wi;
        let at = environment.locate(d);
        self.density(&environment.corner_colors(at.cell), at, d)
    }

    #[inline]
    fn density(&self, corners: &[Rgb; 4], at: Place, d: Vec3) -> f32 {
        let [w00, w10, w01, w11] = luminances(corners);
        let (x, y) = (at.within.x, at.within.y);
        let here = (w00 * (1.0 - x) + w10 * x) * (1.0 - y) + (w01 * (1.0 - x) + w11 * x) * y;
        // dω = 2π² sinθ du dv. The floor keeps the density finite at the poles.
        let sin = safe_sqrt(d.x * d.x + d.z * d.z).max(1e-6);
        here * self.density_per_luminance[at.cell.row] / (2.0 * PI * PI * sin)
    }
}
