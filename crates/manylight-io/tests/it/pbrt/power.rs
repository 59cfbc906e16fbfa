//! The power of area lights: PBRT divides it by the areas of its shapes.

use super::load;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::math::Vec2;
use manylight::scene::SceneDesc;
use manylight::texture::{ColorInput, Texture};
use std::f32::consts::PI;

const LIGHT: &str = "AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ] \"float power\" 12 ";

fn radiance(desc: &SceneDesc) -> ColorInput {
    match desc.emitters.last() {
        Some(Emitter::Area { radiance }) => *radiance,
        other => panic!("{other:?}"),
    }
}

/// The radiance of the last light, which must be constant, times π and its area.
fn power(shape: &str, area: f32) -> f32 {
    let desc = load(&format!("{LIGHT}{shape}"));
    match radiance(&desc) {
        ColorInput::Constant(color) => color.r * PI * area,
        texture => panic!("{texture:?}"),
    }
}

#[test]
fn a_shape_emits_its_power_whatever_its_triangles() {
    for (shape, area) in [
        (
            "Shape \"sphere\" \"float radius\" 2 \"float zmin\" 0",
            8.0 * PI,
        ),
        ("Shape \"sphere\" \"float phimax\" 90", PI),
        (
            "Shape \"disk\" \"float radius\" 3 \"float innerradius\" 1",
            8.0 * PI,
        ),
        ("Shape \"disk\" \"float phimax\" 180", 0.5 * PI),
        (
            "Shape \"cylinder\" \"float zmax\" 2 \"float phimax\" 180",
            3.0 * PI,
        ),
        ("Shape \"disk\"", PI),
        ("Scale 2 2 2 Shape \"sphere\" \"float zmax\" 0", 8.0 * PI),
        (
            "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 3 0 0 0 1 0 1 1 0 ]",
            2.0,
        ),
    ] {
        let found = power(shape, area);
        assert!((found / 12.0 - 1.0).abs() < 2e-3, "{shape}: {found}");
    }
}

#[test]
fn elements_of_a_mesh_emit_the_same_power_each() {
    // Areas 1/2 and 2.
    let desc = load(&format!(
        "{LIGHT} Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 5 0 0 7 0 0 5 2 0 ] \"integer indices\" [ 0 1 2 3 4 5 ]"
    ));
    let ColorInput::Texture(id) = radiance(&desc) else {
        panic!("{:?}", radiance(&desc))
    };
    let Texture::VertexColors(colors) = &desc.textures[id.index()] else {
        panic!("{:?}", desc.textures)
    };
    let of = |triangle: usize| colors.values[colors.triangles[triangle][0] as usize].r;
    assert!((of(0) * PI * 0.5 - 12.0).abs() < 1e-3 && (of(1) * PI * 2.0 - 12.0).abs() < 1e-3);
    // A patch of two triangles and one of 128, of areas 1 and 2.
    let desc = load(&format!(
        "{LIGHT} Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 0 5 0 0 8 0 0 5 1 0 6 1 0 ]\n\
         \"integer indices\" [ 0 1 2 3 4 5 6 7 ]"
    ));
    let ColorInput::Texture(id) = radiance(&desc) else {
        panic!("{:?}", radiance(&desc))
    };
    let Texture::VertexColors(colors) = &desc.textures[id.index()] else {
        panic!("{:?}", desc.textures)
    };
    assert_eq!(colors.triangles.len(), 130);
    let of = |triangle: usize| colors.values[colors.triangles[triangle][0] as usize].r;
    assert!((of(1) * PI - 12.0).abs() < 1e-3 && (of(2) * 2.0 * PI - 12.0).abs() < 1e-2);
    assert_eq!(of(2), of(129));
}

#[test]
fn images_of_lights_have_the_power_in_their_mean() {
    let image: Vec<u8> = b"PF\n2 1\n-1\n"
        .iter()
        .copied()
        .chain(
            [1.0_f32, 1.0, 1.0, 3.0, 3.0, 3.0]
                .into_iter()
                .flat_map(f32::to_le_bytes),
        )
        .collect();
    let text = super::document(
        "AreaLightSource \"diffuse\" \"string filename\" \"l.pfm\" \"float power\" 12\n\
         Shape \"disk\" \"float radius\" 2",
    );
    let desc = super::PbrtFiles::new(text.as_bytes(), &[("l.pfm", &image)])
        .load()
        .desc;
    let found: Rgb = [0.25, 0.75]
        .iter()
        .map(|u| radiance(&desc).eval(Vec2::new(*u, 0.5), &desc.textures) * 0.5)
        .sum();
    assert!((found.r * PI * 4.0 * PI - 12.0).abs() < 0.02, "{found:?}");
    // The image follows PBRT's coordinates of a disk, which a mesh has.
    let shape = &desc.shapes[desc.primitives[0].shape.index()];
    assert!(matches!(shape, manylight::geometry::Shape::Mesh(_)));
}
