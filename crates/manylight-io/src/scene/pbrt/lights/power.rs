//! The radiance of area lights that are given by their power.
//!
//! PBRT v4 divides `power` by π times the area of the shape. Every shape of a mesh emits it: a
//! triangle of a triangle mesh, a patch of a bilinear mesh.

use super::super::super::description::{Additions, product};
use super::super::elements::Elements;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::geometry::{Mesh, Shape};
use manylight::ids::{EmitterId, ShapeId};
use manylight::math::Affine3A;
use manylight::scene::SceneDesc;
use manylight::texture::{ColorInput, Texture, VertexValues};
use std::f32::consts::PI;

/// Relative difference of the radiances of elements up to which they count as equal: rounding.
const EQUAL: f32 = 1e-4;

/// The surface of an area light.
#[derive(Debug)]
pub(in super::super) struct EmittingSurface {
    pub(in super::super) shape: ShapeId,
    pub(in super::super) world_from_object: Affine3A,
    pub(in super::super) elements: Elements,
}

impl EmittingSurface {
    /// Scales the radiance of `emitter` so that every element emits `power` in luminous terms.
    pub(super) fn set_power(&self, desc: &mut SceneDesc, emitter: EmitterId, power: f32) {
        let Emitter::Area { radiance } = desc.emitters[emitter.index()] else {
            return;
        };
        // PBRT scales a spectrum of luminance 1, while the luminance of a color remains a factor;
        // that of an image does not.
        let power = match radiance {
            ColorInput::Constant(_) => power,
            ColorInput::Texture(id) => power / mean_luminance(&desc.textures[id.index()]),
        };
        let factor = match &desc.shapes[self.shape.index()] {
            Shape::Mesh(mesh) => match self.mesh_factors(mesh, power) {
                Factors::One(factor) => ColorInput::Constant(Rgb::splat(factor)),
                Factors::Each(values) => ColorInput::Texture(desc.add(values)),
            },
            shape => {
                let area = area_of(shape, &self.world_from_object);
                ColorInput::Constant(Rgb::splat(radiance_of(power, area)))
            }
        };
        let scaled = product(&mut desc.textures, radiance, factor);
        if let Emitter::Area { radiance } = &mut desc.emitters[emitter.index()] {
            *radiance = scaled;
        }
    }

    /// The factors of the radiance of the elements of a mesh.
    fn mesh_factors(&self, mesh: &Mesh, power: f32) -> Factors {
        let corner = |i: u32| {
            let p = mesh.positions[i as usize];
            self.world_from_object.transform_point3(p)
        };
        let areas: Vec<f32> = mesh
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(corner);
                0.5 * (b - a).cross(c - a).length()
            })
            .collect();
        let runs = self.runs(areas.len());
        let mut factors = Vec::with_capacity(areas.len());
        let mut rest = areas.as_slice();
        for run in runs.iter().copied() {
            let (of_run, others) = rest.split_at(run.min(rest.len()));
            rest = others;
            let area = of_run.iter().copied().map(f64::from).sum::<f64>() as f32;
            let factor = radiance_of(power * self.power_of_run(), area);
            factors.extend(std::iter::repeat_n(factor, of_run.len()));
        }
        // Triangles without an area do not emit.
        let emitting = factors.iter().copied().filter(|factor| *factor > 0.0);
        let (least, most) = emitting.fold((f32::INFINITY, 0.0_f32), |(least, most), factor| {
            (least.min(factor), most.max(factor))
        });
        if most <= least * (1.0 + EQUAL) {
            return Factors::One(most);
        }
        let count = factors.len() as u32;
        Factors::Each(Texture::VertexColors(VertexValues {
            triangles: (0..count).map(|i| [i; 3]).collect(),
            values: factors.into_iter().map(Rgb::splat).collect(),
        }))
    }

    /// The numbers of successive triangles of the elements.
    fn runs(&self, triangles: usize) -> Vec<usize> {
        match &self.elements {
            Elements::Whole => vec![triangles],
            Elements::Triangles => vec![1; triangles],
            Elements::Runs(runs) => runs.iter().map(|run| *run as usize).collect(),
            Elements::Equal { triangles: run, .. } => vec![*run; triangles.div_ceil((*run).max(1))],
        }
    }

    /// The factor of the power of each element.
    fn power_of_run(&self) -> f32 {
        match self.elements {
            Elements::Equal { power, .. } => power,
            _ => 1.0,
        }
    }
}

/// Factors of the radiance of the triangles of a mesh.
enum Factors {
    One(f32),
    Each(Texture),
}

/// The radiance of a Lambertian emitter; 0 without an area.
fn radiance_of(power: f32, area: f32) -> f32 {
    if area > 0.0 { power / (PI * area) } else { 0.0 }
}

/// Mean luminance of the pixels of an image.
fn mean_luminance(texture: &Texture) -> f32 {
    let Texture::Bitmap(bitmap) = texture else {
        return 1.0;
    };
    let image = &bitmap.image;
    let pixels = (image.width * image.height).max(1);
    let luminance = |i: usize| image.rgb(i % image.width, i / image.width).luminance();
    let sum: f64 = (0..pixels).map(|i| f64::from(luminance(i))).sum();
    ((sum / pixels as f64) as f32).max(f32::MIN_POSITIVE)
}

/// Area of a shape without triangles in the world. Spheres and cylinders under a scale that changes
/// angles use the mean scale.
fn area_of(shape: &Shape, world_from_object: &Affine3A) -> f32 {
    let m = world_from_object.matrix3;
    let mean_scale = m.determinant().abs().cbrt();
    match shape {
        Shape::Mesh(_) => 0.0,
        Shape::Sphere { radius, .. } => 4.0 * PI * (radius * mean_scale).powi(2),
        Shape::Disk => PI * m.x_axis.cross(m.y_axis).length(),
        Shape::Cylinder { p0, p1, radius } => {
            let axis = world_from_object.transform_vector3(*p1 - *p0).length();
            2.0 * PI * radius * mean_scale * axis
        }
    }
}
