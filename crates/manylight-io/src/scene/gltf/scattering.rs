//! The scattering models of a material, without its opacity: an opaque part, the reflection of a
//! clear coat with another normal texture, diffuse transmission, and glass.

use super::super::description::{add, add_two_sided, as_color, as_float};
use super::super::parameters::Numbers;
use super::extensions::{DiffuseTransmission, Lobes};
use super::glass::{Glass, surface_transmittance, thick_volume};
use super::images::Content;
use super::json::Json;
use super::material_reader::{Base, MaterialReader};
use manylight::bsdf::material::{
    BelowInterface, CoatReflection, Distribution, PrincipledLayers, PrincipledMaterial, Roughness,
};
use manylight::bsdf::{Bitangent, Material};
use manylight::color::Rgb;
use manylight::ids::MaterialId;
use manylight::texture::{ColorInput, FloatInput};

/// Index of refraction of a clear coat.
const COAT_IOR: f32 = 1.5;
/// Smallest roughness alpha of the reflection of a clear coat, as in the principled model.
const SMALLEST_COAT_ALPHA: f32 = 1e-3;

/// The surfaces that show one primitive of the file.
#[derive(Clone, Copy, Debug)]
pub(super) enum Surfaces {
    One,
    /// Two that emit, each to its front.
    BackToBack,
}

/// The side of a surface that a normal texture describes.
#[derive(Clone, Copy, Debug)]
enum Seen {
    Front,
    /// The normal of a back face is that of the front, reversed: in the frame of a surface that is
    /// turned over, its tangential part is the opposite.
    TurnedOver,
}

/// The models of a material, in frames without normal textures.
struct Models {
    /// The principled model on both sides.
    opaque: MaterialId,
    /// The reflection of a clear coat with another normal texture than the rest.
    coat: Option<MaterialId>,
    transmitter: Option<MaterialId>,
    glass: Option<Glass>,
}

