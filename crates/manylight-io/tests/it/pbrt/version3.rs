//! What PBRT v3 means by other rules than v4: materials, names, blocks, films, lights.

use super::PbrtFiles;
use manylight::bsdf::Material;
use manylight::bsdf::material::Roughness;
use manylight::color::Rgb;
use manylight::emitters::{Emitter, SpotFalloff};
use manylight::ids::MaterialId;
use manylight::math::Vec2;
use manylight::scene::SceneDesc;
use manylight::texture::{ColorInput, FloatInput};

/// A file of PBRT v3 with `world`. Line 1 of `world` is line 3 of the file.
fn files(world: &str) -> PbrtFiles {
    let text = format!(
        "Camera \"perspective\" Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
         WorldBegin LightSource \"infinite\"\n{world}\nWorldEnd\n"
    );
    PbrtFiles::new(text.as_bytes(), &[])
}

/// The description of a file of PBRT v3, and the warnings but those of old names.
fn load(world: &str) -> (SceneDesc, Vec<String>) {
    let loaded = files(world).load();
    let messages = loaded.warnings.iter().map(|w| w.message().to_owned());
    let others = messages.filter(|message| !message.contains("is read as"));
    (loaded.desc, others.collect())
}

/// The description of a file of PBRT v3 that loads without other warnings.
fn quiet(world: &str) -> SceneDesc {
    let (desc, warnings) = load(world);
    assert!(warnings.is_empty(), "{warnings:?}");
    desc
}

/// The leaves of a material with their weights; `TwoSided` is left out.
fn leaves(desc: &SceneDesc, id: MaterialId) -> Vec<(f32, &Material)> {
    let number = |input: &FloatInput| match input {
        FloatInput::Constant(value) => *value,
        FloatInput::Texture(_) => panic!("a constant weight"),
    };
    let times = |id: MaterialId, factor: f32| {
        let inner = leaves(desc, id).into_iter();
        inner
            .map(|(weight, leaf)| (weight * factor, leaf))
            .collect::<Vec<_>>()
    };
    match &desc.materials[id.index()] {
        Material::TwoSided { front, .. } => leaves(desc, *front),
        Material::Blend {
            weight,
            first,
            second,
        } => {
            let w = number(weight);
            let mut all = times(*first, 1.0 - w);
            all.extend(times(*second, w));
            all
        }
        Material::Mask { opacity, inner } => {
            let mut all = times(*inner, number(opacity));
            all.push((1.0 - number(opacity), &Material::Null));
            all
        }
        leaf => vec![(1.0, leaf)],
    }
}

/// The leaves of the material of the last primitive.
fn last(desc: &SceneDesc) -> Vec<(f32, &Material)> {
    leaves(desc, desc.primitives.last().unwrap().material)
}

fn color(input: &ColorInput) -> Rgb {
    match input {
        ColorInput::Constant(color) => *color,
        ColorInput::Texture(_) => panic!("a constant color"),
    }
}

fn near(found: Rgb, expected: [f32; 3]) {
    let off = found
        .zip(expected.into(), |a, b| (a - b).abs())
        .max_channel();
    assert!(off < 1e-5, "{found:?} {expected:?}");
}

/// Color of a leaf times its weight, by the kind of the leaf.
fn part(leaves: &[(f32, &Material)], name: &str) -> Rgb {
    let of = |(weight, leaf): &(f32, &Material)| {
        let (kind, input) = match leaf {
            Material::Diffuse { reflectance } => ("diffuse", reflectance),
            Material::DiffuseTransmitter { transmittance, .. } => ("through", transmittance),
            Material::Conductor {
                eta,
                k,
                specular_reflectance,
                roughness,
            } => {
                assert_eq!((color(eta).r, color(k)), (1.5, Rgb::BLACK));
                let kind = if roughness.is_some() {
                    "facets"
                } else {
                    "mirror"
                };
                (kind, specular_reflectance)
            }
            Material::Dielectric {
                specular_transmittance,
                ..
            } => ("refraction", specular_transmittance),
            Material::ThinDielectric {
                eta: 1.0,
                specular_transmittance,
                ..
            } => ("clear", specular_transmittance),
            other => panic!("{other:?}"),
        };
        (kind == name).then(|| color(input) * *weight)
    };
    leaves.iter().filter_map(of).sum()
}

