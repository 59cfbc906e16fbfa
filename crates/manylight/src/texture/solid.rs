//! Textures by position: patterns in space, and texture coordinates by projection.

use super::ColorInput;
use super::noise::{amplitude, fractal, noise, turbulence};
use crate::color::Rgb;
use crate::math::{Affine3A, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// A pattern as a function of the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// From world space to the space of the pattern.
    pub pattern_from_world: Affine3A,
    /// The pattern.
    pub pattern: Pattern,
}

/// Patterns of pbrt-v4, without its fading of details that are smaller than a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// A sum of octaves of noise.
    Fractal {
        /// Number of octaves.
        octaves: u32,
        /// Factor of the amplitude from one octave to the next.
        roughness: f32,
    },
    /// A sum of octaves of the absolute value of noise.
    Wrinkled {
        /// Number of octaves.
        octaves: u32,
        /// Factor of the amplitude from one octave to the next.
        roughness: f32,
    },
    /// The height of waves in changing wind.
    Windy,
    /// Colors of marble along y, shifted by noise.
    Marble {
        /// Number of octaves.
        octaves: u32,
        /// Factor of the amplitude from one octave to the next.
        roughness: f32,
        /// Factor of the shift.
        variation: f32,
    },
    /// Cubes of edge 1 in two colors.
    Cells {
        /// Color of the cubes of which the sum of the lower coordinates is even.
        color0: ColorInput,
        /// Color of the others.
        color1: ColorInput,
    },
}

/// Colors of marble, as control points of cubic Bézier curves from each of the first six to the
/// third after it. Source: pbrt-v4.
const MARBLE: [[f32; 3]; 9] = [
    [0.58, 0.58, 0.6],
    [0.58, 0.58, 0.6],
    [0.58, 0.58, 0.6],
    [0.5, 0.5, 0.5],
    [0.6, 0.59, 0.58],
    [0.58, 0.58, 0.6],
    [0.58, 0.58, 0.6],
    [0.2, 0.2, 0.33],
    [0.58, 0.58, 0.6],
];
/// Factor of the colors.
const MARBLE_SCALE: f32 = 1.5;
/// Upper bound of the colors' channels.
const MARBLE_MAX: f32 = MARBLE_SCALE * 0.6;

/// Half of the distance over which patterns are differentiated, in their space: below the period of
/// 11 octaves, above the rounding of coordinates up to 1000.
const GRADIENT_STEP: f32 = 5e-4;

impl Solid {
    /// Color at a point; that of cells is unspecified.
    pub(super) fn color(&self, p: Vec3) -> Rgb {
        let p = self.pattern_from_world.transform_point3(p);
        match self.pattern {
            Pattern::Marble { .. } => self.pattern.marble(p),
            _ => Rgb::splat(self.pattern.value(p).max(0.0)),
        }
    }

    /// Value at a point, which may be negative; 0 for cells.
    pub(super) fn value(&self, p: Vec3) -> f32 {
        self.pattern
            .value(self.pattern_from_world.transform_point3(p))
    }

    /// Whether a point lies in a cube of the first color of cells.
    pub(super) fn is_even_cell(&self, p: Vec3) -> bool {
        is_even_cell(self.pattern_from_world.transform_point3(p))
    }

    /// Derivatives of the value by u and v, of which those of the position are given; 0 for cells.
    pub(super) fn gradient(&self, p: Vec3, [dp_du, dp_dv]: [Vec3; 2]) -> Vec2 {
        if matches!(self.pattern, Pattern::Cells { .. }) {
            return Vec2::ZERO;
        }
        let p = self.pattern_from_world.transform_point3(p);
        let slope = |d: Vec3| {
            let d = self.pattern_from_world.transform_vector3(d);
            let Some(step) = d.try_normalize().map(|d| d * GRADIENT_STEP) else {
                return 0.0;
            };
            let difference = self.pattern.value(p + step) - self.pattern.value(p - step);
            difference / (2.0 * GRADIENT_STEP) * d.length()
        };
        Vec2::new(slope(dp_du), slope(dp_dv))
    }

    /// Upper bound of the channels of the color.
    pub(super) fn max_channel(&self, of_input: impl Fn(&ColorInput) -> f32) -> f32 {
        match &self.pattern {
            Pattern::Fractal { octaves, roughness } | Pattern::Wrinkled { octaves, roughness } => {
                amplitude(*roughness, *octaves)
            }
            Pattern::Windy => {
                amplitude(WIND_ROUGHNESS, WIND_OCTAVES) * amplitude(WIND_ROUGHNESS, WAVE_OCTAVES)
            }
            Pattern::Marble { .. } => MARBLE_MAX,
            Pattern::Cells { color0, color1 } => of_input(color0).max(of_input(color1)),
        }
    }

    /// The nested colors.
    pub(super) fn inputs(&self) -> [Option<ColorInput>; 2] {
        match self.pattern {
            Pattern::Cells { color0, color1 } => [Some(color0), Some(color1)],
            _ => [None; 2],
        }
    }
}

