//! Files of versions 0.x.

use crate::{load_version, problems};
use manylight::bsdf::Material;
use manylight::bsdf::material::{OrenNayarVariant, WardVariant};
use manylight::color::Rgb;
use manylight::math::Vec3;
use manylight::sensors::{FovAxis, SensorKind};
use manylight::texture::{ColorInput, FloatInput, Texture};

#[test]
fn camel_case_names_and_old_tags_are_understood() {
    let desc = load_version(
        "0.5.0",
        "<sensor type='perspective'><string name='fovAxis' value='smaller'/><float name='fov' value='40'/>
        <float name='nearClip' value='10'/><transform name='toWorld'><lookAt origin='1, 0, 0' target='0, 0, 0' up='0, 1, 0'/>
        </transform><film type='ldrfilm'><float name='gamma' value='2.2'/><boolean name='banner' value='false'/>
        <boolean name='highQualityEdges' value='true'/></film><sampler type='ldsampler'>
        <integer name='sampleCount' value='9'/></sampler></sensor>
        <integrator type='path'><integer name='maxDepth' value='3'/><boolean name='strictNormals' value='true'/></integrator>
        <bsdf type='dielectric'><float name='intIOR' value='1.5'/><string name='extIOR' value='vacuum'/></bsdf>",
    );
    let sensor = &desc.sensors[1];
    assert_eq!(
        sensor.kind,
        SensorKind::Perspective {
            fov: 40.0,
            fov_axis: FovAxis::Smaller
        }
    );
    assert_eq!(sensor.near_clip, 10.0);
    assert!(
        sensor
            .world_from_camera
            .transform_vector3(Vec3::Z)
            .abs_diff_eq(Vec3::NEG_X, 1e-6)
    );
    assert_eq!(desc.limits.max_depth, Some(3));
    assert!(matches!(
        desc.materials[0],
        Material::Dielectric { eta: 1.5, .. }
    ));
}

#[test]
fn texture_offsets_are_applied_before_scales() {
    let desc = load_version(
        "0.6.0",
        "<texture type='checkerboard'><float name='uscale' value='2'/><float name='uoffset' value='0.5'/>
        <float name='vscale' value='3'/></texture>",
    );
    let Texture::Checkerboard { uv_transform, .. } = &desc.textures[0] else {
        panic!()
    };
    assert_eq!(*uv_transform * Vec3::ONE, Vec3::new(3.0, 3.0, 1.0));
}

#[test]
fn bsdf_models_of_old_files_are_supported() {
    let desc = load_version(
        "0.6.0",
        "<bsdf type='roughdiffuse'><spectrum name='reflectance' value='0.1, 0.2, 0.3'/><float name='alpha' value='1'/></bsdf>
        <bsdf type='phong'><integer name='exponent' value='10'/></bsdf>
        <bsdf type='ward'><string name='variant' value='ward-duer'/><float name='alphaU' value='0.3'/></bsdf>",
    );
    let Material::RoughDiffuse {
        reflectance,
        alpha,
        variant,
    } = &desc.materials[0]
    else {
        panic!()
    };
    assert_eq!(*reflectance, ColorInput::Constant(Rgb::new(0.1, 0.2, 0.3)));
    assert_eq!(*alpha, FloatInput::Constant(1.0));
    assert_eq!(*variant, OrenNayarVariant::Full);
    assert!(matches!(
        desc.materials[1],
        Material::Phong {
            exponent: FloatInput::Constant(10.0),
            ..
        }
    ));
    let Material::Ward {
        variant,
        alpha_u,
        alpha_v,
        ..
    } = &desc.materials[2]
    else {
        panic!()
    };
    assert_eq!(*variant, WardVariant::WardDuer);
    assert_eq!(
        (*alpha_u, *alpha_v),
        (FloatInput::Constant(0.3), FloatInput::Constant(0.1))
    );
}

#[test]
fn reflectance_above_one_is_clamped_in_old_files_and_an_error_in_new_ones() {
    let xml = "<bsdf type='diffuse'><rgb name='reflectance' value='2'/></bsdf>";
    let message =
        "warning 2:53 `reflectance` of bsdf `diffuse` is outside of [0, 1]; it is clamped";
    assert_eq!(problems("0.6.0", xml), [message]);
    assert_eq!(
        problems("3.0.0", xml),
        ["error 2:53 `reflectance` of bsdf `diffuse` must be in [0, 1]"]
    );
}

#[test]
fn old_names_in_new_files_are_errors_with_a_suggestion() {
    let xml = "<bsdf type='dielectric'><float name='intIOR' value='1.5'/></bsdf>";
    assert_eq!(
        problems("3.0.0", xml),
        ["error 2:38 bsdf `dielectric` has no parameter `intIOR` (did you mean `int_ior`?)"]
    );
    assert_eq!(problems("0.6.0", xml), Vec::<String>::new());
}

#[test]
fn references_are_resolved_after_old_parameters_are_removed() {
    let desc = load_version(
        "0.6.0",
        "<spectrum type='srgb' id='red'><rgb name='color' value='1 0 0'/></spectrum>
        <texture type='checkerboard'><float name='uscale' value='2'/><ref name='color0' id='red'/></texture>",
    );
    let Texture::Checkerboard { color0, .. } = &desc.textures[0] else {
        panic!()
    };
    assert_eq!(*color0, ColorInput::Constant(Rgb::new(1.0, 0.0, 0.0)));
}
