//! The tree of a material and its wrappers as the weighted list of models that a scattering function is.

use super::conductor::{Mirror, RoughConductor};
use super::dielectric::{Glass, RoughGlass};
use super::diffuse::Diffuse;
use super::fresnel::Metal;
use super::leaf::{Leaf, Sides, Tilt};
use super::material::{Material, PrincipledMaterial, Roughness};
use super::materials::Materials;
use super::microfacet::Microfacets;
use super::model::Model;
use super::phong::Phong;
use super::plastic::{ColorShift, Plastic, RoughPlastic};
use super::principled::{Principled, PrincipledParameters};
use super::rough_diffuse::RoughDiffuse;
use super::thin_dielectric::Pane;
use super::ward::Ward;
use super::{ALIGNED, Bsdf, ExitTransmittance, Lobes, MAX_LEAVES};
use crate::color::Rgb;
use crate::geometry::SurfacePoint;
use crate::ids::{MaterialId, TextureId};
use crate::math::{Vec2, Vec3};
use crate::texture::{ColorInput, FloatInput, Texture};

/// Fills `bsdf`, which has no leaves yet, with the models of the material `id` at `x`.
pub(super) fn flatten<'s>(
    materials: &'s Materials,
    id: MaterialId,
    x: &SurfacePoint,
    textures: &'s [Texture],
    bsdf: &mut Bsdf<'s>,
) {
    let mut flat = Flattening {
        materials,
        x,
        textures,
        count: 0,
        bsdf,
    };
    flat.add(id, Wrapping::NONE);
    flat.finish();
}

/// What surrounds a material on the way down its tree.
#[derive(Clone, Copy)]
struct Wrapping {
    weight: f32,
    outer: Sides,
    tilt: Option<Tilt>,
    inner: Sides,
}

struct Flattening<'a, 's> {
    materials: &'s Materials,
    x: &'a SurfacePoint,
    textures: &'s [Texture],
    count: usize,
    bsdf: &'a mut Bsdf<'s>,
}