#[test]
fn plastic_is_the_sum_of_a_lambertian_and_of_microfacets() {
    let desc = quiet(
        "Material \"plastic\" \"rgb Kd\" [ .6 .5 .4 ] \"rgb Ks\" [ .3 .2 .1 ] Shape \"sphere\"",
    );
    let sum = last(&desc);
    assert_eq!(sum.len(), 2);
    near(part(&sum, "diffuse"), [0.6, 0.5, 0.4]);
    near(part(&sum, "facets"), [0.3, 0.2, 0.1]);
    // Without one of them, the other one remains as it is.
    let desc = quiet("Material \"plastic\" \"rgb Ks\" [ 0 0 0 ] Shape \"sphere\"");
    assert!(matches!(last(&desc)[..], [(1.0, Material::Diffuse { .. })]));
}

#[test]
fn microfacets_are_rough_at_roughness_0_but_those_of_glass() {
    let alpha = |material: &str| {
        let desc = quiet(&format!(
            "Material {material} \"float roughness\" 0 Shape \"sphere\""
        ));
        let found = last(&desc).into_iter().find_map(|(_, leaf)| match leaf {
            Material::Conductor { roughness, .. } | Material::Dielectric { roughness, .. } => {
                roughness.as_ref().map(|r: &Roughness| r.alpha_u)
            }
            _ => None,
        });
        match found {
            Some(FloatInput::Constant(alpha)) => alpha,
            _ => 0.0,
        }
    };
    // PBRT v3's polynomial at the roughness 0.001, below which it does not go.
    for material in ["\"plastic\"", "\"metal\"", "\"uber\"", "\"translucent\""] {
        assert!(
            (alpha(material) - 0.0474).abs() < 1e-3,
            "{material} {}",
            alpha(material)
        );
    }
    assert_eq!(alpha("\"glass\""), 0.0);
}

#[test]
fn uber_has_coloured_opacity_and_mirrors_by_fresnel() {
    let desc = quiet(
        "Material \"uber\" \"rgb Kd\" [ .4 .4 .4 ] \"rgb Ks\" [ 0 0 0 ] \"rgb Kr\" [ .5 .5 .5 ] \"rgb opacity\" [ 1 .5 .2 ]\n\
         Shape \"sphere\"",
    );
    let sum = last(&desc);
    near(part(&sum, "diffuse"), [0.4, 0.2, 0.08]);
    near(part(&sum, "mirror"), [0.5, 0.25, 0.1]);
    near(part(&sum, "clear"), [0.0, 0.5, 0.8]);
    let desc = quiet(
        "Material \"uber\" \"rgb Kt\" [ .3 .2 .1 ] \"rgb opacity\" [ .5 .5 .5 ] Shape \"sphere\"",
    );
    let sum = last(&desc);
    near(part(&sum[..3], "diffuse"), [0.125; 3]);
    near(part(&sum[..3], "facets"), [0.125; 3]);
    near(part(&sum[..3], "refraction"), [0.15, 0.1, 0.05]);
    assert!(matches!(sum[3], (0.5, Material::Null)));
}

#[test]
fn translucent_reflects_and_transmits_in_colours() {
    let desc = quiet(
        "Material \"translucent\" \"rgb Kd\" [ 1 .5 .5 ] \"rgb Ks\" [ .5 .5 .5 ] \"rgb reflect\" [ .5 .5 1 ] \"rgb transmit\" [ .2 0 0 ]\n\
         Shape \"sphere\"",
    );
    let sum = last(&desc);
    near(part(&sum, "diffuse"), [0.5, 0.25, 0.5]);
    near(part(&sum, "through"), [0.2, 0.0, 0.0]);
    near(part(&sum, "refraction"), [0.1, 0.0, 0.0]);
}

