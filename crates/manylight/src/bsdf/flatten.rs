//! From a material and its wrappers to the list of leaves of a scattering function.

use super::function::{ALIGNED_COSINE, MAX_LEAVES};
use super::instantiate::ModelInstantiation;
use super::leaf::Leaf;
use super::lobes::Classes;
use super::material::{Bitangent, Material};
use super::materials::Materials;
use super::model::Model;
use super::models::diffuse::Diffuse;
use super::scattering_model::ScatteringModel;
use super::sides::Sides;
use super::tilt::Tilt;
use super::{Bsdf, ExitTransmittance, Lobes};
use crate::geometry::{SurfacePoint, SurfacePoints};
use crate::ids::{MaterialId, TextureId};
use crate::lanes::{Color, Float, Mask, One, Vector, Width};
use crate::math::Vec3;
use crate::simd::Outlined;
use crate::texture::{ColorInput, Texture};

impl Materials {
    /// The scattering function of a material at a point.
    ///
    /// The material and its wrappers are flattened to a weighted list of at most four leaves. If
    /// there are more, the leaves with the smallest weights are left out, and leaves on the same
    /// side get their weight.
    pub fn bsdf<'s>(
        &'s self,
        id: MaterialId,
        x: &SurfacePoint,
        textures: &'s [Texture],
    ) -> Bsdf<'s> {
        let x: SurfacePoints<One> = x.into();
        let mut bsdf = Bsdf::without_leaves(&x);
        self.add_leaves(id, &x, textures, &mut bsdf);
        bsdf
    }

    /// Completes [`Bsdf::without_leaves`] to [`Materials::bsdf`] in each lane. In place: sixteen
    /// lanes have 11 kB, and copies of them took 3 to 6 % of the time of path tracing.
    #[inline(always)]
    pub(crate) fn add_leaves<'s, S: Width>(
        &'s self,
        id: MaterialId,
        x: &SurfacePoints<S>,
        textures: &'s [Texture],
        bsdf: &mut Bsdf<'s, S>,
    ) {
        if let Some((reflectance, outer)) = self.plain_diffuse(id) {
            let reflectance = reflectance.eval_each(x, textures);
            return set_lambert(bsdf, reflectance, outer);
        }
        let at = ModelInstantiation {
            materials: self,
            x,
            textures,
        };
        x.offset.width().outline(Flatten { at, id, bsdf });
    }

    /// Reflectance and sides of the most frequent materials: diffuse on one side or on both. A
    /// shortcut.
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

/// Adds Lambert's model alone.
#[inline(always)]
fn set_lambert<S: Width>(bsdf: &mut Bsdf<'_, S>, reflectance: Color<S>, outer: Sides) {
    let s = bsdf.width();
    bsdf.classes = Classes::splat(s, Lobes::DIFFUSE);
    bsdf.leaves[0] = Some(Leaf {
        model: Model::Diffuse(Diffuse { reflectance }),
        weight: Float::splat(s, 1.0),
        outer,
        tilt: None,
        inner: Sides::Own,
        diffuse_is_glossy: Mask::splat(s, false),
        lobes: Classes::splat(s, Lobes::DIFFUSE),
    });
}

/// The scattering functions of a material tree.
struct Flatten<'a, 's, S: Width> {
    at: ModelInstantiation<'a, 's, S>,
    id: MaterialId,
    bsdf: &'a mut Bsdf<'s, S>,
}

impl<S: Width> Outlined for Flatten<'_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Flatten { at, id, bsdf } = self;
        let mut flattening = Flattening { at, count: 0, bsdf };
        flattening.add(id, Wrapping::none(at.x.offset.width()));
        flattening.finish();
    }
}

/// The wrappers around a node of the material tree; see [`Leaf`] for the fields.
#[derive(Clone, Copy)]
struct Wrapping<S: Width> {
    weight: Float<S>,
    outer: Sides,
    tilt: Option<Tilt<S>>,
    inner: Sides,
}

/// A subtree of the material tree that waits to be added.
type Pending<S> = (MaterialId, Wrapping<S>);

/// A traversal of the material tree.
struct Flattening<'a, 's, S: Width> {
    at: ModelInstantiation<'a, 's, S>,
    /// Number of leaves.
    count: usize,
    bsdf: &'a mut Bsdf<'s, S>,
}

