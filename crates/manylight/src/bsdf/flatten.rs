//! From a material and its wrappers to the list of leaves of a scattering function.

use super::instantiate::ModelInstantiation;
use super::leaf::Leaf;
use super::material::{Bitangent, Material};
use super::materials::Materials;
use super::model::Model;
use super::models::diffuse::Diffuse;
use super::sides::Sides;
use super::tilt::Tilt;
use super::{ALIGNED_COSINE, Bsdf, ExitTransmittance, Lobes, MAX_LEAVES};
use crate::geometry::SurfacePoint;
use crate::ids::{MaterialId, TextureId};
use crate::math::Vec3;
use crate::texture::{ColorInput, Texture};

impl Materials {
    /// The scattering function of a material at a point.
    ///
    /// The material and its wrappers are flattened to a weighted list of at most four leaves. If there are more, the leaves with the
    /// smallest weights are left out, and leaves on the same side get their weight.
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
            pass_through: [0.0; 2],
            is_transparent: false,
            transmits: false,
            lobes: Lobes::NONE,
            exit_transmittance: ExitTransmittance::Lambert,
            glossy_width: 1.0,
            is_defensive: x.frame.n.dot(x.ng).abs() < ALIGNED_COSINE,
        };
        if let Some((reflectance, outer)) = self.plain_diffuse(id) {
            let reflectance = reflectance.eval(x, textures);
            bsdf.leaves[0] = Some(Leaf {
                model: Model::Diffuse(Diffuse { reflectance }),
                weight: 1.0,
                outer,
                tilt: None,
                inner: Sides::Own,
                diffuse_is_glossy: false,
            });
            bsdf.lobes = Lobes::DIFFUSE;
        } else {
            let mut flattening = Flattening {
                at: ModelInstantiation {
                    materials: self,
                    x,
                    textures,
                },
                count: 0,
                bsdf: &mut bsdf,
            };
            flattening.add(id, Wrapping::NONE);
            flattening.finish();
        }
        bsdf
    }

    /// Reflectance and sides of the most frequent materials: diffuse on one side or on both. A shortcut.
    #[inline]
    fn plain_diffuse(&self, id: MaterialId) -> Option<(&ColorInput, Sides)> {
        match &self.descriptions()[id.index()] {
            Material::Diffuse { reflectance } => Some((reflectance, Sides::Own)),
            Material::TwoSided { front, back } if front == back => {
                match &self.descriptions()[front.index()] {
                    Material::Diffuse { reflectance } => Some((reflectance, Sides::Both)),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

/// The wrappers around a node of the material tree; see [`Leaf`] for the fields.
#[derive(Clone, Copy)]
struct Wrapping {
    weight: f32,
    outer: Sides,
    tilt: Option<Tilt>,
    inner: Sides,
}

/// A traversal of the material tree.
struct Flattening<'a, 's> {
    at: ModelInstantiation<'a, 's>,
    /// Number of leaves.
    count: usize,
    bsdf: &'a mut Bsdf<'s>,
}

impl<'s> Flattening<'_, 's> {
    /// Adds the subtree of a material.
    fn add(&mut self, id: MaterialId, at: Wrapping) {
        if at.weight <= 0.0 {
            return;
        }
        match &self.at.materials.descriptions()[id.index()] {
            Material::Blend {
                weight,
                first,
                second,
            } => {
                let w = self.at.float(weight).clamp(0.0, 1.0);
                self.add(*first, at.weighted(1.0 - w));
                self.add(*second, at.weighted(w));
            }
            Material::Mask { opacity, inner } => {
                let opacity = self.at.float(opacity).clamp(0.0, 1.0);
                self.add_pass_through(at, at.weight * (1.0 - opacity));
                self.add(*inner, at.weighted(opacity));
            }
            Material::Null => self.add_pass_through(at, at.weight),
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
                // As in Mitsuba 3.9.1, the world-space components of dp_du are used as if they were in the shading frame. Only
                // anisotropic models depend on them.
                self.add(*inner, at.tilted(normal, self.at.x.dp_du));
            }
            Material::NormalMap {
                texture,
                scale,
                bitangent,
                inner,
            } => {
                let textures = self.at.textures;
                let color = textures[texture.index()].eval(self.at.x, textures);
                let mut normal = Vec3::from_array(color.to_array()) * 2.0 - Vec3::ONE;
                normal.x *= scale;
                normal.y *= scale * self.bitangent_sign(*bitangent);
                self.add(*inner, at.tilted(normal, Vec3::X));
            }
            model => self.add_model(id, model, at),
        }
    }

    /// Adds straight-through transmission.
    fn add_pass_through(&mut self, at: Wrapping, weight: f32) {
        let [front, back] = &mut self.bsdf.pass_through;
        match (at.outer, at.inner) {
            (Sides::Front, _) | (_, Sides::Front) => *front += weight,
            (Sides::Back, _) | (_, Sides::Back) => *back += weight,
            _ => {
                *front += weight;
                *back += weight;
            }
        }
    }

    /// Adds a leaf.
    fn add_model(&mut self, id: MaterialId, material: &Material, at: Wrapping) {
        let Wrapping {
            weight,
            outer,
            tilt,
            inner,
        } = at;
        let leaf = Leaf {
            model: self.at.model(id, material),
            weight,
            outer,
            tilt,
            inner,
            diffuse_is_glossy: false,
        };
        if self.count < MAX_LEAVES {
            self.bsdf.leaves[self.count] = Some(leaf);
            self.count += 1;
            return;
        }
        // No space: the leaf with the smallest weight on the same sides and the new one are merged. The heavier model remains, with
        // the sum of the weights.
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

    /// Sets the fields that summarize the leaves.
    fn finish(self) {
        let bsdf = self.bsdf;
        bsdf.is_transparent = bsdf.pass_through != [0.0; 2];
        bsdf.exit_transmittance = match &bsdf.leaves {
            // The frequent case of `unify_diffuse`.
            [Some(leaf), None, ..] if leaf.tilt.is_none() => leaf.model.exit_transmittance(),
            _ => unify_diffuse(&mut bsdf.leaves),
        };
        for leaf in bsdf.leaves.iter().map_while(Option::as_ref) {
            bsdf.lobes = bsdf.lobes.or(leaf.lobes());
            bsdf.glossy_width = bsdf.glossy_width.min(leaf.model.glossy_width());
            bsdf.is_transparent |= matches!(leaf.model, Model::ThinDielectric(_));
            bsdf.transmits |= leaf.model.transmits();
            if let Some(tilt) = &leaf.tilt {
                let cos = bsdf.frame.to_world(tilt.normal()).dot(bsdf.ng).abs();
                bsdf.is_defensive |= cos < ALIGNED_COSINE;
            }
        }
    }

    /// Sign of the second axis of a normal map along n x s.
    fn bitangent_sign(&self, bitangent: Bitangent) -> f32 {
        let x = self.at.x;
        let is_mirrored = || x.dp_du.cross(x.dp_dv).dot(x.frame.n) > 0.0;
        match bitangent {
            Bitangent::AgainstV if is_mirrored() => -1.0,
            _ => 1.0,
        }
    }

    /// The normal of the surface displaced by a height texture, in the shading frame.
    fn bumped_normal(&self, texture: TextureId, scale: f32) -> Vec3 {
        let x = self.at.x;
        let textures = self.at.textures;
        let gradient = textures[texture.index()].gradient(x, [x.dp_du, x.dp_dv], textures) * scale;
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
}

impl Wrapping {
    /// No wrappers.
    const NONE: Wrapping = Wrapping {
        weight: 1.0,
        outer: Sides::Own,
        tilt: None,
        inner: Sides::Own,
    };

    /// With a factor of the weight.
    fn weighted(self, factor: f32) -> Self {
        Wrapping {
            weight: self.weight * factor,
            ..self
        }
    }

    /// Within a two-sided wrapper. The innermost of several in one frame decides.
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

    /// Within a bump or normal map with this normal in the frame of the wrappers outside. Tilts are concatenated.
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

/// Makes all `DIFFUSE` lobes of the leaves have one exit transmittance `b(wo)` around the shading normal, that of the leaf with the
/// largest weight, and returns it. Diffuse lobes of other leaves become `GLOSSY`.
fn unify_diffuse<'s>(leaves: &mut [Option<Leaf<'s>>]) -> ExitTransmittance<'s> {
    let eligible = |leaf: &&Leaf| leaf.tilt.is_none() && leaf.model.lobes().has(Lobes::DIFFUSE);
    let heaviest = leaves
        .iter()
        .flatten()
        .filter(eligible)
        .max_by(|a, b| a.weight.total_cmp(&b.weight));
    let exit = heaviest.map_or(ExitTransmittance::Lambert, |leaf| {
        leaf.model.exit_transmittance()
    });
    for leaf in leaves.iter_mut().flatten() {
        leaf.diffuse_is_glossy =
            leaf.tilt.is_some() || !same_exit(&leaf.model.exit_transmittance(), &exit);
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