const PAIR: &str = "MakeNamedMaterial \"a\" \"string type\" \"matte\" \"rgb Kd\" [ .8 .8 .8 ]\n\
    MakeNamedMaterial \"b\" \"string type\" \"plastic\" \"rgb Kd\" [ .1 .1 .1 ] \"rgb Ks\" [ .2 .2 .2 ]\n";

#[test]
fn the_amount_of_mixtures_is_a_color() {
    let mixed = |amount: &str| {
        format!(
            "{PAIR} Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" {amount} Shape \"sphere\""
        )
    };
    for gray in ["\"rgb amount\" [ .25 .25 .25 ]", "\"float amount\" .25"] {
        let desc = quiet(&mixed(gray));
        let sum = last(&desc);
        near(part(&sum, "diffuse"), [0.25 * 0.8 + 0.75 * 0.1; 3]);
        near(part(&sum, "facets"), [0.75 * 0.2; 3]);
    }
    let desc = quiet(&mixed("\"color amount\" [ .5 .25 1 ]"));
    let sum = last(&desc);
    near(part(&sum, "diffuse"), [0.45, 0.275, 0.8]);
    near(part(&sum, "facets"), [0.1, 0.15, 0.0]);
}

#[test]
fn a_colored_texture_as_amount_warns_once_it_is_loaded() {
    let warnings = |kind: &str, values: &str| {
        let texture =
            format!("Texture \"t\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [ {values} ]\n");
        let mix = format!(
            "Material \"{kind}\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"texture amount\" \"t\"\n\
             Shape \"sphere\""
        );
        load(&format!("{texture}{PAIR}{mix}")).1
    };
    assert_eq!(warnings("mix", ".3 .3 .3"), Vec::<String>::new());
    assert_eq!(
        warnings("mix", ".3 .4 .3"),
        ["`amount` of material `mix` is colored; its luminance is used"]
    );
}

#[test]
fn names_have_the_definition_before_their_use() {
    let desc = quiet(
        "Texture \"t\" \"color\" \"constant\" \"rgb value\" [ .9 0 0 ] Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"\n\
         Texture \"t\" \"color\" \"scale\" \"texture tex1\" \"t\" \"rgb tex2\" [ .5 1 1 ]\n\
         Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"\n\
         AttributeBegin Texture \"t\" \"color\" \"constant\" \"rgb value\" [ 0 0 .9 ]\n\
         Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\" AttributeEnd\n\
         Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"\n\
         MakeNamedMaterial \"m\" \"string type\" \"matte\" \"rgb Kd\" [ .1 0 0 ] NamedMaterial \"m\" Shape \"sphere\"\n\
         MakeNamedMaterial \"m\" \"string type\" \"matte\" \"rgb Kd\" [ .2 0 0 ] Shape \"sphere\"\n\
         NamedMaterial \"m\" Shape \"sphere\"",
    );
    let colors: Vec<[f32; 3]> = desc
        .primitives
        .iter()
        .map(|primitive| part(&leaves(&desc, primitive.material), "diffuse").to_array())
        .collect();
    assert_eq!(
        colors,
        [
            [0.9, 0.0, 0.0],
            [0.45, 0.0, 0.0],
            [0.0, 0.0, 0.9],
            [0.45, 0.0, 0.0],
            [0.1, 0.0, 0.0],
            [0.1, 0.0, 0.0],
            [0.2, 0.0, 0.0]
        ]
    );
    // In PBRT v4 this is an error.
    let twice = "Texture \"t\" \"spectrum\" \"constant\" Texture \"t\" \"spectrum\" \"constant\"";
    assert_eq!(
        super::problems(twice),
        ["error 2:43 the texture `t` is defined twice"]
    );
}

