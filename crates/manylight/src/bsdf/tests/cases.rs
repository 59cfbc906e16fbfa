//! A case for every model and every wrapper.

use crate::bsdf::material::{
    BelowInterface, Bitangent, CoatReflection, ColorShift, ConstantRoughness, Distribution,
    OrenNayarVariant, PrincipledLayers, PrincipledMaterial, PrincipledThinMaterial, Roughness,
    ThinFilm, WardVariant,
};
use crate::bsdf::{Bsdf, Material, Materials};
use crate::color::Rgb;
use crate::geometry::{SurfacePoint, SurfaceRef};
use crate::ids::{MaterialId, PrimitiveId, TextureId};
use crate::image::Image;
use crate::math::{Frame, Mat3, Vec2, Vec3};
use crate::texture::{Bitmap, ColorInput, Filtering, FloatInput, Texture, Wrap};
use std::sync::LazyLock;

/// A material tree; the last entry is the root.
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) materials: Materials,
    pub(super) textures: Vec<Texture>,
}

pub(super) fn rgb(r: f32, g: f32, b: f32) -> ColorInput {
    ColorInput::Constant(Rgb::new(r, g, b))
}

pub(super) fn float(v: f32) -> FloatInput {
    FloatInput::Constant(v)
}

const WHITE: ColorInput = ColorInput::Constant(Rgb::WHITE);

fn rough(distribution: Distribution, u: f32, v: f32) -> Option<Roughness> {
    Some(Roughness {
        distribution,
        alpha_u: float(u),
        alpha_v: float(v),
    })
}

fn rough_coat(distribution: Distribution, alpha: f32) -> Option<ConstantRoughness> {
    Some(ConstantRoughness {
        distribution,
        alpha,
    })
}

pub(super) fn diffuse() -> Material {
    Material::Diffuse {
        reflectance: rgb(0.2, 0.5, 0.8),
    }
}

fn copper(roughness: Option<Roughness>) -> Material {
    let (eta, k) = (rgb(0.2, 0.92, 1.1), rgb(3.9, 2.45, 2.14));
    Material::Conductor {
        eta,
        k,
        specular_reflectance: WHITE,
        roughness,
    }
}

fn glass(eta: f32, roughness: Option<Roughness>) -> Material {
    Material::Dielectric {
        eta,
        specular_reflectance: WHITE,
        specular_transmittance: WHITE,
        roughness,
    }
}

/// A pane that is clearer than it is colored on the way through.
fn pane(eta: f32, roughness: Option<Roughness>) -> Material {
    Material::ThinDielectric {
        eta,
        specular_reflectance: rgb(1.0, 0.9, 0.8),
        specular_transmittance: rgb(0.9, 1.0, 0.7),
        roughness,
    }
}

fn plastic(
    eta: f32,
    tint: ColorInput,
    color_shift: ColorShift,
    roughness: Option<ConstantRoughness>,
) -> Material {
    let diffuse_reflectance = rgb(0.5, 0.3, 0.1);
    Material::Plastic {
        eta,
        diffuse_reflectance,
        specular_reflectance: tint,
        color_shift,
        roughness,
    }
}

fn varnish() -> Material {
    plastic(
        1.5,
        WHITE,
        ColorShift::Nonlinear,
        rough_coat(Distribution::Ggx, 0.2),
    )
}

fn principled(roughness: f32) -> PrincipledMaterial {
    PrincipledMaterial {
        base_color: rgb(0.6, 0.3, 0.2),
        roughness: float(roughness),
        anisotropic: float(0.0),
        metallic: float(0.0),
        spec_trans: float(0.0),
        eta: 1.5,
        spec_tint: float(0.0),
        sheen: float(0.0),
        sheen_tint: float(0.0),
        flatness: float(0.0),
        clearcoat: float(0.0),
        clearcoat_gloss: float(0.0),
        layers: None,
        diffuse_reflectance_sampling_rate: 1.0,
        main_specular_sampling_rate: 1.0,
        clearcoat_sampling_rate: 1.0,
    }
}

fn layers() -> PrincipledLayers {
    PrincipledLayers {
        specular_tint: WHITE,
        coat_roughness: float(0.0),
        coat_reflection: CoatReflection::Here,
        film: None,
        diffuse: float(1.0),
    }
}

