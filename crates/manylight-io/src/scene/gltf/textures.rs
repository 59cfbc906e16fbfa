//! Textures: images with samplers and transforms, their combination with factors and vertex
//! attributes, and what they need of the vertices.

use super::super::description::{WHITE, add, as_float, bitmap, faded_radiance, product};
use super::super::parameters::Numbers;
use super::document::Document;
use super::images::{Content, ImageUses};
use super::json::Json;
use manylight::bsdf::Bitangent;
use manylight::color::Rgb;
use manylight::ids::TextureId;
use manylight::math::{Mat3, Vec2, Vec3};
use manylight::texture::{ColorInput, Filtering, FloatInput, Texture, VertexValues, Wrap};
use std::collections::HashMap;

/// The vertex attributes of a primitive that textures need.
pub(super) struct VertexInputs<'m> {
    pub(super) triangles: &'m [[u32; 3]],
    /// The set of texture coordinates that is that of the mesh.
    pub(super) primary: usize,
    /// The other sets.
    pub(super) uvs: &'m [(usize, Vec<Vec2>)],
    /// Colors of the vertices, linear, with opacity; may be empty.
    pub(super) colors: &'m [[f32; 4]],
    /// From the space of the mesh to the world.
    pub(super) scale: f32,
    /// Whether the primitive is the whole surface of a body, if its material absorbs light within.
    pub(super) is_body: bool,
    pub(super) bitangents: &'m Bitangents,
}

/// The sides to which the second component of normal textures points.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Bitangents {
    /// Against v.
    ByTextureCoordinates,
    /// n x t times this sign.
    OneSign(f32),
    /// n x t times the signs of the vertices.
    Signs(Vec<f32>),
}

/// All textures of a scene.
#[derive(Default)]
pub(super) struct Textures {
    pub(super) list: Vec<Texture>,
    pub(super) images: ImageUses,
    /// Images, and their transforms, by what they are made of.
    bitmaps: HashMap<String, TextureId>,
}

/// The set of texture coordinates of a reference to a texture.
pub(super) fn uv_set(info: &Json<'_>) -> usize {
    let transform = info.extension("KHR_texture_transform");
    let overriding = transform.and_then(|transform| transform.unsigned("texCoord"));
    let set = overriding.or_else(|| info.unsigned("texCoord"));
    set.map_or(0, |set| set.min(u64::from(u8::MAX)) as usize)
}

impl Textures {
    /// The texture to which `info` refers. `None` if it is invalid or not supported, which has been
    /// reported.
    pub(super) fn bitmap(
        &mut self,
        document: &Document<'_>,
        info: &Json<'_>,
        content: Content,
        vertices: &VertexInputs<'_>,
    ) -> Option<TextureId> {
        info.check_given("index")?;
        let index = info.index("index", "textures", document.textures.len())?;
        let texture = &document.textures[index];
        let image = image_of(texture, document)?;
        let (filtering, wrap) = sampler(texture, document)?;
        let key = format!("{image} {content:?} {filtering:?} {wrap:?}");
        let id = match self.bitmaps.get(&key) {
            Some(id) => *id,
            None => {
                let id = add(&mut self.list, bitmap(filtering, wrap, Mat3::IDENTITY));
                self.images.add(image, content, id);
                self.bitmaps.insert(key, id);
                id
            }
        };
        let id = self.transformed(id, uv_transform(info));
        Some(self.at_set(id, info, vertices))
    }

    /// The texture `inner` at transformed coordinates. All transforms of an image share its pixels.
    fn transformed(&mut self, inner: TextureId, uv_transform: Mat3) -> TextureId {
        if uv_transform == Mat3::IDENTITY {
            return inner;
        }
        let key = format!("{inner:?} {uv_transform:?}");
        let textures = &mut self.list;
        *self.bitmaps.entry(key).or_insert_with(|| {
            let transformed = Texture::Transformed {
                uv_transform,
                inner,
            };
            add(textures, transformed)
        })
    }

    /// The texture `id` at the set of texture coordinates that `info` names.
    fn at_set(&mut self, id: TextureId, info: &Json<'_>, vertices: &VertexInputs<'_>) -> TextureId {
        let set = uv_set(info);
        if set == vertices.primary {
            return id;
        }
        let Some((_, uvs)) = vertices.uvs.iter().find(|(other, _)| *other == set) else {
            return id;
        };
        let uvs = VertexValues {
            triangles: vertices.triangles.to_vec(),
            values: uvs.clone(),
        };
        add(&mut self.list, Texture::OtherUv { uvs, inner: id })
    }

    /// The color of the vertices; `None` if they have none.
    pub(super) fn vertex_color(&mut self, vertices: &VertexInputs<'_>) -> Option<ColorInput> {
        let color = |c: &[f32; 4]| Rgb::new(c[0], c[1], c[2]);
        self.vertex_values(vertices, color)
    }