impl<'s> Flattening<'_, 's> {
    fn add(&mut self, id: MaterialId, at: Wrapping) {
        if at.weight <= 0.0 {
            return;
        }
        match &self.materials.descriptions()[id.index()] {
            Material::Blend {
                weight,
                first,
                second,
            } => {
                let w = self.float(weight).clamp(0.0, 1.0);
                self.add(
                    *first,
                    Wrapping {
                        weight: at.weight * (1.0 - w),
                        ..at
                    },
                );
                self.add(
                    *second,
                    Wrapping {
                        weight: at.weight * w,
                        ..at
                    },
                );
            }
            Material::Mask { opacity, inner } => {
                let opacity = self.float(opacity).clamp(0.0, 1.0);
                self.add_open(at, at.weight * (1.0 - opacity));
                self.add(
                    *inner,
                    Wrapping {
                        weight: at.weight * opacity,
                        ..at
                    },
                );
            }
            Material::Null => self.add_open(at, at.weight),
            Material::TwoSided { front, back } if front == back => {
                self.add(*front, at.on(Sides::Both))
            }
            Material::TwoSided { front, back } => {
                self.add(*front, at.on(Sides::Front));
                self.add(*back, at.on(Sides::Back));
            }
            Material::BumpMap {
                texture,
                scale,
                inner,
            } => {
                let normal = self.bumped_normal(*texture, *scale);
                // Mitsuba 3.9.1 takes the world's components of dp_du for those in the shading frame. Only anisotropy shows it.
                self.add(*inner, at.tilted(normal, self.x.dp_du));
            }
            Material::NormalMap { texture, inner } => {
                let color = self.textures[texture.index()].eval(self.x.uv, self.textures);
                let normal = Vec3::from_array(color.to_array()) * 2.0 - Vec3::ONE;
                self.add(*inner, at.tilted(normal, Vec3::X));
            }
            model => self.add_model(id, model, at),
        }
    }

    fn add_open(&mut self, at: Wrapping, weight: f32) {
        let [front, back] = &mut self.bsdf.open;
        match (at.outer, at.inner) {
            (Sides::Front, _) | (_, Sides::Front) => *front += weight,
            (Sides::Back, _) | (_, Sides::Back) => *back += weight,
            _ => {
                *front += weight;
                *back += weight;
            }
        }
    }

    fn add_model(&mut self, id: MaterialId, material: &Material, at: Wrapping) {
        let Wrapping {
            weight,
            outer,
            tilt,
            inner,
        } = at;
        let leaf = Leaf {
            model: self.model(id, material),
            weight,
            outer,
            tilt,
            inner,
            demoted: false,
        };
        if self.count < MAX_LEAVES {
            self.bsdf.leaves[self.count] = Some(leaf);
            self.count += 1;
            return;
        }
        // Full: the weakest leaf of the same sides makes room, and its weight stays with the stronger one.
        let rivals = self
            .bsdf
            .leaves
            .iter_mut()
            .flatten()
            .filter(|l| l.outer == outer && l.inner == inner);
        if let Some(rival) = rivals.min_by(|a, b| a.weight.total_cmp(&b.weight)) {
            let sum = rival.weight + weight;
            if rival.weight < weight {
                *rival = leaf;
            }
            rival.weight = sum;
        }
    }

    /// Sums up the leaves.
    fn finish(self) {
        let bsdf = self.bsdf;
        bsdf.is_open = bsdf.open != [0.0; 2];
        bsdf.exit = match &bsdf.leaves {
            // What `demote` finds for most materials.
            [Some(leaf), None, ..] if leaf.tilt.is_none() => leaf.model.exit(),
            _ => demote(&mut bsdf.leaves),
        };
        for leaf in bsdf.leaves.iter().map_while(Option::as_ref) {
            bsdf.lobes = bsdf.lobes.or(leaf.lobes());
            bsdf.glossy_width = bsdf.glossy_width.min(leaf.model.glossy_width());
            bsdf.is_open |= matches!(leaf.model, Model::Pane(_));
            bsdf.transmits |= leaf.model.transmits();
            if let Some(tilt) = &leaf.tilt {
                let cos = bsdf.frame.to_world(tilt.normal()).dot(bsdf.ng).abs();
                bsdf.defensive |= cos < ALIGNED;
            }
        }
    }

    /// The normal of the height field over the surface, in the shading frame.
    fn bumped_normal(&self, texture: TextureId, scale: f32) -> Vec3 {
        let x = self.x;
        let gradient = self.textures[texture.index()].gradient(x.uv) * scale;
        let n = x.frame.n;
        let du = x.dp_du + n * (gradient.x - n.dot(x.dp_du));
        let dv = x.dp_dv + n * (gradient.y - n.dot(x.dp_dv));
        let normal = du.cross(dv);
        let outward = if x.ng.dot(normal) < 0.0 {
            -normal
        } else {
            normal
        };
        x.frame.to_local(outward)
    }

    fn color(&self, input: &ColorInput) -> Rgb {
        input.eval(self.x.uv, self.textures)
    }

    fn float(&self, input: &FloatInput) -> f32 {
        input.eval(self.x.uv, self.textures)
    }

    fn facets(&self, r: &Roughness) -> Microfacets {
        Microfacets::new(
            r.distribution,
            self.float(&r.alpha_u),
            self.float(&r.alpha_v),
        )
    }

    /// A material that wraps no other.
    fn model(&self, id: MaterialId, material: &Material) -> Model<'s> {
        match material {
            Material::Diffuse { reflectance } => Model::Diffuse(Diffuse {
                reflectance: self.color(reflectance),
            }),
            Material::RoughDiffuse {
                reflectance,
                alpha,
                full,
            } => {
                let (reflectance, alpha) = (self.color(reflectance), self.float(alpha));
                if alpha == 0.0 {
                    return Model::Diffuse(Diffuse { reflectance });
                }
                Model::RoughDiffuse(RoughDiffuse::new(reflectance, alpha, *full))
            }
            Material::Conductor { .. } => self.conductor(material),
            Material::Dielectric { .. } => self.dielectric(material),
            Material::ThinDielectric {
                eta,
                specular_reflectance,
                specular_transmittance,
            } => Model::Pane(Pane {
                eta: *eta,
                reflection_tint: self.color(specular_reflectance),
                transmission_tint: self.color(specular_transmittance),
            }),
            Material::Plastic { .. } => self.plastic(id, material),
            Material::Phong {
                diffuse_reflectance,
                specular_reflectance,
                exponent,
            } => {
                let (diffuse, specular) = (
                    self.color(diffuse_reflectance),
                    self.color(specular_reflectance),
                );
                Model::Phong(Phong::new(diffuse, specular, self.float(exponent)))
            }
            Material::Ward {
                variant,
                diffuse_reflectance,
                specular_reflectance,
                alpha_u,
                alpha_v,
            } => {
                let (diffuse, specular) = (
                    self.color(diffuse_reflectance),
                    self.color(specular_reflectance),
                );
                let alpha = Vec2::new(self.float(alpha_u), self.float(alpha_v));
                Model::Ward(Ward::new(*variant, diffuse, specular, alpha))
            }
            Material::Principled(p) => Model::Principled(self.principled(p)),
            _ => unreachable!("wrappers are taken apart before"),
        }
    }

    fn conductor(&self, material: &Material) -> Model<'s> {
        let Material::Conductor {
            eta,
            k,
            specular_reflectance,
            roughness,
        } = material
        else {
            unreachable!("called for conductors only")
        };
        let metal = Metal::new(self.color(eta), self.color(k));
        let tint = self.color(specular_reflectance);
        match roughness {
            None => Model::Mirror(Mirror { metal, tint }),
            Some(r) => Model::RoughConductor(RoughConductor {
                facets: self.facets(r),
                metal,
                tint,
            }),
        }
    }

    fn dielectric(&self, material: &Material) -> Model<'s> {
        let Material::Dielectric {
            eta,
            specular_reflectance,
            specular_transmittance,
            roughness,
        } = material
        else {
            unreachable!("called for dielectrics only")
        };
        let (eta, reflection_tint) = (*eta, self.color(specular_reflectance));
        let transmission_tint = self.color(specular_transmittance);
        match roughness {
            None => Model::Glass(Glass {
                eta,
                reflection_tint,
                transmission_tint,
            }),
            Some(r) => {
                let facets = self.facets(r);
                Model::RoughGlass(RoughGlass {
                    facets,
                    eta,
                    reflection_tint,
                    transmission_tint,
                })
            }
        }
    }

    fn plastic(&self, id: MaterialId, material: &Material) -> Model<'s> {
        let Material::Plastic {
            eta,
            diffuse_reflectance,
            specular_reflectance,
            nonlinear,
            roughness,
        } = material
        else {
            unreachable!("called for plastics only")
        };
        let shift = if *nonlinear {
            ColorShift::Nonlinear
        } else {
            ColorShift::Linear
        };
        let (diffuse, tint) = (
            self.color(diffuse_reflectance),
            self.color(specular_reflectance),
        );
        let coat = self.materials.coat_of[id.index()].map(|coat| &self.materials.coats[coat]);
        match (coat, roughness) {
            (Some(coat), Some((distribution, alpha))) => {
                let facets = Microfacets::new(*distribution, *alpha, *alpha);
                Model::RoughPlastic(RoughPlastic::new(
                    facets,
                    *eta,
                    coat,
                    (diffuse, tint),
                    shift,
                ))
            }
            _ => Model::Plastic(Plastic::new(*eta, diffuse, tint, shift)),
        }
    }

    fn principled(&self, p: &PrincipledMaterial) -> Principled {
        Principled::new(PrincipledParameters {
            base_color: self.color(&p.base_color),
            roughness: self.float(&p.roughness),
            anisotropic: self.float(&p.anisotropic),
            metallic: self.float(&p.metallic),
            spec_trans: self.float(&p.spec_trans),
            eta: p.eta,
            spec_tint: self.float(&p.spec_tint),
            sheen: self.float(&p.sheen),
            sheen_tint: self.float(&p.sheen_tint),
            flatness: self.float(&p.flatness),
            clearcoat: self.float(&p.clearcoat),
            clearcoat_gloss: self.float(&p.clearcoat_gloss),
            diffuse_rate: p.diffuse_reflectance_sampling_rate,
            specular_rate: p.main_specular_sampling_rate,
            clearcoat_rate: p.clearcoat_sampling_rate,
        })
    }
}

