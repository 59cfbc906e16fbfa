//! Checks of emitters: valid textures, finite numbers.

use super::SceneDesc;
use super::check_materials::{check_color, check_texture};
use super::error::{Checked, ensure};
use crate::color::Rgb;
use crate::emitters::{Emitter, Environment, ProjectorTexture};
use crate::math::{Mat3, Vec3};

pub(super) fn check_emitter(desc: &SceneDesc, emitter: &Emitter) -> Checked {
    match emitter {
        Emitter::Area { radiance } | Emitter::InvisibleArea { radiance } => {
            check_color(desc, *radiance)
        }
        Emitter::Point {
            position,
            intensity,
        } => place(*position).and_then(|()| amount("intensity", *intensity)),
        Emitter::Goniometric {
            position,
            intensity,
            emitter_from_world,
            distribution,
        } => {
            place(*position)?;
            amount("intensity", *intensity)?;
            rotation(emitter_from_world)?;
            check_texture(desc, *distribution)
        }
        Emitter::Spot {
            position,
            direction,
            intensity,
            cutoff,
            beam_width,
            projector,
            ..
        } => {
            place(*position)?;
            axis(*direction)?;
            amount("intensity", *intensity)?;
            ensure(cutoff.is_finite() && beam_width.is_finite(), || {
                format!("the angles {beam_width} and {cutoff} are not finite")
            })?;
            projector
                .as_ref()
                .map_or(Ok(()), |projector| check_projector(desc, projector))
        }
        Emitter::Directional {
            direction,
            irradiance,
        } => axis(*direction).and_then(|()| amount("irradiance", *irradiance)),
        Emitter::Constant { radiance } => amount("radiance", *radiance),
        Emitter::Environment(environment) => check_environment(environment),
    }
}

fn check_projector(desc: &SceneDesc, projector: &ProjectorTexture) -> Checked {
    projector.axes.into_iter().try_for_each(axis)?;
    check_texture(desc, projector.texture)
}

fn check_environment(environment: &Environment) -> Checked {
    let scale = environment.scale;
    ensure(scale.is_finite(), || {
        format!("the scale {scale} is not finite")
    })?;
    rotation(&environment.world_from_emitter)
}

fn place(p: Vec3) -> Checked {
    ensure(p.is_finite(), || format!("the position {p} is not finite"))
}

fn axis(d: Vec3) -> Checked {
    ensure(d.is_finite() && d != Vec3::ZERO, || {
        format!("the direction {d} is not finite or has no length")
    })
}

fn rotation(m: &Mat3) -> Checked {
    ensure(m.is_finite(), || "the rotation is not finite".to_owned())
}

fn amount(what: &str, amount: Rgb) -> Checked {
    ensure(amount.is_finite(), || {
        let Rgb { r, g, b } = amount;
        format!("the {what} {r}, {g}, {b} is not finite")
    })
}
