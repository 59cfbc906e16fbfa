//! What parameters mean: defaults, kinds of values, transforms. The numbers are those that Mitsuba 3.9.1 prints for the
//! same text.

use crate::{Files, document, load, load_version};
use manylight::bsdf::Material;
use manylight::bsdf::material::Distribution;
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::film::Filter;
use manylight::geometry::Shape;
use manylight::ids::TextureId;
use manylight::math::{UVec2, Vec2, Vec3, Vec3A};
use manylight::scene::PathLimits;
use manylight::sensors::{FovAxis, SensorKind};
use manylight::texture::{ColorInput, Filtering, FloatInput, Texture, Wrap};
use manylight_io::{LoadOptions, load_scene};

fn near(a: Rgb, b: [f32; 3]) -> bool {
    a.to_array()
        .iter()
        .zip(b)
        .all(|(a, b)| (a - b).abs() <= 1e-3 * b.abs().max(1.0))
}

/// The last material of a scene with this one bsdf.
fn material(xml: &str) -> Material {
    load(xml).materials.last().unwrap().clone()
}

fn constant(input: &ColorInput) -> Rgb {
    match input {
        ColorInput::Constant(color) => *color,
        ColorInput::Texture(_) => panic!("a texture"),
    }
}

#[test]
fn defaults_of_materials_are_mitsubas() {
    let Material::Diffuse { reflectance } = material("<bsdf type='diffuse'/>") else {
        panic!()
    };
    assert_eq!(constant(&reflectance), Rgb::splat(0.5));
    let Material::Dielectric { eta, .. } = material("<bsdf type='dielectric'/>") else {
        panic!()
    };
    assert!((eta - 1.504_183_3).abs() < 1e-6);
    let Material::Plastic {
        eta,
        nonlinear,
        roughness,
        ..
    } = material("<bsdf type='roughplastic'/>")
    else {
        panic!()
    };
    assert!((eta - 1.489_587_3).abs() < 1e-6 && !nonlinear);
    assert_eq!(roughness, Some((Distribution::Beckmann, 0.1)));
    let Material::Conductor {
        eta, k, roughness, ..
    } = material("<bsdf type='roughconductor'/>")
    else {
        panic!()
    };
    assert_eq!((constant(&eta), constant(&k)), (Rgb::BLACK, Rgb::WHITE));
    assert_eq!(roughness.unwrap().alpha_u, FloatInput::Constant(0.1));
    let copper = material("<bsdf type='conductor'><string name='material' value='Cu'/></bsdf>");
    let Material::Conductor { eta, .. } = copper else {
        panic!()
    };
    assert!(near(constant(&eta), [0.201_005, 0.923_75, 1.102_215]));
    let mask = material("<bsdf type='mask'><bsdf type='diffuse'/></bsdf>");
    assert!(matches!(
        mask,
        Material::Mask {
            opacity: FloatInput::Constant(0.5),
            ..
        }
    ));
}

#[test]
fn principled_takes_eta_or_specular() {
    let eta = |xml: &str| match material(&format!("<bsdf type='principled'>{xml}</bsdf>")) {
        Material::Principled(principled) => principled.eta,
        other => panic!("{other:?}"),
    };
    assert!((eta("") - 1.5).abs() < 1e-6);
    assert!((eta("<float name='specular' value='1'/>") - 1.788_788_5).abs() < 1e-5);
    assert_eq!(eta("<float name='specular' value='0'/>"), 1.0);
    assert_eq!(eta("<float name='eta' value='1.3'/>"), 1.3);
    assert_eq!(
        eta("<float name='eta' value='1'/><float name='spec_trans' value='0.5'/>"),
        1.001
    );
}

