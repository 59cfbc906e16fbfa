//! Shapes, transforms, sensors, emitters, textures, references and parameters. The numbers are
//! those that Mitsuba 3.9.1 prints for the same text.

use crate::materials::constant;
use crate::{Files, document, load};
use manylight::bsdf::Material;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::film::Filter;
use manylight::geometry::Shape;
use manylight::ids::TextureId;
use manylight::math::{UVec2, Vec2, Vec3, Vec3A};
use manylight::scene::PathLimits;
use manylight::sensors::{FovAxis, SensorKind};
use manylight::texture::{ColorInput, Filtering, Texture, Wrap};
use manylight_io::{LoadOptions, load_scene};

#[test]
fn steps_of_transforms_apply_in_order() {
    let desc = load(
        "<shape type='disk'><transform name='to_world'>
            <translate x='1'/><scale value='2'/><rotate z='1' angle='90'/>
            <matrix value='1 0 0 0  0 1 0 0  0 0 1 5  0 0 0 1'/><matrix value='1 0 0 0 1 0 0 0 3'/>
        </transform></shape>",
    );
    let p = desc.primitives[0]
        .world_from_object
        .transform_point3(Vec3::new(1.0, 0.0, 1.0));
    assert!(p.abs_diff_eq(Vec3::new(0.0, 4.0, 21.0), 1e-5), "{p}");
}

#[test]
fn rotation_axes_are_not_normalized_since_version_3() {
    let turned = |version| {
        let shape = "<shape type='disk'><transform name='to_world'><rotate z='2' angle='30'/></transform></shape>";
        let loaded = Files::new(&document(version, shape), &[]).load();
        loaded.desc.primitives[0].world_from_object.matrix3
    };
    // What `mi.ScalarTransform4f().rotate([0, 0, 2], 30)` of Mitsuba 3.9.1 prints.
    let unnormalized = turned("3.0.0");
    assert!(
        unnormalized
            .x_axis
            .abs_diff_eq(Vec3A::new(0.866_025, 1.0, 0.0), 1e-5)
    );
    assert!(
        unnormalized
            .z_axis
            .abs_diff_eq(Vec3A::new(0.0, 0.0, 1.401_92), 1e-5)
    );
    let rotation = turned("0.6.0");
    assert!(
        rotation
            .x_axis
            .abs_diff_eq(Vec3A::new(0.866_025, 0.5, 0.0), 1e-5)
    );
    assert_eq!(rotation.z_axis, Vec3A::Z);
}

#[test]
fn cameras_look_along_z_with_x_to_the_left() {
    let scene = "<scene version='3.0.0'><emitter type='constant'/><sensor type='thinlens'>
        <float name='aperture_radius' value='0.1'/><float name='fov' value='30'/><string name='fov_axis' value='smaller'/>
        <transform name='to_world'><lookat origin='1 2 3' target='1 2 13' up='0 2 1'/></transform>
        <film type='hdrfilm'><integer name='width' value='20'/><integer name='height' value='10'/>
        <integer name='crop_offset_x' value='5'/><integer name='crop_width' value='8'/><rfilter type='mitchell'/></film>
        <sampler type='multijitter'><integer name='sample_count' value='16'/></sampler></sensor></scene>";
    let desc = Files::new(scene, &[]).load().desc;
    let sensor = &desc.sensors[0];
    let m = sensor.world_from_camera;
    assert!(m.transform_vector3(Vec3::Z).abs_diff_eq(Vec3::Z, 1e-6));
    assert!(m.transform_vector3(Vec3::X).abs_diff_eq(Vec3::X, 1e-6));
    assert_eq!(m.transform_point3(Vec3::ZERO), Vec3::new(1.0, 2.0, 3.0));
    let far = 1e4;
    let kind = SensorKind::ThinLens {
        fov: 30.0,
        fov_axis: FovAxis::Smaller,
        aperture_radius: 0.1,
        focus_distance: far,
    };
    assert_eq!(sensor.kind, kind);
    let film = &sensor.film;
    assert_eq!(
        (film.size, film.crop_offset, film.crop_size),
        (UVec2::new(20, 10), UVec2::new(5, 0), UVec2::new(8, 10))
    );
    assert_eq!(
        film.filter,
        Filter::Mitchell {
            b: 1.0 / 3.0,
            c: 1.0 / 3.0
        }
    );
}

