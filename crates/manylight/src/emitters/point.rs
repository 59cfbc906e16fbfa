//! Emitters without extent: isotropic points and spots.

use super::Emitter;
use super::parts::RADIANCE_FLOOR;
use crate::color::Rgb;
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::warp;
use crate::texture::Texture;
use std::f32::consts::PI;

/// Directions along each axis of the grid from which the flux of a spot with a slide is estimated.
const SLIDE_GRID: usize = 32;

/// Flux of a point or spot; black for others.
pub(super) fn point_power(emitter: &Emitter, textures: &[Texture]) -> Rgb {
    match *emitter {
        Emitter::Point { intensity, .. } => intensity * (4.0 * PI),
        Emitter::Spot {
            direction,
            intensity,
            cutoff,
            slide: Some(slide),
            ..
        } => {
            let count = (SLIDE_GRID * SLIDE_GRID) as f32;
            let grid = (0..SLIDE_GRID * SLIDE_GRID)
                .map(|i| Vec2::new((i % SLIDE_GRID) as f32, (i / SLIDE_GRID) as f32))
                .map(|cell| (cell + 0.5) / SLIDE_GRID as f32);
            let sum: Rgb = grid
                .map(|u| cone_direction(direction, cutoff, u))
                .map(|w| emitter.point_intensity(textures, w))
                .sum();
            let brightest = textures[slide.texture.index()].max_luminance(textures);
            let floor = intensity * (brightest * RADIANCE_FLOOR);
            (sum / count).zip(floor, f32::max) / warp::cone_pdf(cutoff.cos())
        }
        // ∫ falloff sinθ dθ, with the falloff linear in the angle beyond the beam.
        Emitter::Spot {
            intensity,
            cutoff,
            beam_width,
            ..
        } => {
            let rim = cutoff - beam_width;
            let mean_cos = if rim > 1e-4 {
                (cutoff.sin() - beam_width.sin()) / rim
            } else {
                cutoff.cos()
            };
            intensity * (2.0 * PI * (1.0 - mean_cos))
        }
        _ => Rgb::BLACK,
    }
}

impl Emitter {
    /// Radiant intensity of a point or spot towards the unit vector `w`, in W/sr; black for others.
    pub fn point_intensity(&self, textures: &[Texture], w: Vec3) -> Rgb {
        match *self {
            Emitter::Point { intensity, .. } => intensity,
            Emitter::Spot {
                direction,
                intensity,
                cutoff,
                beam_width,
                slide,
                ..
            } => {
                let angle = direction.dot(w).clamp(-1.0, 1.0).acos();
                let falloff = intensity * spot_falloff(angle, cutoff, beam_width);
                match slide {
                    Some(slide) if !falloff.is_black() => {
                        let across = Vec2::from(slide.axes.map(|axis| axis.dot(w)));
                        let uv = 0.5 + 0.5 * across / (direction.dot(w) * cutoff.tan());
                        falloff * textures[slide.texture.index()].eval(uv, textures)
                    }
                    _ => falloff,
                }
            }
            _ => Rgb::BLACK,
        }
    }
}

/// A direction within a cone, uniformly distributed.
pub(super) fn cone_direction(axis: Vec3, cutoff: f32, u: Vec2) -> Vec3 {
    let local = warp::cone(u, cutoff.cos());
    Frame::from_normal(axis).to_world(local).normalize()
}

/// As Mitsuba's `spot`: 1 up to the beam, then linear in the angle, 0 from the cutoff on.
fn spot_falloff(angle: f32, cutoff: f32, beam_width: f32) -> f32 {
    if angle <= beam_width {
        1.0
    } else if angle >= cutoff {
        0.0
    } else {
        (cutoff - angle) / (cutoff - beam_width)
    }
}
