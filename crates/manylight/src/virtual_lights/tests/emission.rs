//! Radiant intensity of single and rich lights.

use super::*;
use crate::bsdf::Lobes;
use crate::testing::scenes::{diffuse, rough_glass, rough_plastic};

#[test]
fn a_single_light_is_the_reflection_of_its_photon() {
    let scene = floor(rough_plastic(0.3, Rgb::new(0.2, 0.4, 0.1)));
    let photons = photons_on_floor(&scene, 20, 1);
    let sites: Vec<Site> = (0..20)
        .map(|photon| Site {
            photon,
            probability: 0.25,
        })
        .collect();
    let set = single_lights(
        &scene,
        unlimited(),
        &photons,
        &PhotonClusters::single_photons(&sites),
    );
    for (k, photon) in photons.iter().enumerate() {
        let bsdf = scene.bsdf(&scene.surface_point(photon.at));
        for w in directions(20) {
            let expected = bsdf.f_cos_wo(photon.wi, w, Lobes::NON_SPECULAR) * photon.flux * 4.0;
            let value = set.intensity(LightId(k as u32), w);
            assert!((value - expected).max_channel().abs() <= 1e-5 * expected.max_channel());
        }
    }
}

#[test]
fn a_light_at_every_photon_makes_single_lights() {
    let scene = floor(rough_plastic(0.3, Rgb::new(0.2, 0.4, 0.1)));
    let photons = photons_on_floor(&scene, 500, 2);
    let photons = curve::Curve::around(&photons).sorted(&photons);
    let weights = vec![1.0; photons.len()];
    let sites = select(&photons, &weights, photons.len(), 0.5);
    let plain = single_lights(
        &scene,
        unlimited(),
        &photons,
        &PhotonClusters::single_photons(&sites),
    );
    let (clusters, _) = assign(&scene, &candidates(&photons, &weights), &sites, 0.5);
    let partition = single_lights(&scene, unlimited(), &photons, &clusters);
    assert_eq!(partition.lights().len(), photons.len());
    for (k, (a, b)) in plain.lights().iter().zip(partition.lights()).enumerate() {
        assert_eq!(
            (a.p, a.n, a.radius, a.points, a.flux),
            (b.p, b.n, 0.0, [b.p; 16], b.flux)
        );
        for w in directions(3) {
            let id = LightId(k as u32);
            assert_eq!(plain.intensity(id, w), partition.intensity(id, w));
        }
    }
}

#[test]
fn the_diffuse_part_is_exact() {
    let scene = floor(diffuse(0.3, 0.5, 0.7));
    let photons = photons_on_floor(&scene, 3000, 3);
    let weights: Vec<f32> = photons.iter().map(|p| p.flux.luminance()).collect();
    let sites = select(&photons, &weights, 20, 0.5);
    let (clusters, _) = assign(&scene, &candidates(&photons, &weights), &sites, 0.5);
    let set = rich_lights(&scene, unlimited(), &photons, &clusters, TABLE);
    let places = set.lights().len() * size_of::<SurfaceRef>();
    assert_eq!(set.bytes(), size_of_val(set.lights()) + places);
    for w in directions(50) {
        let sum: Rgb = (0..set.lights().len())
            .map(|k| set.intensity(LightId(k as u32), w))
            .sum();
        let expected: Rgb = photons
            .iter()
            .map(|p| {
                scene
                    .bsdf(&scene.surface_point(p.at))
                    .f_cos_wo(p.wi, w, Lobes::NON_SPECULAR)
                    * p.flux
            })
            .sum();
        assert!(
            (sum - expected).max_channel().abs() <= 1e-4 * expected.max_channel(),
            "{sum:?} {expected:?}"
        );
    }
}

#[test]
fn only_glass_emits_below_the_horizon() {
    let prev = Vec3::new(0.3, 0.2, 1.0);
    let mut below = [0.0f32; 2];
    for (i, material) in [rough_plastic(0.2, Rgb::splat(0.5)), rough_glass(0.3)]
        .into_iter()
        .enumerate()
    {
        let scene = floor(material);
        let photons = [falling(&scene, Vec3::Z, Vec3::Z, prev, Rgb::WHITE)];
        let clusters = twice(&[Site {
            photon: 0,
            probability: 1.0,
        }]);
        let set = rich_lights(&scene, unlimited(), &photons, &clusters, TABLE);
        let under = directions(500).filter(|w| w.z < 0.0);
        below[i] = under
            .map(|w| set.intensity(LightId(0), w).max_channel())
            .fold(0.0, f32::max);
    }
    assert_eq!(below[0], 0.0);
    assert!(below[1] > 0.5, "{below:?}");
}
