//! Layers of materials: coats with normals of their own, thin films, diffuse transmission, and glass
//! with dispersion.

use super::materials::{close, color_at, document, inner, material_of, principled};
use super::*;
use manylight::bsdf::Material;
use manylight::bsdf::material::CoatReflection;
use manylight::color::Rgb;
use manylight::ids::MaterialId;
use manylight::math::{Vec2, Vec3};
use manylight::texture::FloatInput;
use std::f32::consts::{FRAC_PI_2, TAU};

/// The triangle with a dielectric of this base color and these extensions, which loads without a
/// warning.
fn extended(color: [f32; 3], extensions: Value) -> SceneDesc {
    let [r, g, b] = color;
    let folder = Folder::new(&document(json!({
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0.5, "baseColorFactor": [r, g, b, 1] },
        "extensions": extensions
    })));
    let loaded = load_scene(&folder.file, &LoadOptions::default()).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.desc
}

/// The material with a normal texture of its own, and one of its coat.
fn coated(base: Option<Value>, coat: Option<Value>) -> SceneDesc {
    let mut material = json!({
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0.5 },
        "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.3 } }
    });
    if let Some(base) = base {
        material["normalTexture"] = base;
    }
    if let Some(coat) = coat {
        material["extensions"]["KHR_materials_clearcoat"]["clearcoatNormalTexture"] = coat;
    }
    let folder = Folder::new(&document(material));
    let loaded = load_scene(&folder.file, &LoadOptions::default()).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.desc
}

/// The parts of a sum, with their first wrappers.
fn parts(desc: &SceneDesc, material: &Material) -> Vec<Material> {
    match material {
        Material::Sum { first, second } => [*first, *second]
            .into_iter()
            .flat_map(|id: MaterialId| parts(desc, inner(desc, id)))
            .collect(),
        other => vec![other.clone()],
    }
}

#[test]
fn coats_have_normals_of_their_own() {
    let texture = || Some(json!({ "index": 0 }));
    // Equal normals: one model.
    for desc in [coated(None, None), coated(texture(), texture())] {
        let layers = principled(&desc).layers.unwrap();
        assert_eq!(layers.coat_reflection, CoatReflection::Here);
        assert_eq!(parts(&desc, material_of(&desc, 0)).len(), 1);
    }
    // A smooth coat over bumps, and the reverse.
    let scaled = Some(json!({ "index": 0, "scale": 0.25 }));
    for (base, coat, tilted) in [
        (texture(), None, [true, false]),
        (None, texture(), [false, true]),
        (texture(), scaled, [true, true]),
    ] {
        let desc = coated(base, coat);
        let layers = principled(&desc).layers.unwrap();
        assert_eq!(layers.coat_reflection, CoatReflection::Apart);
        let parts = parts(&desc, material_of(&desc, 0));
        let is_tilted = |part: &Material| matches!(part, Material::NormalMap { .. });
        let found: Vec<bool> = parts.iter().map(is_tilted).collect();
        assert_eq!(found, tilted);
        let reflection = desc.materials.iter().find_map(|material| match material {
            Material::Conductor {
                specular_reflectance,
                roughness,
                ..
            } => Some((*specular_reflectance, roughness.unwrap().alpha_u)),
            _ => None,
        });
        let (weight, alpha) = reflection.unwrap();
        assert!(close(color_at(&desc, weight, 0.5), [0.5; 3]));
        assert!(matches!(alpha, FloatInput::Constant(alpha) if (alpha - 0.09).abs() < 1e-6));
    }
}

/// Values of the scattering function of the triangle, times the cosine of `wi`.
fn values(desc: SceneDesc, pairs: &[(Vec3, Vec3)]) -> Vec<Rgb> {
    use manylight::bsdf::Lobes;
    use manylight::geometry::Ray;
    use manylight::scene::Scene;
    let scene = Scene::build(desc, 0).unwrap();
    let ray = Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z);
    let (_, x) = scene.intersect(&ray).unwrap();
    let bsdf = scene.bsdf(&x);
    let value = |(wi, wo): &(Vec3, Vec3)| bsdf.f_cos_wi(*wi, *wo, Lobes::ALL);
    pairs.iter().map(value).collect()
}