/// A material under a thin film.
fn filmed(metallic: f32, weight: f32) -> Material {
    Material::Principled(Box::new(PrincipledMaterial {
        metallic: float(metallic),
        layers: Some(PrincipledLayers {
            specular_tint: rgb(1.0, 0.9, 0.8),
            film: Some(ThinFilm {
                weight: float(weight),
                eta: 1.3,
                thickness: float(420.0),
            }),
            ..layers()
        }),
        ..principled(0.45)
    }))
}

/// Glass whose index of refraction differs between the channels.
fn dispersing(roughness: Option<Roughness>) -> Vec<Material> {
    let part = |eta, color| Material::Dielectric {
        eta,
        specular_reflectance: color,
        specular_transmittance: color,
        roughness,
    };
    let sum = |first, second| Material::Sum {
        first: MaterialId(first),
        second: MaterialId(second),
    };
    vec![
        part(1.4, rgb(1.0, 0.0, 0.0)),
        part(1.5, rgb(0.0, 1.0, 0.0)),
        part(1.6, rgb(0.0, 0.0, 1.0)),
        sum(0, 1),
        sum(3, 2),
    ]
}

/// A base, the reflection of its coat, which may be tilted, and their sum.
fn coated_apart(tilted: Option<Material>) -> Vec<Material> {
    let base = Material::Principled(Box::new(PrincipledMaterial {
        clearcoat: float(0.8),
        layers: Some(PrincipledLayers {
            coat_reflection: CoatReflection::Apart,
            diffuse: float(0.7),
            ..layers()
        }),
        ..principled(0.5)
    }));
    let reflection = Material::Conductor {
        eta: rgb(1.5, 1.5, 1.5),
        k: ColorInput::Constant(Rgb::BLACK),
        specular_reflectance: rgb(0.8, 0.8, 0.8),
        roughness: rough(Distribution::Ggx, 0.15, 0.15),
    };
    let mut list = vec![base, reflection];
    list.extend(tilted);
    list.push(Material::Sum {
        first: MaterialId(0),
        second: MaterialId(list.len() as u32 - 1),
    });
    list
}

fn principled_thin(spec_trans: f32, roughness: f32) -> PrincipledThinMaterial {
    PrincipledThinMaterial {
        base_color: rgb(0.6, 0.3, 0.2),
        roughness: float(roughness),
        anisotropic: float(0.0),
        spec_trans: float(spec_trans),
        eta: float(1.5),
        spec_tint: float(0.0),
        sheen: float(0.0),
        sheen_tint: float(0.0),
        flatness: float(0.0),
        diff_trans: float(0.0),
    }
}

/// A pane that absorbs nothing.
pub(super) fn white_pane(alpha: f32) -> Case {
    let pane = Material::ThinDielectric {
        eta: 1.5,
        specular_reflectance: WHITE,
        specular_transmittance: WHITE,
        roughness: rough(Distribution::Ggx, alpha, alpha),
    };
    Case {
        name: "white_pane",
        materials: Materials::new(vec![pane]),
        textures: Vec::new(),
    }
}

/// Mitsuba's index of refraction for a value of `specular`.
fn eta_of_specular(specular: f32) -> f32 {
    2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
}

fn tilt(first: f32, second: f32, third: f32) -> Texture {
    let color = ColorInput::Constant(Rgb::new(first, second, third));
    Texture::Checkerboard {
        color0: color,
        color1: color,
        uv_transform: Mat3::IDENTITY,
    }
}

/// Three rows of four texels with the values 0 to 11.
fn ramp() -> Texture {
    let image = Image {
        width: 4,
        height: 3,
        channels: 1,
        data: (0..12).map(|i| i as f32).collect(),
    };
    Texture::Bitmap(Bitmap {
        image,
        filtering: Filtering::Bilinear,
        wrap: [Wrap::Repeat; 2],
        uv_transform: Mat3::IDENTITY,
    })
}

/// Every model and every wrapper, made once.
pub(super) fn cases() -> &'static [Case] {
    static CASES: LazyLock<Vec<Case>> = LazyLock::new(all_cases);
    &CASES
}