#[test]
fn spectra_of_emitters_and_surfaces_differ() {
    let radiance = |xml: &str| {
        let desc = load(&format!("<emitter type='constant'>{xml}</emitter>"));
        match desc.emitters.last() {
            Some(Emitter::Constant { radiance }) => *radiance,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(radiance(""), Rgb::WHITE);
    assert_eq!(
        radiance("<rgb name='radiance' value='5'/>"),
        Rgb::splat(5.0)
    );
    assert_eq!(
        radiance("<float name='radiance' value='5'/>"),
        Rgb::splat(5.0)
    );
    assert!(near(
        radiance("<spectrum name='radiance' value='5'/>"),
        [6.023_97, 4.741_455, 4.544_58]
    ));
    let light = "400:0, 500:8, 600:15.6, 700:18.4";
    assert!(near(
        radiance(&format!("<spectrum name='radiance' value='{light}'/>")),
        [20.710_8, 10.854_6, 2.771_15]
    ));
    let d65 = "<spectrum name='radiance' type='d65'><float name='scale' value='2'/></spectrum>";
    assert_eq!(radiance(d65), Rgb::splat(2.0));

    let reflectance = |xml: &str| match material(&format!("<bsdf type='diffuse'>{xml}</bsdf>")) {
        Material::Diffuse { reflectance } => constant(&reflectance),
        other => panic!("{other:?}"),
    };
    assert_eq!(
        reflectance("<spectrum name='reflectance' value='0.7'/>"),
        Rgb::splat(0.7)
    );
    assert_eq!(
        reflectance("<rgb name='reflectance' value='0.1 0.2, 0.3'/>"),
        Rgb::new(0.1, 0.2, 0.3)
    );
    let grey = "400:0.78, 500:0.78, 600:0.78, 700:0.78";
    let color = reflectance(&format!("<spectrum name='reflectance' value='{grey}'/>"));
    assert!(near(color, [0.776_367, 0.779_81, 0.776_029]));
}

#[test]
fn spectra_are_read_from_files() {
    let scene = crate::document(
        "3.0.0",
        "<bsdf type='diffuse'><spectrum name='reflectance' filename='grey.spd'/></bsdf>",
    );
    let desc = Files::new(
        &scene,
        &[(
            "grey.spd",
            "# grey\n400 0.78\n500 0.78\n600 0.78\n700 0.78\n",
        )],
    )
    .load()
    .desc;
    let Material::Diffuse { reflectance } = &desc.materials[0] else {
        panic!()
    };
    assert!(near(
        constant(reflectance),
        [0.776_367, 0.779_81, 0.776_029]
    ));
}

#[test]
fn shapes_without_bsdf_are_grey_or_black() {
    let desc = load(
        "<shape type='sphere'/><shape type='sphere'><emitter type='area'/></shape><shape type='sphere'/>",
    );
    let albedo = |index: usize| match &desc.materials[desc.primitives[index].material.index()] {
        Material::Diffuse { reflectance } => constant(reflectance),
        other => panic!("{other:?}"),
    };
    assert_eq!(albedo(0), Rgb::splat(0.5));
    assert_eq!(albedo(1), Rgb::BLACK);
    assert_eq!(desc.primitives[0].material, desc.primitives[2].material);
    let emitter = desc.primitives[1].emitter.unwrap();
    assert!(matches!(
        desc.emitters[emitter.index()],
        Emitter::Area { .. }
    ));
}

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
fn axes_of_rotations_are_used_as_they_stand_since_version_3() {
    let turned = |version| {
        let shape = "<shape type='disk'><transform name='to_world'><rotate z='2' angle='30'/></transform></shape>";
        let loaded = Files::new(&document(version, shape), &[]).load();
        loaded.desc.primitives[0].world_from_object.matrix3
    };
    // What `mi.ScalarTransform4f().rotate([0, 0, 2], 30)` of Mitsuba 3.9.1 prints.
    let as_it_stands = turned("3.0.0");
    assert!(
        as_it_stands
            .x_axis
            .abs_diff_eq(Vec3A::new(0.866_025, 1.0, 0.0), 1e-5)
    );
    assert!(
        as_it_stands
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
fn a_sensor_without_parameters_has_mitsubas() {
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
fn integrators_give_only_limits() {
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
fn objects_can_be_shared_and_named_anew() {
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
fn groups_are_made_once_and_shown_often() {
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
fn a_mesh_file_is_stored_once_per_use() {
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
    // OBJ files have v upwards, images downwards.
    assert_eq!(mesh(0).uvs[0], Vec2::new(0.0, 0.75));
    assert_eq!(mesh(2).uvs[0], Vec2::new(0.0, 0.25));
    assert_eq!(mesh(0).normals, [Vec3::Z; 3]);
    assert!(mesh(1).normals.is_empty());
}

#[test]
fn an_image_is_one_texture_for_equal_settings() {
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
    // A grey image of two pixels, little endian.
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
        (Wrap::Clamp, Filtering::Nearest)
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
fn textures_stand_in_checkerboards_and_spots() {
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
        projector: Some(slide), ..
    } = &desc.emitters[1]
    else {
        panic!()
    };
    assert_eq!(slide.texture, TextureId(1));
    assert!((slide.axes[0] - Vec3::Y).length() + (slide.axes[1] - Vec3::NEG_X).length() < 1e-6);
}

#[test]
fn parameters_come_from_the_caller_before_the_file() {
    let scene = crate::document(
        "3.0.0",
        "<default name='size' value='3'/><default name='sizes' value='$size'/><default name='kind' value='sphere'/>
        <shape type='$kind'><float name='radius' value='1$sizes'/></shape>",
    );
    let files = Files::new(&scene, &[]);
    let options = LoadOptions {
        defines: vec![("size".to_owned(), "7".to_owned())],
        strict: true,
    };
    let desc = load_scene(&files.scene(), &options).unwrap().desc;
    assert!(matches!(desc.shapes[0], Shape::Sphere { radius: 17.0, .. }));
}

#[test]
fn included_files_are_found_beside_the_file_that_names_them() {
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

#[test]
fn two_sided_materials_have_one_or_two_parts() {
    let desc = load("<bsdf type='twosided'><bsdf type='diffuse'/><bsdf type='conductor'/></bsdf>");
    let Material::TwoSided { front, back } = desc.materials[2] else {
        panic!()
    };
    assert!(matches!(
        desc.materials[front.index()],
        Material::Diffuse { .. }
    ));
    assert!(matches!(
        desc.materials[back.index()],
        Material::Conductor { .. }
    ));
}

#[test]
fn old_and_new_conductors_have_different_defaults() {
    let desc = load_version(
        "0.5.0",
        "<bsdf type='conductor'><float name='extEta' value='2'/></bsdf>",
    );
    let Material::Conductor { eta, .. } = &desc.materials[0] else {
        panic!()
    };
    assert!(near(constant(eta), [0.100_502, 0.461_875, 0.551_108]));
}
