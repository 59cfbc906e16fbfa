//! Sun and sky as an environment map.
//!
//! The sky is the model of Hosek and Wilkie 2012, from the crate `hw-skymodel`. The sun is a
//! disc with the solar radiance of Hosek and Wilkie 2013. Units and frame are those of
//! Mitsuba 3's `sunsky`: x south, y west, z up.

mod solar;
mod sun_position;

#[cfg(test)]
mod tests;

pub use sun_position::PlaceAndTime;

use hw_skymodel::rgb::{Channel, SkyParams, SkyState};
use manylight::color::Rgb;
use manylight::image::Image;
use manylight::math::{Mat3, Vec3};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Parameters of sun and sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunSky {
    /// Unit vector to the sun, in the frame x south, y west, z up. There is no light if the sun is
    /// below the horizon.
    pub sun_direction: Vec3,
    /// Turbidity of the atmosphere, clamped to [1, 10].
    pub turbidity: f32,
    /// Reflectance of the ground, clamped to [0, 1]; it brightens the sky.
    pub albedo: Rgb,
    /// Factor of the radiance of the sun.
    pub sun_scale: f32,
    /// Factor of the radiance of the sky.
    pub sky_scale: f32,
    /// Angular diameter of the sun in degrees. The irradiance does not depend on it.
    pub sun_aperture: f32,
    /// The radiance over the disc of the sun.
    pub sun_disc: SunDisc,
}

/// The radiance over the disc of the sun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SunDisc {
    /// The mean everywhere.
    Uniform,
    /// Less at the limb than in the middle: Mitsuba's `complex_sun`.
    Darkened,
}

impl Default for SunSky {
    /// Mitsuba's defaults.
    fn default() -> Self {
        SunSky {
            sun_direction: PlaceAndTime::default().sun_direction(),
            turbidity: 3.0,
            albedo: Rgb::splat(0.3),
            sun_scale: 1.0,
            sky_scale: 1.0,
            sun_aperture: SUN_DIAMETER,
            sun_disc: SunDisc::Uniform,
        }
    }
}

/// Angular diameter of the sun in degrees, as in Mitsuba.
const SUN_DIAMETER: f32 = 0.5358;

/// Rotation from the frame of an environment map (y up) to the frame of the sky (z up). The
/// transform of a baked map is `world_from_sky * sky_from_environment()`.
pub fn sky_from_environment() -> Mat3 {
    Mat3::from_cols(Vec3::X, Vec3::Z, -Vec3::Y)
}

/// Radiance of sun and sky as the image of a [`manylight::emitters::Environment`], in the frame y
/// up (see [`sky_from_environment`]). It has `width` columns (at least 8) with centers at
/// half-integers, and `width / 2 + 1` rows from pole to pole.
///
/// The flux of the sun is distributed to the texels around its disc by the weights of bilinear
/// interpolation, so that the interpolated map has the same flux.
pub fn bake_sunsky(parameters: &SunSky, width: usize) -> Image {
    /// Least width of a map.
    const MIN_COLUMNS: usize = 8;
    let width = width.max(MIN_COLUMNS);
    let mut image = Image::new(width, width / 2 + 1, 3);
    let sun = parameters.sun_direction.normalize_or_zero();
    if sun.z > 0.0 {
        let parameters = SunSky {
            sun_direction: sun,
            turbidity: parameters.turbidity.clamp(1.0, 10.0),
            ..*parameters
        };
        add_sky(&mut image, &parameters);
        add_sun(&mut image, &parameters);
    }
    image
}

/// Direction in the frame of the sky, from the polar angle of a row and the azimuth of a column of
/// the map.
fn direction(theta: f32, phi: f32) -> Vec3 {
    sky_from_environment()
        * Vec3::new(
            phi.sin() * theta.sin(),
            theta.cos(),
            -phi.cos() * theta.sin(),
        )
}

fn add_sky(image: &mut Image, parameters: &SunSky) {
    let Some(sky) = Sky::new(parameters) else {
        return;
    };
    let (width, row_step) = (image.width, PI / (image.height - 1) as f32);
    image
        .data
        .par_chunks_exact_mut(3 * width)
        .enumerate()
        .for_each(|(row, texels)| {
            let theta = row as f32 * row_step;
            // Fraction of the row above the horizon, where the sky ends.
            let above = ((FRAC_PI_2 - theta) / row_step + 0.5).clamp(0.0, 1.0);
            if above == 0.0 {
                return;
            }
            let middle = theta - 0.5 * row_step * (1.0 - above);
            for (column, texel) in texels.chunks_exact_mut(3).enumerate() {
                let phi = (column as f32 + 0.5) / width as f32 * TAU;
                texel.copy_from_slice(&(sky.radiance(direction(middle, phi)) * above).to_array());
            }
        });
}

/// The model of the sky without the sun.
struct Sky {
    state: SkyState,
    /// Unit vector to the sun.
    sun: Vec3,
    scale: f32,
}

impl Sky {
    /// `None` if the sky is black.
    fn new(parameters: &SunSky) -> Option<Sky> {
        let elevation = parameters
            .sun_direction
            .z
            .clamp(0.0, 1.0)
            .asin()
            .min(FRAC_PI_2);
        let albedo = parameters.albedo.map(|v| v.clamp(0.0, 1.0)).to_array();
        let state = SkyState::new(&SkyParams {
            elevation,
            turbidity: parameters.turbidity,
            albedo,
        })
        .ok()?;
        (parameters.sky_scale != 0.0).then_some(Sky {
            state,
            sun: parameters.sun_direction,
            scale: parameters.sky_scale,
        })
    }