impl Wrapping {
    /// The whole of the material.
    const NONE: Wrapping = Wrapping {
        weight: 1.0,
        outer: Sides::Own,
        tilt: None,
        inner: Sides::Own,
    };

    /// Inside a two-sided wrapper; the innermost of several on one level decides, as only one-sided materials may be inside.
    fn on(self, sides: Sides) -> Self {
        if self.tilt.is_some() {
            Wrapping {
                inner: sides,
                ..self
            }
        } else {
            Wrapping {
                outer: sides,
                ..self
            }
        }
    }

    /// Inside a bump or normal map that gives this normal in the frame around it. A second tilt turns the first one's frame.
    fn tilted(self, normal: Vec3, tangent: Vec3) -> Self {
        let Some(normal) = normal.try_normalize() else {
            return self;
        };
        let normal = self.tilt.map_or(normal, |outer| outer.within(normal));
        Wrapping {
            tilt: Tilt::new(normal, tangent),
            ..self
        }
    }
}

/// `DIFFUSE` promises one `b(wo)` for the whole material, about the shading normal: the strongest leaf decides which,
/// and the diffuse lobes of leaves that differ count as `GLOSSY`.
fn demote<'s>(leaves: &mut [Option<Leaf<'s>>]) -> ExitTransmittance<'s> {
    let eligible = |leaf: &&Leaf| leaf.tilt.is_none() && leaf.model.lobes().has(Lobes::DIFFUSE);
    let strongest = leaves
        .iter()
        .flatten()
        .filter(eligible)
        .max_by(|a, b| a.weight.total_cmp(&b.weight));
    let exit = strongest.map_or(ExitTransmittance::Lambert, |leaf| leaf.model.exit());
    for leaf in leaves.iter_mut().flatten() {
        leaf.demoted = leaf.tilt.is_some() || !same_exit(&leaf.model.exit(), &exit);
    }
    exit
}

fn same_exit(a: &ExitTransmittance, b: &ExitTransmittance) -> bool {
    match (a, b) {
        (ExitTransmittance::Lambert, ExitTransmittance::Lambert) => true,
        (ExitTransmittance::Fresnel { eta: a }, ExitTransmittance::Fresnel { eta: b }) => a == b,
        (ExitTransmittance::Coated(a), ExitTransmittance::Coated(b)) => std::ptr::eq(*a, *b),
        _ => false,
    }
}