#[test]
fn an_animation_moves_the_camera_and_nothing_else() {
    let animation = |name: &str, start: &str| {
        format!(
            "<animation name='{name}'>
            <transform time='{start}'><translate x='1'/></transform>
            <transform time='0.25'><rotate y='1' angle='90'/><translate x='3'/></transform></animation>"
        )
    };
    for (version, name) in [("3.0.0", "to_world"), ("0.6.0", "toWorld")] {
        let to_world = animation(name, "0");
        let scene = format!(
            "<scene version='{version}'><emitter type='constant'/><sensor type='perspective'>{to_world}</sensor>
            <shape type='sphere'>{to_world}</shape><shape type='sphere'>{to_world}</shape></scene>"
        );
        let loaded = Files::new(&scene, &[]).load();
        let messages: Vec<&str> = loaded.warnings.iter().map(|w| w.message()).collect();
        let warning = "only cameras move; the first transform of this <animation> is used";
        assert_eq!(messages, [warning]);
        let sensor = &loaded.desc.sensors[0];
        assert_eq!(sensor.motion.len(), 7);
        assert_eq!(sensor.motion[0], sensor.world_from_camera);
        let middle = sensor.motion[3];
        assert!(middle.translation.abs_diff_eq(Vec3A::X * 2.0, 1e-6));
        let forward = middle.transform_vector3(Vec3::Z);
        assert!(forward.abs_diff_eq(Vec3::new(1.0, 0.0, 1.0).normalize(), 1e-6));
        assert_eq!(
            loaded.desc.primitives[0].world_from_object.translation,
            Vec3A::X
        );
    }
    let sensor = |content: &str| {
        let scene = format!(
            "<scene version='3.0.0'><emitter type='constant'/><sensor type='perspective'>\n{content}</sensor></scene>"
        );
        let found =
            manylight_io::check_scene(&Files::new(&scene, &[]).scene(), &LoadOptions::default());
        let first = found.first().map(|diagnostic| diagnostic.message.clone());
        first.unwrap_or_default()
    };
    for (content, message) in [
        (
            animation("to_world", "1"),
            "expected the times of key frames in ascending order",
        ),
        (
            "<animation name='to_world'/>".into(),
            "an animation is empty",
        ),
        (
            "<animation name='to_world'><transform/></animation>".into(),
            "<transform> needs the attribute `time`",
        ),
        (
            "<animation name='to_world'><transform time='0'/></animation>".into(),
            "found 1 key frames, expected two or more",
        ),
        (
            "<animation name='to_world'><scale value='2'/></animation>".into(),
            "<scale> cannot be nested in <animation>",
        ),
        (animation("to_world", "-1e9"), "expected at most 1000000"),
    ] {
        let found = sensor(&content);
        assert!(found.contains(message), "{found}");
    }
}

#[test]
fn a_sensor_without_parameters_has_the_defaults_of_mitsuba() {
    let desc = load("");
    let sensor = &desc.sensors[0];
    // The diagonal of a 50 mm lens on 36 mm x 24 mm: 38.18 degrees horizontally on 768 x 576.
    let SensorKind::Perspective {
        fov,
        fov_axis: FovAxis::Diagonal,
    } = sensor.kind
    else {
        panic!()
    };
    let tan_x = (0.5 * fov.to_radians()).tan() * 768.0 / 768_f32.hypot(576.0);
    assert!((2.0 * tan_x.atan().to_degrees() - 38.184_84).abs() < 1e-4);
    assert_eq!((sensor.near_clip, sensor.far_clip), (0.01, 1e4));
    assert_eq!(sensor.film.size, UVec2::new(768, 576));
    assert_eq!(sensor.film.filter, Filter::Gaussian { stddev: 0.5 });
    assert_eq!(sensor.principal_point_offset, Vec2::ZERO);
    assert_eq!(
        desc.limits,
        PathLimits {
            max_depth: None,
            rr_depth: 5,
            hide_emitters: false
        }
    );
}

#[test]
fn emitters_are_placed_by_position_or_transform() {
    let desc = load(
        "<emitter type='point'><point name='position' x='1' y='2' z='3'/></emitter>
        <emitter type='spot'><transform name='to_world'><lookat origin='0 5 0' target='0 0 0' up='1 0 0'/></transform></emitter>
        <emitter type='directional'><vector name='direction' value='0 -2 0'/></emitter>",
    );
    assert!(matches!(
        desc.emitters[1],
        Emitter::Point {
            position: Vec3 {
                x: 1.0,
                y: 2.0,
                z: 3.0
            },
            ..
        }
    ));
    let Emitter::Spot {
        position,
        direction,
        cutoff,
        beam_width,
        ..
    } = desc.emitters[2]
    else {
        panic!()
    };
    assert_eq!((position, direction), (Vec3::Y * 5.0, Vec3::NEG_Y));
    assert!(
        (cutoff.to_degrees() - 20.0).abs() < 1e-5 && (beam_width.to_degrees() - 15.0).abs() < 1e-5
    );
    assert!(matches!(
        desc.emitters[3],
        Emitter::Directional {
            direction: Vec3::NEG_Y,
            ..
        }
    ));
}

