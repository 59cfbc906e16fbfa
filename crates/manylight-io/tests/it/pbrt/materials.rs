//! Materials of PBRT v4 and v3.

use super::{PbrtFiles, load, loaded};
use manylight::bsdf::Material;
use manylight::bsdf::material::{ColorShift, ConstantRoughness, Distribution};
use manylight::color::Rgb;
use manylight::scene::SceneDesc;
use manylight::texture::{ColorInput, FloatInput, Texture};
use manylight_io::spectra::metal;

/// The material of the last primitive, without `TwoSided`.
fn last(desc: &SceneDesc) -> &Material {
    let id = desc.primitives.last().unwrap().material;
    match &desc.materials[id.index()] {
        Material::TwoSided { front, back } if front == back => &desc.materials[front.index()],
        other => other,
    }
}

/// The material of a shape after the directive `Material` with these arguments.
fn material(arguments: &str) -> Material {
    last(&load(&format!("Material {arguments} Shape \"sphere\""))).clone()
}

fn constant(r: f32, g: f32, b: f32) -> ColorInput {
    ColorInput::Constant(Rgb::new(r, g, b))
}

#[test]
fn opaque_materials_scatter_on_both_sides() {
    let desc = load("Material \"diffuse\" \"rgb reflectance\" [ .1 .2 .3 ] Shape \"sphere\"");
    let id = desc.primitives[0].material;
    assert!(matches!(
        desc.materials[id.index()],
        Material::TwoSided { .. }
    ));
    assert!(matches!(
        last(&desc),
        Material::Diffuse { reflectance } if *reflectance == constant(0.1, 0.2, 0.3)
    ));
}

#[test]
fn roughness_is_mapped_to_its_root() {
    let alphas = |arguments: &str| match material(arguments) {
        Material::Conductor {
            roughness: Some(r), ..
        } => {
            assert_eq!(r.distribution, Distribution::Ggx);
            Some([r.alpha_u, r.alpha_v])
        }
        Material::Conductor { .. } => None,
        other => panic!("{other:?}"),
    };
    let equal = |a| Some([FloatInput::Constant(a); 2]);
    assert_eq!(alphas("\"conductor\""), None);
    assert_eq!(alphas("\"conductor\" \"float roughness\" 0.25"), equal(0.5));
    assert_eq!(
        alphas("\"conductor\" \"float roughness\" 0.25 \"bool remaproughness\" false"),
        equal(0.25)
    );
    assert_eq!(
        alphas("\"conductor\" \"float roughness\" 0.25 \"float vroughness\" 0.04"),
        Some([FloatInput::Constant(0.5), FloatInput::Constant(0.2)])
    );
    assert_eq!(
        alphas("\"conductor\" \"float roughness\" 0.0005 \"bool remaproughness\" false"),
        None
    );
}

#[test]
fn conductors_have_named_spectra_or_reflectances() {
    let indices = |arguments: &str| match material(arguments) {
        Material::Conductor { eta, k, .. } => [eta, k],
        other => panic!("{other:?}"),
    };
    let of = |name| {
        let (eta, k) = metal(name).unwrap();
        [ColorInput::Constant(eta), ColorInput::Constant(k)]
    };
    assert_eq!(indices("\"conductor\""), of("Cu"));
    let silver =
        "\"conductor\" \"spectrum eta\" \"metal-Ag-eta\" \"spectrum k\" [ \"metal-Ag-k\" ]";
    assert_eq!(indices(silver), of("Ag"));
    let [eta, k] = indices("\"conductor\" \"rgb reflectance\" [ 0.5 0.8 0.2 ]");
    assert_eq!(eta, constant(1.0, 1.0, 1.0));
    let ColorInput::Constant(k) = k else {
        panic!("{k:?}")
    };
    // Reflectance at normal incidence: k² / (4 + k²).
    let reflectance = k.map(|k| k * k / (4.0 + k * k));
    assert!((reflectance.r - 0.5).abs() < 1e-5 && (reflectance.g - 0.8).abs() < 1e-5);
}

