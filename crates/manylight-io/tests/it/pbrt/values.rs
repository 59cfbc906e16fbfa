//! Transforms, cameras, film, shapes, lights, textures and included files.

use super::{PbrtFiles, document, load, load_file, loaded, warnings};
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::film::Filter;
use manylight::geometry::{Mesh, Shape};
use manylight::math::{UVec2, Vec2, Vec3};
use manylight::scene::SceneDesc;
use manylight::sensors::{FovAxis, SensorKind};
use manylight::texture::{ColorInput, Texture, Wrap};
use std::f32::consts::PI;

fn mesh(desc: &SceneDesc, primitive: usize) -> &Mesh {
    match &desc.shapes[desc.primitives[primitive].shape.index()] {
        Shape::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

fn place(desc: &SceneDesc, primitive: usize, p: Vec3) -> Vec3 {
    desc.primitives[primitive]
        .world_from_object
        .transform_point3(p)
}

#[test]
fn transforms_apply_to_what_follows_them() {
    let desc = load(
        "AttributeBegin Translate 1 0 0 Scale 2 2 2 Rotate 90 0 0 1\n\
         CoordinateSystem \"here\" Shape \"disk\"\n\
         TransformBegin Identity Shape \"disk\" TransformEnd Shape \"disk\" AttributeEnd\n\
         Shape \"disk\" CoordSysTransform \"here\" ConcatTransform [ 1 0 0 0 0 1 0 0 0 0 1 0 3 0 0 1 ] Shape \"disk\"\n\
         Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 0 0 7 1 ] Shape \"disk\"",
    );
    let x = |i| place(&desc, i, Vec3::X);
    let expected = [
        Vec3::new(1.0, 2.0, 0.0),
        Vec3::X,
        Vec3::new(1.0, 2.0, 0.0),
        Vec3::X,
        Vec3::new(1.0, 8.0, 0.0),
        Vec3::new(1.0, 0.0, 7.0),
    ];
    for (i, expected) in expected.into_iter().enumerate() {
        assert!(x(i).abs_diff_eq(expected, 1e-5), "{i}: {}", x(i));
    }
}

#[test]
fn the_camera_looks_along_z_with_x_to_the_right() {
    let desc = load_file(
        "LookAt 1 2 3  1 2 13  0 2 0\n\
         Camera \"perspective\" \"float fov\" 30 \"float lensradius\" 0.1 \"float focaldistance\" 7\n\
         Film \"rgb\" \"integer xresolution\" 20 \"integer yresolution\" 10 \"float cropwindow\" [ .25 .75 0 1 ]\n\
         PixelFilter \"triangle\" \"float xradius\" 1.5 \"float yradius\" 1.5\n\
         Sampler \"halton\" Integrator \"volpath\" \"integer maxdepth\" 7\n\
         WorldBegin LightSource \"point\"",
    );
    let sensor = &desc.sensors[0];
    let m = sensor.world_from_camera;
    assert!(
        m.transform_point3(Vec3::ZERO)
            .abs_diff_eq(Vec3::new(1.0, 2.0, 3.0), 1e-6)
    );
    assert!(m.transform_vector3(Vec3::Z).abs_diff_eq(Vec3::Z, 1e-6));
    // Our camera frame has x to the left.
    assert!(m.transform_vector3(Vec3::X).abs_diff_eq(Vec3::NEG_X, 1e-6));
    let kind = SensorKind::ThinLens {
        fov: 30.0,
        fov_axis: FovAxis::Smaller,
        aperture_radius: 0.1,
        focus_distance: 7.0,
    };
    assert_eq!(sensor.kind, kind);
    let film = &sensor.film;
    assert_eq!(
        (film.size, film.crop_offset, film.crop_size),
        (UVec2::new(20, 10), UVec2::new(5, 0), UVec2::new(10, 10))
    );
    assert_eq!(film.filter, Filter::Tent { radius: 1.5 });
    // Seven scattering events are eight segments.
    assert_eq!(desc.limits.max_depth, Some(8));
}

#[test]
fn other_radii_of_filters_of_a_fixed_radius_are_reported() {
    let found = |filter: &str| {
        let text =
            format!("Camera \"perspective\" PixelFilter {filter} WorldBegin LightSource \"point\"");
        PbrtFiles::new(text.as_bytes(), &[]).problems()
    };
    for (filter, message) in [
        ("\"mitchell\"", None),
        ("\"sinc\"", None),
        ("\"mitchell\" \"float xradius\" 2 \"float yradius\" 2", None),
        ("\"sinc\" \"float xradius\" 3 \"float yradius\" 3", None),
        (
            "\"mitchell\" \"float xradius\" 3 \"float yradius\" 3",
            Some("warning 1:34 filter `mitchell` has the radius 2 here, not 3"),
        ),
        (
            "\"sinc\" \"float xradius\" 4 \"float yradius\" 4",
            Some("warning 1:34 filter `sinc` has the radius 3 here, not 4"),
        ),
    ] {
        let expected: Vec<&str> = message.into_iter().collect();
        assert_eq!(found(filter), expected, "{filter}");
    }
}

#[test]
fn screen_windows_shift_and_scale_the_film() {
    let desc = load_file(
        "Camera \"perspective\" \"float fov\" 90 \"float screenwindow\" [ 0 2 -1 1 ]\n\
         Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
         WorldBegin LightSource \"point\"",
    );
    let sensor = &desc.sensors[0];
    assert_eq!(sensor.principal_point_offset, Vec2::new(0.5, 0.0));
    let SensorKind::Perspective { fov, fov_axis } = sensor.kind else {
        panic!("{:?}", sensor.kind)
    };
    assert_eq!(fov_axis, FovAxis::X);
    assert!((fov - 90.0).abs() < 1e-4);
    let resolved = manylight::sensors::Sensor::new(sensor.clone());
    // The left edge of the film is the axis of the camera; the right edge is at tan 63.4° = 2.
    let direction = |x| resolved.ray(Vec2::new(x, 4.0), Vec2::ZERO).d;
    assert!(
        direction(0.0).abs_diff_eq(Vec3::Z, 1e-5),
        "{}",
        direction(0.0)
    );
    let right = direction(8.0);
    assert!((right.x / right.z - 2.0).abs() < 1e-4, "{right}");
}

#[test]
fn the_exposure_of_the_film_scales_emission() {
    let desc = load_file(
        "Camera \"perspective\" \"float shutteropen\" 0 \"float shutterclose\" 0.5\n\
         Film \"rgb\" \"float iso\" 400 \"string sensor\" \"cie1931\" \"float diagonal\" 35\n\
         WorldBegin LightSource \"point\" \"rgb I\" [ 1 2 3 ] \"float scale\" 10",
    );
    match &desc.emitters[0] {
        Emitter::Point { intensity, .. } => assert_eq!(*intensity, Rgb::new(20.0, 40.0, 60.0)),
        other => panic!("{other:?}"),
    }
}

#[test]
fn lights_have_the_powers_of_pbrt_v4() {
    let desc = load(
        "LightSource \"point\" \"blackbody I\" 3000 \"float power\" 100 \"point3 from\" [ 1 2 3 ]\n\
         LightSource \"spot\" \"rgb I\" [ 1 1 1 ] \"float power\" 5 \"float coneangle\" 60 \"float conedeltaangle\" 0\n\
         LightSource \"distant\" \"float illuminance\" 3 \"point3 from\" [ 0 0 5 ] \"point3 to\" [ 0 0 0 ]\n\
         LightSource \"infinite\" \"spectrum L\" [ 400 5 700 5 ] \"float illuminance\" 2\n\
         AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ] \"float power\" 6\n\
         Scale 2 2 2 Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]",
    );
    let [_, point, spot, distant, infinite, area] = &desc.emitters[..] else {
        panic!("{:?}", desc.emitters)
    };
    let near = |a: f32, b: f32| assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
    match point {
        Emitter::Point {
            intensity,
            position,
        } => {
            near(intensity.luminance(), 100.0 / (4.0 * PI));
            assert!(intensity.r > intensity.b);
            assert_eq!(*position, Vec3::new(1.0, 2.0, 3.0));
        }
        other => panic!("{other:?}"),
    }
    match spot {
        Emitter::Spot { intensity, .. } => near(intensity.luminance(), 5.0 / PI),
        other => panic!("{other:?}"),
    }
    match distant {
        Emitter::Directional {
            direction,
            irradiance,
        } => {
            near(irradiance.luminance(), 3.0);
            assert_eq!(*direction, Vec3::NEG_Z);
        }
        other => panic!("{other:?}"),
    }
    match infinite {
        Emitter::Constant { radiance } => near(radiance.luminance(), 2.0 / PI),
        other => panic!("{other:?}"),
    }
    match area {
        Emitter::Area {
            radiance: ColorInput::Constant(radiance),
        } => near(radiance.luminance(), 6.0 / (PI * 2.0)),
        other => panic!("{other:?}"),
    }
}

#[test]
fn both_sides_of_two_sided_lights_emit() {
    let desc = load(
        "AreaLightSource \"diffuse\" \"bool twosided\" true \"float scale\" 3\n\
         Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] Shape \"disk\" Shape \"sphere\"",
    );
    // The inside of the sphere is not visible.
    assert_eq!(desc.primitives.len(), 5);
    let [front, back] = [0, 1].map(|i| &desc.primitives[i]);
    assert_eq!(front.emitter, back.emitter);
    assert_ne!(front.flip_normals, back.flip_normals);
    let below = mesh(&desc, 1).positions[1];
    assert!(below.z < 0.0 && below.abs_diff_eq(Vec3::X, 1e-4), "{below}");
    let below = place(&desc, 3, Vec3::ZERO);
    assert!(below.z < 0.0 && below.z > -1e-4, "{below}");
}

#[test]
fn normals_have_the_orientation_of_pbrt() {
    let triangle = "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]";
    let with_normals = format!("{triangle} \"normal N\" [ 0 0 -1 0 0 -1 0 0 -1 ]");
    let desc = load(&format!(
        "{triangle} {with_normals} Scale -1 1 1 {triangle} {with_normals} ReverseOrientation {triangle}"
    ));
    // World-space geometric normals, by the winding and the flag.
    let normals = [1.0, -1.0, 1.0, -1.0, -1.0];
    for (i, expected) in normals.into_iter().enumerate() {
        let [a, b, c] = mesh(&desc, i).triangles[0]
            .map(|v| place(&desc, i, mesh(&desc, i).positions[v as usize]));
        let side = if desc.primitives[i].flip_normals {
            -1.0
        } else {
            1.0
        };
        assert_eq!((b - a).cross(c - a).z.signum() * side, expected, "{i}");
    }
}

#[test]
fn spheres_face_outwards_and_have_v_along_z() {
    let source = document("Scale -1 1 1 Shape \"sphere\" \"float radius\" 2");
    let desc = PbrtFiles::new(source.as_bytes(), &[]).load().desc;
    for source in ["Shape \"sphere\"", "Scale -1 1 1 Shape \"sphere\""] {
        let scene = manylight::scene::Scene::build(load(source), 0).unwrap();
        let ray = manylight::geometry::Ray::new(Vec3::new(0.0, -5.0, 0.5), Vec3::Y);
        let hit = scene.geometry.intersect(&ray).unwrap();
        let point = scene.geometry.surface_point(hit.at);
        assert!(point.ng.y < -0.5, "{source}: {}", point.ng);
        assert!(
            point.uv.y > 0.6 && point.uv.y < 0.7,
            "{source}: {}",
            point.uv
        );
    }
    assert_eq!(desc.primitives.len(), 1);
}

#[test]
fn parts_of_quadrics_are_tessellated() {
    let desc = load(
        "Shape \"sphere\" \"float zmax\" 0 Shape \"cylinder\" \"float phimax\" 90 Shape \"disk\" \"float innerradius\" 0.5\n\
         Shape \"cylinder\" \"float radius\" 0.5 Shape \"cone\" Shape \"paraboloid\" Shape \"hyperboloid\"",
    );
    let lowest = mesh(&desc, 0)
        .positions
        .iter()
        .fold(f32::MIN, |a, p| a.max(p.z));
    assert!(lowest < 1e-6);
    assert!(
        mesh(&desc, 1)
            .positions
            .iter()
            .all(|p| p.x > -1e-6 && p.y > -1e-6)
    );
    assert!(
        mesh(&desc, 2)
            .positions
            .iter()
            .all(|p| p.truncate().length() > 0.499)
    );
    assert!(matches!(
        desc.shapes[desc.primitives[3].shape.index()],
        Shape::Cylinder { radius: 0.5, .. }
    ));
    // Outward normals agree with the winding.
    for i in [0, 1, 4, 5] {
        let mesh = mesh(&desc, i);
        let [a, b, c] = mesh.triangles[mesh.triangles.len() / 2].map(|v| v as usize);
        let p = &mesh.positions;
        assert!(
            (p[b] - p[a]).cross(p[c] - p[a]).dot(mesh.normals[a]) > 0.0,
            "{i}"
        );
    }
}

#[test]
fn patches_and_height_fields_are_meshes() {
    let desc = load(
        "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 0 ] \"point2 uv\" [ 0 0 2 0 0 2 2 2 ]\n\
         Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 1 ] \"integer indices\" [ 0 1 2 3 ]\n\
         Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 3 \"float Pz\" [ 0 1 2 3 4 5 ]",
    );
    let flat = mesh(&desc, 0);
    assert_eq!((flat.triangles.len(), flat.uvs[3]), (2, Vec2::splat(2.0)));
    let twisted = mesh(&desc, 1);
    assert_eq!(twisted.triangles.len(), 128);
    let middle = twisted.positions[4 * 9 + 4];
    assert!(
        middle.abs_diff_eq(Vec3::new(0.5, 0.5, 0.25), 1e-6),
        "{middle}"
    );
    let field = mesh(&desc, 2);
    assert_eq!(field.positions[5], Vec3::new(1.0, 1.0, 5.0));
}

#[test]
fn curves_of_one_material_become_one_mesh() {
    let curve = "Shape \"curve\" \"string type\" \"cylinder\" \"point3 P\" [ 0 0 0 1 0 0 2 0 0 3 0 0 ] \"float width\" 0.2\n";
    let desc = load(&format!("{curve}{curve}Material \"diffuse\"\n{curve}"));
    assert_eq!(desc.primitives.len(), 2);
    assert_eq!(
        mesh(&desc, 0).triangles.len(),
        2 * mesh(&desc, 1).triangles.len()
    );
}

#[test]
fn objects_are_instanced() {
    let world = "ObjectBegin \"a\" Translate 0 0 1 Shape \"sphere\" ObjectEnd Translate 5 0 0 ObjectInstance \"a\" \
                 Scale 1 -1 1 ObjectInstance \"a\"";
    let desc = load(world);
    assert_eq!((desc.groups.len(), desc.instances.len()), (1, 2));
    let inner = desc.groups[0][0].world_from_object.translation;
    assert_eq!(Vec3::from(inner), Vec3::Z);
    assert_eq!(
        Vec3::from(desc.instances[1].world_from_group.translation),
        Vec3::new(5.0, 0.0, 0.0)
    );
    let emitting = "ObjectBegin \"a\" AreaLightSource \"diffuse\" Shape \"sphere\" ObjectEnd ObjectInstance \"a\"";
    assert_eq!(
        warnings(emitting),
        ["surfaces in objects do not emit light, as in PBRT"]
    );
}

#[test]
fn attributes_are_inherited_and_restored() {
    let desc = load(
        "AttributeBegin Attribute \"shape\" \"float radius\" 3 Shape \"sphere\" Shape \"sphere\" \"float radius\" 2\n\
         Attribute \"shape\" \"float radius\" 4 Shape \"sphere\" AttributeEnd Shape \"sphere\"",
    );
    let radii: Vec<f32> = desc
        .primitives
        .iter()
        .map(|primitive| match desc.shapes[primitive.shape.index()] {
            Shape::Sphere { radius, .. } => radius,
            _ => 0.0,
        })
        .collect();
    assert_eq!(radii, [3.0, 2.0, 4.0, 1.0]);
}

#[test]
fn files_are_found_beside_the_scene_and_beside_the_including_file() {
    let ply = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let packed = |bytes: &[u8]| {
        use std::io::Write;
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let include = document("Include \"sub/part.pbrt.gz\" Import \"more.pbrt\"");
    let part = packed(
        b"Shape \"plymesh\" \"string filename\" \"own.ply\" Shape \"plymesh\" \"string filename\" \"sub/own.ply\"",
    );
    let zipped = packed(ply);
    let files = PbrtFiles::new(
        include.as_bytes(),
        &[
            ("sub/part.pbrt.gz", &part),
            ("sub/own.ply", ply),
            ("mesh.ply.gz", &zipped),
            (
                "more.pbrt",
                b"Shape \"plymesh\" \"string filename\" \"mesh.ply.gz\"",
            ),
        ],
    );
    let loaded = files.load();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!(loaded.desc.primitives.len(), 3);
    // Meshes without normals are flat, as in PBRT.
    assert!(mesh(&loaded.desc, 2).normals.is_empty());
}

#[test]
fn textures_are_placed_and_combined() {
    let scene = document(
        "Texture \"image\" \"spectrum\" \"imagemap\" \"string filename\" \"a.pfm\" \"float uscale\" 2 \"float vdelta\" 0.25 \
         \"string wrap\" \"clamp\" \"float scale\" 0.5 \"bool invert\" true\n\
         Texture \"checks\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [ 1 0 0 ] \"texture tex2\" \"image\" \"float uscale\" 4\n\
         Texture \"half\" \"spectrum\" \"scale\" \"texture tex\" \"checks\" \"float scale\" 0.5\n\
         Texture \"mix\" \"spectrum\" \"mix\" \"texture tex1\" \"half\" \"rgb tex2\" [ 0 0 1 ] \"float amount\" 0.25\n\
         Texture \"ramp\" \"float\" \"bilerp\" \"float v00\" 0 \"float v10\" 1 \"float v01\" 2 \"float v11\" 3\n\
         Material \"diffuse\" \"texture reflectance\" \"mix\" Shape \"sphere\"",
    );
    // Bottom row first: 0.2 and 0.4, then 0.6 and 0.8.
    let mut image = b"Pf\n2 2\n-1\n".to_vec();
    for value in [0.2_f32, 0.4, 0.6, 0.8] {
        image.extend(value.to_le_bytes());
    }
    let loaded = PbrtFiles::new(scene.as_bytes(), &[("a.pfm", &image)]).load();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let textures = &loaded.desc.textures;
    let at = |i: usize, u: f32, v: f32| textures[i].eval(Vec2::new(u, v), textures);
    let Texture::Bitmap(bitmap) = &textures[0] else {
        panic!("{:?}", textures[0])
    };
    assert_eq!(bitmap.wrap, [Wrap::Clamp; 2]);
    // u = 0.125 and v = 0 are texel column 0 and t = 0.25: the lower row. 1 - 0.2 / 2.
    assert!((at(0, 0.125, 0.0).r - 0.9).abs() < 1e-6);
    assert!((at(0, 0.375, 0.5).r - 0.6).abs() < 1e-6);
    // Cells of the checkerboard have edges of 1 in (4 u, v).
    assert_eq!(at(1, 0.1, 0.5), Rgb::new(1.0, 0.0, 0.0));
    assert!(at(1, 0.3, 0.5).r < 1.0);
    assert_eq!(at(2, 0.1, 0.5), Rgb::new(0.5, 0.0, 0.0));
    assert_eq!(at(3, 0.1, 0.5), Rgb::new(0.375, 0.0, 0.25));
    let ramp = textures.last().unwrap();
    for (u, v, expected) in [
        (0.0, 0.0, 0.0),
        (1.0, 0.0, 1.0),
        (0.0, 1.0, 2.0),
        (0.5, 0.5, 1.5),
    ] {
        let found = ramp.eval_float(Vec2::new(u, v), textures);
        assert!((found - expected).abs() < 1e-5, "{u} {v}: {found}");
    }
}

#[test]
fn float_checkerboards_have_their_first_value_in_the_first_cell() {
    let desc = load(
        "Texture \"a\" \"float\" \"checkerboard\" \"float tex1\" 0.25 \"float tex2\" 0.75\n\
         Material \"mix\" \"string materials\" [ \"x\" \"y\" ] \"texture amount\" \"a\"\n\
         MakeNamedMaterial \"x\" \"string type\" \"diffuse\" MakeNamedMaterial \"y\" \"string type\" \"diffuse\"",
    );
    let first = desc.textures[0].eval_float(Vec2::splat(0.5), &desc.textures);
    assert_eq!(first, 0.25);
}

#[test]
fn environment_maps_are_equal_area_octahedral() {
    // Half of the square with z > 0.
    let n = 32_usize;
    let mut image = format!("PF\n{n} {n}\n-1\n").into_bytes();
    for i in 0..n * n {
        let (x, y) = ((i % n) as f32 + 0.5, (i / n) as f32 + 0.5);
        let distance = (2.0 * x / n as f32 - 1.0).abs() + (2.0 * y / n as f32 - 1.0).abs();
        let value: f32 = if distance < 1.0 { 3.0 } else { 0.0 };
        (0..3).for_each(|_| image.extend(value.to_le_bytes()));
    }
    let scene = "Camera \"perspective\" WorldBegin Rotate -90 1 0 0\n\
                 LightSource \"infinite\" \"string filename\" \"sky.pfm\" \"float scale\" 2";
    let desc = PbrtFiles::new(scene.as_bytes(), &[("sky.pfm", &image)])
        .load()
        .desc;
    let Emitter::Environment(map) = &desc.emitters[0] else {
        panic!("{:?}", desc.emitters)
    };
    assert_eq!((map.image.width, map.image.height), (64, 32));
    assert!((map.image.rgb(7, 2).g - 6.0).abs() < 1e-5);
    assert_eq!(map.image.rgb(7, 29).g, 0.0);
    // The light's z, the emitter's y, is the world's y.
    let up = map.world_from_emitter * Vec3::Y;
    assert!(up.abs_diff_eq(Vec3::Y, 1e-6), "{up}");
}

#[test]
fn motion_uses_the_start_and_warns_once() {
    let loaded = loaded(
        "TransformTimes 0 1 ActiveTransform EndTime Translate 9 0 0 ActiveTransform All Translate 1 0 0\n\
         Shape \"disk\" Shape \"disk\"",
    );
    assert_eq!(place(&loaded.desc, 0, Vec3::ZERO), Vec3::X);
    let messages: Vec<&str> = loaded.warnings.iter().map(|w| w.message()).collect();
    assert_eq!(
        messages,
        ["only cameras move; the transform at the start is used"]
    );
}

#[test]
fn cameras_move_between_their_transforms() {
    let camera = "ActiveTransform EndTime Rotate 90 0 1 0 Translate -2 0 0 ActiveTransform All \
                  Translate -1 0 0 Camera \"perspective\"";
    let rest = "WorldBegin LightSource \"infinite\" Shape \"sphere\"";
    let motion = |times: &str| {
        load_file(&format!("{times} {camera} {rest}")).sensors[0]
            .motion
            .clone()
    };
    assert_eq!(motion("").len(), 25);
    let moved = motion("TransformTimes 2 2.25");
    assert_eq!(moved.len(), 7);
    let at = |frame: usize| Vec3::from(moved[frame].translation);
    assert!(at(0).abs_diff_eq(Vec3::X, 1e-5) && at(6).abs_diff_eq(Vec3::X * 3.0, 1e-5));
    assert!(at(3).abs_diff_eq(Vec3::X * 2.0, 1e-5), "{}", at(3));
    let forward = |frame: usize| moved[frame].transform_vector3(Vec3::Z);
    assert!(forward(0).abs_diff_eq(Vec3::Z, 1e-5));
    assert!(forward(6).abs_diff_eq(-Vec3::X, 1e-5), "{}", forward(6));
    let problems = PbrtFiles::new(
        format!("TransformTimes 1 0 {camera} {rest}").as_bytes(),
        &[],
    )
    .problems();
    assert!(
        problems[0].contains("this camera cannot move"),
        "{problems:?}"
    );
}

#[test]
fn opacity_scales_the_emission_of_a_surface() {
    let quad = "Shape \"trianglemesh\" \"point3 P\" [ -1 -1 0 1 -1 0 1 1 0 -1 1 0 ] \"point2 uv\" [ 0 0 1 0 1 1 0 1 ] \"integer indices\" [ 0 1 2 0 2 3 ]";
    let radiance = |desc: &SceneDesc| match desc.emitters.last() {
        Some(Emitter::Area { radiance }) => *radiance,
        other => panic!("{other:?}"),
    };
    let desc = load(&format!(
        "AreaLightSource \"diffuse\" \"rgb L\" [ 4 4 4 ] {quad} \"float alpha\" .25"
    ));
    assert_eq!(radiance(&desc), ColorInput::Constant(Rgb::splat(1.0)));
    // The power is that without the opacity.
    let desc = load(&format!(
        "AreaLightSource \"diffuse\" \"float power\" 8 {quad} \"float alpha\" .25"
    ));
    assert!(
        matches!(radiance(&desc), ColorInput::Constant(c) if (c.r - 8.0 / (PI * 2.0) * 0.25).abs() < 1e-5)
    );
    let board = "Texture \"a\" \"float\" \"checkerboard\" \"float uscale\" 2 \"float vscale\" 2 \"float tex1\" 1 \"float tex2\" 0";
    let desc = load(&format!(
        "{board} AreaLightSource \"diffuse\" \"rgb L\" [ 4 4 4 ] \"bool twosided\" true {quad} \"texture alpha\" \"a\""
    ));
    let at = |u: f32| radiance(&desc).eval(Vec2::new(u, 0.25), &desc.textures).r;
    assert_eq!([at(0.25), at(0.75)], [4.0, 0.0]);
    // Of two surfaces back to back, each hides the other side alone.
    let [front, back] = [0, 1].map(|i| &desc.primitives[i]);
    assert_eq!(front.material, back.material);
    let Material::TwoSided { front, back } = desc.materials[front.material.index()] else {
        panic!("{:?}", desc.materials)
    };
    assert!(matches!(
        desc.materials[front.index()],
        Material::Mask { .. }
    ));
    assert!(matches!(desc.materials[back.index()], Material::Null));
}

#[test]
fn an_emitter_of_no_opacity_lights_without_being_seen() {
    let quad = "Shape \"bilinearmesh\" \"point3 P\" [ -1 -1 0 1 -1 0 -1 1 0 1 1 0 ]";
    let zero = "Texture \"z\" \"float\" \"constant\" \"float value\" 0";
    for (light, alpha, expected) in [
        ("\"rgb L\" [ 4 4 4 ]", "\"float alpha\" 0", 4.0),
        ("\"rgb L\" [ 4 4 4 ]", "\"texture alpha\" \"z\"", 4.0),
        // The power of the opaque surface: its area is 4.
        ("\"float power\" 8", "\"float alpha\" 0", 2.0 / PI),
    ] {
        let text = format!("{zero} AreaLightSource \"diffuse\" {light} {quad} {alpha}");
        match load(&text).emitters.last() {
            Some(Emitter::InvisibleArea {
                radiance: ColorInput::Constant(color),
            }) => assert!((color.r - expected).abs() < 1e-5, "{text}: {color:?}"),
            other => panic!("{text}: {other:?}"),
        }
    }
    // Both sides of a surface that both emit.
    let desc = load(&format!(
        "AreaLightSource \"diffuse\" \"bool twosided\" true {quad} \"float alpha\" 0"
    ));
    assert_eq!(desc.primitives.len(), 2);
    assert!(desc.primitives.iter().all(|primitive| {
        let emitter = primitive.emitter.map(|id| &desc.emitters[id.index()]);
        emitter.is_some_and(Emitter::is_invisible)
    }));
}

#[test]
fn textured_triangles_without_coordinates_have_those_of_pbrt() {
    let quad = "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 1 1 0 0 1 0 ] \"integer indices\" [ 0 1 2 0 2 3 ]";
    let texture = "Texture \"t\" \"spectrum\" \"checkerboard\" ";
    let desc = load(&format!(
        "{texture} Material \"diffuse\" {quad} Material \"diffuse\" \"texture reflectance\" \"t\" {quad}"
    ));
    // Materials without textures do not need any.
    assert!(mesh(&desc, 0).uvs.is_empty());
    let textured = mesh(&desc, 1);
    assert_eq!(textured.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(textured.positions[4], Vec3::new(1.0, 1.0, 0.0));
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE];
    assert_eq!(textured.uvs, [uvs, uvs].concat());
}