#[test]
fn integrators_determine_path_limits() {
    let limits = |xml: &str| load(xml).limits;
    let path = limits(
        "<integrator type='path'><integer name='max_depth' value='7'/><integer name='rr_depth' value='3'/>
        <boolean name='hide_emitters' value='true'/></integrator>",
    );
    assert_eq!(
        path,
        PathLimits {
            max_depth: Some(7),
            rr_depth: 3,
            hide_emitters: true
        }
    );
    let unlimited =
        limits("<integrator type='volpath'><integer name='max_depth' value='-1'/></integrator>");
    assert_eq!(unlimited.max_depth, None);
    assert_eq!(limits("<integrator type='direct'/>").max_depth, Some(2));
    let nested = "<integrator type='aov'><string name='aovs' value='d:depth'/>
        <integrator type='path'><integer name='max_depth' value='4'/></integrator></integrator>";
    assert_eq!(limits(nested).max_depth, Some(4));
}

#[test]
fn objects_can_be_shared_and_have_aliases() {
    let desc = load(
        "<shape type='sphere'><ref id='later'/></shape>
        <bsdf type='twosided' id='later'><bsdf type='diffuse' id='inner'/></bsdf><alias id='inner' as='other'/>
        <shape type='sphere'><ref name='bsdf' id='other'/></shape><shape type='sphere'><ref id='later'/></shape>",
    );
    let materials: Vec<u32> = desc
        .primitives
        .iter()
        .map(|primitive| primitive.material.0)
        .collect();
    assert_eq!(materials, [1, 0, 1]);
    assert_eq!(desc.materials.len(), 2);
}