#[test]
fn textured_indices_of_coated_conductors_are_relative_to_the_coat() {
    let desc = loaded(
        "Texture \"t\" \"spectrum\" \"checkerboard\"\n\
         Material \"coatedconductor\" \"texture conductor.eta\" \"t\" \"rgb conductor.k\" [ 3 3 3 ]\n\
         \"float interface.eta\" 2 Shape \"sphere\"",
    )
    .desc;
    let indices = desc.materials.iter().find_map(|material| match material {
        Material::Conductor {
            eta: ColorInput::Texture(eta),
            k,
            ..
        } => Some((*eta, *k)),
        _ => None,
    });
    let (eta, k) = indices.expect("a conductor with a textured index");
    assert_eq!(k, constant(1.5, 1.5, 1.5));
    assert!(matches!(
        desc.textures[eta.index()],
        Texture::Product { first: ColorInput::Texture(_), second }
            if second == constant(0.5, 0.5, 0.5)
    ));
}

#[test]
fn dielectrics_and_coats_have_their_index() {
    assert!(matches!(
        material("\"dielectric\""),
        Material::Dielectric {
            eta: 1.5,
            roughness: None,
            ..
        }
    ));
    assert!(matches!(
        material("\"thindielectric\" \"float eta\" 1.3"),
        Material::ThinDielectric { eta: 1.3, .. }
    ));
    let glass = loaded("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\" Shape \"sphere\"");
    assert!(
        matches!(last(&glass.desc), Material::Dielectric { eta, .. } if (*eta - 1.5168).abs() < 1e-4)
    );
    assert_eq!(
        glass.warnings[0].message(),
        "the dispersion of `glass-BK7` is ignored"
    );
    assert!(matches!(
        material(
            "\"coateddiffuse\" \"float roughness\" 0.04 \"float thickness\" 0.1 \"integer maxdepth\" 20"
        ),
        Material::Plastic {
            eta: 1.5,
            color_shift: ColorShift::Nonlinear,
            roughness: Some(ConstantRoughness {
                distribution: Distribution::Ggx,
                alpha: 0.2
            }),
            ..
        }
    ));
}

#[test]
fn leaves_transmit_what_they_do_not_reflect() {
    let desc = load(
        "Material \"diffusetransmission\" \"rgb reflectance\" [ .1 .2 .3 ] \"rgb transmittance\" [ .4 .2 .1 ] \
         \"float scale\" 0.5 Shape \"sphere\"",
    );
    let Material::Blend {
        weight,
        first,
        second,
    } = *last(&desc)
    else {
        panic!("{:?}", last(&desc))
    };
    assert_eq!(weight, FloatInput::Constant(0.5));
    let Material::TwoSided { front, .. } = desc.materials[first.index()] else {
        panic!("the reflecting part has two sides")
    };
    assert!(matches!(
        desc.materials[front.index()],
        Material::Diffuse { reflectance } if reflectance == constant(0.1, 0.2, 0.3)
    ));
    assert!(matches!(
        desc.materials[second.index()],
        Material::DiffuseTransmitter { transmittance, .. } if transmittance == constant(0.4, 0.2, 0.1)
    ));
}

#[test]
fn mixtures_interfaces_and_opacities_wrap_materials() {
    let named = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" MakeNamedMaterial \"b\" \"string type\" \"interface\" ";
    let desc = load(&format!(
        "{named} Material \"mix\" \"string materials\" [ \"a\" \"b\" ] \"float amount\" 0.3 Shape \"sphere\""
    ));
    assert!(matches!(
        last(&desc),
        Material::Blend { weight: FloatInput::Constant(0.3), second, .. }
            if matches!(desc.materials[second.index()], Material::Null)
    ));
    let desc = load(&format!(
        "{named} NamedMaterial \"a\" Shape \"sphere\" \"float alpha\" 0.25"
    ));
    assert!(matches!(
        last(&desc),
        Material::Mask {
            opacity: FloatInput::Constant(0.25),
            ..
        }
    ));
}

