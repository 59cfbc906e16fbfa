//! Transforms of emitters, spectra of emitters, small maps, and the working directory. The numbers
//! are those of Mitsuba 3.9.1.

use crate::{Files, document, load};
use manylight::color::Rgb;
use manylight::emitters::Emitter;
use manylight::math::{Vec2, Vec3};
use manylight::scene::{PathLimits, SceneDesc};
use std::f32::consts::PI;

fn last(desc: &SceneDesc) -> &Emitter {
    desc.emitters.last().unwrap()
}

/// The last emitter of a scene with this emitter, whose `to_world` is a scale.
fn scaled(kind: &str, scale: &str, parameters: &str) -> SceneDesc {
    load(&format!(
        "<emitter type='{kind}'>{parameters}<transform name='to_world'><scale {scale}/></transform></emitter>"
    ))
}

#[test]
fn a_uniform_spectrum_is_white_on_emitters() {
    let radiance = |spectrum: &str| match last(&load(&format!(
        "<emitter type='constant'>{spectrum}</emitter>"
    ))) {
        Emitter::Constant { radiance } => *radiance,
        other => panic!("{other:?}"),
    };
    for tag in ["spectrum", "texture"] {
        let uniform = format!(
            "<{tag} type='uniform' name='radiance'><float name='value' value='2.5'/></{tag}>"
        );
        assert_eq!(radiance(&uniform), Rgb::splat(2.5));
    }
    // A number as a spectrum is one of equal energy.
    let equal_energy = radiance("<spectrum name='radiance' value='1'/>");
    assert!((equal_energy.r - 1.204_79).abs() < 1e-4 && (equal_energy.b - 0.908_92).abs() < 1e-4);
}

#[test]
fn nothing_is_visible_at_depth_0() {
    let limits =
        load("<integrator type='path'><integer name='max_depth' value='0'/></integrator>").limits;
    let expected = PathLimits {
        max_depth: Some(1),
        hide_emitters: true,
        ..PathLimits::default()
    };
    assert_eq!(limits, expected);
}

#[test]
fn a_scale_deforms_the_cone_of_a_spot() {
    // What `sample_direction` returns for a spot at the origin and a point p, for `scale x='3'`
    // with a cone of 20 degrees, and for `scale z='2'`.
    let cases = [
        ("x='3'", [0.3, 0.0, 2.0], 0.244_499),
        ("x='3'", [1.7, 0.0, 2.0], 0.121_358),
        ("x='3'", [0.0, 0.7, 2.0], 0.031_624),
        ("x='3'", [0.0, 0.75, 2.0], 0.0),
        ("z='2'", [0.0, 0.0, 2.0], 0.25),
        ("z='2'", [0.3, 0.0, 2.0], 0.161_405),
        ("z='2'", [0.5, 0.0, 2.0], 0.0),
        ("value='2'", [0.5, 0.0, 2.0], 0.235_294),
    ];
    for (scale, p, expected) in cases {
        let desc = scaled("spot", scale, "<float name='cutoff_angle' value='20'/>");
        let p = Vec3::from(p);
        let found =
            last(&desc).point_intensity(&desc.textures, p.normalize()).r / p.length_squared();
        assert!(
            (found - expected).abs() < 2e-3 * expected + 1e-3,
            "{scale} {p}: {found} {expected}"
        );
    }
}

#[test]
fn a_scale_along_a_directional_emitter_makes_it_brighter() {
    for (scale, expected) in [("value='2'", 2.0), ("z='3'", 3.0), ("x='3'", 1.0)] {
        let desc = scaled("directional", scale, "<rgb name='irradiance' value='1'/>");
        assert!(
            matches!(last(&desc), Emitter::Directional { irradiance, .. } if (irradiance.r - expected).abs() < 1e-5),
            "{scale}"
        );
    }
}

#[test]
fn a_scale_changes_brightness_and_image_of_a_projector() {
    let tangent = 30.0_f32.to_radians().tan();
    for (scale, brightness, window) in [
        ("value='2'", 2.0, [1.0, 1.0]),
        ("x='2'", 1.0, [2.0, 1.0]),
        ("z='2'", 2.0, [0.5, 0.5]),
    ] {
        let parameters = "<float name='fov' value='60'/><rgb name='irradiance' value='1'/>";
        let desc = scaled("projector", scale, parameters);
        let Emitter::Spot {
            intensity,
            projector: Some(projector),
            ..
        } = last(&desc)
        else {
            panic!("{:?}", desc.emitters)
        };
        assert!((intensity.r / PI - brightness).abs() < 1e-5, "{scale}");
        let expected = Vec2::from(window) * tangent;
        let window = projector.window.unwrap();
        assert!(window.abs_diff_eq(expected, 1e-5), "{scale}: {window}");
    }
}