impl<'s, S: Width> Flattening<'_, 's, S> {
    /// Adds the subtree of a material, in depth-first order.
    #[inline(always)]
    fn add(&mut self, id: MaterialId, at: Wrapping<S>) {
        let mut current = Some((id, at));
        let mut pending: Vec<Pending<S>> = Vec::new();
        while let Some((id, at)) = current.take().or_else(|| pending.pop()) {
            if at.weight.gt(0.0).none() {
                continue;
            }
            current = self.add_node(id, at, &mut pending);
        }
    }

    /// Adds a leaf, or returns the first child of a wrapper. Other children become pending.
    #[inline(always)]
    fn add_node(
        &mut self,
        id: MaterialId,
        at: Wrapping<S>,
        pending: &mut Vec<Pending<S>>,
    ) -> Option<Pending<S>> {
        match &self.at.materials.descriptions()[id.index()] {
            Material::Blend {
                weight,
                first,
                second,
            } => {
                let w = self.at.float(weight).clamp(0.0, 1.0);
                pending.push((*second, at.weighted(w)));
                Some((*first, at.weighted(1.0 - w)))
            }
            Material::Sum { first, second } => {
                pending.push((*second, at));
                Some((*first, at))
            }
            Material::Mask { opacity, inner } => {
                let opacity = self.at.float(opacity).clamp(0.0, 1.0);
                self.add_pass_through(at, at.weight * (1.0 - opacity));
                Some((*inner, at.weighted(opacity)))
            }
            Material::Null => {
                self.add_pass_through(at, at.weight);
                None
            }
            Material::TwoSided { front, back } if front == back => {
                Some((*front, at.on(Sides::Both)))
            }
            Material::TwoSided { front, back } => {
                pending.push((*back, at.on(Sides::Back)));
                Some((*front, at.on(Sides::Front)))
            }
            Material::BumpMap {
                texture,
                scale,
                inner,
            } => {
                let normal = self.bumped_normal(*texture, *scale);
                // As in Mitsuba 3.9.1, the world-space components of dp_du are used as if they were
                // in the shading frame. Only anisotropic models depend on them.
                Some((*inner, at.tilted(normal, self.at.x.dp_du)))
            }
            Material::NormalMap {
                texture,
                scale,
                bitangent,
                inner,
            } => {
                let color = ColorInput::Texture(*texture).eval_each(self.at.x, self.at.textures);
                let normal = Vector::new(
                    (color.r * 2.0 - 1.0) * *scale,
                    (color.g * 2.0 - 1.0) * *scale * self.bitangent_sign(*bitangent),
                    color.b * 2.0 - 1.0,
                );
                let tangent = Vector::splat(normal.z.width(), Vec3::X);
                Some((*inner, at.tilted(normal, tangent)))
            }
            model => {
                self.add_model(id, model, at);
                None
            }
        }
    }

    /// Adds straight-through transmission.
    #[inline(always)]
    fn add_pass_through(&mut self, at: Wrapping<S>, weight: Float<S>) {
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
    #[inline(always)]
    fn add_model(&mut self, id: MaterialId, material: &Material, at: Wrapping<S>) {
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
            diffuse_is_glossy: Mask::splat(weight.width(), false),
            lobes: Classes::splat(weight.width(), Lobes::NONE),
        };
        if self.count < MAX_LEAVES {
            self.bsdf.leaves[self.count] = Some(leaf);
            self.count += 1;
            return;
        }
        // No space: the leaf with the smallest weight on the same sides and the new one are merged.
        // The heavier model remains, with the sum of the weights. In lanes, the sum of the lanes
        // decides.
        let rivals = self
            .bsdf
            .leaves
            .iter_mut()
            .flatten()
            .filter(|l| l.outer == outer && l.inner == inner);
        if let Some(rival) = rivals.min_by(|a, b| total(a.weight).total_cmp(&total(b.weight))) {
            let sum = rival.weight + weight;
            if total(rival.weight) < total(weight) {
                *rival = leaf;
            }
            rival.weight = sum;
        }
    }

    /// Sets the fields that summarize the leaves.
    #[inline(always)]
    fn finish(self) {
        let bsdf = self.bsdf;
        let [front, back] = bsdf.pass_through;
        bsdf.is_transparent = (front.gt(0.0) | back.gt(0.0)).any();
        let is_plain = match &bsdf.leaves {
            // The frequent case of `unify_diffuse`.
            [Some(leaf), None, ..] => leaf.tilt.is_none(),
            _ => false,
        };
        if !is_plain {
            unify_diffuse(&mut bsdf.leaves);
        }
        for leaf in bsdf.leaves.iter_mut().map_while(Option::as_mut) {
            leaf.set_lobes();
            bsdf.classes = bsdf.classes.or(leaf.lobes);
            bsdf.is_transparent |= matches!(leaf.model, Model::ThinDielectric(_));
            bsdf.transmits |= leaf.model.transmits();
            if let Some(tilt) = &leaf.tilt {
                let cos = bsdf.frame.to_world(tilt.normal()).dot(bsdf.ng).abs();
                bsdf.is_defensive |= cos.lt(ALIGNED_COSINE) & tilt.is_tilted;
            }
        }
    }

    /// Sign of the second axis of a normal map along n x s.
    #[inline(always)]
    fn bitangent_sign(&self, bitangent: Bitangent) -> Float<S> {
        let x = self.at.x;
        let is_mirrored = x.dp_du.cross(x.dp_dv).dot(x.frame.n).gt(0.0);
        match bitangent {
            Bitangent::AgainstV => is_mirrored.select(-1.0, 1.0),
            Bitangent::RightHanded => x.offset.same(1.0),
            Bitangent::Signed(sign) => self.at.float(&sign).sign(),
        }
    }

    /// The normal of the surface displaced by a height texture, in the shading frame.
    #[inline(always)]
    fn bumped_normal(&self, texture: TextureId, scale: f32) -> Vector<S> {
        let x = self.at.x;
        let textures = self.at.textures;
        let gradient = textures[texture.index()].gradient_each(x, textures) * scale;
        let n = x.frame.n;
        let du = x.dp_du + n * (gradient.x - n.dot(x.dp_du));
        let dv = x.dp_dv + n * (gradient.y - n.dot(x.dp_dv));
        let normal = du.cross(dv);
        let outward = normal * x.ng.dot(normal).lt(0.0).select(-1.0, 1.0);
        x.frame.to_local(outward)
    }
}

