//! Radiant intensity of points and spots.

use super::description::{DeformedCone, Emitter, ProjectorTexture, SpotFalloff};
use crate::color::Rgb;
use crate::math::{Frame, Vec2, Vec3};
use crate::sampling::warp;
use crate::texture::Texture;
use std::f32::consts::{PI, TAU};

impl Emitter {
    /// Radiant intensity of a point or spot towards the unit vector `w`, in W/sr; black for other
    /// emitters.
    pub fn point_intensity(&self, textures: &[Texture], w: Vec3) -> Rgb {
        match *self {
            Emitter::Point { intensity, .. } => intensity,
            Emitter::Goniometric {
                intensity,
                emitter_from_world,
                distribution,
                ..
            } => {
                let d = emitter_from_world * w;
                let azimuth = d.y.atan2(d.x).rem_euclid(TAU) / TAU;
                let uv = Vec2::new(azimuth, d.z.clamp(-1.0, 1.0).acos() / PI);
                intensity * textures[distribution.index()].eval(uv, textures)
            }
            Emitter::Spot {
                direction,
                intensity,
                cutoff,
                beam_width,
                falloff,
                projector,
                ..
            } => {
                let angle = direction.dot(w).clamp(-1.0, 1.0).acos();
                let falloff = intensity
                    * match falloff {
                        SpotFalloff::Deformed(cone) if angle < cutoff => cone.falloff(w),
                        SpotFalloff::Deformed(_) => 0.0,
                        _ => spot_falloff(falloff, angle, cutoff, beam_width),
                    };
                match projector {
                    Some(projector) if !falloff.is_black() => {
                        let across = Vec2::from(projector.axes.map(|axis| axis.dot(w)));
                        let half = projector.window.unwrap_or(Vec2::splat(cutoff.tan()));
                        let uv = 0.5 + 0.5 * across / (direction.dot(w) * half);
                        if projector.window.is_some() && !is_in_unit_square(uv) {
                            return Rgb::BLACK;
                        }
                        falloff * textures[projector.texture.index()].eval(uv, textures)
                    }
                    _ => falloff,
                }
            }
            _ => Rgb::BLACK,
        }
    }
}

fn is_in_unit_square(uv: Vec2) -> bool {
    uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all()
}

/// A direction of a spot, and its density per solid angle: uniform in the cone, or on the window of
/// a projector.
pub(super) fn spot_direction(
    axis: Vec3,
    cutoff: f32,
    projector: Option<&ProjectorTexture>,
    u: Vec2,
) -> (Vec3, f32) {
    let Some((projector, half)) = projector.and_then(|p| Some((p, p.window?))) else {
        return (
            cone_direction(axis, cutoff, u),
            warp::cone_pdf(cutoff.cos()),
        );
    };
    let on_plane = (2.0 * u - 1.0) * half;
    let [a, b] = projector.axes;
    let to_plane = axis + a * on_plane.x + b * on_plane.y;
    let distance = to_plane.length();
    (
        to_plane / distance,
        distance.powi(3) / (4.0 * half.x * half.y),
    )
}

/// A uniformly distributed direction in the cone of half-angle `cutoff` around `axis`.
fn cone_direction(axis: Vec3, cutoff: f32, u: Vec2) -> Vec3 {
    let local = warp::cone(u, cutoff.cos());
    Frame::from_normal(axis).to_world(local).normalize()
}

impl DeformedCone {
    /// Falloff towards a direction of the world.
    fn falloff(&self, w: Vec3) -> f32 {
        let local = (self.cone_from_world * w).normalize_or_zero();
        let angle = local.z.clamp(-1.0, 1.0).acos();
        spot_falloff(
            SpotFalloff::LinearAngle,
            angle,
            self.cutoff,
            self.beam_width,
        )
    }
}

/// Falloff of a spot: 1 up to the beam width, or by the angle alone; 0 beyond the cutoff. Angles in
/// radians.
fn spot_falloff(falloff: SpotFalloff, angle: f32, cutoff: f32, beam_width: f32) -> f32 {
    if falloff == SpotFalloff::FlatIrradiance && angle < cutoff {
        angle.cos().powi(-3)
    } else if angle <= beam_width {
        1.0
    } else if angle >= cutoff {
        0.0
    } else {
        match falloff {
            SpotFalloff::LinearAngle => (cutoff - angle) / (cutoff - beam_width),
            SpotFalloff::SmoothCosine | SpotFalloff::QuarticCosine => {
                let t = (angle.cos() - cutoff.cos()) / (beam_width.cos() - cutoff.cos());
                let t = t.clamp(0.0, 1.0);
                match falloff {
                    SpotFalloff::QuarticCosine => t.powi(4),
                    _ => t * t * (3.0 - 2.0 * t),
                }
            }
            SpotFalloff::FlatIrradiance | SpotFalloff::Deformed(_) => 0.0,
        }
    }
}
