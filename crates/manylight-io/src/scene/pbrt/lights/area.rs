//! Emitting surfaces.

use super::super::super::assets::Decode;
use super::super::super::description::{Additions, bitmap, flip_v, set_image};
use super::super::super::parameters::{Numbers, Parameters};
use super::super::builder::Builder;
use super::super::entities::{Entity, ShapeEntity};
use crate::image::Transfer;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::geometry::Shape;
use manylight::ids::{EmitterId, ShapeId};
use manylight::image::Image;
use manylight::math::Affine3A;
use manylight::scene::SceneDesc;
use manylight::texture::{ColorInput, Filtering, Texture, Wrap};
use std::f32::consts::PI;

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
        geometry: ShapeId,
        world_from_object: &Affine3A,
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
        if let Some(power) = power.filter(|power| *power > 0.0) {
            let world = *world_from_object;
            let sides = if two_sided { 2.0 } else { 1.0 };
            self.after_loading(move |desc: &mut SceneDesc| {
                set_power(desc, emitter, geometry, &world, power / sides);
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

/// Scales the radiance of an emitter so that every element of the shape emits `power` in luminous
/// terms. PBRT's elements are triangles.
fn set_power(
    desc: &mut SceneDesc,
    emitter: EmitterId,
    geometry: ShapeId,
    world_from_object: &Affine3A,
    power: f32,
) {
    let shape = &desc.shapes[geometry.index()];
    let elements = match shape {
        Shape::Mesh(mesh) => mesh.triangles.len(),
        _ => 1,
    };
    let area = area_of(shape, world_from_object);
    let Emitter::Area { radiance } = &mut desc.emitters[emitter.index()] else {
        return;
    };
    match *radiance {
        ColorInput::Constant(color) if area > 0.0 && color.luminance() > 0.0 => {
            // PBRT scales the given spectrum of luminance 1; the luminance of a color remains a
            // factor.
            let factor = power * elements as f32 / (PI * area);
            *radiance = ColorInput::Constant(color * factor);
        }
        ColorInput::Texture(id) if area > 0.0 => {
            if let Texture::Bitmap(bitmap) = &mut desc.textures[id.index()] {
                let pixels = (bitmap.image.width * bitmap.image.height).max(1);
                let sum: f32 = (0..pixels)
                    .map(|i| {
                        let (x, y) = (i % bitmap.image.width, i / bitmap.image.width);
                        bitmap.image.rgb(x, y).luminance()
                    })
                    .sum();
                let mean = sum / pixels as f32;
                let factor = power / (PI * area * mean.max(f32::MIN_POSITIVE));
                bitmap.image.data.iter_mut().for_each(|v| *v *= factor);
            }
        }
        _ => {}
    }
}

/// Area of a shape in the world. Spheres and cylinders under a scale that changes angles use the
/// mean scale.
fn area_of(shape: &Shape, world_from_object: &Affine3A) -> f32 {
    let m = world_from_object.matrix3;
    let mean_scale = m.determinant().abs().cbrt();
    match shape {
        Shape::Mesh(mesh) => {
            let corner = |i: u32| world_from_object.transform_point3(mesh.positions[i as usize]);
            let areas = mesh.triangles.iter().map(|triangle| {
                let [a, b, c] = triangle.map(corner);
                f64::from(0.5 * (b - a).cross(c - a).length())
            });
            areas.sum::<f64>() as f32
        }
        Shape::Sphere { radius, .. } => 4.0 * PI * (radius * mean_scale).powi(2),
        Shape::Disk => PI * m.x_axis.cross(m.y_axis).length(),
        Shape::Cylinder { p0, p1, radius } => {
            let axis = world_from_object.transform_vector3(*p1 - *p0).length();
            2.0 * PI * radius * mean_scale * axis
        }
    }
}