/// A name and a list of materials.
type Named = (&'static str, Vec<Material>);

fn diffuse_and_conductors() -> Vec<Named> {
    use Distribution::{Beckmann, Ggx};
    vec![
        ("diffuse", vec![diffuse()]),
        (
            "rough_diffuse",
            vec![Material::RoughDiffuse {
                reflectance: rgb(0.2, 0.5, 0.8),
                alpha: float(0.4),
                variant: OrenNayarVariant::Qualitative,
            }],
        ),
        (
            "rough_diffuse_full",
            vec![Material::RoughDiffuse {
                reflectance: rgb(0.2, 0.5, 0.8),
                alpha: float(0.5),
                variant: OrenNayarVariant::Full,
            }],
        ),
        (
            "substrate",
            vec![Material::Substrate {
                diffuse_reflectance: rgb(0.2, 0.5, 0.8),
                specular_reflectance: rgb(0.3, 0.05, 0.2),
                roughness: Roughness {
                    distribution: Ggx,
                    alpha_u: float(0.4),
                    alpha_v: float(0.2),
                },
            }],
        ),
        (
            "substrate_of_low_roughness",
            vec![Material::Substrate {
                diffuse_reflectance: rgb(0.2, 0.5, 0.8),
                specular_reflectance: rgb(0.3, 0.05, 0.2),
                roughness: Roughness {
                    distribution: Ggx,
                    alpha_u: float(0.05),
                    alpha_v: float(0.05),
                },
            }],
        ),
        ("conductor", vec![copper(None)]),
        ("rough_conductor_ggx", vec![copper(rough(Ggx, 0.3, 0.3))]),
        (
            "rough_conductor_beckmann_aniso",
            vec![Material::Conductor {
                eta: rgb(0.2, 0.92, 1.1),
                k: rgb(3.9, 2.45, 2.14),
                specular_reflectance: rgb(0.9, 0.8, 0.7),
                roughness: rough(Beckmann, 0.15, 0.4),
            }],
        ),
        (
            "rough_conductor_narrow",
            vec![copper(rough(Ggx, 0.05, 0.05))],
        ),
        (
            "rough_mirror",
            vec![Material::Conductor {
                eta: ColorInput::Constant(Rgb::BLACK),
                k: WHITE,
                specular_reflectance: WHITE,
                roughness: rough(Beckmann, 0.2, 0.2),
            }],
        ),
    ]
}

fn dielectrics() -> Vec<Named> {
    use Distribution::{Beckmann, Ggx};
    vec![
        ("glass", vec![glass(1.5, None)]),
        (
            "diffuse_transmitter",
            vec![Material::DiffuseTransmitter {
                transmittance: rgb(0.2, 0.5, 0.8),
                below: None,
            }],
        ),
        (
            "diffuse_transmitter_below",
            vec![Material::DiffuseTransmitter {
                transmittance: rgb(0.2, 0.5, 0.8),
                below: Some(BelowInterface {
                    eta: 1.7,
                    coat: float(0.8),
                }),
            }],
        ),
        ("dispersing_glass", dispersing(None)),
        ("rough_dispersing_glass", dispersing(rough(Ggx, 0.3, 0.3))),
        (
            "leaf",
            vec![
                Material::DiffuseTransmitter {
                    transmittance: rgb(0.4, 0.9, 0.2),
                    below: None,
                },
                diffuse(),
                Material::TwoSided {
                    front: MaterialId(1),
                    back: MaterialId(1),
                },
                Material::Blend {
                    weight: float(0.5),
                    first: MaterialId(2),
                    second: MaterialId(0),
                },
            ],
        ),
        (
            "thin_glass",
            vec![Material::ThinDielectric {
                eta: 1.5,
                specular_reflectance: WHITE,
                specular_transmittance: rgb(0.9, 0.8, 0.7),
                roughness: None,
            }],
        ),
        ("thin_rough_glass", vec![pane(1.5, rough(Ggx, 0.3, 0.3))]),
        (
            "thin_rough_glass_beckmann_aniso",
            vec![pane(1.33, rough(Beckmann, 0.2, 0.4))],
        ),
        (
            "thin_rough_glass_inverted",
            vec![pane(1.0 / 1.5, rough(Ggx, 0.25, 0.25))],
        ),
        (
            "thin_rough_glass_narrow",
            vec![pane(1.5, rough(Ggx, 0.05, 0.05))],
        ),
        (
            "rough_glass_ggx",
            vec![Material::Dielectric {
                eta: 1.5,
                specular_reflectance: rgb(0.9, 0.8, 0.7),
                specular_transmittance: rgb(0.5, 0.6, 0.9),
                roughness: rough(Ggx, 0.3, 0.3),
            }],
        ),
        (
            "rough_glass_beckmann_aniso",
            vec![glass(1.33, rough(Beckmann, 0.2, 0.4))],
        ),
        (
            "rough_glass_inverted",
            vec![glass(1.0 / 1.5, rough(Ggx, 0.25, 0.25))],
        ),
    ]
}

fn coats_and_empirical_models() -> Vec<Named> {
    use ColorShift::{Linear, Nonlinear};
    use Distribution::{Beckmann, Ggx};
    vec![
        (
            "plastic",
            vec![plastic(1.5, rgb(0.9, 0.8, 0.7), Linear, None)],
        ),
        (
            "plastic_nonlinear",
            vec![plastic(1.9, WHITE, Nonlinear, None)],
        ),
        ("rough_plastic_ggx", vec![varnish()]),
        (
            "rough_plastic_beckmann",
            vec![plastic(
                1.49 / 1.000_277,
                rgb(0.9, 0.8, 0.7),
                Linear,
                rough_coat(Beckmann, 0.1),
            )],
        ),
        (
            "rough_plastic_narrow",
            vec![plastic(1.5, WHITE, Linear, rough_coat(Ggx, 0.05))],
        ),
        (
            "phong",
            vec![Material::Phong {
                diffuse_reflectance: rgb(0.5, 0.3, 0.1),
                specular_reflectance: rgb(0.4, 0.4, 0.4),
                exponent: float(30.0),
            }],
        ),
        ("ward", vec![ward(WardVariant::Ward)]),
        ("ward_duer", vec![ward(WardVariant::WardDuer)]),
        ("ward_balanced", vec![ward(WardVariant::Balanced)]),
    ]
}

fn principled_models() -> Vec<Named> {
    vec![
        (
            "principled_plain",
            vec![Material::Principled(Box::new(PrincipledMaterial {
                eta: eta_of_specular(0.5),
                ..principled(0.5)
            }))],
        ),
        (
            "principled_metal",
            vec![Material::Principled(Box::new(PrincipledMaterial {
                metallic: float(0.7),
                anisotropic: float(0.6),
                eta: eta_of_specular(0.4),
                ..principled(0.4)
            }))],
        ),
        (
            "principled_full",
            vec![Material::Principled(Box::new(PrincipledMaterial {
                metallic: float(0.2),
                anisotropic: float(0.3),
                eta: 1.4,
                spec_tint: float(0.5),
                sheen: float(0.7),
                sheen_tint: float(0.4),
                flatness: float(0.5),
                clearcoat: float(0.8),
                clearcoat_gloss: float(0.3),
                ..principled(0.6)
            }))],
        ),
        (
            "principled_layered",
            vec![Material::Principled(Box::new(PrincipledMaterial {
                metallic: float(0.2),
                clearcoat: float(0.8),
                layers: Some(PrincipledLayers {
                    specular_tint: rgb(2.0, 1.0, 0.3),
                    coat_roughness: float(0.45),
                    ..layers()
                }),
                ..principled(0.4)
            }))],
        ),
        ("principled_film", vec![filmed(0.2, 0.8)]),
        ("principled_film_on_metal", vec![filmed(1.0, 1.0)]),
        (
            "principled_coat_apart_map",
            coated_apart(Some(Material::NormalMap {
                texture: TextureId(0),
                scale: 0.4,
                bitangent: Bitangent::AgainstV,
                inner: MaterialId(1),
            })),
        ),
        ("principled_coat_apart", coated_apart(None)),
        (
            "principled_glass",
            vec![Material::Principled(Box::new(PrincipledMaterial {
                metallic: float(0.1),
                spec_trans: float(0.8),
                spec_tint: float(0.3),
                clearcoat: float(0.5),
                clearcoat_gloss: float(0.4),
                ..principled(0.5)
            }))],
        ),
    ]
}

fn thin_models() -> Vec<Named> {
    vec![
        (
            "principled_thin",
            vec![Material::PrincipledThin(Box::new(PrincipledThinMaterial {
                diff_trans: float(0.8),
                ..principled_thin(0.4, 0.6)
            }))],
        ),
        (
            "principled_thin_full",
            vec![Material::PrincipledThin(Box::new(PrincipledThinMaterial {
                anisotropic: float(0.5),
                eta: float(1.4),
                spec_tint: float(0.6),
                sheen: float(0.7),
                sheen_tint: float(0.4),
                flatness: float(0.5),
                diff_trans: float(1.2),
                ..principled_thin(0.3, 0.7)
            }))],
        ),
        (
            "principled_thin_paper",
            vec![Material::PrincipledThin(Box::new(PrincipledThinMaterial {
                diff_trans: float(1.0),
                ..principled_thin(0.0, 0.5)
            }))],
        ),
        (
            "principled_thin_foil",
            vec![Material::PrincipledThin(Box::new(principled_thin(
                1.0, 0.35,
            )))],
        ),
    ]
}

/// Materials of which one lobe returns much less light than Fresnel's equations or the weights of
/// wrappers alone suggest.
pub(super) fn unequal_lobes() -> Vec<Case> {
    let black = ColorInput::Constant(Rgb::BLACK);
    let tinted = |reflection, transmission, roughness| Material::Dielectric {
        eta: 1.5,
        specular_reflectance: reflection,
        specular_transmittance: transmission,
        roughness,
    };
    let narrow = rough(Distribution::Ggx, 0.15, 0.15);
    let blend = |first| {
        vec![
            first,
            diffuse(),
            Material::Blend {
                weight: float(0.2),
                first: MaterialId(0),
                second: MaterialId(1),
            },
        ]
    };
    let named: Vec<Named> = vec![
        ("smooth screen", vec![tinted(WHITE, black, None)]),
        ("rough screen", vec![tinted(WHITE, black, narrow)]),
        (
            "rough green screen",
            vec![tinted(WHITE, rgb(0.0, 0.02, 0.0), narrow)],
        ),
        ("glass without reflection", vec![tinted(black, WHITE, None)]),
        (
            "dark plastic",
            vec![Material::Plastic {
                eta: 1.9,
                diffuse_reflectance: rgb(0.1, 0.1, 0.1),
                specular_reflectance: WHITE,
                color_shift: ColorShift::Nonlinear,
                roughness: None,
            }],
        ),
        (
            "principled",
            vec![Material::Principled(Box::new(principled(0.5)))],
        ),
        (
            "dark principled",
            vec![Material::Principled(Box::new(PrincipledMaterial {
                base_color: rgb(0.01, 0.01, 0.01),
                clearcoat: float(1.0),
                ..principled(0.5)
            }))],
        ),
        (
            "principled screen",
            vec![Material::Principled(Box::new(PrincipledMaterial {
                base_color: black,
                spec_trans: float(1.0),
                ..principled(0.4)
            }))],
        ),
        (
            "blend with black",
            blend(Material::Diffuse { reflectance: black }),
        ),
        (
            "blend with glass",
            blend(tinted(rgb(0.1, 0.1, 0.1), black, None)),
        ),
    ];
    let case = |(name, materials)| Case {
        name,
        materials: Materials::new(materials),
        textures: Vec::new(),
    };
    named.into_iter().map(case).collect()
}

fn untilted_wrappers() -> Vec<Named> {
    use Distribution::Ggx;
    let two_sided = |id: u32| Material::TwoSided {
        front: MaterialId(id),
        back: MaterialId(id),
    };
    vec![
        (
            "blend",
            vec![
                diffuse(),
                varnish(),
                Material::Blend {
                    weight: float(0.3),
                    first: MaterialId(0),
                    second: MaterialId(1),
                },
            ],
        ),
        (
            "mask",
            vec![
                diffuse(),
                Material::Mask {
                    opacity: float(0.3),
                    inner: MaterialId(0),
                },
            ],
        ),
        ("null", vec![Material::Null]),
        ("two_sided", vec![varnish(), two_sided(0)]),
        (
            "two_sided_different",
            vec![
                diffuse(),
                copper(rough(Ggx, 0.3, 0.3)),
                Material::TwoSided {
                    front: MaterialId(0),
                    back: MaterialId(1),
                },
            ],
        ),
    ]
}

fn tilts() -> Vec<Named> {
    use Distribution::Ggx;
    let two_sided = |id: u32| Material::TwoSided {
        front: MaterialId(id),
        back: MaterialId(id),
    };
    let bumped = |id: u32| Material::BumpMap {
        texture: TextureId(1),
        scale: 0.05,
        inner: MaterialId(id),
    };
    let mapped = |id: u32| Material::NormalMap {
        texture: TextureId(0),
        scale: 1.0,
        bitangent: Bitangent::RightHanded,
        inner: MaterialId(id),
    };
    vec![
        ("normal_map", vec![diffuse(), mapped(0)]),
        (
            "normal_map_scaled",
            vec![
                diffuse(),
                Material::NormalMap {
                    texture: TextureId(0),
                    scale: 0.5,
                    bitangent: Bitangent::AgainstV,
                    inner: MaterialId(0),
                },
            ],
        ),
        (
            "normal_map_left_handed",
            vec![
                diffuse(),
                Material::NormalMap {
                    texture: TextureId(0),
                    scale: 1.0,
                    bitangent: Bitangent::Signed(float(-0.5)),
                    inner: MaterialId(0),
                },
            ],
        ),
        (
            "normal_map_anisotropic",
            vec![copper(rough(Ggx, 0.15, 0.4)), mapped(0)],
        ),
        (
            "two_sided_normal_map",
            vec![diffuse(), mapped(0), two_sided(1)],
        ),
        (
            "normal_map_two_sided",
            vec![varnish(), two_sided(0), mapped(1)],
        ),
        (
            "normal_map_glass",
            vec![glass(1.5, rough(Ggx, 0.3, 0.3)), mapped(0)],
        ),
        ("bump_map", vec![diffuse(), bumped(0)]),
        (
            "bump_map_anisotropic",
            vec![copper(rough(Ggx, 0.15, 0.4)), bumped(0)],
        ),
        (
            "normal_map_plastic",
            vec![plastic(1.5, WHITE, ColorShift::Linear, None), mapped(0)],
        ),
    ]
}

/// A row of the table of reference values has the name of its case; not every case has one.
fn all_cases() -> Vec<Case> {
    let lists = [
        diffuse_and_conductors(),
        dielectrics(),
        coats_and_empirical_models(),
        principled_models(),
        thin_models(),
        untilted_wrappers(),
        tilts(),
    ];
    lists
        .into_iter()
        .flatten()
        .map(|(name, materials)| {
            let mild = matches!(
                name,
                "normal_map" | "normal_map_left_handed" | "normal_map_glass" | "normal_map_plastic"
            );
            let normal = if mild {
                tilt(0.65, 0.4, 0.9)
            } else {
                tilt(0.3, 0.6, 0.9)
            };
            Case {
                name,
                materials: Materials::new(materials),
                textures: vec![normal, ramp()],
            }
        })
        .collect()
}

fn ward(variant: WardVariant) -> Material {
    let (diffuse_reflectance, specular_reflectance) = (rgb(0.5, 0.3, 0.1), rgb(0.4, 0.4, 0.4));
    Material::Ward {
        variant,
        diffuse_reflectance,
        specular_reflectance,
        alpha_u: float(0.15),
        alpha_v: float(0.3),
    }
}

/// A point with the shading frame of the world's axes, the geometric normal `ng` and these texture
/// coordinates.
pub(super) fn surface_at(ng: Vec3, uv: Vec2) -> SurfacePoint {
    SurfacePoint {
        p: Vec3::ZERO,
        ng,
        frame: Frame {
            s: Vec3::X,
            t: Vec3::Y,
            n: Vec3::Z,
        },
        uv,
        dp_du: Vec3::X,
        dp_dv: Vec3::Y,
        at: SurfaceRef {
            primitive: PrimitiveId(0),
            element: 0,
            instance: SurfaceRef::NO_INSTANCE,
            coordinates: Vec2::ZERO,
        },
        offset: 0.0,
    }
}

impl Case {
    pub(super) fn bsdf(&self, ng: Vec3) -> Bsdf<'_> {
        self.bsdf_at(&surface_at(ng, Vec2::new(0.3, 0.4)))
    }

    pub(super) fn bsdf_at(&self, x: &SurfacePoint) -> Bsdf<'_> {
        let root = MaterialId::from(self.materials.descriptions().len() - 1);
        self.materials.bsdf(root, x, &self.textures)
    }
}