#[test]
fn textured_roughness_is_mapped_after_loading() {
    let mut image = b"Pf\n1 1\n-1\n".to_vec();
    image.extend(0.25_f32.to_le_bytes());
    let scene = super::document(
        "Texture \"r\" \"float\" \"imagemap\" \"string filename\" \"r.pfm\"\n\
         Material \"conductor\" \"texture roughness\" \"r\" Shape \"sphere\"\n\
         Material \"coateddiffuse\" \"texture roughness\" \"r\" Shape \"sphere\"",
    );
    let loaded = PbrtFiles::new(scene.as_bytes(), &[("r.pfm", &image)]).load();
    let desc = &loaded.desc;
    let metal = desc.primitives[0].material;
    let Material::TwoSided { front, .. } = desc.materials[metal.index()] else {
        panic!("metals have two sides")
    };
    let Material::Conductor {
        roughness: Some(roughness),
        ..
    } = &desc.materials[front.index()]
    else {
        panic!("{:?}", desc.materials)
    };
    let alpha = roughness
        .alpha_u
        .eval(manylight::math::Vec2::splat(0.5), &desc.textures);
    assert!((alpha - 0.5).abs() < 1e-6, "{alpha}");
    assert!(matches!(
        last(desc),
        Material::Plastic { roughness: Some(rough), .. } if (rough.alpha - 0.5).abs() < 1e-6
    ));
    assert_eq!(loaded.warnings.len(), 1);
}

#[test]
fn materials_of_version_3_are_named_once() {
    let scene = "LookAt 0 0 5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 40\n\
        Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
        Sampler \"lowdiscrepancy\" \"integer pixelsamples\" 4 WorldBegin\n\
        LightSource \"infinite\" \"rgb L\" [ 1 1 1 ] \"integer nsamples\" 4\n\
        Material \"matte\" \"rgb Kd\" [ .1 .2 .3 ] Shape \"sphere\" \"float shine\" 1\n\
        Material \"matte\" \"rgb Kd\" [ .1 .2 .3 ] \"float sigma\" 20 Shape \"sphere\"\n\
        Material \"plastic\" \"color Ks\" [ .5 .5 .5 ] \"float roughness\" 0.1 Shape \"sphere\"\n\
        Material \"glass\" \"float index\" 1.4 \"rgb Kt\" [ 1 .5 1 ] Shape \"sphere\"\n\
        Material \"mirror\" Shape \"sphere\" Material \"metal\" Shape \"sphere\"\n\
        Material \"substrate\" \"rgb Ks\" [ .04 .04 .04 ] Shape \"sphere\"\n\
        Material \"uber\" \"rgb Kt\" [ .3 .3 .3 ] \"rgb opacity\" [ .5 .5 .5 ] Shape \"sphere\"\n\
        Material \"translucent\" Shape \"sphere\" Material \"disney\" \"rgb color\" [ 1 0 0 ] Shape \"sphere\"\n\
        Material \"\" Shape \"sphere\" WorldEnd";
    let loaded = PbrtFiles::new(scene.as_bytes(), &[]).load();
    let messages: Vec<&str> = loaded.warnings.iter().map(|w| w.message()).collect();
    let old = messages
        .iter()
        .filter(|m| m.contains("of PBRT v3 is read as"));
    assert_eq!(old.count(), 10, "{messages:#?}");
    assert!(messages.contains(&"shape `sphere` has no parameter `shine`"));
    let desc = &loaded.desc;
    let of = |i: usize| {
        let id = desc.primitives[i].material;
        match &desc.materials[id.index()] {
            Material::TwoSided { front, .. } => &desc.materials[front.index()],
            other => other,
        }
    };
    assert!(matches!(of(1), Material::RoughDiffuse { .. }));
    assert!(matches!(of(3), Material::Dielectric { eta: 1.4, .. }));
    assert!(matches!(
        of(7),
        Material::Mask { opacity: FloatInput::Constant(o), .. } if (o - 0.5).abs() < 1e-5
    ));
    assert!(matches!(of(9), Material::Principled(_)));
    assert!(matches!(of(10), Material::Null));
}