fn at(cos: f32, phi: f32) -> Vec3 {
    let sin = (1.0 - cos * cos).sqrt();
    Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

#[test]
fn a_coat_apart_is_the_coat_of_the_model_where_normals_are_equal() {
    // The scale 0 flattens the normals of the coat, which makes it another material.
    let flat = Some(json!({ "index": 0, "scale": 0 }));
    let pairs: Vec<(Vec3, Vec3)> = (1..10)
        .map(|i| (at(0.1 * i as f32, 0.3), at(0.75, 3.0)))
        .collect();
    let [one, two] = [coated(None, None), coated(None, flat)].map(|desc| values(desc, &pairs));
    for (one, two) in one.into_iter().zip(two) {
        assert!((one.g / two.g - 1.0).abs() < 2e-3, "{one:?} {two:?}");
    }
}

/// Fresnel's equations for an interface of index 1.5.
fn fresnel(cos: f32) -> f32 {
    let t = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
    let (s, p) = (
        (cos - 1.5 * t) / (cos + 1.5 * t),
        (t - 1.5 * cos) / (t + 1.5 * cos),
    );
    0.5 * (s * s + p * p)
}

#[test]
fn diffuse_transmission_is_a_base_under_the_interface() {
    let desc = extended(
        [0.8, 0.8, 0.8],
        json!({ "KHR_materials_diffuse_transmission": {
            "diffuseTransmissionFactor": 0.25, "diffuseTransmissionColorFactor": [1, 0.5, 0]
        } }),
    );
    // fresnel_mix(base = mix(color / π, transmission color / π, 0.25)), at half vectors with the
    // mirrored direction.
    let mut pairs = Vec::new();
    for cos in [0.2f32, 0.5, 0.9] {
        for phi in [0.0, 1.0, 2.5] {
            for side in [1.0, -1.0] {
                let wi = at(cos, phi) * Vec3::new(1.0, 1.0, -side);
                pairs.push((wi, at(0.6, 0.0) * Vec3::new(1.0, 1.0, side)));
            }
        }
    }
    for ((wi, wo), found) in pairs.iter().zip(values(desc, &pairs)) {
        let half = 0.5 * (*wi * Vec3::new(1.0, 1.0, -1.0) + *wo).length();
        let passing = (1.0 - fresnel(half)) * wi.z.abs() / std::f32::consts::PI;
        let expected = [0.25 * passing, 0.125 * passing, 0.0];
        for (a, b) in found.to_array().into_iter().zip(expected) {
            assert!(
                (a - b).abs() < 1e-4 * b + 1e-6,
                "{found:?} for {expected:?}"
            );
        }
    }
}

/// Flux of both sides over incident flux.
fn total_albedo(desc: SceneDesc, cos: f32) -> [Rgb; 2] {
    let steps = [200, 200];
    let cell = FRAC_PI_2 / steps[0] as f32 * TAU / steps[1] as f32;
    [1.0, -1.0].map(|side| {
        let mut weights = Vec::new();
        let mut pairs = Vec::new();
        for i in 0..steps[0] * steps[1] {
            let theta = (i / steps[1]) as f32 + 0.5;
            let theta = theta * FRAC_PI_2 / steps[0] as f32;
            let phi = ((i % steps[1]) as f32 + 0.5) * TAU / steps[1] as f32;
            let wi = at(theta.cos(), phi) * Vec3::new(1.0, 1.0, side);
            pairs.push((wi, at(cos, 0.0)));
            weights.push(theta.sin() * cell);
        }
        let found = values(desc.clone(), &pairs);
        found.into_iter().zip(weights).map(|(v, w)| v * w).sum()
    })
}

#[test]
fn diffuse_transmission_keeps_the_energy_of_diffuse_reflection() {
    let material = |factor: f32| {
        extended(
            [1.0, 1.0, 1.0],
            json!({ "KHR_materials_diffuse_transmission": { "diffuseTransmissionFactor": factor } }),
        )
    };
    for cos in [0.9, 0.5, 0.2] {
        let [reflected, _] = total_albedo(material(0.0), cos);
        let [front, back] = total_albedo(material(0.4), cos);
        let sum = front.g + back.g;
        assert!(
            (sum / reflected.g - 1.0).abs() < 1e-3,
            "{sum} {reflected:?}"
        );
        assert!(back.g > 0.3, "{front:?} {back:?}");
    }
}

#[test]
fn diffuse_transmission_has_textures_and_no_metal() {
    let texture = json!({ "index": 0 });
    let desc = extended(
        [1.0, 1.0, 1.0],
        json!({ "KHR_materials_diffuse_transmission": {
            "diffuseTransmissionFactor": 0.5, "diffuseTransmissionTexture": texture,
            "diffuseTransmissionColorFactor": [1, 1, 0.5], "diffuseTransmissionColorTexture": texture
        } }),
    );
    let parts = parts(&desc, material_of(&desc, 0));
    let Some(Material::DiffuseTransmitter {
        transmittance,
        below: Some(below),
    }) = parts.get(1)
    else {
        panic!("{parts:?}")
    };
    // Opacity is 0.2 and the color 1, 0.2158, 0.0513.
    let color = color_at(&desc, *transmittance, 0.25);
    assert!(
        close(color, [0.1, 0.02158, 0.1 * 0.0513 * 0.5]),
        "{color:?}"
    );
    assert!((below.eta - 1.5).abs() < 1e-5);
    let diffuse = principled(&desc).layers.unwrap().diffuse;
    let diffuse = diffuse.eval(Vec2::new(0.25, 0.5), &desc.textures);
    assert!((diffuse - 0.9).abs() < 1e-3, "{diffuse}");

    let metal = load(&document(json!({
        "extensions": { "KHR_materials_diffuse_transmission": { "diffuseTransmissionFactor": 0.5 } }
    })));
    let [reflected, through] = total_albedo(metal, 0.5);
    assert!(through.is_black() && reflected.g > 0.3, "{through:?}");
}

#[test]
fn films_have_thickness_weight_and_index() {
    let texture = json!({ "index": 0 });
    let desc = extended(
        [0.5, 0.5, 0.5],
        json!({ "KHR_materials_iridescence": {
            "iridescenceFactor": 0.5, "iridescenceTexture": texture, "iridescenceIor": 1.8,
            "iridescenceThicknessMinimum": 200, "iridescenceThicknessMaximum": 800,
            "iridescenceThicknessTexture": texture
        } }),
    );
    let film = principled(&desc).layers.unwrap().film.unwrap();
    let value = |input: FloatInput| input.eval(Vec2::new(0.25, 0.5), &desc.textures);
    assert!((value(film.weight) - 0.5).abs() < 1e-3 && film.eta == 1.8);
    let expected = 200.0 + 600.0 * 128.0 / 255.0;
    assert!((value(film.thickness) - expected).abs() < 0.1);

    let desc = extended(
        [0.5, 0.5, 0.5],
        json!({ "KHR_materials_iridescence": { "iridescenceFactor": 1 } }),
    );
    let film = principled(&desc).layers.unwrap().film.unwrap();
    assert_eq!((film.eta, value(film.thickness)), (1.3, 400.0));
}

#[test]
fn a_film_colors_the_interface_and_keeps_light_from_the_base() {
    // By the formulas of the specification for index 1.3, 400 nm, a base of reflectance 0.04 and
    // the cosine 0.6 to the facet: mirror directions over a base with a Lambertian of albedo 1/2.
    const FILM: [f32; 3] = [0.020_440, 0.009_127, 0.043_316];
    let found = |weight: f32, color: f32| {
        let desc = extended(
            [color; 3],
            json!({ "KHR_materials_iridescence": { "iridescenceFactor": weight } }),
        );
        values(desc, &[(at(0.6, 0.0), at(0.6, std::f32::consts::PI))])[0].to_array()
    };
    let (bare, filmed) = (found(0.0, 0.0), found(1.0, 0.0));
    for (i, film) in FILM.into_iter().enumerate() {
        let ratio = filmed[i] / bare[i] * fresnel(0.6);
        assert!((ratio / film - 1.0).abs() < 5e-3, "{ratio} for {film}");
    }
    // Half of the film, and the diffuse part under the largest channel of it.
    let half = found(0.5, 0.0);
    for i in 0..3 {
        let expected = 0.5 * (bare[i] + filmed[i]);
        assert!((half[i] / expected - 1.0).abs() < 1e-4);
        let diffuse = found(0.5, 0.5)[i] - half[i];
        let reflected = 0.5 * (fresnel(0.6) + FILM[2]);
        let expected = 0.5 * (1.0 - reflected) * 0.6 / std::f32::consts::PI;
        assert!(
            (diffuse / expected - 1.0).abs() < 2e-3,
            "{diffuse} for {expected}"
        );
    }
}

#[test]
fn dispersion_has_an_index_for_each_channel() {
    let glass = |dispersion: f32| {
        extended(
            [0.25, 1.0, 1.0],
            json!({
                "KHR_materials_ior": { "ior": 1.8 },
                "KHR_materials_transmission": { "transmissionFactor": 1 },
                "KHR_materials_volume": { "thicknessFactor": 1 },
                "KHR_materials_dispersion": { "dispersion": dispersion }
            }),
        )
    };
    let desc = glass(2.0);
    let parts = parts(&desc, material_of(&desc, 0));
    assert_eq!(parts.len(), 3);
    // Half of the spread: 0.8 · 0.025 · 2.
    for (channel, (part, expected)) in parts.iter().zip([1.76, 1.8, 1.84]).enumerate() {
        let Material::Dielectric {
            eta,
            specular_reflectance,
            specular_transmittance,
            ..
        } = part
        else {
            panic!("{part:?}")
        };
        assert!((eta - expected).abs() < 1e-5);
        let of_channel =
            |value: f32| std::array::from_fn(|i| if i == channel { value } else { 0.0 });
        let [reflected, transmitted] = [specular_reflectance, specular_transmittance]
            .map(|color| color_at(&desc, *color, 0.5));
        assert!(close(reflected, of_channel(1.0)));
        let root = [0.5, 1.0, 1.0][channel];
        assert!(close(transmitted, of_channel(root)), "{transmitted:?}");
    }
    let plain = glass(0.0);
    assert!(matches!(
        material_of(&plain, 0),
        Material::Dielectric { .. }
    ));
}

/// The document with a closed tetrahedron of volume 1/6 in the place of the triangle.
fn tetrahedron(mut document: Value) -> Value {
    let corners = bytes_of(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let positions = add_accessor(&mut document, &corners, 5126, 4, "VEC3");
    let faces = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];
    let indices = add_accessor(&mut document, &faces, 5121, 12, "SCALAR");
    let primitive = "/meshes/0/primitives/0";
    let attributes = json!({ "POSITION": positions });
    set(
        &mut document,
        &format!("{primitive}/attributes"),
        attributes,
    );
    set(
        &mut document,
        &format!("{primitive}/indices"),
        json!(indices),
    );
    document
}

#[test]
fn bodies_absorb_along_paths() {
    let body = |distance: Value| {
        tetrahedron(document(json!({
            "pbrMetallicRoughness": {
                "metallicFactor": 0, "roughnessFactor": 0, "baseColorFactor": [0.25, 1, 1, 1]
            },
            "extensions": {
                "KHR_materials_transmission": { "transmissionFactor": 1 },
                "KHR_materials_volume": {
                    "thicknessFactor": 3, "attenuationColor": [0.5, 1, 0], "attenuationDistance": distance
                }
            }
        })))
    };
    let mut document = body(json!(2));
    // The distance is one in the world.
    set(&mut document, "/nodes/0/scale", json!([4, 4, 4]));
    let desc = load(&document);
    let [medium] = desc.media[..] else {
        panic!("{:?}", desc.media)
    };
    assert_eq!(medium.material, desc.primitives[0].material);
    let Rgb { r, g, b } = medium.absorption;
    assert!((r - 0.5 * 2.0f32.ln()).abs() < 1e-6 && g == 0.0, "{r} {g}");
    // Black as soon as possible, but finite.
    assert!(b > 40.0 && b.is_finite(), "{b}");
    let Material::Dielectric {
        specular_transmittance,
        ..
    } = material_of(&desc, 0)
    else {
        panic!()
    };
    let tint = color_at(&desc, *specular_transmittance, 0.5);
    assert!(close(tint, [0.5, 1.0, 1.0]), "{tint:?}");

    let found = Folder::new(&body(json!(-2))).problems();
    assert!(
        matches!(found.as_slice(), [only] if only.contains("attenuationDistance: found -2, expected positive")),
        "{found:?}"
    );
}

#[test]
fn what_layers_do_not_combine_is_named() {
    let film = json!({ "iridescenceFactor": 1 });
    let transmission = json!({ "transmissionFactor": 0.5 });
    let volume = json!({ "thicknessFactor": 1 });
    let material = |extensions: Value| {
        document(json!({
            "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": extensions
        }))
    };
    for (extensions, expected) in [
        (
            json!({ "KHR_materials_iridescence": film, "KHR_materials_transmission": transmission, "KHR_materials_volume": volume }),
            "/materials/0/extensions/KHR_materials_transmission: the thin film (KHR_materials_iridescence) of what transmits light is ignored",
        ),
        (
            json!({
                "KHR_materials_diffuse_transmission": { "diffuseTransmissionFactor": 0.5 },
                "KHR_materials_transmission": transmission, "KHR_materials_volume": volume,
                "KHR_materials_dispersion": { "dispersion": 1 }
            }),
            "the dispersion (KHR_materials_dispersion) of glass that is mixed with a base of several layers is ignored",
        ),
    ] {
        let found = Folder::new(&material(extensions)).problems();
        assert!(
            matches!(found.as_slice(), [only] if only.starts_with("warning") && only.contains(expected)),
            "{found:?}"
        );
    }
}

#[test]
fn broken_layers_are_one_message_each() {
    let path = |name: &str, member: &str| format!("/materials/0/extensions/{name}/{member}");
    for (name, member, value, expected) in [
        (
            "KHR_materials_iridescence",
            "iridescenceFactor",
            json!(2),
            "expected a number from 0 to 1",
        ),
        (
            "KHR_materials_iridescence",
            "iridescenceIor",
            json!(0.5),
            "expected at least 1",
        ),
        (
            "KHR_materials_iridescence",
            "iridescenceThicknessMaximum",
            json!(-1),
            "expected a thickness in nm of at least 0",
        ),
        (
            "KHR_materials_iridescence",
            "iridescenceThicknessTexture",
            json!({ "index": 7 }),
            "found 7",
        ),
        (
            "KHR_materials_diffuse_transmission",
            "diffuseTransmissionFactor",
            json!("half"),
            "expected a number",
        ),
        (
            "KHR_materials_diffuse_transmission",
            "diffuseTransmissionColorFactor",
            json!([1, 1]),
            "found 2 numbers, expected 3",
        ),
        (
            "KHR_materials_dispersion",
            "dispersion",
            json!(-1),
            "expected at least 0",
        ),
        (
            "KHR_materials_clearcoat",
            "clearcoatNormalTexture",
            json!({ "index": 7 }),
            "found 7",
        ),
    ] {
        let mut extension = json!({
            "iridescenceFactor": 1, "diffuseTransmissionFactor": 1, "clearcoatFactor": 1
        });
        extension[member] = value;
        let found = Folder::new(&document(json!({ "extensions": { name: extension } }))).problems();
        assert!(
            matches!(found.as_slice(), [only] if only.contains(&path(name, member)) && only.contains(expected)),
            "{name} {member}: {found:?}"
        );
    }
}
