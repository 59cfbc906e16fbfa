//! Checks of materials: valid ids, no cycles, finite numbers.

use super::SceneDesc;
use super::check::check_color;
use super::error::{Checked, check_index, ensure, with_context};
use super::nesting::Nesting;
use crate::bsdf::Material;
use crate::ids::{MaterialId, TextureId};
use crate::texture::{ColorInput, FloatInput};

pub(super) fn check_materials(desc: &SceneDesc) -> Checked {
    for (i, material) in desc.materials.iter().enumerate() {
        check_material(desc, material).map_err(|e| with_context(&format!("material {i}"), &e))?;
    }
    let mut states = vec![VisitState::New; desc.materials.len()];
    (0..desc.materials.len()).try_for_each(|i| check_cycles(desc, &mut states, i))
}

fn check_material(desc: &SceneDesc, material: &Material) -> Checked {
    for inner in inner_materials(material) {
        check_index("material", inner.index(), desc.materials.len())?;
    }
    for input in color_inputs(material) {
        check_color(desc, *input)?;
    }
    for input in float_inputs(material) {
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
            check_number("the roughness", roughness.map_or(0.0, |(_, alpha)| alpha))
        }
        Material::Principled(ref p) => check_eta(p.eta),
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
                let inner = inner_materials(&desc.materials[id]);
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
        for inner in inner_materials(&desc.materials[id]).map(MaterialId::index) {
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

/// The materials in a wrapper.
fn inner_materials(material: &Material) -> impl Iterator<Item = MaterialId> {
    let ids = match *material {
        Material::Blend { first, second, .. } => [Some(first), Some(second)],
        Material::TwoSided { front, back } => [Some(front), Some(back)],
        Material::Mask { inner, .. }
        | Material::BumpMap { inner, .. }
        | Material::NormalMap { inner, .. } => [Some(inner), None],
        _ => [None, None],
    };
    ids.into_iter().flatten()
}

/// The colors of a material.
fn color_inputs(material: &Material) -> Vec<&ColorInput> {
    match material {
        Material::Diffuse { reflectance } | Material::RoughDiffuse { reflectance, .. } => {
            vec![reflectance]
        }
        Material::DiffuseTransmitter { transmittance } => vec![transmittance],
        Material::Conductor {
            eta,
            k,
            specular_reflectance,
            ..
        } => vec![eta, k, specular_reflectance],
        Material::Dielectric {
            specular_reflectance,
            specular_transmittance,
            ..
        }
        | Material::ThinDielectric {
            specular_reflectance,
            specular_transmittance,
            ..
        } => vec![specular_reflectance, specular_transmittance],
        Material::Plastic {
            diffuse_reflectance,
            specular_reflectance,
            ..
        }
        | Material::Phong {
            diffuse_reflectance,
            specular_reflectance,
            ..
        }
        | Material::Ward {
            diffuse_reflectance,
            specular_reflectance,
            ..
        } => vec![diffuse_reflectance, specular_reflectance],
        Material::Principled(p) => vec![&p.base_color],
        Material::PrincipledThin(p) => vec![&p.base_color],
        Material::Blend { .. }
        | Material::Mask { .. }
        | Material::Null
        | Material::TwoSided { .. }
        | Material::BumpMap { .. }
        | Material::NormalMap { .. } => Vec::new(),
    }
}

/// The numbers of a material that may be textured.
fn float_inputs(material: &Material) -> Vec<&FloatInput> {
    match material {
        Material::RoughDiffuse { alpha, .. } => vec![alpha],
        Material::Conductor { roughness, .. } | Material::Dielectric { roughness, .. } => roughness
            .iter()
            .flat_map(|r| [&r.alpha_u, &r.alpha_v])
            .collect(),
        Material::Phong { exponent, .. } => vec![exponent],
        Material::Ward {
            alpha_u, alpha_v, ..
        } => vec![alpha_u, alpha_v],
        Material::Principled(p) => vec![
            &p.roughness,
            &p.anisotropic,
            &p.metallic,
            &p.spec_trans,
            &p.spec_tint,
            &p.sheen,
            &p.sheen_tint,
            &p.flatness,
            &p.clearcoat,
            &p.clearcoat_gloss,
        ],
        Material::PrincipledThin(p) => vec![
            &p.roughness,
            &p.anisotropic,
            &p.spec_trans,
            &p.eta,
            &p.spec_tint,
            &p.sheen,
            &p.sheen_tint,
            &p.flatness,
            &p.diff_trans,
        ],
        Material::Blend { weight, .. } => vec![weight],
        Material::Mask { opacity, .. } => vec![opacity],
        Material::Diffuse { .. }
        | Material::DiffuseTransmitter { .. }
        | Material::ThinDielectric { .. }
        | Material::Plastic { .. }
        | Material::Null
        | Material::TwoSided { .. }
        | Material::BumpMap { .. }
        | Material::NormalMap { .. } => Vec::new(),
    }
}
