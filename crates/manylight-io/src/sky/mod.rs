//! Sun and sky as an environment map: the sky of Hosek and Wilkie 2012 from the `hw-skymodel` crate, which carries its data
//! set, and the sun as a uniform disc with the solar radiance of Hosek and Wilkie 2013. Units and frame are those of
//! Mitsuba 3's `sunsky`: z points up, x south, y west.

mod solar;

#[cfg(test)]
mod tests;

use hw_skymodel::rgb::{Channel, SkyParams, SkyState};
use manylight::color::Rgb;
use manylight::image::Image;
use manylight::math::{Mat3, Vec3};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Sun and sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunSky {
    /// Unit vector to the sun; z up. With the sun below the horizon there is no light.
    pub sun_direction: Vec3,
    /// Haze: 1 (none) to 10, and limited to that.
    pub turbidity: f32,
    /// Reflectance of the ground, which lights the sky, in [0, 1] and limited to that.
    pub albedo: Rgb,
    /// Times the sun's radiance.
    pub sun_scale: f32,
    /// Times the sky's radiance.
    pub sky_scale: f32,
    /// Diameter of the sun's disc in degrees. A larger disc is dimmer and sends the same light.
    pub sun_aperture: f32,
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
        }
    }
}

/// The sun seen from the earth, in degrees.
const SUN_DIAMETER: f32 = 0.5358;

/// Where and when the sky is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceAndTime {
    /// Degrees north.
    pub latitude: f32,
    /// Degrees east.
    pub longitude: f32,
    /// Hours that local time is ahead of universal time.
    pub timezone: f32,
    /// Year.
    pub year: i32,
    /// Month from 1.
    pub month: i32,
    /// Day from 1.
    pub day: i32,
    /// Local hour.
    pub hour: f32,
    /// Minute.
    pub minute: f32,
    /// Second.
    pub second: f32,
}

impl Default for PlaceAndTime {
    /// Mitsuba's default: Tokyo, 10 July 2010, 15:00.
    fn default() -> Self {
        let (latitude, longitude, timezone) = (35.6894, 139.6917, 9.0);
        PlaceAndTime {
            latitude,
            longitude,
            timezone,
            year: 2010,
            month: 7,
            day: 10,
            hour: 15.0,
            minute: 0.0,
            second: 0.0,
        }
    }
}

impl PlaceAndTime {
    /// Unit vector to the sun: x south, y west, z up. The algorithm PSA of Blanco-Muriel et al. 2001.
    pub fn sun_direction(&self) -> Vec3 {
        let hours = f64::from(self.hour - self.timezone)
            + (f64::from(self.minute) + f64::from(self.second) / 60.0) / 60.0;
        let days = self.days_since_2000(hours);

        // Ecliptic coordinates.
        let omega = 2.1429 - 0.001_039_459_4 * days;
        let mean_longitude = 4.895_063_0 + 0.017_202_791_698 * days;
        let anomaly = 6.240_060_0 + 0.017_201_969_9 * days;
        let longitude =
            mean_longitude + 0.033_416_07 * anomaly.sin() + 0.000_348_94 * (2.0 * anomaly).sin()
                - 0.000_113_4
                - 0.000_020_3 * omega.sin();
        let obliquity = 0.409_092_8 - 6.2140e-9 * days + 0.000_039_6 * omega.cos();

        // Celestial coordinates.
        let right_ascension = (obliquity.cos() * longitude.sin()).atan2(longitude.cos());
        let declination = (obliquity.sin() * longitude.sin()).asin();

        // Local coordinates.
        let sidereal_hours = 6.697_424_324_2 + 0.065_709_828_3 * days + hours;
        let hour_angle =
            (sidereal_hours * 15.0 + f64::from(self.longitude)).to_radians() - right_ascension;
        let latitude = f64::from(self.latitude).to_radians();
        let zenith = (latitude.cos() * hour_angle.cos() * declination.cos()
            + declination.sin() * latitude.sin())
        .clamp(-1.0, 1.0)
        .acos();
        let azimuth = (-hour_angle.sin())
            .atan2(declination.tan() * latitude.cos() - latitude.sin() * hour_angle.cos());
        const EARTH_RADIUS_PER_SUN_DISTANCE: f64 = 6371.01 / 149_597_890.0;
        let zenith = zenith + EARTH_RADIUS_PER_SUN_DISTANCE * zenith.sin();
        Vec3::new(
            (-azimuth.cos() * zenith.sin()) as f32,
            (-azimuth.sin() * zenith.sin()) as f32,
            zenith.cos() as f32,
        )
    }