impl<'a> MaterialReader<'a, '_> {
    /// The material without its opacity, and the same for a surface that is turned over, if there
    /// is one.
    pub(super) fn scattering(&mut self, base: &Base, surfaces: Surfaces) -> [MaterialId; 2] {
        let models = self.models(base);
        let is_double = matches!(surfaces, Surfaces::BackToBack);
        let has_normals = self.json.has("normalTexture")
            || self
                .coat()
                .is_some_and(|coat| coat.has("clearcoatNormalTexture"));
        let front = self.seen(&models, Seen::Front);
        let back = match is_double && has_normals {
            true => self.seen(&models, Seen::TurnedOver),
            false => front,
        };
        [front, back]
    }

    fn coat(&self) -> Option<Json<'a>> {
        self.json.extension("KHR_materials_clearcoat")
    }

    fn models(&mut self, base: &Base) -> Models {
        let lobes = Lobes::read(self, base);
        let diffuse = match &lobes.transmission {
            Some(through) => self.textures.one_minus(through.weight),
            None => FloatInput::Constant(1.0),
        };
        let opaque = add(self.list, principled(base, &lobes, diffuse));
        Models {
            opaque: add_two_sided(self.list, opaque),
            coat: (lobes.coat_reflection == CoatReflection::Apart)
                .then(|| self.coat_reflection(&lobes)),
            transmitter: lobes
                .transmission
                .map(|through| self.transmitter(base, &lobes, through)),
            glass: Glass::read(self, base, &lobes),
        }
    }

    /// The reflection of a clear coat: a conductor without absorption has Fresnel's reflectance of
    /// a dielectric.
    fn coat_reflection(&mut self, lobes: &Lobes) -> MaterialId {
        let alpha = match self.textures.power(lobes.coat_roughness, 2.0) {
            FloatInput::Constant(alpha) => FloatInput::Constant(alpha.max(SMALLEST_COAT_ALPHA)),
            textured => textured,
        };
        let gray = |v: f32| ColorInput::Constant(Rgb::splat(v));
        let reflection = Material::Conductor {
            eta: gray(COAT_IOR),
            k: gray(0.0),
            specular_reflectance: as_color(lobes.clearcoat),
            roughness: Some(Roughness {
                distribution: Distribution::Ggx,
                alpha_u: alpha,
                alpha_v: alpha,
            }),
        };
        let one_sided = add(self.list, reflection);
        add_two_sided(self.list, one_sided)
    }

    /// Diffuse transmission below the interface and the coat. The absorption of a volume is divided
    /// between the sides at which light enters and leaves.
    fn transmitter(
        &mut self,
        base: &Base,
        lobes: &Lobes,
        through: DiffuseTransmission,
    ) -> MaterialId {
        let dielectric = self.textures.one_minus(base.metallic);
        let per_side = thick_volume(self.json).map_or(Rgb::WHITE, |volume| {
            surface_transmittance(&volume, self.vertices).map(f32::sqrt)
        });
        let factors = [
            as_color(through.weight),
            as_color(dielectric),
            ColorInput::Constant(per_side),
        ];
        let transmittance = factors.into_iter().fold(through.color, |all, factor| {
            self.textures.product(all, factor)
        });
        add(
            self.list,
            Material::DiffuseTransmitter {
                transmittance,
                below: Some(BelowInterface {
                    eta: eta_of_reflectance(base.f0.unwrap_or(lobes.f0)),
                    coat: lobes.clearcoat,
                }),
            },
        )
    }

    /// The models in the frames of the normal textures, put together.
    fn seen(&mut self, models: &Models, side: Seen) -> MaterialId {
        let json = self.json;
        let mut opaque = self.normal_mapped(json, "normalTexture", models.opaque, side);
        if let Some(transmitter) = models.transmitter {
            let second = self.normal_mapped(json, "normalTexture", transmitter, side);
            opaque = self.sum(opaque, second);
        }
        if let (Some(reflection), Some(coat)) = (models.coat, self.coat()) {
            let name = "clearcoatNormalTexture";
            let second = self.normal_mapped(&coat, name, reflection, side);
            opaque = self.sum(opaque, second);
        }
        match &models.glass {
            Some(glass) => self.with_glass(opaque, glass, side),
            None => opaque,
        }
    }

    fn sum(&mut self, first: MaterialId, second: MaterialId) -> MaterialId {
        add(self.list, Material::Sum { first, second })
    }

    /// A mixture of an opaque material and glass.
    fn with_glass(&mut self, opaque: MaterialId, glass: &Glass, side: Seen) -> MaterialId {
        let parts: Vec<MaterialId> = (glass.parts.iter())
            .map(|part| add(self.list, part.clone()))
            .collect();
        let sum = parts.into_iter().reduce(|sum, part| self.sum(sum, part));
        let Some(sum) = sum else {
            return opaque;
        };
        let second = self.normal_mapped(self.json, "normalTexture", sum, side);
        match glass.weight {
            FloatInput::Constant(1.0) => second,
            weight => add(
                self.list,
                Material::Blend {
                    weight,
                    first: opaque,
                    second,
                },
            ),
        }
    }

    /// The material in the frame of the normal texture `name`. It has both sides within this frame,
    /// so that all of the normal is reversed on the back.
    fn normal_mapped(
        &mut self,
        json: &Json<'a>,
        name: &str,
        inner: MaterialId,
        side: Seen,
    ) -> MaterialId {
        let Some(info) = json.member(name) else {
            return inner;
        };
        let Some(texture) = self.texture(json, name, Content::Raw) else {
            return inner;
        };
        let scale = info.float("scale", 1.0);
        let (scale, bitangent) = match side {
            Seen::Front => (scale, self.bitangent),
            Seen::TurnedOver => (-scale, self.turned_over(self.bitangent)),
        };
        add(
            self.list,
            Material::NormalMap {
                texture,
                scale,
                bitangent,
                inner,
            },
        )
    }

    /// The same bitangent by the opposite normal.
    fn turned_over(&mut self, bitangent: Bitangent) -> Bitangent {
        let Bitangent::Signed(sign) = bitangent else {
            return bitangent;
        };
        let opposite = ColorInput::Constant(Rgb::splat(-1.0));
        Bitangent::Signed(as_float(self.textures.product(opposite, as_color(sign))))
    }
}

/// The opaque part of a material, with this factor of the diffuse lobe.
pub(super) fn principled(base: &Base, lobes: &Lobes, diffuse: FloatInput) -> Material {
    let constant = FloatInput::Constant;
    Material::Principled(Box::new(PrincipledMaterial {
        base_color: base.color,
        roughness: lobes.roughness.unwrap_or(base.roughness),
        anisotropic: lobes.anisotropic,
        metallic: base.metallic,
        spec_trans: constant(0.0),
        eta: eta_of_reflectance(base.f0.unwrap_or(lobes.f0)),
        spec_tint: constant(0.0),
        sheen: lobes.sheen,
        sheen_tint: constant(0.0),
        flatness: constant(0.0),
        clearcoat: lobes.clearcoat,
        clearcoat_gloss: constant(0.0),
        layers: Some(PrincipledLayers {
            specular_tint: lobes.specular_tint,
            coat_roughness: lobes.coat_roughness,
            coat_reflection: lobes.coat_reflection,
            film: lobes.film,
            diffuse,
        }),
        diffuse_reflectance_sampling_rate: 1.0,
        main_specular_sampling_rate: 1.0,
        clearcoat_sampling_rate: 1.0,
    }))
}

/// The index of refraction with the reflectance `f0` at normal incidence.
fn eta_of_reflectance(f0: f32) -> f32 {
    /// Largest reflectance of a dielectric here: that of an index of refraction of 199.
    const LARGEST: f32 = 0.98;
    /// Smallest index of refraction: an interface without reflection would have none.
    const SMALLEST_ETA: f32 = 1.001;
    let root = f0.clamp(0.0, LARGEST).sqrt();
    ((1.0 + root) / (1.0 - root)).max(SMALLEST_ETA)
}
