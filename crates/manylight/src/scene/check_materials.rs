//! Checks of materials: valid ids, no cycles.

use super::SceneDesc;
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
    for texture in textures(material) {
        check_texture(desc, texture)?;
    }
    Ok(())
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

/// The textures of a material.
fn textures(material: &Material) -> Vec<TextureId> {
    let colors = color_inputs(material)
        .into_iter()
        .filter_map(|input| match input {
            ColorInput::Texture(id) => Some(*id),
            ColorInput::Constant(_) => None,
        });
    let floats = float_inputs(material)
        .into_iter()
        .filter_map(|input| match input {
            FloatInput::Texture(id) => Some(*id),
            FloatInput::Constant(_) => None,
        });
    let map = match material {
        Material::BumpMap { texture, .. } | Material::NormalMap { texture, .. } => Some(*texture),
        _ => None,
    };
    colors.chain(floats).chain(map).collect()
}

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