    /// The opacity of the vertices; `None` if they have none.
    pub(super) fn vertex_opacity(&mut self, vertices: &VertexInputs<'_>) -> Option<ColorInput> {
        self.vertex_values(vertices, |c| Rgb::splat(c[3]))
    }

    /// A value of each vertex color, unless all are white.
    fn vertex_values(
        &mut self,
        vertices: &VertexInputs<'_>,
        value: impl Fn(&[f32; 4]) -> Rgb,
    ) -> Option<ColorInput> {
        let values: Vec<Rgb> = vertices.colors.iter().map(value).collect();
        if values.iter().all(|value| *value == Rgb::WHITE) {
            return None;
        }
        let triangles = vertices.triangles.to_vec();
        let colors = Texture::VertexColors(VertexValues { triangles, values });
        Some(ColorInput::Texture(add(&mut self.list, colors)))
    }

    /// The bitangent of the normal textures of a primitive.
    pub(super) fn bitangent(&mut self, vertices: &VertexInputs<'_>) -> Bitangent {
        let signs = match vertices.bitangents {
            Bitangents::ByTextureCoordinates => return Bitangent::AgainstV,
            Bitangents::OneSign(sign) => return Bitangent::Signed(FloatInput::Constant(*sign)),
            Bitangents::Signs(signs) => signs,
        };
        let signs = Texture::VertexColors(VertexValues {
            triangles: vertices.triangles.to_vec(),
            values: signs.iter().map(|sign| Rgb::splat(*sign)).collect(),
        });
        Bitangent::Signed(FloatInput::Texture(add(&mut self.list, signs)))
    }

    /// The product of two colors.
    pub(super) fn product(&mut self, first: ColorInput, second: ColorInput) -> ColorInput {
        product(&mut self.list, first, second)
    }

    /// The radiance of a surface with this opacity.
    pub(super) fn faded_radiance(
        &mut self,
        radiance: ColorInput,
        opacity: FloatInput,
    ) -> ColorInput {
        faded_radiance(&mut self.list, radiance, opacity)
    }

    /// 1 where `value` is at least `threshold`, else 0.
    pub(super) fn step(&mut self, value: ColorInput, threshold: f32) -> ColorInput {
        let value = match value {
            ColorInput::Constant(color) => {
                let is_visible = color.r >= threshold;
                return if is_visible {
                    WHITE
                } else {
                    ColorInput::Constant(Rgb::BLACK)
                };
            }
            ColorInput::Texture(base) => Texture::Step {
                base,
                threshold: threshold * MIN_PART,
            },
        };
        ColorInput::Texture(add(&mut self.list, value))
    }

    /// `first` with weight 1 - `weight`, `second` with weight `weight`.
    pub(super) fn mix(
        &mut self,
        first: ColorInput,
        second: ColorInput,
        weight: FloatInput,
    ) -> ColorInput {
        let mix = Texture::Mix {
            first,
            second,
            weight,
        };
        ColorInput::Texture(add(&mut self.list, mix))
    }

    /// One minus a number.
    pub(super) fn one_minus(&mut self, number: FloatInput) -> FloatInput {
        match number {
            FloatInput::Constant(value) => FloatInput::Constant(1.0 - value),
            textured => as_float(self.mix(WHITE, ColorInput::Constant(Rgb::BLACK), textured)),
        }
    }

    /// A power of a number.
    pub(super) fn power(&mut self, number: FloatInput, exponent: f32) -> FloatInput {
        match number {
            FloatInput::Constant(value) => FloatInput::Constant(value.powf(exponent)),
            FloatInput::Texture(base) => {
                FloatInput::Texture(add(&mut self.list, Texture::Power { base, exponent }))
            }
        }
    }

    /// A number times a texture, if there is one.
    pub(super) fn scaled(&mut self, factor: f32, texture: Option<TextureId>) -> FloatInput {
        let Some(id) = texture else {
            return FloatInput::Constant(factor);
        };
        let factor = ColorInput::Constant(Rgb::splat(factor));
        as_float(self.product(factor, ColorInput::Texture(id)))
    }
}

/// Extensions with images in formats that are not read.
const OTHER_FORMATS: [(&str, &str); 3] = [
    ("KHR_texture_basisu", "Basis Universal"),
    ("EXT_texture_avif", "AVIF"),
    ("MSFT_texture_dds", "DDS"),
];