/// The environment of a map with `height` rows of two pixels, whose values are 0.1, 0.2, ...
fn map(height: usize, transform: &str) -> (SceneDesc, Vec<String>) {
    let bytes = (1..=6 * height).flat_map(|i| (i as f32 * 0.1).to_le_bytes());
    let header = format!("PF\n2 {height}\n-1\n").into_bytes();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("m.pfm"),
        header.into_iter().chain(bytes).collect::<Vec<u8>>(),
    )
    .unwrap();
    let emitter = format!(
        "<emitter type='envmap'><string name='filename' value='m.pfm'/>{transform}</emitter>"
    );
    let scene = folder.path().join("s.xml");
    let text = document("3.0.0", &emitter).replace("<emitter type=\"constant\"/>", "");
    std::fs::write(&scene, text).unwrap();
    let loaded = manylight_io::load_scene(&scene, &manylight_io::LoadOptions::default()).unwrap();
    let warnings = loaded.warnings.iter().map(|w| w.message().to_owned());
    (loaded.desc, warnings.collect())
}

#[test]
fn small_maps_are_enlarged_to_three_rows() {
    let rows = |height: usize| {
        let (desc, warnings) = map(height, "");
        assert!(warnings.is_empty(), "{warnings:?}");
        match last(&desc) {
            Emitter::Environment(map) => {
                let image = &map.image;
                let at = |y: usize| image.data[y * image.width * image.channels];
                (0..image.height).map(at).collect::<Vec<f32>>()
            }
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(rows(1), [0.1; 3]);
    // The rows of a PFM file go up: the first one is 0.7.
    let near = |found: Vec<f32>, expected: [f32; 3]| {
        let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
        assert!(
            found.len() == 3 && off.fold(0.0, f32::max) < 1e-4,
            "{found:?}"
        );
    };
    near(rows(2), [0.7, 0.1, 0.1]);
    near(rows(3), [1.3, 0.7, 0.1]);
}

#[test]
fn scales_of_maps_warn() {
    let transform = |steps: &str| format!("<transform name='to_world'>{steps}</transform>");
    let (_, warnings) = map(3, &transform("<scale value='2'/>"));
    assert_eq!(
        warnings,
        [
            "a scale in `to_world` of emitter `envmap` has no effect here; in Mitsuba it distorts the map"
        ]
    );
    let (_, warnings) = map(3, &transform("<scale x='-1'/><rotate y='1' angle='33'/>"));
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn constant_volumes_are_textures_of_one_color() {
    let desc = load(
        "<bsdf type='diffuse'><texture type='volume' name='reflectance'><volume type='constvolume' name='volume'>\
         <rgb name='value' value='.7 .2 .1'/></volume></texture></bsdf>",
    );
    let Some(manylight::bsdf::Material::Diffuse { reflectance }) = desc.materials.last() else {
        panic!("{:?}", desc.materials)
    };
    let found = reflectance.eval(Vec2::splat(0.3), &desc.textures);
    assert_eq!(found, Rgb::new(0.7, 0.2, 0.1));
}

#[test]
fn filters_of_polarization_transmit_half_of_the_light() {
    use manylight::bsdf::Material;
    use manylight::texture::ColorInput;
    for (kind, expected) in [("polarizer", 0.4), ("circular", 0.4), ("retarder", 0.8)] {
        let desc = load(&format!(
            "<bsdf type='{kind}'><float name='theta' value='30'/><spectrum name='transmittance' value='.8'/></bsdf>"
        ));
        assert!(
            matches!(
                desc.materials.last(),
                Some(Material::ThinDielectric { eta: 1.0, specular_transmittance: ColorInput::Constant(t), .. })
                    if (t.r - expected).abs() < 1e-6
            ),
            "{kind}: {:?}",
            desc.materials
        );
    }
}

#[test]
fn files_are_searched_in_the_working_directory_last() {
    let folder = tempfile::tempdir().unwrap();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::create_dir(folder.path().join("xml")).unwrap();
    std::fs::write(folder.path().join("t.obj"), obj).unwrap();
    // The path of the mesh from the working directory, which tests cannot change.
    let here = std::env::current_dir().unwrap();
    let up = "../".repeat(here.components().count() - 1);
    let mesh = format!(
        "{up}{}",
        folder
            .path()
            .join("t.obj")
            .strip_prefix("/")
            .unwrap()
            .display()
    );
    let shape = format!("<shape type='obj'><string name='filename' value='{mesh}'/></shape>");
    let scene = folder.path().join("xml/s.xml");
    std::fs::write(&scene, document("3.0.0", &shape)).unwrap();
    let loaded = manylight_io::load_scene(&scene, &manylight_io::LoadOptions::default()).unwrap();
    assert_eq!(loaded.desc.shapes.len(), 1);
    let absent = Files::new(&document("3.0.0", &shape.replace("t.obj", "u.obj")), &[]);
    assert!(
        manylight_io::load_scene(&absent.scene(), &manylight_io::LoadOptions::default()).is_err()
    );
}

#[test]
fn other_treatments_of_bumps_warn() {
    let bump = "<bsdf type='bumpmap'><boolean name='use_shadowing_function' value='false'/>\
        <boolean name='flip_invalid_normals' value='true'/><texture type='checkerboard'/><bsdf type='diffuse'/></bsdf>";
    assert_eq!(
        crate::problems("3.0.0", bump),
        [
            "warning 2:13 `use_shadowing_function` of bsdf `bumpmap` cannot be false here; true is used"
        ]
    );
}
