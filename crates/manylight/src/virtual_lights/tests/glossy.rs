//! Glossy parts: exact flux in all forms, and the accuracy of their shape.

use super::*;
use crate::bsdf::Lobes;
use crate::lanes::{Mask, One};
use crate::testing::scenes::{rough_glass, rough_metal, rough_plastic};

/// The integral of the lookups is the reflected flux, for roughness 0.1 to 1.
#[test]
fn tables_hold_exactly_the_reflected_flux() {
    for alpha in [0.1, 0.2, 0.5, 1.0] {
        let scene = floor(rough_metal(alpha));
        for (i, z) in [1.0, 0.5, 0.1].into_iter().enumerate() {
            let prev = Vec3::new(0.7, 0.3 * i as f32, 0.0) + Vec3::Z * z;
            let photons = [falling(
                &scene,
                Vec3::Z,
                Vec3::Z,
                prev,
                Rgb::new(1.0, 2.0, 3.0),
            )];
            let clusters = twice(&[Site {
                photon: 0,
                probability: 1.0,
            }]);
            let set = rich_lights(&scene, unlimited(), &photons, &clusters, TABLE);
            let emitted = emitted(&set, LightId(0));
            let target = set.profile_flux().scattered;
            for c in 0..3 {
                assert!(
                    close(set.profile_flux().emitted[c], target[c], 1e-5),
                    "{:?}",
                    set.profile_flux()
                );
                assert!(
                    close(emitted[c], target[c], 1e-4),
                    "alpha {alpha}, height {z}: {emitted:?} of {target:?}"
                );
            }
        }
    }
}

/// The target flux is a Monte Carlo estimate: unbiased.
#[test]
fn the_reflected_flux_is_the_albedo_on_average() {
    for alpha in [0.1, 0.4] {
        let scene = floor(rough_metal(alpha));
        let prev = Vec3::new(1.0, 0.2, 1.0);
        let photons: Vec<Photon> = (0..200)
            .map(|i| {
                let p = Vec3::new(i as f32 / 200.0 - 0.5, 0.1, 1.0);
                falling(&scene, p, Vec3::Z, prev + p, Rgb::WHITE)
            })
            .collect();
        let sites: Vec<Site> = (0..200)
            .map(|photon| Site {
                photon,
                probability: 1.0,
            })
            .collect();
        let set = rich_lights(&scene, unlimited(), &photons, &twice(&sites), TABLE);
        let expected: Rgb = photons
            .iter()
            .map(|p| {
                scene
                    .bsdf(&scene.surface_point(p.at))
                    .albedo(p.wi, Lobes::GLOSSY)
            })
            .sum();
        let reflected = set.profile_flux().scattered;
        assert!(
            close(reflected[1], f64::from(expected.g), 0.01),
            "{reflected:?} of {expected:?}"
        );
    }
}

#[test]
fn wide_lobes_keep_their_shape() {
    let scene = floor(rough_metal(0.5));
    let photons = [falling(
        &scene,
        Vec3::Z,
        Vec3::Z,
        Vec3::new(0.5, 0.2, 1.0),
        Rgb::WHITE,
    )];
    let clusters = twice(&[Site {
        photon: 0,
        probability: 1.0,
    }]);
    let set = rich_lights(&scene, unlimited(), &photons, &clusters, TABLE);
    let bsdf = scene.bsdf(&scene.surface_point(photons[0].at));
    let peak = bsdf.f_cos_wo(
        photons[0].wi,
        Vec3::new(-photons[0].wi.x, -photons[0].wi.y, photons[0].wi.z),
        Lobes::GLOSSY,
    );
    for w in directions(400) {
        let expected = bsdf.f_cos_wo(photons[0].wi, w, Lobes::GLOSSY);
        let expected = if w.z > 0.0 { expected } else { Rgb::BLACK };
        let error = set.intensity(LightId(0), w).g - expected.g;
        assert!(error.abs() < 0.06 * peak.g, "{error} at {w}");
    }
}

