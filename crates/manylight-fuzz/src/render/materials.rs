//! Materials.

use super::numbers::Numbers;
use super::textures::{color_input, float_input};
use manylight::bsdf::Material;
use manylight::bsdf::material::{
    BelowInterface, Bitangent, CoatReflection, ColorShift, ConstantRoughness, Distribution,
    OrenNayarVariant, PrincipledLayers, PrincipledMaterial, PrincipledThinMaterial, Roughness,
    ThinFilm, WardVariant,
};
use manylight::color::Rgb;
use manylight::ids::{MaterialId, TextureId};
use manylight::texture::{ColorInput, FloatInput};

pub(super) fn materials(numbers: &mut Numbers, textures: usize) -> Vec<Material> {
    let count = 1 + numbers.below(5);
    let mut list: Vec<Material> = (0..count)
        .map(|_| material(numbers, textures, count))
        .collect();
    if numbers.flag() {
        list.extend(coated(numbers, textures, count));
    }
    list
}

/// Three materials, the first of index `start`: a base under a clear coat, the reflection of that
/// coat, and the sum of both.
/// The parts of sums must share the light, so that arbitrary ones are none.
fn coated(numbers: &mut Numbers, textures: usize, start: usize) -> [Material; 3] {
    let base = PrincipledMaterial {
        spec_trans: FloatInput::Constant(0.0),
        layers: Some(layers(numbers, textures, CoatReflection::Apart)),
        ..principled(numbers, textures)
    };
    let gray = |v: f32| ColorInput::Constant(Rgb::splat(v));
    let alpha = float_input(numbers, textures, 1.0);
    let coat = Material::Conductor {
        eta: gray(1.5),
        k: gray(0.0),
        specular_reflectance: gray(numbers.unit()),
        roughness: Some(Roughness {
            distribution: Distribution::Ggx,
            alpha_u: alpha,
            alpha_v: alpha,
        }),
    };
    let sum = Material::Sum {
        first: MaterialId::from(start),
        second: MaterialId::from(start + 1),
    };
    [Material::Principled(Box::new(base)), coat, sum]
}

fn distribution(numbers: &mut Numbers) -> Distribution {
    numbers.choose(&[Distribution::Ggx, Distribution::Beckmann])
}

fn roughness(numbers: &mut Numbers, textures: usize) -> Option<Roughness> {
    (!numbers.rarely(3)).then(|| Roughness {
        distribution: distribution(numbers),
        alpha_u: float_input(numbers, textures, 1.0),
        alpha_v: float_input(numbers, textures, 1.0),
    })
}

fn bitangent(numbers: &mut Numbers, textures: usize) -> Bitangent {
    let sign = float_input(numbers, textures, 1.0);
    numbers.choose(&[
        Bitangent::RightHanded,
        Bitangent::AgainstV,
        Bitangent::Signed(sign),
    ])
}

/// One of `count` materials, in which others may be nested.
fn material(numbers: &mut Numbers, textures: usize, count: usize) -> Material {
    match numbers.below(20) {
        0..=11 => model(numbers, textures),
        12 => Material::Blend {
            weight: float_input(numbers, textures, 1.0),
            first: MaterialId::from(numbers.index(count)),
            second: MaterialId::from(numbers.index(count)),
        },
        13 | 14 => Material::Mask {
            opacity: float_input(numbers, textures, 1.0),
            inner: MaterialId::from(numbers.index(count)),
        },
        15 => Material::Null,
        16 | 17 => Material::TwoSided {
            front: MaterialId::from(numbers.index(count)),
            back: MaterialId::from(numbers.index(count)),
        },
        18 if textures > 0 => Material::BumpMap {
            texture: TextureId::from(numbers.index(textures)),
            scale: numbers.float(-2.0, 2.0),
            inner: MaterialId::from(numbers.index(count)),
        },
        19 if textures > 0 => Material::NormalMap {
            texture: TextureId::from(numbers.index(textures)),
            scale: numbers.float(-2.0, 2.0),
            bitangent: bitangent(numbers, textures),
            inner: MaterialId::from(numbers.index(count)),
        },
        _ => Material::default(),
    }
}

