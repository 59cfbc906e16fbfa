//! Conductors, bare and coated.

use super::super::super::description::{WHITE, scaled};
use super::super::super::parameters::Parameters;
use super::super::builder::Builder;
use super::super::colors::ColorUse;
use super::super::entities::Entity;
use manylight::bsdf::Material;
use manylight::bsdf::material::Roughness;
use manylight::color::Rgb;
use manylight::ids::MaterialId;
use manylight::texture::{ColorInput, FloatInput};

/// Largest reflectance of a conductor that is given by it, as in PBRT.
const MAX_CONDUCTOR_REFLECTANCE: f32 = 0.9999;

impl Builder<'_> {
    /// A conductor. The names of its parameters start with `prefix`, which is empty or
    /// `conductor.`.
    pub(super) fn conductor(&mut self, entity: &Entity<'_>, prefix: &str) -> Material {
        let roughness = self.roughness(entity, prefix, 0.0);
        let [eta_name, k_name] = match prefix {
            "" => ["eta", "k"],
            _ => ["conductor.eta", "conductor.k"],
        };
        if let Some(reflectance) = self.color_input(entity, "reflectance", ColorUse::Reflectance) {
            return self.conductor_of_reflectance(entity, reflectance, roughness);
        }
        let copper = crate::spectra::metal("Cu").unwrap_or((Rgb::BLACK, Rgb::WHITE));
        let eta = self.color_input(entity, eta_name, ColorUse::Coefficient);
        let k = self.color_input(entity, k_name, ColorUse::Coefficient);
        Material::Conductor {
            eta: eta.unwrap_or(ColorInput::Constant(copper.0)),
            k: k.unwrap_or(ColorInput::Constant(copper.1)),
            specular_reflectance: WHITE,
            roughness,
        }
    }

    /// The conductor with eta 1 and the k that has this reflectance at normal incidence.
    fn conductor_of_reflectance(
        &mut self,
        entity: &Entity<'_>,
        reflectance: ColorInput,
        roughness: Option<Roughness>,
    ) -> Material {
        match reflectance {
            ColorInput::Constant(color) => {
                let k = color.map(|r| {
                    let r = r.clamp(0.0, MAX_CONDUCTOR_REFLECTANCE);
                    2.0 * r.sqrt() / (1.0 - r).sqrt()
                });
                Material::Conductor {
                    eta: WHITE,
                    k: ColorInput::Constant(k),
                    specular_reflectance: WHITE,
                    roughness,
                }
            }
            texture => {
                let params = &entity.params;
                let object = params.describe();
                let message = format!(
                    "a textured `reflectance` of {object} does not depend on the angle here"
                );
                params.unsupported("textured conductor", message);
                mirror(texture, roughness)
            }
        }
    }

    /// A conductor under a dielectric coat: a blend of the conductor with the reflection of the
    /// coat, by the reflectance of the coat at normal incidence.
    pub(super) fn coated_conductor(&mut self, entity: &Entity<'_>) -> MaterialId {
        self.ignore_layers(entity);
        let params = &entity.params;
        let object = params.describe();
        let message = format!(
            "{object} is approximated by a blend of conductor and coat at normal incidence"
        );
        params.unsupported(object, message);
        let eta = self.eta(entity, "interface.eta", 1.5);
        let coat = self.roughness(entity, "interface.", 0.0);
        let mut metal = self.conductor(entity, "conductor.");
        if let Material::Conductor {
            eta: metal_eta, k, ..
        } = &mut metal
        {
            // Indices relative to the coat.
            for index in [metal_eta, k] {
                *index = scaled(&mut self.desc.textures, *index, eta.recip());
            }
        }
        let reflectance = ((eta - 1.0) / (eta + 1.0)).powi(2);
        let first = self.both_sides(metal);
        let second = self.both_sides(mirror(WHITE, coat));
        self.blend(FloatInput::Constant(reflectance), first, second)
    }
}

/// A mirror of a reflectance that does not depend on the angle.
pub(super) fn mirror(reflectance: ColorInput, roughness: Option<Roughness>) -> Material {
    Material::Conductor {
        eta: ColorInput::Constant(Rgb::BLACK),
        k: WHITE,
        specular_reflectance: reflectance,
        roughness,
    }
}