#[test]
fn many_photons_keep_their_mean_lobe() {
    // Against the sum over the lobes of all photons: tables use a subset of the photons, so only
    // the mean over lights agrees. With four lights the previous vertices are nearer than the
    // photons of a light to each other.
    let scene = floor(rough_metal(0.2));
    let photons = photons_on_floor(&scene, 4000, 9);
    let weights = vec![1.0; photons.len()];
    for (lights, sets) in [(100, 1), (4, 25)] {
        let light_sets: Vec<VirtualLights> = (0..sets)
            .map(|set| {
                let u = (set as f32 + 0.3) / sets as f32;
                let sites = select(&photons, &weights, lights, u);
                let (clusters, _) = assign(&scene, &candidates(&photons, &weights), &sites, 0.1);
                rich_lights(&scene, unlimited(), &photons, &clusters, TABLE)
            })
            .collect();
        let (mut error, mut total) = (0.0, 0.0);
        for w in directions(100).filter(|w| w.z > 0.1) {
            let emission_view = |set: &VirtualLights| -> Rgb {
                (0..set.lights().len())
                    .map(|k| set.intensity(LightId(k as u32), w))
                    .sum()
            };
            let mean = light_sets.iter().map(emission_view).sum::<Rgb>() / sets as f32;
            let reflected = |p: &Photon| {
                let bsdf = scene.bsdf(&scene.surface_point(p.at));
                bsdf.f_cos_wo(p.wi, w, Lobes::NON_SPECULAR) * p.flux
            };
            let expected: Rgb = photons.iter().map(reflected).sum();
            error += (mean.g - expected.g).abs();
            total += expected.g;
        }
        assert!(error / total < 0.1, "{lights} lights: {}", error / total);
    }
}

/// A light of one photon from `prev` on a floor of metal: flux emitted by quadrature, flux of the
/// profile, and target.
fn metal_light(alpha: f32, prev: Vec3, form: GlossyForm) -> ([f64; 3], [f64; 3], [f64; 3]) {
    let scene = floor(rough_metal(alpha));
    let flux = Rgb::new(1.0, 2.0, 3.0);
    let photons = [falling(&scene, Vec3::Z, Vec3::Z, prev, flux)];
    let clusters = twice(&[Site {
        photon: 0,
        probability: 1.0,
    }]);
    let set = rich_lights(&scene, unlimited(), &photons, &clusters, form);
    let flux = set.profile_flux();
    let emitted = emitted_in_squares(&set, LightId(0), 1025);
    (emitted, flux.emitted, flux.scattered)
}

/// The integral of the lookups is the reflected flux in every form.
#[test]
fn every_form_holds_exactly_the_reflected_flux() {
    let table = |side, storage| GlossyForm::Table { side, storage };
    let forms = [
        table(32, TableStorage::Float),
        table(8, TableStorage::Shared),
        table(128, TableStorage::Shared),
        table(48, TableStorage::Blocks),
        GlossyForm::Lobes { count: 1 },
        GlossyForm::Lobes { count: 5 },
        GlossyForm::Lobes { count: 8 },
    ];
    let mut rng = Pcg::new(21);
    for form in forms {
        for alpha in [0.1f32, 0.15, 0.3, 0.6, 1.0] {
            // Narrow lobes fall between the texels of coarse tables.
            let alpha = if form == forms[1] {
                alpha.max(0.3)
            } else {
                alpha
            };
            let u = Vec2::new(rng.next_f32(), rng.next_f32());
            let prev = warp::cosine_hemisphere(u) + Vec3::Z * 0.02;
            let (emitted, held, target) = metal_light(alpha, prev, form);
            for c in 0..3 {
                assert!(close(held[c], target[c], 1e-5), "{held:?} of {target:?}");
                // Sub-samples of texels approximate the horizon.
                // Blocks that a horizon crosses are rounded on both sides of it.
                let tolerance = match form {
                    _ if form == forms[1] => 2e-3,
                    _ if form == forms[3] => 1e-3,
                    _ => 1e-4,
                };
                assert!(
                    close(emitted[c], target[c], tolerance),
                    "{form:?}, alpha {alpha}, from {prev}: {emitted:?} of {target:?}"
                );
            }
        }
    }
}

#[test]
fn storages_agree_within_their_rounding() {
    let scene = floor(rough_metal(0.2));
    let photons = photons_on_floor(&scene, 400, 9);
    let weights = vec![1.0; photons.len()];
    let sites = select(&photons, &weights, 10, 0.3);
    let (clusters, _) = assign(&scene, &candidates(&photons, &weights), &sites, 0.1);
    let set = |storage| {
        let form = GlossyForm::Table { side: 32, storage };
        rich_lights(&scene, unlimited(), &photons, &clusters, form)
    };
    let exact = set(TableStorage::Float);
    let mut sizes = Vec::new();
    for (storage, part) in [
        (TableStorage::Float, 1e-6),
        (TableStorage::Shared, 1.0 / 128.0),
        (TableStorage::Blocks, 0.25),
    ] {
        let rounded = set(storage);
        sizes.push((rounded.bytes() - size_of_val(rounded.lights())) / rounded.lights().len());
        for k in 0..exact.lights().len() {
            for w in directions(200) {
                let a = exact.intensity(LightId(k as u32), w);
                let b = rounded.intensity(LightId(k as u32), w);
                let off = (a - b).map(f32::abs).max_channel();
                // The error is relative to the brightest channel of the texels interpolated, or of
                // the blocks that hold them.
                let scale = match storage {
                    TableStorage::Float => a.max_channel(),
                    TableStorage::Shared => 4.0 * a.max_channel(),
                    TableStorage::Blocks => brightest_around(&exact, k, w),
                };
                assert!(off <= part * scale + 1e-9, "{storage:?}: {a:?} {b:?}");
            }
        }
    }
    assert_eq!(sizes[..2], [12_324, 4132]);
    assert!(sizes[2] < 600, "{sizes:?}");
}

