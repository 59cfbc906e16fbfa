//! Parts of the description of a scene that all formats make in the same way: additions to its
//! lists, textures that are made of others, films.

use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::film::{FilmDesc, Filter};
use manylight::geometry::Shape;
use manylight::ids::{EmitterId, MaterialId, ShapeId, TextureId};
use manylight::image::Image;
use manylight::math::{Mat3, UVec2, Vec3};
use manylight::scene::SceneDesc;
use manylight::texture::{Bitmap, ColorInput, Filtering, FloatInput, Texture, Wrap};

/// White, of every input that multiplies.
pub(super) const WHITE: ColorInput = ColorInput::Constant(Rgb::WHITE);

/// An item of a list of a description.
pub(super) trait Listed: Sized {
    /// Index in the list.
    type Id: From<usize>;

    fn list(desc: &mut SceneDesc) -> &mut Vec<Self>;
}

macro_rules! listed {
    ($($item:ident, $id:ident, $list:ident;)*) => {$(
        impl Listed for $item {
            type Id = $id;

            fn list(desc: &mut SceneDesc) -> &mut Vec<Self> {
                &mut desc.$list
            }
        }
    )*};
}

listed! {
    Material, MaterialId, materials;
    Emitter, EmitterId, emitters;
    Shape, ShapeId, shapes;
    Texture, TextureId, textures;
}

/// Additions to the lists of a description.
pub(super) trait Additions {
    /// Adds an item to its list.
    fn add<T: Listed>(&mut self, item: T) -> T::Id;
}

impl Additions for SceneDesc {
    fn add<T: Listed>(&mut self, item: T) -> T::Id {
        add(T::list(self), item)
    }
}

/// Adds an item to a list.
pub(super) fn add<T: Listed>(list: &mut Vec<T>, item: T) -> T::Id {
    list.push(item);
    T::Id::from(list.len() - 1)
}

/// Adds a material for both sides of a surface.
pub(super) fn add_two_sided(materials: &mut Vec<Material>, inner: MaterialId) -> MaterialId {
    let (front, back) = (inner, inner);
    add(materials, Material::TwoSided { front, back })
}

/// A bitmap without its image, which is read later.
pub(super) fn bitmap(filtering: Filtering, wrap: [Wrap; 2], uv_transform: Mat3) -> Texture {
    Texture::Bitmap(Bitmap {
        image: Image::default(),
        filtering,
        wrap,
        uv_transform,
    })
}

/// The transform of texture coordinates that turns v over: it points up in some formats, but down
/// in images.
pub(super) fn flip_v() -> Mat3 {
    Mat3::from_cols(Vec3::X, -Vec3::Y, Vec3::new(0.0, 1.0, 1.0))
}

/// Sets the image of a bitmap.
pub(super) fn set_image(textures: &mut [Texture], texture: TextureId, image: Image) {
    if let Texture::Bitmap(bitmap) = &mut textures[texture.index()] {
        bitmap.image = image;
    }
}

/// Sets the image of an environment.
pub(super) fn set_environment(desc: &mut SceneDesc, emitter: EmitterId, image: Image) {
    if let Emitter::Environment(environment) = &mut desc.emitters[emitter.index()] {
        environment.image = image;
    }
}

/// The radiance of a surface with this opacity. Opacity belongs to the surface: it scales what the
/// surface emits as it scales what it scatters; the rest of the light passes by the mask of its
/// material. Mitsuba alone has emitters of full radiance under masks.
pub(super) fn faded_radiance(
    textures: &mut Vec<Texture>,
    radiance: ColorInput,
    opacity: FloatInput,
) -> ColorInput {
    match (radiance, opacity) {
        (radiance, FloatInput::Constant(1.0)) => radiance,
        (ColorInput::Constant(color), FloatInput::Constant(opacity)) => {
            ColorInput::Constant(color * opacity.clamp(0.0, 1.0))
        }
        // A mixture takes a number as its weight; a product would take the color of the opacity.
        (radiance, opacity) => ColorInput::Texture(add(
            textures,
            Texture::Mix {
                first: ColorInput::Constant(Rgb::BLACK),
                second: radiance,
                weight: opacity,
            },
        )),
    }
}

/// A material of one of two surfaces that lie back to back and are the two sides of one: on its
/// back all light passes, so that a ray through both meets each opacity once.
pub(super) fn add_front_alone(materials: &mut Vec<Material>, front: MaterialId) -> MaterialId {
    let back = add(materials, Material::Null);
    add(materials, Material::TwoSided { front, back })
}

/// The product of two colors.
pub(super) fn product(
    textures: &mut Vec<Texture>,
    first: ColorInput,
    second: ColorInput,
) -> ColorInput {
    match (first, second) {
        (ColorInput::Constant(a), ColorInput::Constant(b)) => ColorInput::Constant(a * b),
        (WHITE, other) | (other, WHITE) => other,
        _ => ColorInput::Texture(add(textures, Texture::Product { first, second })),
    }
}

/// A color times a number.
pub(super) fn scaled(textures: &mut Vec<Texture>, color: ColorInput, factor: f32) -> ColorInput {
    product(textures, color, ColorInput::Constant(Rgb::splat(factor)))
}

/// A gray color as a number.
pub(super) fn as_float(color: ColorInput) -> FloatInput {
    match color {
        ColorInput::Constant(color) => FloatInput::Constant(color.r),
        ColorInput::Texture(id) => FloatInput::Texture(id),
    }
}

/// A number as a gray color.
pub(super) fn as_color(number: FloatInput) -> ColorInput {
    match number {
        FloatInput::Constant(value) => ColorInput::Constant(Rgb::splat(value)),
        FloatInput::Texture(id) => ColorInput::Texture(id),
    }
}

/// The axes of a transform, normalized.
pub(super) fn rotation(linear: Mat3) -> Mat3 {
    let axes = [linear.x_axis, linear.y_axis, linear.z_axis];
    let [x, y, z] = axes.map(Vec3::normalize_or_zero);
    Mat3::from_cols(x, y, z)
}

/// A film without a crop.
pub(super) fn film_of_size(size: UVec2, filter: Filter) -> FilmDesc {
    FilmDesc {
        size,
        crop_offset: UVec2::ZERO,
        crop_size: size,
        filter,
    }
}