/// Octaves of the wind's strength.
const WIND_OCTAVES: u32 = 3;
/// Octaves of the waves.
const WAVE_OCTAVES: u32 = 6;
/// Roughness of both.
const WIND_ROUGHNESS: f32 = 0.5;
/// Scale of the wind relative to the waves.
const WIND_SCALE: f32 = 0.1;

impl Pattern {
    /// Value at a point of the pattern's space; 0 for cells.
    fn value(&self, p: Vec3) -> f32 {
        match *self {
            Pattern::Fractal { octaves, roughness } => fractal(p, roughness, octaves),
            Pattern::Wrinkled { octaves, roughness } => turbulence(p, roughness, octaves),
            Pattern::Windy => {
                let wind = fractal(p * WIND_SCALE, WIND_ROUGHNESS, WIND_OCTAVES);
                wind.abs() * fractal(p, WIND_ROUGHNESS, WAVE_OCTAVES)
            }
            Pattern::Marble { .. } => self.marble(p).luminance(),
            Pattern::Cells { .. } => 0.0,
        }
    }

    /// Color of marble; black for other patterns.
    fn marble(&self, p: Vec3) -> Rgb {
        let Pattern::Marble {
            octaves,
            roughness,
            variation,
        } = *self
        else {
            return Rgb::BLACK;
        };
        let along = p.y + variation * fractal(p, roughness, octaves);
        let t = (0.5 + 0.5 * along.sin()) * (MARBLE.len() - 3) as f32;
        let first = (t as usize).min(MARBLE.len() - 4);
        let t = t - first as f32;
        let s = 1.0 - t;
        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        let control = MARBLE[first..first + 4]
            .iter()
            .map(|c| Rgb::new(c[0], c[1], c[2]));
        control
            .zip(weights)
            .fold(Rgb::BLACK, |sum, (color, weight)| sum + color * weight)
            * MARBLE_SCALE
    }
}

fn is_even_cell(p: Vec3) -> bool {
    let sum: f32 = p.floor().element_sum();
    sum.rem_euclid(2.0) == 0.0
}

/// Discs of radius 0.35 in about half of the unit squares of texture space, where noise decides.
/// Source: pbrt-v4.
pub(super) fn is_in_dot(uv: Vec2) -> bool {
    const RADIUS: f32 = 0.35;
    const MAX_SHIFT: f32 = 0.5 - RADIUS;
    let cell = (uv + 0.5).floor();
    let noise = |x: f32, y: f32| noise(Vec3::new(cell.x + x, cell.y + y, 0.5));
    if noise(0.5, 0.5) <= 0.0 {
        return false;
    }
    let center = cell + MAX_SHIFT * Vec2::new(noise(1.5, 2.8), noise(4.5, 9.8));
    center.distance_squared(uv) < RADIUS * RADIUS
}

/// Texture coordinates as functions of the position in the space of a projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// From world space to the space of the projection.
    pub from_world: Affine3A,
    /// The kind of projection.
    pub kind: ProjectionKind,
}

/// Kinds of projections, with the coordinates of pbrt-v4. φ = atan2(y, x) in [0, 2π).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProjectionKind {
    /// u = θ/π from +z, v = φ/2π.
    Spherical,
    /// u = (π + atan2(y, x)) / 2π, v = z.
    Cylindrical,
    /// The products with two vectors, plus an offset.
    Planar {
        /// Vectors of u and v.
        axes: [Vec3; 2],
        /// (u, v) at the origin.
        offset: Vec2,
    },
}

impl Projection {
    /// Texture coordinates of a point in world space.
    pub(super) fn uv(&self, p: Vec3) -> Vec2 {
        let p = self.from_world.transform_point3(p);
        match self.kind {
            ProjectionKind::Spherical => {
                let theta = p.truncate().length().atan2(p.z);
                Vec2::new(theta / PI, p.y.atan2(p.x).rem_euclid(TAU) / TAU)
            }
            ProjectionKind::Cylindrical => Vec2::new((PI + p.y.atan2(p.x)) / TAU, p.z),
            ProjectionKind::Planar { axes, offset } => offset + Vec2::from(axes.map(|a| a.dot(p))),
        }
    }

    /// Derivatives of the position by u and v of the surface to those of the projected coordinates:
    /// columns are d(u', v')/du and d(u', v')/dv. By differences, except on planes.
    pub(super) fn derivatives(&self, p: Vec3, dp: [Vec3; 2]) -> [Vec2; 2] {
        dp.map(|d| match self.kind {
            ProjectionKind::Planar { axes, .. } => {
                let d = self.from_world.transform_vector3(d);
                Vec2::from(axes.map(|a| a.dot(d)))
            }
            _ => {
                let local = self.from_world.transform_vector3(d);
                let scale = self.from_world.transform_point3(p).length();
                let h = GRADIENT_STEP * scale / local.length();
                if !h.is_finite() {
                    return Vec2::ZERO;
                }
                let difference = self.uv(p + d * h) - self.uv(p - d * h);
                // Across the seam of an angle, the other way around is shorter.
                (difference - difference.round()) / (2.0 * h)
            }
        })
    }
}