/// The largest channel of the intensity of light `k` within a block of 4 x 4 of 32 x 32 texels
/// around the unit vector `w`, in W/sr.
fn brightest_around(set: &VirtualLights, k: usize, w: Vec3) -> f32 {
    let around = directions(60).map(|d| (w + d * 0.5).normalize());
    let intensity = |w: Vec3| set.intensity(LightId(k as u32), w).max_channel();
    around.map(intensity).fold(intensity(w), f32::max)
}

/// `∫ |I - I_exact|` relative to the flux, for lights of 16 photons from similar directions.
fn misplaced(alpha: f32, form: GlossyForm) -> f64 {
    let scene = floor(rough_metal(alpha));
    let (maker, mut rng) = (form.maker(), Pcg::new(7));
    let (mut error, mut total) = (0.0, 0.0);
    for _ in 0..5 {
        let mut next = || rng.next_f32();
        let base = Vec3::new(2.0 * next() - 1.0, 2.0 * next() - 1.0, 0.2 + next());
        let paths: Vec<Reflection> = (0..16)
            .map(|_| {
                let off = Vec3::new(next() - 0.5, next() - 0.5, next()) * 0.3;
                let photon = falling(&scene, Vec3::Z, Vec3::Z, base + off, Rgb::WHITE);
                Reflection {
                    bsdf: scene.bsdf(&scene.surface_point(photon.at)),
                    wi: photon.wi,
                    flux: Rgb::WHITE,
                }
            })
            .collect();
        let profile = maker.make(&paths, alpha, Vec3::Z, &mut Pcg::new(11));
        let mut profiles = form.store();
        let index = profiles.push(&profile);
        let n = 128;
        for i in 0..n * n {
            let uv = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let w = direction_from_square(uv);
            if w.z > 0.0 {
                let exact = |s: &Reflection| s.bsdf.f_cos_wo(s.wi, w, Lobes::GLOSSY).g;
                let exact: f32 = paths.iter().map(exact).sum();
                let solid_angle = solid_angle_density(uv);
                let found = (profiles.get(index)).lookup(w.into(), Mask::splat(One, true));
                error += f64::from((found.g.get() - exact).abs() * solid_angle);
                total += f64::from(exact * solid_angle);
            }
        }
    }
    error / total
}

#[test]
fn more_lobes_keep_more_of_the_shape() {
    for (alpha, most) in [(0.1, 0.2), (0.2, 0.15), (0.4, 0.15), (0.8, 0.15)] {
        let [one, three, five] =
            [1, 3, 5].map(|count| misplaced(alpha, GlossyForm::Lobes { count }));
        assert!(five < three + 0.02 && three < one, "{one} {three} {five}");
        assert!(five < most, "alpha {alpha}: {five}");
    }
}

#[test]
fn mixtures_at_their_edges() {
    let lobes = GlossyForm::Lobes { count: 5 };
    // A black photon emits nothing, and a one-sided light emits nothing below its horizon.
    let scene = floor(rough_plastic(0.2, Rgb::splat(0.5)));
    let prev = Vec3::new(0.3, 0.2, 1.0);
    let clusters = twice(&[Site {
        photon: 0,
        probability: 1.0,
    }]);
    for flux in [Rgb::BLACK, Rgb::new(0.0, 1.0, 0.0)] {
        let photons = [falling(&scene, Vec3::Z, Vec3::Z, prev, flux)];
        let set = rich_lights(&scene, unlimited(), &photons, &clusters, lobes);
        for w in directions(200) {
            let value = set.intensity(LightId(0), w);
            assert_eq!(value.is_black(), w.z <= 0.0 || flux.is_black(), "{w}");
            assert!(value.is_finite() && value.r == 0.0 && value.b == 0.0);
        }
        let bytes = set.bytes() - size_of_val(set.lights());
        assert_eq!(bytes, 5 * 20 + size_of::<SurfaceRef>());
    }
    // A transmitting light emits on both sides with all of its flux.
    let scene = floor(rough_glass(0.3));
    let photons = [falling(&scene, Vec3::Z, Vec3::Z, prev, Rgb::WHITE)];
    let set = rich_lights(&scene, unlimited(), &photons, &clusters, lobes);
    let target = set.profile_flux().scattered;
    assert!(close(emitted(&set, LightId(0))[1], target[1], 1e-4));
    assert!(directions(200).any(|w| w.z < -0.5 && set.intensity(LightId(0), w).g > 0.1));
}