/// The index of the image of a texture.
fn image_of(texture: &Json<'_>, document: &Document<'_>) -> Option<usize> {
    if let Some(source) = texture.get("source") {
        // The image for programs that do not read the other format.
        return source.as_index("images", document.images.len());
    }
    if let Some(webp) = texture.extension("EXT_texture_webp") {
        webp.check_given("source")?;
        return webp.index("source", "images", document.images.len());
    }
    let other = OTHER_FORMATS
        .iter()
        .find(|(name, _)| texture.extension(name).is_some());
    match other {
        Some((name, format)) => {
            let converting = match *name {
                "KHR_texture_basisu" => {
                    ", or convert them by `gltf-transform ktxdecompress IN OUT`"
                }
                _ => "",
            };
            texture.reporter().error_once(
                name,
                texture.path(),
                &format!("the texture has a {format} image alone (extension `{name}`), which is not supported"),
                format!("export textures as PNG, JPEG or WebP, or with such a fallback{converting}"),
            );
        }
        None => texture.error("the texture has no image: the property `source` is missing"),
    }
    None
}

/// Filter, and continuation along u and v.
fn sampler(texture: &Json<'_>, document: &Document<'_>) -> Option<(Filtering, [Wrap; 2])> {
    let default = (Filtering::Bilinear, [Wrap::Repeat; 2]);
    let Some(index) = texture.get("sampler") else {
        return Some(default);
    };
    let sampler = &document.samplers[index.as_index("samplers", document.samplers.len())?];
    // Which texels a pixel sees is a matter of sampling, so only magnification matters.
    let filtering = match sampler.unsigned("magFilter") {
        None | Some(9729) => Filtering::Bilinear,
        Some(9728) => Filtering::Nearest,
        Some(other) => {
            sampler.unexpected("magFilter", other, "9728 (nearest) or 9729 (linear)");
            return None;
        }
    };
    let wrap = |name: &str| match sampler.unsigned(name) {
        None | Some(10497) => Some(Wrap::Repeat),
        Some(33071) => Some(Wrap::Clamp),
        Some(33648) => Some(Wrap::Mirror),
        Some(other) => {
            let expected = "33071 (clamp), 33648 (mirror) or 10497 (repeat)";
            sampler.unexpected(name, other, expected);
            None
        }
    };
    Some((filtering, [wrap("wrapS")?, wrap("wrapT")?]))
}

/// The transform of (u, v, 1) by the extension KHR_texture_transform.
fn uv_transform(info: &Json<'_>) -> Mat3 {
    let Some(json) = info.extension("KHR_texture_transform") else {
        return Mat3::IDENTITY;
    };
    let [x, y] = json.floats("offset", [0.0; 2]);
    let [width, height] = json.floats("scale", [1.0; 2]);
    let (sin, cos) = json.float("rotation", 0.0).sin_cos();
    Mat3::from_cols(
        Vec3::new(cos, -sin, 0.0) * width,
        Vec3::new(sin, cos, 0.0) * height,
        Vec3::new(x, y, 1.0),
    )
}

/// Part of a cutoff that counts as the whole: interpolation between equal texels rounds. Texels of
/// 16 bits differ by more.
const MIN_PART: f32 = 1.0 - 1e-6;

/// What a material needs of the vertices of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct VertexNeeds {
    /// Sets of texture coordinates; the first is the primary one, along which tangents are defined.
    pub(super) sets: Vec<usize>,
    /// Whether the directions of the tangents matter.
    pub(super) tangents: bool,
    /// Whether it matters if the primitive is closed.
    pub(super) body: bool,
}

/// All references to textures within a material.
fn texture_infos<'a>(json: &Json<'a>, found: &mut Vec<Json<'a>>) {
    for (name, member) in json.members() {
        if name.ends_with("Texture") {
            found.push(member);
        } else if name != "extras" {
            texture_infos(&member, found);
        }
    }
}

/// What the material of this index needs of the vertices.
pub(super) fn vertex_needs(document: &Document<'_>, index: Option<usize>) -> VertexNeeds {
    let Some(json) = index.map(|index| &document.materials[index]) else {
        return VertexNeeds::default();
    };
    let mut infos = Vec::new();
    texture_infos(json, &mut infos);
    infos.retain(|info| !info.path().ends_with("/occlusionTexture"));
    let rank = |info: &Json<'_>| match info.path().rsplit('/').next() {
        Some("normalTexture") => 0,
        Some("clearcoatNormalTexture") => 1,
        Some("baseColorTexture" | "diffuseTexture") => 2,
        _ => 3,
    };
    infos.sort_by_key(rank);
    let mut sets = Vec::new();
    for set in infos.iter().map(uv_set) {
        if !sets.contains(&set) {
            sets.push(set);
        }
    }
    let is_normal = |info: &Json<'_>| {
        let name = info.path().rsplit('/').next();
        matches!(name, Some("normalTexture" | "clearcoatNormalTexture"))
    };
    let tangents =
        infos.iter().any(is_normal) || json.extension("KHR_materials_anisotropy").is_some();
    VertexNeeds {
        sets,
        tangents,
        body: json.extension("KHR_materials_volume").is_some(),
    }
}
