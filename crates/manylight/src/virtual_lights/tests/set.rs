//! Sets of lights: positions, areas, depth limits, and the balance of flux.

use super::*;
use crate::geometry::Shape;
use crate::math::Affine3A;
use crate::testing::scenes::diffuse;

#[test]
fn lights_on_a_ball_are_on_its_surface() {
    let mut b = Builder::new(Vec3::new(0.0, 0.0, 3.0), Vec3::new(0.0, 0.1, 0.0), 60.0, 8);
    let white = b.material(diffuse(0.5, 0.5, 0.5));
    b.place(
        Shape::Sphere {
            center: Vec3::ZERO,
            radius: 0.02,
        },
        Affine3A::IDENTITY,
        white,
        None,
    );
    let scene = b.build();
    let photons: Vec<Photon> = directions(400)
        .filter(|w| w.z > 0.92)
        .map(|w| falling(&scene, w * 0.1, w, Vec3::Z, Rgb::WHITE))
        .collect();
    let center = (0..photons.len())
        .max_by(|&a, &b| photons[a].p.z.total_cmp(&photons[b].p.z))
        .expect("photons");
    let sites = [Site {
        photon: center as u32,
        probability: 1.0,
    }];
    let weights = vec![1.0; photons.len()];
    let (clusters, _) = assign(&scene, &candidates(&photons, &weights), &sites, 0.5);
    let set = rich_lights(&scene, unlimited(), &photons, &clusters, TABLE);
    let light = set
        .lights()
        .iter()
        .max_by(|a, b| a.radius.total_cmp(&b.radius))
        .expect("lights");
    assert!(light.radius > 0.003, "{light:?}");
    for p in light.points.into_iter().chain([light.p]) {
        assert!((p.length() - 0.02).abs() < 1e-5, "{p}");
    }
    assert!(light.n.dot(light.p.normalize()) > 0.999);
}

#[test]
fn lights_are_not_in_holes() {
    // Photons on a ring, as if an object covered the center of the floor.
    let scene = floor(diffuse(0.5, 0.5, 0.5));
    let photons: Vec<Photon> = (0..200)
        .map(|i| {
            let (sin, cos) = (i as f32 * 0.1).sin_cos();
            falling(
                &scene,
                Vec3::new(0.3 * cos, 0.3 * sin, 1.0),
                Vec3::Z,
                Vec3::Z * 2.0,
                Rgb::WHITE,
            )
        })
        .collect();
    let sites = [Site {
        photon: 0,
        probability: 1.0,
    }];
    let (clusters, _) = assign(&scene, &candidates(&photons, &[1.0; 200]), &sites, 0.5);
    let set = rich_lights(&scene, unlimited(), &photons, &clusters, TABLE);
    for light in set.lights() {
        assert!((light.p.length() - 0.3).abs() < 0.05, "{light:?}");
    }
}

#[test]
fn depth_shares_accumulate_only_in_scenes_with_a_limit() {
    let scene = floor(diffuse(0.5, 0.5, 0.5));
    let photons = photons_on_floor(&scene, 2000, 7);
    let weights = vec![1.0; photons.len()];
    let sites = select(&photons, &weights, 10, 0.3);
    let (clusters, _) = assign(&scene, &candidates(&photons, &weights), &sites, 0.1);
    let share = |max_depth, depth| {
        let limits = PathLimits {
            max_depth,
            ..unlimited()
        };
        rich_lights(&scene, limits, &photons, &clusters, TABLE).share_up_to(LightId(0), depth)
    };
    // Depths 1 to 4 have equal flux.
    for (depth, expected) in [
        (0, 0.0),
        (1, 0.25),
        (2, 0.5),
        (3, 0.75),
        (4, 1.0),
        (40, 1.0),
    ] {
        assert!((share(Some(8), depth) - expected).abs() < 0.06);
    }
    assert_eq!(
        (share(None, 1), share(Some(40), 1), share(None, 0)),
        (1.0, 1.0, 0.0)
    );
}

#[test]
fn areas_add_up_to_the_floor() {
    let scene = floor(diffuse(0.5, 0.5, 0.5));
    let photons = photons_on_floor(&scene, 5000, 8);
    let weights = vec![1.0; photons.len()];
    let sites = select(&photons, &weights, 400, 0.3);
    let set = single_lights(
        &scene,
        unlimited(),
        &photons,
        &PhotonClusters::single_photons(&sites),
    );
    let total: f32 = set.lights().iter().map(|light| light.area).sum();
    // Lights at the border have farther neighbors.
    assert!(total > 3.6 && total < 5.5, "{total}");
}

#[test]
fn the_flux_of_a_room_balances() {
    use crate::particles::{trace_photons, usable_by_virtual_lights};
    use crate::sampling::Pass;
    let scene = crate::testing::scenes::glossy_box(8).build();
    let photons = trace_photons(
        &scene,
        &scene.infinite_light_guide(),
        unlimited(),
        4000,
        Pass { index: 0, seed: 1 },
        usable_by_virtual_lights,
    );
    let weights: Vec<f32> = photons.iter().map(|p| p.flux.luminance()).collect();
    let sites = select(&photons, &weights, 200, 0.3);
    let (clusters, nearest) = assign(&scene, &candidates(&photons, &weights), &sites, 0.1);
    let set = rich_lights(&scene, unlimited(), &photons, &clusters, TABLE);
    let is_unassigned = |photon: &&Photon| {
        let location = SurfaceLocation::of_photon(photon, &scene);
        nearest.light(&scene, &location).is_none()
    };
    let all = sum(photons.iter().map(|photon| photon.flux));
    let unassigned = sum(photons
        .iter()
        .filter(is_unassigned)
        .map(|photon| photon.flux));
    let lights = sum(set.lights().iter().map(|light| light.flux));
    let profiles = set.profile_flux();
    for c in 0..3 {
        assert!(unassigned[c] < 0.1 * all[c], "{unassigned:?} of {all:?}");
        // Unassigned photons are thinned: only the expectation of their flux is exact.
        let noise = unassigned[c] + 1e-6 * all[c];
        let difference = (lights[c] - all[c]).abs();
        assert!(difference < noise, "{lights:?} of {all:?}");
        let is_close = close(profiles.emitted[c], profiles.scattered[c], 1e-4);
        assert!(is_close, "{profiles:?}");
    }
}

/// In full precision.
fn sum(fluxes: impl Iterator<Item = Rgb>) -> [f64; 3] {
    fluxes.fold([0.0; 3], |sum, flux| {
        let flux = flux.to_array();
        std::array::from_fn(|c| sum[c] + f64::from(flux[c]))
    })
}