#[test]
fn names_that_version_3_does_not_find_warn() {
    let (desc, warnings) = load(
        "AttributeBegin Texture \"t\" \"color\" \"constant\" \"rgb value\" [ .9 0 0 ] AttributeEnd\n\
         Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"",
    );
    near(part(&last(&desc), "diffuse"), [0.9, 0.0, 0.0]);
    assert_eq!(
        warnings,
        ["PBRT v3 does not find `t` here: it is defined later or in another block"]
    );
}

#[test]
fn blocks_are_counted() {
    let red = "Material \"matte\" \"rgb Kd\" [ .8 0 0 ]";
    let desc = quiet(&format!(
        "AttributeBegin ObjectBegin \"o\" AttributeBegin {red} Shape \"sphere\" AttributeEnd\n\
         AttributeEnd Shape \"disk\" ObjectEnd ObjectInstance \"o\" Shape \"cylinder\""
    ));
    assert_eq!(desc.groups.len(), 1);
    assert_eq!((desc.groups[0].len(), desc.primitives.len()), (2, 1));
    near(
        part(&leaves(&desc, desc.groups[0][0].material), "diffuse"),
        [0.8, 0.0, 0.0],
    );
    near(part(&last(&desc), "diffuse"), [0.5; 3]);
    // Ends without a beginning, and beginnings without an end, are passed over with a message.
    let (_, warnings) = load("AttributeEnd Shape \"sphere\" AttributeBegin");
    assert_eq!(
        warnings,
        [
            "`AttributeEnd` without `AttributeBegin`",
            "`AttributeBegin` has no `AttributeEnd` before the end of the file"
        ]
    );
    assert_eq!(
        super::problems("ObjectBegin \"o\" AttributeEnd AttributeBegin ObjectEnd")[0],
        "error 2:17 found `AttributeEnd`, expected `ObjectEnd`"
    );
}

#[test]
fn included_text_may_end_a_block() {
    let text = super::document("AttributeBegin Scale 2 2 2 Include \"a.pbrt\" Shape \"disk\"");
    let loaded = PbrtFiles::new(text.as_bytes(), &[("a.pbrt", b"AttributeEnd")]).load();
    let scale = loaded.desc.primitives[0]
        .world_from_object
        .matrix3
        .x_axis
        .length();
    assert_eq!((scale, loaded.warnings.len()), (1.0, 0));
    let text = super::document("AttributeBegin Import \"a.pbrt\" AttributeEnd");
    let problems = PbrtFiles::new(text.as_bytes(), &[("a.pbrt", b"AttributeEnd")]).problems();
    assert_eq!(
        problems[0],
        "error 1:1 `AttributeEnd` without `AttributeBegin`"
    );
}

#[test]
fn the_scale_of_the_film_multiplies_the_picture() {
    for film in ["\"image\"", "\"rgb\""] {
        let text = format!(
            "Camera \"perspective\" Film {film} \"float scale\" 3 WorldBegin\n\
             LightSource \"infinite\" \"rgb L\" [ .5 .5 .5 ] LightSource \"point\"\n\
             AreaLightSource \"diffuse\" \"rgb L\" [ 2 2 2 ] Shape \"sphere\""
        );
        let desc = PbrtFiles::new(text.as_bytes(), &[]).load().desc;
        let emitted = desc.emitters.iter().map(|emitter| match emitter {
            Emitter::Constant { radiance } => radiance.r,
            Emitter::Point { intensity, .. } => intensity.r,
            Emitter::Area { radiance } => color(radiance).r,
            other => panic!("{other:?}"),
        });
        assert_eq!(emitted.collect::<Vec<f32>>(), [1.5, 3.0, 6.0]);
    }
}

