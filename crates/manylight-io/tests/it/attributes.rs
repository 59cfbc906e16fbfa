//! Attributes of meshes as textures, files of curves, and shapes made of others.

use crate::{Files, describe, document, load};
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::geometry::Shape;
use manylight::math::{Affine3A, Vec2};
use manylight::scene::SceneDesc;
use manylight::texture::{ColorInput, FloatInput, Texture, TexturePoint};
use manylight_io::{LoadOptions, check_scene};

/// Two triangles with a color and a number at each vertex, a color on each face, and integers.
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    property float r\nproperty float g\nproperty float b\nproperty float heat_x\nproperty ushort level_0\n\
    element face 2\nproperty list uchar int vertex_indices\nproperty float paint_r\nproperty float paint_g\n\
    property float paint_b\nend_header\n\
    -1 -1 0 1 0 0 0.1 65535\n1 -1 0 0 1 0 0.2 30000\n1 1 0 0 0 1 0.3 0\n-1 1 0 1 1 1 0.9 100\n\
    3 0 1 2 0.1 0.2 0.3\n3 0 2 3 0.4 0.5 0.6\n";

fn attribute(name: &str, parameter: &str) -> String {
    format!(
        "<texture type='mesh_attribute' name='{parameter}'><string name='name' value='{name}'/></texture>"
    )
}

fn mesh(content: &str) -> String {
    format!("<shape type='ply'><string name='filename' value='a.ply'/>{content}</shape>")
}

fn load_files(content: &str) -> SceneDesc {
    let files = Files::new(&document("3.0.0", content), &[("a.ply", PLY)]);
    let loaded = files.load();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.desc
}

fn problems_of_files(content: &str, others: &[(&str, &str)]) -> Vec<String> {
    let files = Files::new(&document("3.0.0", content), others);
    let found = check_scene(&files.scene(), &LoadOptions::default());
    found.iter().map(describe).collect()
}

/// The middle of an edge or a corner of a triangle.
fn place(element: u32, x: f32, y: f32) -> TexturePoint {
    TexturePoint {
        element,
        coordinates: Vec2::new(x, y),
        ..TexturePoint::default()
    }
}

/// The reflectance of the material of a primitive.
fn reflectance(desc: &SceneDesc, primitive: usize, at: TexturePoint) -> Rgb {
    let material = desc.primitives[primitive].material;
    match &desc.materials[material.index()] {
        Material::Diffuse { reflectance } => reflectance.eval(at, &desc.textures),
        other => panic!("{other:?}"),
    }
}

#[test]
fn attributes_of_vertices_are_interpolated_and_those_of_faces_are_not() {
    let colored = |name: &str| {
        mesh(&format!(
            "<bsdf type='diffuse'>{}</bsdf>",
            attribute(name, "reflectance")
        ))
    };
    let names = [
        "vertex_color",
        "vertex_heat",
        "face_paint_color",
        "vertex_level",
    ];
    let desc = load_files(&names.map(colored).concat());
    assert_eq!(
        reflectance(&desc, 0, place(0, 0.5, 0.0)),
        Rgb::new(0.5, 0.5, 0.0)
    );
    assert_eq!(reflectance(&desc, 0, place(1, 0.0, 1.0)), Rgb::WHITE);
    let heat = reflectance(&desc, 1, place(0, 0.0, 0.5));
    assert!((heat.r - 0.2).abs() < 1e-6 && heat.r == heat.b);
    let paint = reflectance(&desc, 2, place(1, 0.2, 0.7)).to_array();
    for (found, expected) in paint.into_iter().zip([0.4, 0.5, 0.6]) {
        assert!((found - expected).abs() < 1e-6, "{paint:?}");
    }
    // Integers are fractions with the sRGB transfer function, as in Mitsuba: 30000 / 65535.
    let level = reflectance(&desc, 3, place(0, 1.0, 0.0));
    assert!((level.g - 0.177).abs() < 1e-3, "{level:?}");
}

#[test]
fn every_shape_has_its_own_values_and_materials_are_shared_otherwise() {
    let shared = format!(
        "<bsdf type='diffuse' id='m'>{}</bsdf><bsdf type='diffuse' id='plain'/>",
        attribute("vertex_color", "reflectance")
    );
    let ball = "<shape type='sphere'><texture type='checkerboard' name='vertex_color'><rgb name='color0' value='0.9'/></texture><ref id='m'/></shape>";
    let desc = load_files(&format!(
        "{shared}{}{ball}{}{}",
        mesh("<ref id='m'/>"),
        mesh("<ref id='plain'/>"),
        mesh("<ref id='plain'/>")
    ));
    assert_eq!(
        reflectance(&desc, 0, place(0, 0.0, 0.0)),
        Rgb::new(1.0, 0.0, 0.0)
    );
    assert_eq!(reflectance(&desc, 1, place(0, 0.0, 0.0)), Rgb::splat(0.9));
    assert_ne!(desc.primitives[0].material, desc.primitives[1].material);
    assert_eq!(desc.primitives[2].material, desc.primitives[3].material);
}

