//! From material descriptions to scattering functions at points.

use super::diffuse::Diffuse;
use super::flatten::flatten;
use super::leaf::{Leaf, Sides};
use super::material::{Distribution, Material};
use super::model::Model;
use super::plastic::Coat;
use super::{ALIGNED, Bsdf, ExitTransmittance, Lobes, MAX_LEAVES};
use crate::geometry::SurfacePoint;
use crate::ids::MaterialId;
use crate::math::Vec2;
use crate::texture::{ColorInput, FloatInput, Texture};
use rayon::prelude::*;

/// What makes one rough coat differ from another.
type CoatKey = (Distribution, u32, u32);

/// Everything precomputed about the materials of a scene: tables of coat transmittance and the like.
#[derive(Debug)]
pub struct Materials {
    materials: Vec<Material>,
    pub(super) coats: Vec<Coat>,
    /// Per material, its index into `coats`.
    pub(super) coat_of: Vec<Option<usize>>,
}

impl Materials {
    /// Precomputes the tables. Ids inside must be valid and free of cycles (checked by `Scene::build`).
    pub fn new(materials: Vec<Material>) -> Self {
        let mut keys: Vec<CoatKey> = Vec::new();
        let coat_of = materials
            .iter()
            .map(|material| {
                let &Material::Plastic {
                    eta,
                    roughness: Some((distribution, alpha)),
                    ..
                } = material
                else {
                    return None;
                };
                let key = (distribution, alpha.to_bits(), eta.to_bits());
                Some(keys.iter().position(|k| *k == key).unwrap_or_else(|| {
                    keys.push(key);
                    keys.len() - 1
                }))
            })
            .collect();
        let coat = |(distribution, alpha, eta)| {
            Coat::new(distribution, f32::from_bits(alpha), f32::from_bits(eta))
        };
        let coats = keys.into_par_iter().map(coat).collect();
        Materials {
            materials,
            coats,
            coat_of,
        }
    }

    /// The descriptions; index by [`MaterialId`](crate::ids::MaterialId).
    pub fn descriptions(&self) -> &[Material] {
        &self.materials
    }

    /// Whether light can pass straight through this material anywhere.
    pub fn is_transparent(&self, id: MaterialId) -> bool {
        match &self.materials[id.index()] {
            Material::Null | Material::ThinDielectric { .. } => true,
            Material::Mask { opacity, inner } => {
                !matches!(opacity, FloatInput::Constant(o) if *o >= 1.0)
                    || self.is_transparent(*inner)
            }
            Material::Blend { first, second, .. } => {
                self.is_transparent(*first) || self.is_transparent(*second)
            }
            Material::TwoSided { front, back } => {
                self.is_transparent(*front) || self.is_transparent(*back)
            }
            Material::BumpMap { inner, .. } | Material::NormalMap { inner, .. } => {
                self.is_transparent(*inner)
            }
            _ => false,
        }
    }

    /// The opacity of a material that lets light straight through where that is below 1, and has no other way to.
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

    /// The scattering function at a point.
    ///
    /// A tree of wrappers becomes a weighted list of at most four models. Where there would be more, the weakest are left out and
    /// the others take over their weight, side by side.
    pub fn bsdf<'s>(
        &'s self,
        id: MaterialId,
        x: &SurfacePoint,
        textures: &'s [Texture],
    ) -> Bsdf<'s> {
        let mut bsdf = Bsdf {
            ng: x.ng,
            frame: x.frame,
            leaves: [None; MAX_LEAVES],
            open: [0.0; 2],
            is_open: false,
            transmits: false,
            lobes: Lobes::NONE,
            exit: ExitTransmittance::Lambert,
            glossy_width: 1.0,
            defensive: x.frame.n.dot(x.ng).abs() < ALIGNED,
        };
        if let Some((reflectance, outer)) = self.plain_lambert(id) {
            let reflectance = reflectance.eval(x.uv, textures);
            bsdf.leaves[0] = Some(Leaf {
                model: Model::Diffuse(Diffuse { reflectance }),
                weight: 1.0,
                outer,
                tilt: None,
                inner: Sides::Own,
                demoted: false,
            });
            bsdf.lobes = Lobes::DIFFUSE;
        } else {
            flatten(self, id, x, textures, &mut bsdf);
        }
        bsdf
    }

    /// Asks for the memory of the textures that lend a material its color at `uv`.
    #[inline]
    pub fn prefetch(&self, id: MaterialId, uv: Vec2, textures: &[Texture]) {
        match &self.materials[id.index()] {
            Material::Diffuse { reflectance } | Material::RoughDiffuse { reflectance, .. } => {
                reflectance.prefetch(uv, textures)
            }
            Material::Plastic {
                diffuse_reflectance,
                ..
            } => diffuse_reflectance.prefetch(uv, textures),
            Material::Conductor {
                specular_reflectance,
                ..
            } => specular_reflectance.prefetch(uv, textures),
            Material::Principled(p) => p.base_color.prefetch(uv, textures),
            Material::TwoSided { front: inner, .. }
            | Material::Mask { inner, .. }
            | Material::NormalMap { inner, .. } => self.prefetch(*inner, uv, textures),
            Material::BumpMap { texture, inner, .. } => {
                textures[texture.index()].prefetch(uv);
                self.prefetch(*inner, uv, textures);
            }
            _ => (),
        }
    }

    /// The most frequent materials, whose scattering functions are known without more ado: Lambertian, on one side or both.
    #[inline]
    fn plain_lambert(&self, id: MaterialId) -> Option<(&ColorInput, Sides)> {
        match &self.materials[id.index()] {
            Material::Diffuse { reflectance } => Some((reflectance, Sides::Own)),
            Material::TwoSided { front, back } if front == back => {
                match &self.materials[front.index()] {
                    Material::Diffuse { reflectance } => Some((reflectance, Sides::Both)),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}
