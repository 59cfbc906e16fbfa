//! Infinite lights: constant ones and environment maps.

use super::super::super::assets::Decode;
use super::super::super::description::{Additions, rotation, set_environment};
use super::super::super::parameters::{Numbers, Parameters};
use super::super::super::pixels::three_channels;
use super::super::super::sink::Problem;
use super::super::builder::Builder;
use super::super::entities::Entity;
use crate::image::Transfer;
use manylight::color::Rgb;
use manylight::emitters::{Emitter, Environment};
use manylight::image::Image;
use manylight::math::{Mat3, Vec2, Vec3};
use manylight::scene::SceneDesc;
use rayon::prelude::*;
use std::cell::Cell;
use std::f32::consts::{PI, TAU};
use std::rc::Rc;

/// PBRT's directions (z up) from those of the emitter (y up), such that the azimuth of a
/// latitude-longitude map of PBRT v3 and that of ours agree. A reflection.
const PBRT_FROM_EMITTER: Mat3 = Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::NEG_X);

impl Builder<'_> {
    pub(super) fn infinite(&mut self, entity: &Entity<'_>) {
        let params = &entity.params;
        // A portal guides sampling and does not change the converged image of what is visible
        // through it.
        params.ignore(&["portal"]);
        let file = params.string(Self::map_parameter(entity));
        let Some(name) = file.filter(|name| !name.value.is_empty()) else {
            self.constant_environment(entity);
            return;
        };
        let tint = if self.is_v3 {
            self.emission(entity, "L")
        } else {
            self.emission_scale(entity)
        };
        let illuminance = params.maybe_float("illuminance");
        let Some(path) = entity.find_file(name, "environment map") else {
            return;
        };
        let world_from_light = rotation(self.world_from(entity).matrix3.into());
        let emitter = self.desc.add(Emitter::Environment(Environment {
            image: Image::default(),
            scale: 1.0,
            world_from_emitter: world_from_light * PBRT_FROM_EMITTER,
        }));
        let is_v3 = self.is_v3;
        let size = Rc::new(Cell::new([0, 0]));
        if !is_v3 {
            self.square_maps.push((name.span, Rc::clone(&size)));
        }
        let store = move |desc: &mut SceneDesc, image: Image| {
            let image = three_channels(&image);
            size.set([image.width, image.height]);
            let map = environment_map(image, is_v3, illuminance, tint);
            set_environment(desc, emitter, map);
        };
        let decode = Decode::Color(Transfer::Auto);
        self.assets.add_image_use(path, decode, name.span, store);
    }

    fn constant_environment(&mut self, entity: &Entity<'_>) {
        let radiance = self.emission(entity, "L");
        // The illuminance of a hemisphere of radiance 1.
        let factor = self.power_factor(entity, "illuminance", PI);
        self.desc.add(Emitter::Constant {
            radiance: radiance * factor,
        });
    }

    /// Warns about environment maps that are not square and thus not equal-area octahedral maps.
    /// For images that have been loaded.
    pub(in super::super) fn check_square_maps(&self) {
        for (span, size) in &self.square_maps {
            let [width, height] = size.get();
            if width != height {
                let message = format!(
                    "the environment map of {width} x {height} pixels is not square; it is read as a latitude-longitude map"
                );
                let problem = Problem::new("scene::suspicious", *span, message);
                self.sink.warn_once("latitude-longitude map", problem);
            }
        }
    }
}

/// The map of an environment, in latitude-longitude form, with its illuminance and tint.
fn environment_map(image: Image, is_v3: bool, illuminance: Option<f32>, tint: Rgb) -> Image {
    let is_equal_area = !is_v3 && image.width == image.height;
    let mut map = if is_equal_area {
        latitude_longitude(&image)
    } else {
        image
    };
    let factor = match illuminance {
        Some(target) if target > 0.0 => target / upward_illuminance(&map),
        _ => 1.0,
    };
    tint_image(&mut map, tint * factor);
    map
}

