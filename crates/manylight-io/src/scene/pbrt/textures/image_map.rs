//! Image textures.

use super::super::super::assets::{Decode, ImageUse};
use super::super::super::files::find_external_file;
use super::super::super::sink::Problem;
use super::super::Builder;
use super::super::entities::Entity;
use crate::image::Transfer;
use manylight::ids::TextureId;
use manylight::image::Image;
use manylight::math::{Mat3, Vec3};
use manylight::scene::SceneDesc;
use manylight::texture::{Bitmap, ColorInput, Filtering, Texture, Wrap};
use std::path::Path;

impl Builder<'_> {
    pub(super) fn image_map(&mut self, entity: &Entity, is_spectrum: bool) -> Option<ColorInput> {
        let params = &entity.params;
        params.ignore(&["maxanisotropy", "trilinear"]);
        let filters = [
            ("bilinear", Filtering::Bilinear),
            ("trilinear", Filtering::Bilinear),
            ("ewa", Filtering::Bilinear),
            ("EWA", Filtering::Bilinear),
            ("point", Filtering::Nearest),
        ];
        let filtering = params.choice(self.sink, "filter", Filtering::Bilinear, &filters);
        let wrap = self.wrap(entity);
        // v points up in PBRT, down in images.
        let flip = Mat3::from_cols(Vec3::X, -Vec3::Y, Vec3::new(0.0, 1.0, 1.0));
        let mapping = self.mapping(entity);
        let uv_transform = flip * mapping.uv_transform;
        let scale = params.float(self.sink, "scale", 1.0);
        let invert = params.boolean(self.sink, "invert", false);
        let name = params.required_string(self.sink, "filename")?;
        let transfer = self.transfer(entity, &name.value);
        let path = find_external_file(self.sink, &entity.folders, name, "texture")?;
        let key = format!(
            "{} {filtering:?} {wrap:?} {mapping:?} {scale} {invert} {transfer:?} {is_spectrum}",
            path.display()
        );
        if let Some(texture) = self.bitmaps.get(&key) {
            return Some(ColorInput::Texture(*texture));
        }
        let texture = self.add_texture(Texture::Bitmap(Bitmap {
            image: Image::default(),
            filtering,
            wrap: [wrap; 2],
            uv_transform,
        }));
        let decode = if is_spectrum || self.is_v3 {
            Decode::Color(transfer)
        } else {
            Decode::Float(transfer)
        };
        let use_image = store_edited(texture, scale, invert, is_spectrum);
        self.assets
            .add_image_use(path, decode, name.span, use_image);
        let mapped = self.at_mapped_uv(mapping, texture);
        self.bitmaps.insert(key, mapped);
        Some(ColorInput::Texture(mapped))
    }

    fn wrap(&self, entity: &Entity) -> Wrap {
        let choices = [
            ("repeat", Wrap::Repeat),
            ("clamp", Wrap::Clamp),
            ("black", Wrap::Clamp),
            ("octahedralsphere", Wrap::Clamp),
        ];
        let params = &entity.params;
        let wrap = params.choice(self.sink, "wrap", Wrap::Repeat, &choices);
        if let Some(name) = params.string(self.sink, "wrap")
            && matches!(name.value.as_str(), "black" | "octahedralsphere")
        {
            let message = format!(
                "wrap mode `{}` is not supported; it is replaced by `clamp`",
                name.value
            );
            let problem = Problem::new("scene::unsupported", name.span, message);
            self.sink.warn_once(format!("wrap {}", name.value), problem);
        }
        wrap
    }

    /// The transfer function. `encoding` concerns PNG files; other integer formats are sRGB.
    fn transfer(&self, entity: &Entity, file: &str) -> Transfer {
        let params = &entity.params;
        let is_png = Path::new(file)
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
        if params.has("gamma") && !params.boolean(self.sink, "gamma", true) {
            return Transfer::Raw;
        }
        let Some(encoding) = params.string(self.sink, "encoding") else {
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

/// Stores an image in the bitmap `texture`, scaled and then inverted. Values of spectra are clamped to [0, 1].
fn store_edited(texture: TextureId, scale: f32, invert: bool, is_spectrum: bool) -> ImageUse {
    Box::new(move |desc: &mut SceneDesc, mut image: Image| {
        let edit = |v: f32| {
            let v = if invert { 1.0 - v * scale } else { v * scale };
            if is_spectrum { v.clamp(0.0, 1.0) } else { v }
        };
        image.data.iter_mut().for_each(|v| *v = edit(*v));
        if let Texture::Bitmap(bitmap) = &mut desc.textures[texture.index()] {
            bitmap.image = image;
        }
    })
}