#[test]
fn attributes_may_be_scaled_weigh_materials_and_emit() {
    let scaled = "<bsdf type='mask'><texture type='mesh_attribute' name='opacity'><string name='name' value='vertex_heat'/><float name='scale' value='2'/></texture><bsdf type='diffuse'/></bsdf>";
    let lamp = format!(
        "<emitter type='area'>{}</emitter>",
        attribute("face_paint_color", "radiance")
    );
    let desc = load_files(&(mesh(scaled) + &mesh(&lamp)));
    let Material::Mask { opacity, .. } = &desc.materials[desc.primitives[0].material.index()]
    else {
        panic!("expected a mask");
    };
    let FloatInput::Texture(texture) = *opacity else {
        panic!("expected a texture");
    };
    let value = desc.textures[texture.index()].eval_float(place(0, 1.0, 0.0), &desc.textures);
    assert!((value - 0.4).abs() < 1e-6);
    let emitter = desc.primitives[1].emitter.unwrap();
    let Emitter::Area {
        radiance: ColorInput::Texture(texture),
    } = desc.emitters[emitter.index()]
    else {
        panic!("expected a texture");
    };
    assert!(
        matches!(&desc.textures[texture.index()], Texture::VertexColors(v) if v.triangles[1] == [1; 3])
    );
}

#[test]
fn absent_attributes_are_errors_with_the_names_that_exist() {
    let bsdf = format!(
        "<bsdf type='diffuse'>{}</bsdf>",
        attribute("vertex_paint", "reflectance")
    );
    let found = problems_of_files(&mesh(&bsdf), &[("a.ply", PLY)]);
    assert_eq!(
        found,
        [
            "error 2:94 the mesh has no attribute `vertex_paint` (it has vertex_color, vertex_heat, vertex_level, face_paint_color)"
        ]
    );
    let ball = format!("<shape type='sphere'>{bsdf}</shape>");
    let found = problems_of_files(&ball, &[]);
    assert!(
        found[0].contains("but shape `sphere` is no mesh with attributes"),
        "{found:?}"
    );
    let wrong = format!(
        "<bsdf type='diffuse'>{}</bsdf>",
        attribute("color", "reflectance")
    );
    let found = problems_of_files(&mesh(&wrong), &[("a.ply", PLY)]);
    assert!(
        found[0].contains("which starts with `vertex_` or `face_`"),
        "{found:?}"
    );
}

#[test]
fn integer_colors_are_read_as_srgb_with_a_warning() {
    let bytes = PLY
        .replace("property float r\n", "property uchar red\n")
        .replace("property float g\n", "property uchar green\n")
        .replace("property float b\n", "property uchar blue\n")
        .replace("-1 -1 0 1 0 0", "-1 -1 0 188 0 255");
    let bsdf = format!(
        "<bsdf type='diffuse'>{}</bsdf>",
        attribute("vertex_color", "reflectance")
    );
    let files = Files::new(&document("3.0.0", &mesh(&bsdf)), &[("a.ply", &bytes)]);
    let loaded = files.load();
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    let color = reflectance(&loaded.desc, 0, place(0, 0.0, 0.0));
    assert!(
        (color.r - 0.503).abs() < 1e-3 && color.b == 1.0,
        "{color:?}"
    );
}

#[test]
fn curves_are_tubes_that_are_invisible_from_inside() {
    let curves = |kind: &str, file: &str| {
        format!(
            "<shape type='{kind}'><string name='filename' value='{file}'/><transform name='to_world'><scale value='3'/></transform><bsdf type='twosided'><bsdf type='diffuse'/></bsdf></shape>"
        )
    };
    let rod = "0 0 0 0.5\n0 0 1 0.5\n";
    let bow = "0 0 0 0.1\n0 1 0 0.1\n1 1 0 0.1\n1 0 0 0.1\n2 0 0 0.1\n";
    let content = curves("linearcurve", "rod.txt") + &curves("bsplinecurve", "bow.txt");
    let files = Files::new(
        &document("3.0.0", &content),
        &[("rod.txt", rod), ("bow.txt", bow)],
    );
    let desc = files.load().desc;
    for primitive in &desc.primitives {
        let Material::TwoSided { front, back } = desc.materials[primitive.material.index()] else {
            panic!("expected two sides");
        };
        assert!(matches!(
            desc.materials[front.index()],
            Material::Diffuse { .. }
        ));
        assert!(matches!(desc.materials[back.index()], Material::Null));
        // Radii do not grow with the transform.
        assert_eq!(primitive.world_from_object, Affine3A::IDENTITY);
    }
    let Shape::Mesh(mesh) = &desc.shapes[desc.primitives[0].shape.index()] else {
        panic!("expected a mesh");
    };
    let bounds = mesh.bounds();
    assert!((bounds.max.z - 3.5).abs() < 1e-5 && (bounds.max.x - 0.5).abs() < 0.01);

    let found = problems_of_files(&curves("bsplinecurve", "rod.txt"), &[("rod.txt", rod)]);
    assert!(
        found[0]
            .contains("rod.txt:3:1: a curve with 2 control points ends here, expected at least 4"),
        "{found:?}"
    );
    let found = problems_of_files(&curves("linearcurve", "no.txt"), &[]);
    assert!(
        found[0].contains("the file of curves `no.txt` does not exist"),
        "{found:?}"
    );
}

#[test]
fn merged_shapes_are_their_parts() {
    let merged = "<shape type='merge'><shape type='sphere'/><shape type='merge'><shape type='cube'/></shape></shape>";
    let desc = load(merged);
    assert_eq!(desc.primitives.len(), 2);
    let desc = load(&format!(
        "<shape type='shapegroup' id='g'><shape type='disk'/>{merged}</shape><shape type='instance'><ref id='g'/></shape>"
    ));
    assert_eq!(desc.groups[0].len(), 3);
    assert!(matches!(
        desc.shapes[desc.groups[0][0].shape.index()],
        Shape::Disk
    ));
}
