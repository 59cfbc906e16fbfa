//! Emitting surfaces.

use super::super::super::assets::Decode;
use super::super::super::description::{Additions, bitmap, flip_v, set_image};
use super::super::super::names::name_light_group;
use super::super::super::parameters::{Numbers, Parameters};
use super::super::builder::Builder;
use super::super::entities::{Entity, ShapeEntity};
use super::power::EmittingSurface;
use crate::image::Transfer;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::ids::EmitterId;
use manylight::image::Image;
use manylight::scene::SceneDesc;
use manylight::texture::{ColorInput, Filtering, Wrap};

/// An emitter of a surface.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct AreaLight {
    pub(in super::super) emitter: EmitterId,
    /// Whether the back emits, too.
    pub(in super::super) two_sided: bool,
}

impl Builder<'_> {
    /// The emitter of a shape that is already in the description.
    pub(in super::super) fn area_light(
        &mut self,
        shape: &ShapeEntity<'_>,
        surface: EmittingSurface,
    ) -> Option<AreaLight> {
        let entity = shape.area_light.as_deref()?;
        let params = &entity.params;
        params.ignore(super::SAMPLING_PARAMETERS);
        if !matches!(params.plugin.value.as_str(), "diffuse" | "area") {
            self.unknown_plugin(entity, ["diffuse"]);
            params.ignore_all();
            return None;
        }
        let two_sided = params.boolean("twosided", false);
        let power = params.maybe_float("power");
        let radiance = self.radiance(entity);
        let emitter = self.desc.add(Emitter::Area { radiance });
        let group = params.string(super::LIGHT_GROUP);
        let group = group.map(|name| name.value.as_str());
        name_light_group(&mut self.desc, emitter.index(), group);
        if let Some(power) = power.filter(|power| *power > 0.0) {
            let sides = if two_sided { 2.0 } else { 1.0 };
            self.after_loading(move |desc: &mut SceneDesc| {
                surface.set_power(desc, emitter, power / sides);
            });
        }
        entity.params.finish(self.is_v3);
        Some(AreaLight { emitter, two_sided })
    }

    /// The radiance `L`, or that of an image.
    fn radiance(&mut self, entity: &Entity<'_>) -> ColorInput {
        let params = &entity.params;
        let Some(name) = params.string("filename") else {
            return ColorInput::Constant(self.emission(entity, "L"));
        };
        let Some(path) = entity.find_file(name, "image of a light") else {
            return ColorInput::Constant(Rgb::WHITE);
        };
        let scale = self.emission_scale(entity).luminance();
        let bitmap = bitmap(Filtering::Nearest, [Wrap::Clamp; 2], flip_v());
        let texture = self.desc.add(bitmap);
        let store = move |desc: &mut SceneDesc, mut image: Image| {
            image.data.iter_mut().for_each(|v| *v *= scale);
            set_image(&mut desc.textures, texture, image);
        };
        let decode = Decode::Color(Transfer::Auto);
        self.assets.add_image_use(path, decode, name.span, store);
        ColorInput::Texture(texture)
    }
}
