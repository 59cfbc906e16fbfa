//! Properties of values: sums over classes, reciprocity, product form, finiteness, summaries of
//! materials.

use super::*;
use crate::ids::MaterialId;
use crate::math::float::ONE_MINUS_EPSILON;
use std::f32::consts::FRAC_1_PI;

#[test]
fn classes_sum_to_the_whole() {
    for case in cases() {
        let bsdf = case.bsdf(Vec3::Z);
        let mut sampler = sampler(12);
        for _ in 0..100 {
            let (wi, wo) = (direction(&mut sampler), direction(&mut sampler));
            let parts =
                [Lobes::DIFFUSE, Lobes::GLOSSY, Lobes::NEAR_DELTA].map(|c| bsdf.f(wi, wo, c).g);
            assert_close(
                parts.iter().sum(),
                bsdf.f(wi, wo, Lobes::ALL).g,
                1e-5,
                case.name,
            );
            let absent = Lobes(Lobes::ALL.0 & !bsdf.lobes().0);
            assert!(bsdf.f(wi, wo, absent).is_black() && bsdf.f(wi, wo, Lobes::DELTA).is_black());
        }
    }
}

#[test]
fn values_are_reciprocal() {
    for case in cases() {
        // A tilted frame depends on `wo` only.
        if case.name.contains("_map") {
            continue;
        }
        let bsdf = case.bsdf(Vec3::Z);
        let eta = match case.name {
            "rough_glass_ggx" | "principled_glass" | "rough_dispersing_glass" => 1.5,
            "rough_glass_beckmann_aniso" => 1.33,
            "rough_glass_inverted" => 1.0 / 1.5,
            _ => 1.0,
        };
        let index2 = |w: Vec3| if w.z < 0.0 { eta * eta } else { 1.0 };
        let mut sampler = sampler(13);
        for _ in 0..500 {
            let (wi, wo) = (direction(&mut sampler), direction(&mut sampler));
            let there = bsdf.f(wi, wo, Lobes::ALL) / index2(wo);
            let back = bsdf.f(wo, wi, Lobes::ALL) / index2(wi);
            // HalfVector vectors lose digits where the refracted directions are nearly opposite.
            assert_close(there.g, back.g, 2e-3, case.name);
        }
    }
}

#[test]
fn diffuse_lobes_are_products() {
    for case in cases() {
        for ng in normals() {
            let bsdf = case.bsdf(ng);
            let mut sampler = sampler(14);
            for _ in 0..100 {
                let (wi, wo) = (direction(&mut sampler), direction(&mut sampler));
                let product = if wi.z * wo.z > 0.0 {
                    let b = bsdf.exit_transmittance().eval(wo.z.abs());
                    bsdf.diffuse_weight(wi) * (b * wo.dot(ng).abs() * FRAC_1_PI)
                } else {
                    Rgb::BLACK
                };
                assert_close(
                    product.r,
                    bsdf.f_cos_wo(wi, wo, Lobes::DIFFUSE).r,
                    1e-5,
                    case.name,
                );
            }
        }
    }
}

#[test]
fn all_results_are_finite() {
    let odd = [
        Vec3::Z,
        -Vec3::Z,
        Vec3::X,
        Vec3::new(1.0, 0.0, 1e-7),
        Vec3::new(0.0, -1.0, -1e-4).normalize(),
        Vec3::new(0.6, 0.0, 0.8),
    ];
    for case in cases() {
        for ng in normals() {
            let bsdf = case.bsdf(ng);
            for wi in odd {
                for wo in odd {
                    let context = format!("{} {wi} {wo}", case.name);
                    let f = bsdf.f_cos_wi(wi, wo, Lobes::ALL);
                    assert!(
                        f.is_finite() && f.to_array().iter().all(|&x| x >= 0.0),
                        "{context}: {f:?}"
                    );
                    assert!(!bsdf.pdf_wi(wi, wo, Lobes::ALL).is_nan(), "{context}");
                    assert!(!bsdf.pdf_wo(wi, wo, Lobes::ALL).is_nan(), "{context}");
                }
                for u in [0.0, 0.5, ONE_MINUS_EPSILON] {
                    let u = BsdfNumbers {
                        lobe: u,
                        direction: Vec2::new(u, 1.0 - u).min(Vec2::splat(ONE_MINUS_EPSILON)),
                    };
                    for sample in [
                        bsdf.sample_wi(wi, u, Lobes::ALL),
                        bsdf.sample_wo(wi, u, Lobes::ALL),
                    ] {
                        let length = sample.map_or(1.0, |s| s.w.length());
                        assert!((length - 1.0).abs() < 1e-3, "{} {wi}: {length}", case.name);
                    }
                }
            }
        }
    }
}