#[test]
fn texture_coordinates_are_red_and_green() {
    let desc = quiet(
        "Texture \"t\" \"color\" \"uv\" \"float uscale\" 2 Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"",
    );
    let leaves = last(&desc);
    let (_, Material::Diffuse { reflectance }) = leaves[0] else {
        panic!("{leaves:?}")
    };
    for (uv, expected) in [([0.2, 0.7], [0.4, 0.7, 0.0]), ([0.9, 1.3], [0.8, 0.3, 0.0])] {
        let found = reflectance.eval(Vec2::from(uv), &desc.textures);
        let off = found
            .zip(expected.into(), |a, b| (a - b).abs())
            .max_channel();
        assert!(off < 1e-3, "{found:?} {expected:?}");
    }
}

#[test]
fn tables_of_materials_become_gray_and_must_be_there() {
    let world = "Material \"fourier\" \"string bsdffile\" \"roughglass.bsdf\" Shape \"sphere\"";
    let problems = files(world).problems();
    assert!(
        problems
            .iter()
            .any(|p| p.contains("the table of the material `roughglass.bsdf` does not exist")),
        "{problems:?}"
    );
    let text = format!(
        "Film \"image\" Camera \"perspective\" WorldBegin LightSource \"infinite\" {world}"
    );
    let there = PbrtFiles::new(text.as_bytes(), &[("roughglass.bsdf", b"SCATFUN")]).load();
    near(part(&last(&there.desc), "diffuse"), [0.5; 3]);
}

#[test]
fn spots_fade_by_the_fourth_power() {
    let desc = quiet("LightSource \"spot\" \"float coneangle\" 40 \"float conedeltaangle\" 20");
    let Some(Emitter::Spot { falloff, .. }) = desc.emitters.last() else {
        panic!("{:?}", desc.emitters)
    };
    assert_eq!(*falloff, SpotFalloff::QuarticCosine);
}

#[test]
fn substrate_has_the_model_of_its_name() {
    let desc = quiet(
        "Material \"substrate\" \"rgb Ks\" [ .1 .2 .3 ] \"float vroughness\" 1 Shape \"sphere\"",
    );
    let leaves = last(&desc);
    let (
        _,
        Material::Substrate {
            diffuse_reflectance,
            specular_reflectance,
            roughness,
        },
    ) = leaves[0]
    else {
        panic!("{leaves:?}")
    };
    near(color(diffuse_reflectance), [0.5; 3]);
    near(color(specular_reflectance), [0.1, 0.2, 0.3]);
    let alphas = [roughness.alpha_u, roughness.alpha_v].map(|alpha| match alpha {
        FloatInput::Constant(alpha) => alpha,
        FloatInput::Texture(_) => 0.0,
    });
    assert!(
        (alphas[0] - 0.4617).abs() < 1e-3 && (alphas[1] - 1.6214).abs() < 1e-3,
        "{alphas:?}"
    );
}

#[test]
fn disney_surfaces_may_be_thin() {
    let desc = quiet(
        "Material \"disney\" \"bool thin\" \"true\" \"float difftrans\" 1.2 Shape \"sphere\"",
    );
    let leaves = last(&desc);
    let (_, Material::PrincipledThin(thin)) = leaves[0] else {
        panic!("{leaves:?}")
    };
    assert_eq!(thin.diff_trans, FloatInput::Constant(1.2));
}

#[test]
fn a_world_that_ends_is_one_of_version_3() {
    // Spots tell the versions apart.
    let falloff = |text: &str| {
        let text = format!("{text} LightSource \"spot\" WorldEnd");
        let desc = PbrtFiles::new(text.as_bytes(), &[]).load().desc;
        match desc.emitters.last() {
            Some(Emitter::Spot { falloff, .. }) => *falloff,
            other => panic!("{other:?}"),
        }
    };
    let camera = "Camera \"perspective\"";
    assert_eq!(
        falloff(&format!("{camera} WorldBegin")),
        SpotFalloff::QuarticCosine
    );
    assert_eq!(
        falloff(&format!("{camera} Film \"rgb\" WorldBegin")),
        SpotFalloff::SmoothCosine
    );
}