#[test]
fn groups_are_shared_by_instances() {
    let desc = load(
        "<shape type='shapegroup' id='pair'><shape type='sphere'/><shape type='cube' id='box'/></shape>
        <shape type='instance'><ref id='pair'/><transform name='to_world'><translate z='2'/></transform></shape>
        <shape type='instance'><ref id='pair'/></shape>",
    );
    assert_eq!(desc.primitives.len(), 0);
    assert_eq!(desc.groups.len(), 1);
    assert_eq!(desc.groups[0][1].name, "box");
    assert_eq!(
        desc.instances
            .iter()
            .map(|instance| instance.group)
            .collect::<Vec<_>>(),
        [0, 0]
    );
    assert_eq!(
        desc.instances[0]
            .world_from_group
            .transform_point3(Vec3::ZERO),
        Vec3::Z * 2.0
    );
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 1 0.25\nvt 0 1\nf 1/1 2/2 3/3\n";

#[test]
fn equal_mesh_files_are_shared() {
    let scene = crate::document(
        "3.0.0",
        "<shape type='obj'><string name='filename' value='a.obj'/></shape>
        <shape type='obj'><string name='filename' value='a.obj'/>
            <transform name='to_world'><scale value='3'/></transform></shape>
        <shape type='obj'><string name='filename' value='a.obj'/><boolean name='face_normals' value='true'/></shape>
        <shape type='obj'><string name='filename' value='a.obj'/><boolean name='flip_tex_coords' value='false'/></shape>",
    );
    let desc = Files::new(&scene, &[("a.obj", TRIANGLE)]).load().desc;
    let shapes: Vec<u32> = desc
        .primitives
        .iter()
        .map(|primitive| primitive.shape.0)
        .collect();
    assert_eq!(shapes, [0, 0, 1, 2]);
    let mesh = |index: usize| match &desc.shapes[index] {
        Shape::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    };
    // v points up in OBJ files, down in images.
    assert_eq!(mesh(0).uvs[0], Vec2::new(0.0, 0.75));
    assert_eq!(mesh(2).uvs[0], Vec2::new(0.0, 0.25));
    assert_eq!(mesh(0).normals, [Vec3::Z; 3]);
    assert!(mesh(1).normals.is_empty());
}

#[test]
fn bitmaps_with_equal_settings_are_shared() {
    let texture = |extra: &str| {
        format!(
            "<bsdf type='diffuse'><texture name='reflectance' type='bitmap'><string name='filename' value='a.pfm'/>{extra}</texture></bsdf>"
        )
    };
    let content = [
        texture(""),
        texture(""),
        texture("<string name='wrap_mode' value='clamp'/><string name='filter_type' value='nearest'/>"),
        "<texture type='checkerboard'><transform name='to_uv'><scale x='4' y='2'/><translate x='0.5'/></transform></texture>"
            .to_owned(),
    ]
    .concat();
    // A gray image of two pixels, little endian.
    let pixels = "Pf\n2 1\n-1\n\0\0\0?\0\0\0?";
    let desc = Files::new(&crate::document("3.0.0", &content), &[("a.pfm", pixels)])
        .load()
        .desc;
    assert_eq!(desc.textures.len(), 3);
    let Texture::Bitmap(bitmap) = &desc.textures[1] else {
        panic!()
    };
    assert_eq!(
        (bitmap.wrap, bitmap.filtering),
        ([Wrap::Clamp; 2], Filtering::Nearest)
    );
    assert_eq!((bitmap.image.width, bitmap.image.data[0]), (2, 0.5));
    let Texture::Checkerboard {
        color0,
        color1,
        uv_transform,
    } = &desc.textures[2]
    else {
        panic!()
    };
    let defaults = [0.4, 0.2].map(|v| ColorInput::Constant(Rgb::splat(v)));
    assert_eq!([*color0, *color1], defaults);
    assert_eq!(
        *uv_transform * Vec3::new(1.0, 1.0, 1.0),
        Vec3::new(4.5, 2.0, 1.0)
    );
}

#[test]
fn checkerboards_and_spots_accept_textures() {
    let desc = load(
        "<emitter type='spot'>
          <transform name='to_world'><rotate z='1' angle='90'/><scale value='2'/></transform>
          <texture type='checkerboard' name='texture'>
            <texture type='checkerboard' name='color0'/><rgb name='color1' value='0.5'/>
          </texture>
        </emitter>",
    );
    let Texture::Checkerboard { color0, color1, .. } = &desc.textures[1] else {
        panic!()
    };
    assert_eq!(*color0, ColorInput::Texture(TextureId(0)));
    assert_eq!(*color1, ColorInput::Constant(Rgb::splat(0.5)));
    let Emitter::Spot {
        projector: Some(slide),
        ..
    } = &desc.emitters[1]
    else {
        panic!()
    };
    assert_eq!(slide.texture, TextureId(1));
    assert!((slide.axes[0] - Vec3::Y).length() + (slide.axes[1] - Vec3::NEG_X).length() < 1e-6);
}

#[test]
fn defines_override_defaults() {
    let scene = crate::document(
        "3.0.0",
        "<default name='size' value='3'/><default name='sizes' value='$size'/><default name='kind' value='sphere'/>
        <shape type='$kind'><float name='radius' value='1$sizes'/></shape>",
    );
    let files = Files::new(&scene, &[]);
    let options = LoadOptions {
        defines: vec![("size".to_owned(), "7".to_owned())],
        strict: true,
        ..LoadOptions::default()
    };
    let desc = load_scene(&files.scene(), &options).unwrap().desc;
    assert!(matches!(desc.shapes[0], Shape::Sphere { radius: 17.0, .. }));
}

#[test]
fn included_files_are_found_in_the_folder_of_the_scene() {
    let scene = crate::document(
        "3.0.0",
        "<include filename='parts.xml'/><shape type='sphere'><ref id='red'/></shape>",
    );
    let parts = "<scene version='0.6.0'><bsdf type='diffuse' id='red'><srgb name='diffuseReflectance' value='#ff0000'/>
        </bsdf><include filename='one.xml'/></scene>";
    let one = "<shape type='cylinder' version='3.0.0'><point name='p1' value='0 0 2'/></shape>";
    let desc = Files::new(&scene, &[("parts.xml", parts), ("one.xml", one)])
        .load()
        .desc;
    let Material::Diffuse { reflectance } = &desc.materials[0] else {
        panic!()
    };
    assert_eq!(constant(reflectance), Rgb::new(1.0, 0.0, 0.0));
    assert!(matches!(
        desc.shapes[0],
        Shape::Cylinder {
            p1: Vec3 { z: 2.0, .. },
            ..
        }
    ));
    assert_eq!(desc.primitives[1].material.0, 0);
}