/// Multiplies all pixels.
fn tint_image(image: &mut Image, tint: Rgb) {
    if tint == Rgb::WHITE {
        return;
    }
    for pixel in image.data.chunks_exact_mut(3) {
        for (value, factor) in pixel.iter_mut().zip(tint.to_array()) {
            *value *= factor;
        }
    }
}

/// An azimuth, as the equal-area octahedral map needs it: mirrored into the first quadrant.
#[derive(Clone, Copy)]
struct Azimuth {
    /// Part of the first quadrant.
    fraction: f32,
    /// Signs of x and y.
    signs: Vec2,
}

impl Azimuth {
    /// Of `u` in [0, 1], in turns from +x to +y.
    fn new(u: f32) -> Self {
        let quadrant = (4.0 * u) as u32 & 3;
        let fraction = (4.0 * u).fract();
        let sign = |is_negative: bool| if is_negative { -1.0 } else { 1.0 };
        Azimuth {
            fraction: if quadrant & 1 == 0 {
                fraction
            } else {
                1.0 - fraction
            },
            signs: Vec2::new(sign(matches!(quadrant, 1 | 2)), sign(quadrant >= 2)),
        }
    }
}

/// A polar angle: its ring on the square, and its cosine's sign.
#[derive(Clone, Copy)]
struct Ring {
    radius: f32,
    is_lower: bool,
    /// Sine of the angle.
    weight: f32,
}

impl Ring {
    /// Of `v` in [0, 1], in half turns from +z.
    fn new(v: f32) -> Self {
        let (sin, cos) = (v * PI).sin_cos();
        Ring {
            radius: (1.0 - cos.abs()).max(0.0).sqrt(),
            is_lower: cos < 0.0,
            weight: sin,
        }
    }

    /// The point of the square of a direction: the inverse of the equal-area octahedral map.
    fn at(self, azimuth: Azimuth) -> Vec2 {
        let across = azimuth.fraction * self.radius;
        let p = if self.is_lower {
            Vec2::new(1.0 - across, 1.0 + across - self.radius)
        } else {
            Vec2::new(self.radius - across, across)
        };
        (p * azimuth.signs + Vec2::ONE) * 0.5
    }
}

/// An equal-area octahedral map as a latitude-longitude map with about equal pixels at the equator.
/// A texel is the mean over its area, so that small bright sources keep their energy.
pub(super) fn latitude_longitude(square: &Image) -> Image {
    /// Samples along each edge of a texel.
    const SAMPLES: usize = 4;
    let n = square.width;
    let (width, height) = (2 * n, n.max(2));
    let offset = |i: usize| (i as f32 + 0.5) / SAMPLES as f32;
    let azimuths: Vec<Azimuth> = (0..width * SAMPLES)
        .map(|i| Azimuth::new(offset(i) / width as f32))
        .collect();
    let row = |y: usize| {
        // The first and the last row lie at the poles.
        let rings: [Ring; SAMPLES] = std::array::from_fn(|i| {
            let v = (y as f32 + offset(i) - 0.5) / (height - 1) as f32;
            Ring::new(v.clamp(0.0, 1.0))
        });
        let total = SAMPLES as f32 * rings.iter().map(|ring| ring.weight).sum::<f32>();
        let index = move |t: f32| ((t * n as f32) as usize).min(n - 1);
        let texel = move |azimuths: &[Azimuth]| {
            let mut sum = Rgb::BLACK;
            for ring in rings {
                for azimuth in azimuths {
                    let at = ring.at(*azimuth);
                    sum += square.rgb(index(at.x), index(at.y)) * ring.weight;
                }
            }
            (sum / total.max(f32::MIN_POSITIVE)).to_array()
        };
        azimuths.chunks_exact(SAMPLES).flat_map(texel)
    };
    Image {
        width,
        height,
        channels: 3,
        data: (0..height).into_par_iter().flat_map_iter(row).collect(),
    }
}