/// The sum over the lanes.
#[inline(always)]
fn total<S: Width>(x: Float<S>) -> f32 {
    x.store().as_ref().iter().sum()
}

impl<S: Width> Wrapping<S> {
    /// No wrappers.
    #[inline(always)]
    fn none(s: S) -> Self {
        Wrapping {
            weight: Float::splat(s, 1.0),
            outer: Sides::Own,
            tilt: None,
            inner: Sides::Own,
        }
    }

    /// With a factor of the weight.
    #[inline(always)]
    fn weighted(self, factor: Float<S>) -> Self {
        Wrapping {
            weight: self.weight * factor,
            ..self
        }
    }

    /// Within a two-sided wrapper. The innermost of several in one frame decides.
    #[inline(always)]
    fn on(self, sides: Sides) -> Self {
        if self.tilt.is_some_and(|tilt| tilt.is_tilted.any()) {
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

    /// Within a bump or normal map with this normal in the frame of the wrappers outside. Tilts are
    /// concatenated.
    #[inline(always)]
    fn tilted(self, normal: Vector<S>, tangent: Vector<S>) -> Self {
        let (normal, valid) = normal.try_normalize();
        let normal = self.tilt.map_or(normal, |outer| outer.within(normal));
        let tilt = Tilt::new(normal, tangent, valid);
        Wrapping {
            tilt: Some(match self.tilt {
                Some(outer) => tilt.or(valid, outer),
                None => tilt,
            }),
            ..self
        }
    }
}

/// Makes all `DIFFUSE` lobes of the leaves have one exit transmittance `b(wo)` around the shading
/// normal, that of the leaf with the largest weight. Diffuse lobes of other leaves become `GLOSSY`.
#[inline(always)]
fn unify_diffuse<S: Width>(leaves: &mut [Option<Leaf<S>>; MAX_LEAVES]) {
    let Some(first) = &leaves[0] else {
        return;
    };
    let none = Mask::splat(first.weight.width(), false);
    let each = leaves.each_ref();
    let exits = each.map(|leaf| leaf.as_ref().map(|leaf| leaf.model.exit_transmittance()));
    // The weight of each leaf in the lanes in which its lobe can decide, else 0.
    let weights = each.map(|leaf| {
        leaf.as_ref().map(|leaf| {
            let untilted = leaf.tilt.map_or(!none, |tilt| !tilt.is_tilted);
            (leaf.model.lobes().diffuse & untilted).select(leaf.weight, 0.0)
        })
    });
    for (i, leaf) in leaves.iter_mut().enumerate() {
        let (Some(leaf), Some(exit)) = (leaf, &exits[i]) else {
            break;
        };
        // The heaviest leaf with this exit against the heaviest with another; the last of equal
        // ones decides.
        let mut heaviest = leaf.weight.same(0.0);
        let mut is_other = none;
        for (weight, other) in weights.iter().zip(&exits) {
            if let (Some(weight), Some(other)) = (weight, other) {
                let decides = weight.gt(0.0) & weight.ge(heaviest);
                heaviest = decides.select(*weight, heaviest);
                is_other = match same_exit(exit, other) {
                    true => is_other & !decides,
                    false => is_other | decides,
                };
            }
        }
        let is_tilted = leaf.tilt.map_or(none, |tilt| tilt.is_tilted);
        leaf.diffuse_is_glossy = is_tilted | is_other;
    }
}

fn same_exit(a: &ExitTransmittance, b: &ExitTransmittance) -> bool {
    match (a, b) {
        (ExitTransmittance::Lambert, ExitTransmittance::Lambert) => true,
        (ExitTransmittance::Fresnel { eta: a }, ExitTransmittance::Fresnel { eta: b }) => a == b,
        (ExitTransmittance::Coated(a), ExitTransmittance::Coated(b)) => std::ptr::eq(*a, *b),
        _ => false,
    }
}