#[test]
fn the_sign_of_the_bitangent_mirrors_a_normal_map() {
    let named = |name: &str| cases().iter().find(|case| case.name == name).unwrap();
    let [right, left] = ["normal_map", "normal_map_left_handed"].map(named);
    let (wi, wo) = (Vec3::new(0.3, 0.5, 0.8), Vec3::new(-0.2, 0.4, 0.9));
    let mirrored = |w: Vec3| Vec3::new(w.x, -w.y, w.z);
    let a = right
        .bsdf(Vec3::Z)
        .f(wi.normalize(), wo.normalize(), Lobes::ALL);
    let (wi, wo) = (mirrored(wi), mirrored(wo));
    let b = left
        .bsdf(Vec3::Z)
        .f(wi.normalize(), wo.normalize(), Lobes::ALL);
    assert!(a.g > 0.1);
    assert_close(a.g, b.g, 1e-5, "mirrored normal map");
}

#[test]
fn rough_panes_keep_the_light_of_both_sides() {
    // Albedos at the cosines 0.9, 0.5 and 0.2: the mean masking G1(wo) of directions that are mirrored
    // at visible facets, by NumPy. Light that facets reflect more than once is missing.
    for (alpha, albedos) in [
        (0.04, [0.998, 0.995, 0.975]),
        (0.09, [0.990, 0.975, 0.912]),
        (0.36, [0.814, 0.777, 0.796]),
    ] {
        let case = white_pane(alpha);
        let bsdf = case.bsdf(Vec3::Z);
        for (z, albedo) in [0.9f32, 0.5, 0.2].into_iter().zip(albedos) {
            let w = Vec3::new((1.0 - z * z).sqrt(), 0.0, z);
            let [front, back] = [w, -w].map(|w| bsdf.albedo(w, Lobes::ALL).g);
            assert_close(front, back, 1e-3, "the sides of a pane");
            assert!((front - albedo).abs() < 0.01, "{alpha} {z}: {front}");
        }
        // Most light passes, straight on.
        let through = bsdf.f_cos_wo(Vec3::Z, -Vec3::Z, Lobes::ALL).g;
        let reflected = bsdf.f_cos_wo(Vec3::Z, Vec3::Z, Lobes::ALL).g;
        let r = 0.08f32 / 1.04;
        assert_close(reflected / (reflected + through), r, 1e-3, "reflectance");
    }
}

#[test]
fn deep_trees_keep_their_weight() {
    // A chain of blends of seven equal materials.
    let mut materials: Vec<Material> = (0..7).map(|_| diffuse()).collect();
    for i in 1..7u32 {
        let first = if i == 1 { 0 } else { 5 + i };
        materials.push(Material::Blend {
            weight: float(0.3),
            first: MaterialId(first),
            second: MaterialId(i),
        });
    }
    let case = Case {
        name: "deep",
        materials: Materials::new(materials),
        textures: Vec::new(),
    };
    let albedo = case
        .bsdf(Vec3::Z)
        .albedo(Vec3::new(0.6, 0.0, 0.8), Lobes::ALL);
    assert_close(albedo.g, 0.5, 1e-5, "deep");
}

#[test]
fn transparency_and_widths_are_known_beforehand() {
    for case in cases() {
        let root = MaterialId::from(case.materials.descriptions().len() - 1);
        let transparent = matches!(case.name, "thin_glass" | "mask" | "null");
        assert_eq!(
            case.materials.is_transparent(root),
            transparent,
            "{}",
            case.name
        );
        let bsdf = case.bsdf(Vec3::Z);
        assert_eq!(
            !bsdf.transmittance(Vec3::Z).is_black(),
            transparent,
            "{}",
            case.name
        );
        let width = match case.name {
            "rough_conductor_ggx" | "rough_glass_ggx" | "normal_map_glass" => 0.3,
            "rough_plastic_ggx" | "blend" | "two_sided" => 0.2,
            "rough_conductor_narrow" | "diffuse" | "principled_glass" => bsdf.glossy_roughness(),
            _ => continue,
        };
        assert_close(bsdf.glossy_roughness(), width, 1e-6, case.name);
    }
    let near_delta = cases()
        .iter()
        .find(|case| case.name == "rough_conductor_narrow")
        .unwrap();
    assert_eq!(near_delta.bsdf(Vec3::Z).lobes(), Lobes::NEAR_DELTA);
    assert_eq!(near_delta.bsdf(Vec3::Z).glossy_roughness(), 1.0);
}

#[test]
fn a_bsdf_stays_small() {
    assert!(size_of::<Bsdf>() <= 720, "{}", size_of::<Bsdf>());
}