/// A scattering model.
fn model(numbers: &mut Numbers, textures: usize) -> Material {
    match numbers.below(12) {
        0 => Material::Diffuse {
            reflectance: color_input(numbers, textures, 1.0),
        },
        1 => Material::RoughDiffuse {
            reflectance: color_input(numbers, textures, 1.0),
            alpha: float_input(numbers, textures, 1.0),
            variant: numbers.choose(&[OrenNayarVariant::Qualitative, OrenNayarVariant::Full]),
        },
        2 => Material::DiffuseTransmitter {
            transmittance: color_input(numbers, textures, 1.0),
            below: numbers.flag().then(|| BelowInterface {
                eta: numbers.float(1.0, 2.0),
                coat: float_input(numbers, textures, 1.0),
            }),
        },
        3 => Material::Conductor {
            eta: color_input(numbers, textures, 2.0),
            k: color_input(numbers, textures, 5.0),
            specular_reflectance: color_input(numbers, textures, 1.0),
            roughness: roughness(numbers, textures),
        },
        4 => Material::Dielectric {
            eta: numbers.float(0.5, 2.0),
            specular_reflectance: color_input(numbers, textures, 1.0),
            specular_transmittance: color_input(numbers, textures, 1.0),
            roughness: roughness(numbers, textures),
        },
        5 => Material::ThinDielectric {
            eta: numbers.float(0.5, 2.0),
            specular_reflectance: color_input(numbers, textures, 1.0),
            specular_transmittance: color_input(numbers, textures, 1.0),
            roughness: roughness(numbers, textures),
        },
        6 => Material::Plastic {
            eta: numbers.float(1.0, 2.0),
            diffuse_reflectance: color_input(numbers, textures, 1.0),
            specular_reflectance: color_input(numbers, textures, 1.0),
            color_shift: numbers.choose(&[ColorShift::Linear, ColorShift::Nonlinear]),
            roughness: numbers.rarely(4).then(|| ConstantRoughness {
                distribution: distribution(numbers),
                alpha: numbers.unit(),
            }),
        },
        7 => Material::Phong {
            diffuse_reflectance: color_input(numbers, textures, 1.0),
            specular_reflectance: color_input(numbers, textures, 1.0),
            exponent: float_input(numbers, textures, 200.0),
        },
        8 => Material::Ward {
            variant: numbers.choose(&[
                WardVariant::Ward,
                WardVariant::WardDuer,
                WardVariant::Balanced,
            ]),
            diffuse_reflectance: color_input(numbers, textures, 1.0),
            specular_reflectance: color_input(numbers, textures, 1.0),
            alpha_u: float_input(numbers, textures, 1.0),
            alpha_v: float_input(numbers, textures, 1.0),
        },
        9 => Material::Principled(Box::new(principled(numbers, textures))),
        10 => Material::Substrate {
            diffuse_reflectance: color_input(numbers, textures, 1.0),
            specular_reflectance: color_input(numbers, textures, 1.0),
            roughness: Roughness {
                distribution: distribution(numbers),
                alpha_u: float_input(numbers, textures, 1.0),
                alpha_v: float_input(numbers, textures, 1.0),
            },
        },
        _ => Material::PrincipledThin(Box::new(principled_thin(numbers, textures))),
    }
}

fn principled(numbers: &mut Numbers, textures: usize) -> PrincipledMaterial {
    let mut input = |high| float_input(numbers, textures, high);
    let [
        roughness,
        anisotropic,
        metallic,
        spec_trans,
        spec_tint,
        sheen,
    ] = [1.0; 6].map(&mut input);
    let [sheen_tint, flatness, clearcoat, clearcoat_gloss] = [1.0; 4].map(&mut input);
    let layers = (numbers.flag()).then(|| layers(numbers, textures, CoatReflection::Here));
    PrincipledMaterial {
        base_color: color_input(numbers, textures, 1.0),
        roughness,
        anisotropic,
        metallic,
        spec_trans,
        eta: numbers.float(1.0, 2.0),
        spec_tint,
        sheen,
        sheen_tint,
        flatness,
        clearcoat,
        clearcoat_gloss,
        layers,
        diffuse_reflectance_sampling_rate: numbers.unit(),
        main_specular_sampling_rate: numbers.unit(),
        clearcoat_sampling_rate: numbers.unit(),
    }
}

fn layers(
    numbers: &mut Numbers,
    textures: usize,
    coat_reflection: CoatReflection,
) -> PrincipledLayers {
    PrincipledLayers {
        specular_tint: color_input(numbers, textures, 2.0),
        coat_roughness: float_input(numbers, textures, 1.0),
        coat_reflection,
        film: numbers.flag().then(|| ThinFilm {
            weight: float_input(numbers, textures, 1.0),
            eta: numbers.float(0.5, 2.5),
            thickness: float_input(numbers, textures, 1200.0),
        }),
        diffuse: float_input(numbers, textures, 1.0),
    }
}

fn principled_thin(numbers: &mut Numbers, textures: usize) -> PrincipledThinMaterial {
    let mut input = |high| float_input(numbers, textures, high);
    let [roughness, anisotropic, spec_trans, eta] = [1.0, 1.0, 1.0, 2.0].map(&mut input);
    let [spec_tint, sheen, sheen_tint, flatness, diff_trans] =
        [1.0, 1.0, 1.0, 1.0, 2.0].map(&mut input);
    PrincipledThinMaterial {
        base_color: color_input(numbers, textures, 1.0),
        roughness,
        anisotropic,
        spec_trans,
        eta,
        spec_tint,
        sheen,
        sheen_tint,
        flatness,
        diff_trans,
    }
}
