//! The materials of a scene.

use super::material::{ConstantRoughness, Material};
use super::models::coat::Coat;
use super::models::coat_family::{self, CoatParameters};
use crate::ids::MaterialId;
use crate::texture::FloatInput;
use std::collections::HashMap;

/// All materials of a scene, with tables of rough coats.
#[derive(Debug)]
pub struct Materials {
    materials: Vec<Material>,
    /// Without duplicates.
    pub(super) coats: Vec<Coat>,
    /// By material: index into `coats`.
    pub(super) coat_of: Vec<Option<usize>>,
}

impl Materials {
    /// Precomputes the tables. Material ids must be valid and free of cycles; `Scene::build` checks
    /// this.
    pub fn new(materials: Vec<Material>) -> Self {
        let mut coats: Vec<CoatParameters> = Vec::new();
        let mut indices = HashMap::new();
        let coat_of = materials
            .iter()
            .map(|material| {
                let &Material::Plastic {
                    eta,
                    roughness:
                        Some(ConstantRoughness {
                            distribution,
                            alpha,
                        }),
                    ..
                } = material
                else {
                    return None;
                };
                let key = (distribution, alpha.to_bits(), eta.to_bits());
                Some(*indices.entry(key).or_insert_with(|| {
                    coats.push(CoatParameters {
                        distribution,
                        alpha,
                        eta,
                    });
                    coats.len() - 1
                }))
            })
            .collect();
        let coats = coat_family::tabulate(&coats);
        Materials {
            materials,
            coats,
            coat_of,
        }
    }

    /// The descriptions, indexed by [`MaterialId`](crate::ids::MaterialId).
    pub fn descriptions(&self) -> &[Material] {
        &self.materials
    }

    /// Whether light can pass straight through some point of this material.
    pub fn is_transparent(&self, id: MaterialId) -> bool {
        match &self.materials[id.index()] {
            Material::Null
            | Material::ThinDielectric {
                roughness: None, ..
            } => true,
            Material::Mask { opacity, .. } if !matches!(opacity, FloatInput::Constant(o) if *o >= 1.0) => {
                true
            }
            material => material.inner().any(|inner| self.is_transparent(inner)),
        }
    }

    /// Whether the material is an interface that refracts, or a sum of such, as of glass with
    /// dispersion.
    pub(crate) fn refracts(&self, id: MaterialId) -> bool {
        match &self.materials[id.index()] {
            Material::Dielectric { .. } => true,
            Material::Sum { first, second } => self.refracts(*first) && self.refracts(*second),
            _ => false,
        }
    }

    /// The opacity of a material that transmits light straight through by this opacity only; `None`
    /// for other materials.
    #[inline]
    pub fn cut_out(&self, id: MaterialId) -> Option<&FloatInput> {
        match &self.materials[id.index()] {
            Material::Mask { opacity, inner } => (!self.is_transparent(*inner)).then_some(opacity),
            Material::TwoSided { front, back } if front == back => self.cut_out(*front),
            Material::BumpMap { inner, .. } | Material::NormalMap { inner, .. } => {
                self.cut_out(*inner)
            }
            _ => None,
        }
    }

    /// Whether a bump or normal map tilts the shading frame somewhere.
    pub(crate) fn has_tilts(&self, id: MaterialId) -> bool {
        match &self.materials[id.index()] {
            Material::BumpMap { .. } | Material::NormalMap { .. } => true,
            material => material.inner().any(|inner| self.has_tilts(inner)),
        }
    }
}
