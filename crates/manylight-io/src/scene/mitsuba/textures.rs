//! Texture plugins.

use super::super::assets::Channel;
use super::super::attributes::AttributeRequest;
use super::super::description::{Additions, bitmap};
use super::super::files::find_file;
use super::super::parameters::{Numbers, Parameters};
use super::builder::{DescBuilder, Substitute};
use super::colors::ColorUse;
use super::family::{PluginFamily, TEXTURES};
use super::props::Props;
use super::values::{ObjectId, Value};
use crate::image::Transfer;
use glam::DMat4;
use manylight::color::Rgb;
use manylight::ids::TextureId;
use manylight::image::Image;
use manylight::math::{Mat3, Vec3};
use manylight::texture::{Bitmap, ColorInput, Filtering, Texture, VertexValues, Wrap};

const REPLACED_BY_CONSTANT: &str = "it is replaced by a constant";

const SUBSTITUTES: &[Substitute] = &[
    ("volume", REPLACED_BY_CONSTANT),
    ("gridtexture", REPLACED_BY_CONSTANT),
    ("wireframe", REPLACED_BY_CONSTANT),
    ("curvature", REPLACED_BY_CONSTANT),
    ("scale", REPLACED_BY_CONSTANT),
];

impl DescBuilder<'_> {
    /// The texture, added at its first use. `None` if it is invalid or not supported: the default
    /// of the parameter replaces it.
    pub(super) fn texture(&mut self, id: ObjectId) -> Option<TextureId> {
        let key = self.scoped(id);
        if let Some(texture) = self.made.textures.get(&key) {
            return Some(*texture);
        }
        let props = self.props(id);
        let texture = match props.plugin().value.as_str() {
            "bitmap" => self.bitmap(&props),
            "checkerboard" => Some(self.checkerboard(&props)),
            "mesh_attribute" | "vertexcolors" => self.mesh_attribute(&props),
            "volume" if self.constant_volume(&props).is_some() => self.volume(&props),
            _ => {
                self.unsupported(&props, TEXTURES, SUBSTITUTES);
                return None;
            }
        };
        props.ignore(&["id"]);
        props.finish();
        self.made
            .textures
            .extend(texture.map(|texture| (key, texture)));
        texture
    }

    /// The texture, or a texture of the constant color of a spectrum.
    pub(super) fn color_texture(&mut self, id: ObjectId) -> Option<TextureId> {
        if self.tree.get(id).family == PluginFamily::Texture {
            return self.texture(id);
        }
        let color = self.spectrum_plugin(id, ColorUse::Coefficient)?;
        Some(self.constant_texture(color))
    }

    /// A texture of one color.
    pub(super) fn constant_texture(&mut self, color: Rgb) -> TextureId {
        self.desc.add(Texture::Bitmap(Bitmap {
            image: Image {
                width: 1,
                height: 1,
                channels: 3,
                data: color.to_array().to_vec(),
            },
            filtering: Filtering::Nearest,
            wrap: [Wrap::Repeat; 2],
            uv_transform: Mat3::IDENTITY,
        }))
    }

    /// The texture times `scale`.
    pub(super) fn scaled(&mut self, texture: TextureId, scale: f32) -> TextureId {
        if scale == 1.0 {
            return texture;
        }
        self.desc.add(Texture::Product {
            first: ColorInput::Texture(texture),
            second: ColorInput::Constant(Rgb::splat(scale)),
        })
    }

    fn bitmap(&mut self, props: &Props<'_>) -> Option<TextureId> {
        props.ignore(&["format", "accel", "max_anisotropy", "cache", "id"]);
        let filtering = self.filtering(props);
        let wrap = self.wrap(props);
        let uv_transform = uv_transform(props);
        let transfer = transfer(props);
        let channel = props.choice("channel", Channel::All, &Channel::NAMES);
        let name = props.required_string("filename")?;
        let path = find_file(self.sink, &props.object().folders, name, "texture")?;
        let settings = format!("{filtering:?} {wrap:?} {uv_transform:?} {transfer:?} {channel:?}");
        let key = (path.clone(), settings);
        if let Some(texture) = self.made.bitmaps.get(&key) {
            return Some(*texture);
        }
        let bitmap = bitmap(filtering, [wrap; 2], uv_transform);
        let texture = self.desc.add(bitmap);
        self.assets
            .add_texture_image(texture, path, transfer, channel, name.span);
        self.made.bitmaps.insert(key, texture);
        Some(texture)
    }

    fn filtering(&self, props: &Props<'_>) -> Filtering {
        let Some(text) = props.string("filter_type") else {
            return Filtering::Bilinear;
        };
        if props.is_v0() && matches!(text.value.as_str(), "trilinear" | "ewa") {
            let filter = &text.value;
            let message =
                format!("texture filter `{filter}` is not supported; it is replaced by `bilinear`");
            self.sink
                .unsupported(format!("filter {filter}"), text.span, message);
            return Filtering::Bilinear;
        }
        let choices = [
            ("bilinear", Filtering::Bilinear),
            ("nearest", Filtering::Nearest),
        ];
        props.choice("filter_type", Filtering::Bilinear, &choices)
    }

    /// The wrap mode: `wrap_mode`, or `wrap_mode_u` and `wrap_mode_v` in 0.x.
    fn wrap(&self, props: &Props<'_>) -> Wrap {
        if props.is_v0() {
            self.wrap_v0(props)
        } else {
            let choices = [
                ("repeat", Wrap::Repeat),
                ("mirror", Wrap::Mirror),
                ("clamp", Wrap::Clamp),
            ];
            props.choice("wrap_mode", Wrap::Repeat, &choices)
        }
    }

    fn wrap_v0(&self, props: &Props<'_>) -> Wrap {
        let choices = [
            ("repeat", Wrap::Repeat),
            ("mirror", Wrap::Mirror),
            ("clamp", Wrap::Clamp),
            ("zero", Wrap::Clamp),
            ("one", Wrap::Clamp),
        ];
        let both = props.choice("wrap_mode", Wrap::Repeat, &choices);
        let u = props.choice("wrap_mode_u", both, &choices);
        let v = props.choice("wrap_mode_v", both, &choices);
        for name in ["wrap_mode", "wrap_mode_u", "wrap_mode_v"] {
            if let Some(text) = props.has(name).then(|| props.string(name)).flatten()
                && matches!(text.value.as_str(), "zero" | "one")
            {
                let mode = &text.value;
                let message =
                    format!("wrap mode `{mode}` is not supported; it is replaced by `clamp`");
                self.sink.unsupported("wrap constant", text.span, message);
            }
        }
        if u != v {
            let message = "different wrap modes along u and v are not supported; `wrap_mode_u` is used for both";
            props.unsupported("wrap uv", message);
        }
        u
    }

    fn checkerboard(&mut self, props: &Props<'_>) -> TextureId {
        props.ignore(&["line_width", "id"]);
        let color0 = self.color_input(props, "color0", 0.4, ColorUse::Reflectance);
        let color1 = self.color_input(props, "color1", 0.2, ColorUse::Reflectance);
        let uv_transform = uv_transform(props);
        self.desc.add(Texture::Checkerboard {
            color0,
            color1,
            uv_transform,
        })
    }

    /// The volume of a `volume` texture, if its values are constant.
    fn constant_volume(&self, props: &Props<'_>) -> Option<ObjectId> {
        let volume = props.single(PluginFamily::Volume)?;
        (self.tree.get(volume).plugin.value == "constvolume").then_some(volume)
    }

    /// A texture with the values of a volume at the surface.
    fn volume(&mut self, props: &Props<'_>) -> Option<TextureId> {
        let volume = self.props(self.constant_volume(props)?);
        volume.ignore(&["to_world", "id"]);
        let texture = match volume
            .get("value")
            .and_then(|p| self.nested_texture(&p.value))
        {
            Some(texture) => self.texture(texture),
            None => {
                let color = self.color(&volume, "value", 1.0, ColorUse::Coefficient);
                Some(self.constant_texture(color))
            }
        };
        volume.finish();
        texture
    }

    /// The texture with an attribute of the current shape: a texture that is nested in the shape
    /// under this name, or values of its mesh.
    pub(super) fn mesh_attribute(&mut self, props: &Props<'_>) -> Option<TextureId> {
        let name = if props.plugin().value == "vertexcolors" {
            self.require_v0(props, "use `mesh_attribute`");
            "vertex_color".to_owned()
        } else {
            let name = props.required_string("name")?;
            if !name.value.contains("vertex_") && !name.value.contains("face_") {
                let expected = "the name of an attribute, which starts with `vertex_` or `face_`";
                props.refuse_named("name", expected);
                return None;
            }
            name.value.clone()
        };
        let scale = props.float("scale", 1.0);
        let shape = self.current_shape?;
        let owner = self.tree.get(shape.object);
        let nested = owner.params.iter().find(|param| param.name.value == name);
        if let Some(Value::Object(nested)) = nested.map(|param| &param.value) {
            let texture = self.color_texture(*nested)?;
            return Some(self.scaled(texture, scale));
        }
        let Some(mesh) = shape.mesh else {
            let message = format!(
                "{} needs the attribute `{name}`, but {} is no mesh with attributes",
                props.describe(),
                self.props(shape.object).describe()
            );
            self.sink
                .error_at("scene::missing_attribute", props.span(), message);
            return None;
        };
        let texture = self
            .desc
            .add(Texture::VertexColors(VertexValues::default()));
        self.assets.add_attribute(AttributeRequest {
            shape: mesh,
            name,
            scale,
            texture,
            span: props.span(),
        });
        Some(texture)
    }
}

