//! Image textures.

use super::super::super::assets::Decode;
use super::super::super::description::{Additions, bitmap, flip_v, set_image};
use super::super::super::parameters::{Numbers, Parameters};
use super::super::super::sink::Problem;
use super::super::bindings::TextureType;
use super::super::builder::Builder;
use super::super::entities::Entity;
use crate::image::Transfer;
use manylight::image::Image;
use manylight::scene::SceneDesc;
use manylight::texture::{ColorInput, Filtering, Wrap};
use std::path::Path;

impl Builder<'_> {
    pub(super) fn image_map(&mut self, entity: &Entity<'_>, ty: TextureType) -> Option<ColorInput> {
        let params = &entity.params;
        params.ignore(&["maxanisotropy", "trilinear"]);
        let filters = [
            ("bilinear", Filtering::Bilinear),
            ("trilinear", Filtering::Bilinear),
            ("ewa", Filtering::Bilinear),
            ("EWA", Filtering::Bilinear),
            ("point", Filtering::Nearest),
        ];
        let filtering = params.choice("filter", Filtering::Bilinear, &filters);
        let wrap = self.wrap(entity);
        let mapping = self.mapping(entity);
        // v points up in PBRT.
        let uv_transform = flip_v() * mapping.uv_transform;
        let scale = params.float("scale", 1.0);
        let invert = params.boolean("invert", false);
        let name = params.required_string("filename")?;
        let transfer = self.transfer(entity, &name.value);
        let path = entity.find_file(name, "texture")?;
        let key = format!(
            "{} {filtering:?} {wrap:?} {mapping:?} {scale} {invert} {transfer:?} {ty:?}",
            path.display()
        );
        if let Some(texture) = self.made.bitmaps.get(&key) {
            return Some(ColorInput::Texture(*texture));
        }
        let bitmap = bitmap(filtering, [wrap; 2], uv_transform);
        let texture = self.desc.add(bitmap);
        let decode = if ty == TextureType::Spectrum || self.is_v3 {
            Decode::Color(transfer)
        } else {
            Decode::Float(transfer)
        };
        // Scaled and then inverted. Values of spectra are clamped to [0, 1].
        let edit = move |v: f32| {
            let v = if invert { 1.0 - v * scale } else { v * scale };
            match ty {
                TextureType::Spectrum => v.clamp(0.0, 1.0),
                TextureType::Float => v,
            }
        };
        let store = move |desc: &mut SceneDesc, mut image: Image| {
            image.data.iter_mut().for_each(|v| *v = edit(*v));
            set_image(&mut desc.textures, texture, image);
        };
        self.assets.add_image_use(path, decode, name.span, store);
        let mapped = self.at_mapped_uv(mapping, texture);
        self.made.bitmaps.insert(key, mapped);
        Some(ColorInput::Texture(mapped))
    }

    fn wrap(&self, entity: &Entity<'_>) -> Wrap {
        let choices = [
            ("repeat", Wrap::Repeat),
            ("clamp", Wrap::Clamp),
            ("black", Wrap::Clamp),
            ("octahedralsphere", Wrap::Clamp),
        ];
        let params = &entity.params;
        let wrap = params.choice("wrap", Wrap::Repeat, &choices);
        if let Some(name) = params.string("wrap")
            && matches!(name.value.as_str(), "black" | "octahedralsphere")
        {
            let mode = &name.value;
            let message = format!("wrap mode `{mode}` is not supported; it is replaced by `clamp`");
            self.sink
                .unsupported(format!("wrap {mode}"), name.span, message);
        }
        wrap
    }

    /// The transfer function. `encoding` concerns PNG files; other integer formats are sRGB.
    fn transfer(&self, entity: &Entity<'_>, file: &str) -> Transfer {
        let params = &entity.params;
        let is_png = Path::new(file)
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
        if params.has("gamma") && !params.boolean("gamma", true) {
            return Transfer::Raw;
        }
        let Some(encoding) = params.string("encoding") else {
            return Transfer::Auto;
        };
        let gamma = encoding.value.strip_prefix("gamma ").map(str::trim);
        let transfer = match (encoding.value.as_str(), gamma.map(str::parse::<f32>)) {
            ("sRGB", _) => Transfer::Srgb,
            ("linear", _) => Transfer::Raw,
            (_, Some(Ok(gamma))) if gamma > 0.0 => Transfer::Gamma(gamma),
            _ => {
                let message = format!("unknown encoding `{}`", encoding.value);
                let help = "expected `sRGB`, `linear` or for example `gamma 2.2`";
                let problem = Problem::new("scene::bad_value", encoding.span, message);
                self.sink.error(problem.help(help));
                Transfer::Auto
            }
        };
        if is_png { transfer } else { Transfer::Auto }
    }
}
