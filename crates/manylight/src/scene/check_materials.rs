//! Checks of materials: valid ids, no cycles, finite numbers.

use super::SceneDesc;
use super::error::{Checked, check_index, ensure, with_context};
use super::nesting::Nesting;
use crate::bsdf::Material;
use crate::color::Rgb;
use crate::ids::{MaterialId, TextureId};
use crate::texture::{ColorInput, FloatInput};

pub(super) fn check_materials(desc: &SceneDesc) -> Checked {
    for (i, material) in desc.materials.iter().enumerate() {
        check_material(desc, material).map_err(|e| with_context(&format!("material {i}"), &e))?;
    }
    for medium in &desc.media {
        check_index("material", medium.material.index(), desc.materials.len())?;
        let Rgb { r, g, b } = medium.absorption;
        let is_valid = |v: f32| v.is_finite() && v >= 0.0;
        ensure([r, g, b].into_iter().all(is_valid), || {
            format!("the absorption {r}, {g}, {b} of a medium is negative or not finite")
        })?;
    }
    let mut states = vec![VisitState::New; desc.materials.len()];
    (0..desc.materials.len()).try_for_each(|i| check_cycles(desc, &mut states, i))
}

fn check_material(desc: &SceneDesc, material: &Material) -> Checked {
    for inner in material.inner() {
        check_index("material", inner.index(), desc.materials.len())?;
    }
    for input in material.colors() {
        check_color(desc, *input)?;
    }
    for input in material.floats() {
        match *input {
            FloatInput::Texture(id) => check_texture(desc, id)?,
            FloatInput::Constant(x) => check_number("a parameter", x)?,
        }
    }
    match *material {
        Material::BumpMap { texture, scale, .. } | Material::NormalMap { texture, scale, .. } => {
            check_texture(desc, texture)?;
            check_number("the scale", scale)
        }
        Material::Dielectric { eta, .. } | Material::ThinDielectric { eta, .. } => check_eta(eta),
        Material::Plastic { eta, roughness, .. } => {
            check_eta(eta)?;
            check_number("the roughness", roughness.map_or(0.0, |r| r.alpha))
        }
        Material::Principled(ref p) => {
            let film = p.layers.and_then(|layers| layers.film);
            check_eta(film.map_or(1.0, |film| film.eta))?;
            check_eta(p.eta)
        }
        Material::DiffuseTransmitter { below, .. } => check_eta(below.map_or(1.0, |b| b.eta)),
        _ => Ok(()),
    }
}

fn check_number(what: &str, x: f32) -> Checked {
    ensure(x.is_finite(), || format!("{what}, {x}, is not finite"))
}

fn check_eta(eta: f32) -> Checked {
    ensure(eta.is_finite() && eta > 0.0, || {
        format!("the index of refraction {eta} is not positive and finite")
    })
}

/// Whether a color is finite, or the id of its texture valid.
pub(super) fn check_color(desc: &SceneDesc, input: ColorInput) -> Checked {
    match input {
        ColorInput::Texture(id) => check_texture(desc, id),
        ColorInput::Constant(Rgb { r, g, b }) => {
            ensure(r.is_finite() && g.is_finite() && b.is_finite(), || {
                format!("the color {r}, {g}, {b} is not finite")
            })
        }
    }
}

/// Whether the id of a texture is valid.
pub(super) fn check_texture(desc: &SceneDesc, id: TextureId) -> Checked {
    check_index("texture", id.index(), desc.textures.len())
}

/// State of a material in the depth-first search for cycles.
#[derive(Clone, Copy, PartialEq)]
enum VisitState {
    New,
    /// On the current path: an inner material in this state closes a cycle.
    OnPath,
    Done(Nesting),
}

/// Depth-first search from `start`, with an explicit stack: the chain of wrappers may be long.
fn check_cycles(desc: &SceneDesc, states: &mut [VisitState], start: usize) -> Checked {
    let mut stack = vec![start];
    while let Some(&id) = stack.last() {
        if states[id] != VisitState::New {
            if states[id] == VisitState::OnPath {
                let inner = desc.materials[id].inner();
                let nestings = inner.filter_map(|inner| match states[inner.index()] {
                    VisitState::Done(nesting) => Some(nesting),
                    VisitState::New | VisitState::OnPath => None,
                });
                let nesting = Nesting::of(&format!("material {id}"), nestings)?;
                states[id] = VisitState::Done(nesting);
            }
            stack.pop();
            continue;
        }
        states[id] = VisitState::OnPath;
        for inner in desc.materials[id].inner().map(MaterialId::index) {
            ensure(states[inner] != VisitState::OnPath, || {
                format!("material {inner} wraps itself")
            })?;
            if states[inner] == VisitState::New {
                stack.push(inner);
            }
        }
    }
    Ok(())
}