    /// Radiance from the direction `d`, in the frame of the sky.
    fn radiance(&self, d: Vec3) -> Rgb {
        let theta = d.z.clamp(0.0, 1.0).acos();
        let gamma = d.dot(self.sun).clamp(-1.0, 1.0).acos();
        let value = |channel| (self.state.radiance(theta, gamma, channel) * UNIT).max(0.0);
        Rgb::new(value(Channel::R), value(Channel::G), value(Channel::B)) * self.scale
    }
}

/// Factor from the unit of the model's data to that of Mitsuba: 1 over the integral of the
/// luminosity function in nm.
const UNIT: f32 = 1.0 / 106.750_26;

/// Adds the sun: splats the flux of a regular set of directions in its disc.
fn add_sun(image: &mut Image, parameters: &SunSky) {
    /// Directions in the disc: rings of equal solid angle times azimuths.
    const RINGS: usize = 48;
    const SPOKES: usize = 96;
    /// Least angular radius of the disc in radians, far below a texel of any map.
    const MIN_HALF_ANGLE: f32 = 1e-3;
    if parameters.sun_scale == 0.0 {
        return;
    }
    let half_angle = (0.5 * parameters.sun_aperture)
        .to_radians()
        .clamp(MIN_HALF_ANGLE, FRAC_PI_2);
    let elevation = parameters.sun_direction.z.min(1.0).asin().to_degrees();
    let radiance = solar::disc_radiance(parameters.turbidity, elevation) * parameters.sun_scale;
    // Scale the radiance so that the flux does not depend on the size of the disc. Computed in
    // single precision, as in Mitsuba, which is accurate to 0.2 %.
    let per_disc = |half_angle: f32| 1.0 - half_angle.cos();
    let radiance = radiance * (per_disc((0.5 * SUN_DIAMETER).to_radians()) / per_disc(half_angle));
    let flux = radiance * cap(half_angle);
    let share = flux * (1.0 / (RINGS * SPOKES) as f32);
    let (x, y) = parameters.sun_direction.any_orthonormal_pair();
    for ring in 0..RINGS {
        // Equal solid angles: uniform in the square of the sine of half the angle.
        let fraction = (ring as f32 + 0.5) / RINGS as f32;
        let sine = fraction.sqrt() * (0.5 * half_angle).sin();
        let share = match parameters.sun_disc {
            SunDisc::Uniform => share,
            // The fraction is the squared sine of the angle on the sun's surface.
            SunDisc::Darkened => share * solar::limb_darkening((1.0 - fraction).sqrt()),
        };
        let angle = 2.0 * sine.asin();
        for spoke in 0..SPOKES {
            let turn = (spoke as f32 + 0.5) / SPOKES as f32 * TAU;
            let d = parameters.sun_direction * angle.cos()
                + (x * turn.cos() + y * turn.sin()) * angle.sin();
            if d.z > 0.0 {
                splat(image, d, share);
            }
        }
    }
}

/// Adds `radiance` to a texel.
fn add(image: &mut Image, column: usize, row: usize, radiance: Rgb) {
    let start = (row * image.width + column) * 3;
    for (value, addend) in image.data[start..start + 3]
        .iter_mut()
        .zip(radiance.to_array())
    {
        *value += addend;
    }
}

/// Solid angle of a cone, in a form that is accurate for small angles.
fn cap(half_angle: f32) -> f32 {
    4.0 * PI * (0.5 * half_angle).sin().powi(2)
}

/// Adds flux (radiance times solid angle) in direction `d` to four texels: the adjoint of bilinear
/// interpolation.
fn splat(image: &mut Image, d: Vec3, flux: Rgb) {
    let d = sky_from_environment().transpose() * d;
    let x = d.x.atan2(-d.z) / TAU * image.width as f32 - 0.5;
    let y = d.y.clamp(-1.0, 1.0).acos() / PI * (image.height - 1) as f32;
    let (s, t) = (x - x.floor(), y - y.floor());
    let column = (x.floor() as i64).rem_euclid(image.width as i64) as usize;
    let row = (y as usize).min(image.height - 1);
    for (columns, across) in [(0, 1.0 - s), (1, s)] {
        for (rows, down) in [(0, 1.0 - t), (1, t)] {
            let row = (row + rows).min(image.height - 1);
            add(
                image,
                (column + columns) % image.width,
                row,
                flux * (across * down / texel_solid_angle(image, row)),
            );
        }
    }
}

/// Integral over the sphere of the bilinear weight of a texel in `row`: the azimuth of a column
/// times ∫ (1 - |θ - θ_row| / h) sin θ dθ, where h is the polar angle between rows.
fn texel_solid_angle(image: &Image, row: usize) -> f32 {
    let last = image.height - 1;
    let h = PI / last as f32;
    let polar = if row == 0 || row == last {
        1.0 - h.sin() / h
    } else {
        (row as f32 * h).sin() * 4.0 * (0.5 * h).sin().powi(2) / h
    };
    polar * TAU / image.width as f32
}