/// Illuminance on an upward-facing patch under a latitude-longitude map.
fn upward_illuminance(map: &Image) -> f32 {
    let (width, height) = (map.width, map.height);
    let mut sum = 0.0_f64;
    for y in 0..height {
        let theta = (y as f32) / (height - 1).max(1) as f32 * PI;
        if theta >= 0.5 * PI {
            break;
        }
        let row: f64 = (0..width)
            .map(|x| f64::from(map.rgb(x, y).luminance()))
            .sum();
        sum += row * f64::from(theta.sin() * theta.cos());
    }
    (sum * f64::from(TAU / width as f32 * PI / (height - 1).max(1) as f32)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The direction (z up) of a point of the square under the equal-area octahedral map. Source:
    /// Clarberg 2008.
    fn direction_from_square(uv: Vec2) -> Vec3 {
        let p = uv * 2.0 - Vec2::ONE;
        let (u, v) = (p.x.abs(), p.y.abs());
        let distance = 1.0 - (u + v);
        let r = 1.0 - distance.abs();
        let phi = if r == 0.0 { 1.0 } else { (v - u) / r + 1.0 } * std::f32::consts::FRAC_PI_4;
        let ring = r * (2.0 - r * r).max(0.0).sqrt();
        let z = (1.0 - r * r).copysign(distance);
        Vec3::new(
            phi.cos().copysign(p.x) * ring,
            phi.sin().copysign(p.y) * ring,
            z,
        )
    }

    #[test]
    fn the_square_and_the_sphere_correspond() {
        for i in 0..400 {
            let uv = Vec2::new((i % 20) as f32 + 0.4, (i / 20) as f32 + 0.6) / 20.0;
            let w = direction_from_square(uv);
            assert!((w.length() - 1.0).abs() < 1e-5);
            let turns = (w.y.atan2(w.x) / TAU).rem_euclid(1.0);
            let back = Ring::new(w.z.acos() / PI).at(Azimuth::new(turns));
            assert!(back.abs_diff_eq(uv, 1e-4), "{uv} {w} {back}");
        }
        assert!(direction_from_square(Vec2::splat(0.5)).abs_diff_eq(Vec3::Z, 1e-6));
    }

    #[test]
    fn conversion_keeps_directions_and_energy() {
        // A map that is the direction plus 1.
        let n = 64;
        let pixel = |i: usize| {
            let uv = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            (direction_from_square(uv) + Vec3::ONE).to_array()
        };
        let square = Image {
            width: n,
            height: n,
            channels: 3,
            data: (0..n * n).flat_map(pixel).collect(),
        };
        let map = latitude_longitude(&square);
        /// The direction (z up) of a point of a latitude-longitude map.
        fn direction_from_map(u: f32, v: f32) -> Vec3 {
            let (sin_phi, cos_phi) = (u * TAU).sin_cos();
            let (sin_theta, cos_theta) = (v * PI).sin_cos();
            Vec3::new(cos_phi * sin_theta, sin_phi * sin_theta, cos_theta)
        }
        for (x, y) in [(5, 9), (100, 40), (70, 20)] {
            let v = y as f32 / (map.height - 1) as f32;
            let w = direction_from_map((x as f32 + 0.5) / map.width as f32, v) + Vec3::ONE;
            let found = Vec3::from_array(map.rgb(x, y).to_array());
            assert!(found.abs_diff_eq(w, 0.05), "{found} {w}");
        }
        // Illuminance of the constant part: π. Of z with luminance weight of blue: 2π/3.
        let expected = PI + Rgb::LUMINANCE[2] * TAU / 3.0;
        assert!((upward_illuminance(&map) / expected - 1.0).abs() < 0.01);
    }

    #[test]
    fn azimuths_of_the_emitter_are_those_of_pbrt() {
        // u = atan2(x, -z) / 2π in the emitter's frame is φ / 2π in PBRT's.
        let w = Vec3::new(0.3, 0.5, -0.2);
        let p = PBRT_FROM_EMITTER * w;
        assert!((p.y.atan2(p.x) - w.x.atan2(-w.z)).abs() < 1e-6);
        assert_eq!(p.z, w.y);
    }
}