/// The transfer function of a bitmap.
fn transfer(props: &Props<'_>) -> Transfer {
    let raw = props.boolean("raw", false);
    let gamma = if props.is_v0() { gamma(props) } else { None };
    match gamma {
        _ if raw => Transfer::Raw,
        // In 0.x, -1 means the default of the file format.
        Some(gamma) if gamma <= 0.0 => Transfer::Auto,
        Some(1.0) => Transfer::Raw,
        Some(gamma) => Transfer::Gamma(gamma),
        None => Transfer::Auto,
    }
}

/// The parameter `gamma` of 0.x, a number or `srgb` (`None`).
fn gamma(props: &Props<'_>) -> Option<f32> {
    match &props.get("gamma")?.value {
        Value::String(name) if name.value.eq_ignore_ascii_case("srgb") => None,
        _ => props.maybe_float("gamma"),
    }
}

/// The parameter `to_uv` as a transform of (u, v, 1).
fn uv_transform(props: &Props<'_>) -> Mat3 {
    let matrix = props
        .transform("to_uv")
        .unwrap_or(DMat4::IDENTITY)
        .as_mat4();
    let column = |index: usize| Vec3::new(matrix.col(index).x, matrix.col(index).y, 0.0);
    Mat3::from_cols(column(0), column(1), column(3) + Vec3::Z)
}