    /// Days since noon of 1 January 2000, universal time, of which `hours` have passed on this day.
    fn days_since_2000(&self, hours: f64) -> f64 {
        // Fliegel and van Flandern 1968; the divisions are meant to truncate.
        let january = (self.month - 14) / 12;
        let julian_day = (1461 * (self.year + 4800 + january)) / 4
            + (367 * (self.month - 2 - 12 * january)) / 12
            - (3 * ((self.year + 4900 + january) / 100)) / 4
            + self.day
            - 32075;
        f64::from(julian_day) - 0.5 + hours / 24.0 - 2_451_545.0
    }
}

/// From the frame of an environment map (y up) to the frame of the sky (z up). A baked map is placed by
/// `world_from_sky * sky_from_environment()`.
pub fn sky_from_environment() -> Mat3 {
    Mat3::from_cols(Vec3::X, Vec3::Z, -Vec3::Y)
}

/// The radiance of sun and sky as the image of a [`manylight::emitters::Environment`]: `width` columns with centers at
/// half-integers, `width / 2 + 1` rows from pole to pole. Its frame has y up; see [`sky_from_environment`].
///
/// The sun's flux is spread over the texels that it touches, such that bilinear lookup sends exactly that flux.
/// At least 8 columns are made.
pub fn bake_sunsky(parameters: &SunSky, width: usize) -> Image {
    const FEWEST_COLUMNS: usize = 8;
    let width = width.max(FEWEST_COLUMNS);
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

/// Polar angle of a row and azimuth of a column to a direction in the frame of the sky.
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
            // The sky ends at the horizon: texels that reach below it hold the share that is above.
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

/// The sky without the sun.
struct Sky {
    state: SkyState,
    sun: Vec3,
    scale: f32,
}

impl Sky {
    /// `None` if it is black.
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

    fn radiance(&self, d: Vec3) -> Rgb {
        let theta = d.z.clamp(0.0, 1.0).acos();
        let gamma = d.dot(self.sun).clamp(-1.0, 1.0).acos();
        let value = |channel| (self.state.radiance(theta, gamma, channel) * UNIT).max(0.0);
        Rgb::new(value(Channel::R), value(Channel::G), value(Channel::B)) * self.scale
    }
}

/// From the data set's unit to Mitsuba's: one over the integral of the luminosity function in nm.
const UNIT: f32 = 1.0 / 106.750_26;

/// Splats a regular set of directions on the disc.
fn add_sun(image: &mut Image, parameters: &SunSky) {
    const RINGS: usize = 48;
    const SPOKES: usize = 96;
    /// Smaller discs differ in nothing that a map can hold.
    const SMALLEST_HALF_ANGLE: f32 = 1e-3;
    if parameters.sun_scale == 0.0 {
        return;
    }
    let half_angle = (0.5 * parameters.sun_aperture)
        .to_radians()
        .clamp(SMALLEST_HALF_ANGLE, FRAC_PI_2);
    let elevation = parameters.sun_direction.z.min(1.0).asin().to_degrees();
    let radiance = solar::disc_radiance(parameters.turbidity, elevation) * parameters.sun_scale;
    // A disc of another size sends the same flux. In single precision, as Mitsuba has it, this holds to 0.2 %.
    let per_disc = |half_angle: f32| 1.0 - half_angle.cos();
    let radiance = radiance * (per_disc((0.5 * SUN_DIAMETER).to_radians()) / per_disc(half_angle));
    let flux = radiance * cap(half_angle);
    let share = flux * (1.0 / (RINGS * SPOKES) as f32);
    let (x, y) = parameters.sun_direction.any_orthonormal_pair();
    for ring in 0..RINGS {
        // Rings of equal solid angle.
        let sine = ((ring as f32 + 0.5) / RINGS as f32).sqrt() * (0.5 * half_angle).sin();
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

/// Adds to a texel.
fn add(image: &mut Image, column: usize, row: usize, radiance: Rgb) {
    let start = (row * image.width + column) * 3;
    for (value, addend) in image.data[start..start + 3]
        .iter_mut()
        .zip(radiance.to_array())
    {
        *value += addend;
    }
}

/// Solid angle of a cone; stable for small angles.
fn cap(half_angle: f32) -> f32 {
    4.0 * PI * (0.5 * half_angle).sin().powi(2)
}

/// Adds flux (radiance times solid angle) from direction `d`: the adjoint of bilinear lookup.
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

/// The integral of a texel's bilinear weight over the sphere: ∫ (1 - |θ - θ_row| / h) sin θ dθ times a column's azimuth.
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
