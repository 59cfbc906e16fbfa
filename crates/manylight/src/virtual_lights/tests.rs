//! Lights of real surfaces: what they shine, where they stand, and that no flux is lost.

use super::sources::Source;
use super::testing::photon;
use super::*;
use crate::bsdf::{Lobes, Material};
use crate::geometry::{Ray, Shape};
use crate::ids::LightId;
use crate::lanes::{LANES, Lanes3};
use crate::math::octahedral::{direction_from_square, solid_angle_density};
use crate::math::{Affine3A, Frame, Spread, Vec2};
use crate::particles::Photon;
use crate::sampling::rng::Pcg;
use crate::sampling::warp;
use crate::scene::{PathLimits, Scene};
use crate::testing::scenes::{Builder, diffuse, rough_glass, rough_metal, rough_plastic};

const TABLE: GlossyForm = GlossyForm::Table {
    side: 32,
    storage: TableStorage::Shared,
};

fn unlimited() -> PathLimits {
    PathLimits::default()
}

/// The square [-1, 1]² at z = 0, facing +z.
fn floor(material: Material) -> Scene {
    let mut b = Builder::new(Vec3::new(0.0, 0.0, 3.0), Vec3::new(0.0, 0.1, 0.0), 60.0, 8);
    let material = b.material(material);
    b.rectangle(Vec3::ZERO, Vec3::X, Vec3::Y, material, None);
    b.build()
}

/// A photon that falls onto the surface in front of `above`, seen along `-n`, from the vertex `prev`.
fn falling(scene: &Scene, above: Vec3, n: Vec3, prev: Vec3, flux: Rgb) -> Photon {
    let (hit, x) = scene
        .intersect(&Ray::new(above, -n))
        .expect("a surface below");
    let wi = (prev - x.p).normalize();
    let side = x.normal_towards(wi);
    let diffuse_flux = flux * scene.bsdf(&x).diffuse_weight(wi);
    Photon {
        wi,
        prev,
        flux,
        diffuse_flux,
        at: hit.at,
        ..photon(x.p, side)
    }
}

/// Photons on random places of the floor from random vertices above it, in random colors.
fn photons_on_floor(scene: &Scene, count: usize, key: u64) -> Vec<Photon> {
    let mut rng = Pcg::new(key);
    let mut next = || rng.next_f32();
    (0..count)
        .map(|i| {
            let p = Vec3::new(2.0 * next() - 1.0, 2.0 * next() - 1.0, 1.0);
            let prev = Vec3::new(4.0 * next() - 2.0, 4.0 * next() - 2.0, 0.2 + 2.0 * next());
            let flux = Rgb::new(next(), 0.2 + next(), next());
            Photon {
                depth: 1 + (i % 4) as u16,
                ..falling(scene, p, Vec3::Z, prev, flux)
            }
        })
        .collect()
}

fn directions(count: usize) -> impl Iterator<Item = Vec3> {
    let mut rng = Pcg::new(5);
    (0..count).map(move |_| warp::sphere(Vec2::new(rng.next_f32(), rng.next_f32())))
}

/// Integral of the intensity of a light over the sphere, by the midpoint rule on the octahedral map, where texels end at edges of the
/// rule's squares.
fn emitted(field: &VirtualLights, id: LightId) -> [f64; 3] {
    emitted_in_squares(field, id, 1024)
}

/// The same with `n`² squares. Of an odd number none has its middle on the horizon of the floor, where lobes are not dark.
fn emitted_in_squares(field: &VirtualLights, id: LightId, n: usize) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for i in 0..n * n {
        let uv = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
        let solid_angle = f64::from(solid_angle_density(uv)) / (n * n) as f64;
        let intensity = field.intensity(id, direction_from_square(uv)).to_array();
        (0..3).for_each(|c| sum[c] += f64::from(intensity[c]) * solid_angle);
    }
    sum
}

/// Each site as a light of its own photon, which is there twice, half each: one photon alone would need no table.
fn twice(sites: &[Site]) -> PhotonClusters {
    PhotonClusters::of_sites(sites, |site| vec![(site.photon, 0.5 / site.probability); 2])
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs().max(1e-12)
}

#[test]
fn a_plain_light_is_the_reflection_of_its_photon() {
    let scene = floor(rough_plastic(0.3, Rgb::new(0.2, 0.4, 0.1)));
    let photons = photons_on_floor(&scene, 20, 1);
    let sites: Vec<Site> = (0..20)
        .map(|photon| Site {
            photon,
            probability: 0.25,
        })
        .collect();
    let field = VirtualLights::plain(&scene, unlimited(), &photons, &sites);
    for (k, photon) in photons.iter().enumerate() {
        let bsdf = scene.bsdf(&scene.surface_point(photon.at));
        for w in directions(20) {
            let expected = bsdf.f_cos_wo(photon.wi, w, Lobes::NON_SPECULAR) * photon.flux * 4.0;
            let value = field.intensity(LightId(k as u32), w);
            assert!((value - expected).max_channel().abs() <= 1e-5 * expected.max_channel());
        }
    }
}

/// Random cones; for each of `lights` another direction in it. The sum of what they shine there must be within their bound. Returns the sum of
/// bounds over the sum of values.
fn hold_bounds(field: &VirtualLights, count: u32) -> f64 {
    let ids: Vec<LightId> = (0..field.lights().len() as u32).map(LightId).collect();
    let mut rng = Pcg::new(6);
    let (mut bounds, mut values) = (0.0, 0.0);
    for cluster in ids.chunks(5) {
        let mut bound = IntensityBound::NONE;
        for &id in cluster {
            bound.add(&field.intensity_bound(id));
        }
        for _ in 0..count {
            let axis = warp::sphere(Vec2::new(rng.next_f32(), rng.next_f32()));
            let half_angle = rng.next_f32().powi(2);
            let frame = Frame::from_normal(axis);
            let mut within = || {
                let (sin, cos) = (half_angle * rng.next_f32().sqrt()).sin_cos();
                let turn = std::f32::consts::TAU * rng.next_f32();
                frame.to_world(Vec3::new(sin * turn.cos(), sin * turn.sin(), cos))
            };
            let value: f32 = (cluster.iter())
                .map(|&id| field.intensity(id, within()).luminance())
                .sum();
            let spreads = [Spread::new(half_angle); LANES];
            let bound = bound.luminances(&Lanes3::from_fn(|_| axis), &spreads)[0];
            assert!(value <= bound * 1.0001 + 1e-6, "{value} beyond {bound}");
            bounds += f64::from(bound);
            values += f64::from(value);
        }
    }
    bounds / values
}

#[test]
fn bounds_of_intensity_hold() {
    let tables = |side, storage| Some(GlossyForm::Table { side, storage });
    let forms = [
        None,
        tables(8, TableStorage::Float),
        tables(32, TableStorage::Shared),
        tables(50, TableStorage::Shared),
        Some(GlossyForm::Lobes { count: 5 }),
        Some(GlossyForm::Lobes { count: 1 }),
    ];
    for material in [
        diffuse(0.5, 0.6, 0.7),
        rough_plastic(0.3, Rgb::new(0.2, 0.4, 0.1)),
        rough_metal(0.12),
    ] {
        let scene = floor(material);
        let photons = photons_on_floor(&scene, 400, 8);
        let weights = vec![1.0; photons.len()];
        let sites = select(&photons, &weights, 40, 0.5);
        let (shares, _) = assign(&scene, &photons, &sites, &weights, 0.5);
        for form in forms {
            let field = match form {
                None => VirtualLights::single(&scene, unlimited(), &photons, &shares),
                Some(form) => VirtualLights::rich(&scene, unlimited(), &photons, &shares, form),
            };
            let looseness = hold_bounds(&field, 2000);
            println!("{form:?}: bounds over values {looseness:.1}");
            assert!(looseness < 200.0, "{form:?}: {looseness}");
        }
    }
}

#[test]
fn with_a_light_at_every_photon_the_partition_is_plain() {
    let scene = floor(rough_plastic(0.3, Rgb::new(0.2, 0.4, 0.1)));
    let photons = curve::Curve::sorted(&photons_on_floor(&scene, 500, 2));
    let weights = vec![1.0; photons.len()];
    let sites = select(&photons, &weights, photons.len(), 0.5);
    let plain = VirtualLights::plain(&scene, unlimited(), &photons, &sites);
    let (shares, _) = assign(&scene, &photons, &sites, &weights, 0.5);
    let partition = VirtualLights::single(&scene, unlimited(), &photons, &shares);
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
    let (shares, _) = assign(&scene, &photons, &sites, &weights, 0.5);
    let field = VirtualLights::rich(&scene, unlimited(), &photons, &shares, TABLE);
    assert_eq!(field.bytes(), size_of_val(field.lights()));
    for w in directions(50) {
        let sum: Rgb = (0..field.lights().len())
            .map(|k| field.intensity(LightId(k as u32), w))
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

/// The integral of what is looked up is the flux that should be reflected, from rough to nearly mirror-like.
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
            let shares = twice(&[Site {
                photon: 0,
                probability: 1.0,
            }]);
            let field = VirtualLights::rich(&scene, unlimited(), &photons, &shares, TABLE);
            let emitted = emitted(&field, LightId(0));
            let target = field.energy().reflected;
            for c in 0..3 {
                assert!(
                    close(field.energy().glossy[c], target[c], 1e-5),
                    "{:?}",
                    field.energy()
                );
                assert!(
                    close(emitted[c], target[c], 1e-4),
                    "alpha {alpha}, height {z}: {emitted:?} of {target:?}"
                );
            }
        }
    }
}

/// The target itself is an estimate from few directions: right on average.
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
        let field = VirtualLights::rich(&scene, unlimited(), &photons, &twice(&sites), TABLE);
        let expected: Rgb = photons
            .iter()
            .map(|p| {
                scene
                    .bsdf(&scene.surface_point(p.at))
                    .albedo(p.wi, Lobes::GLOSSY)
            })
            .sum();
        let reflected = field.energy().reflected;
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
    let shares = twice(&[Site {
        photon: 0,
        probability: 1.0,
    }]);
    let field = VirtualLights::rich(&scene, unlimited(), &photons, &shares, TABLE);
    let bsdf = scene.bsdf(&scene.surface_point(photons[0].at));
    let peak = bsdf.f_cos_wo(
        photons[0].wi,
        Vec3::new(-photons[0].wi.x, -photons[0].wi.y, photons[0].wi.z),
        Lobes::GLOSSY,
    );
    for w in directions(400) {
        let expected = bsdf.f_cos_wo(photons[0].wi, w, Lobes::GLOSSY);
        let expected = if w.z > 0.0 { expected } else { Rgb::BLACK };
        let error = field.intensity(LightId(0), w).g - expected.g;
        assert!(error.abs() < 0.06 * peak.g, "{error} at {w}");
    }
}

#[test]
fn many_photons_keep_their_mean_lobe() {
    // All photons of one light, against the sum over all of their lobes: tables draw few, so only the mean over lights agrees. The vertices
    // that the photons come from are nearer than the photons of four lights to each other.
    let scene = floor(rough_metal(0.2));
    let photons = photons_on_floor(&scene, 4000, 9);
    let weights = vec![1.0; photons.len()];
    for (lights, sets) in [(100, 1), (4, 25)] {
        let fields: Vec<VirtualLights> = (0..sets)
            .map(|set| {
                let u = (set as f32 + 0.3) / sets as f32;
                let sites = select(&photons, &weights, lights, u);
                let (shares, _) = assign(&scene, &photons, &sites, &weights, 0.1);
                VirtualLights::rich(&scene, unlimited(), &photons, &shares, TABLE)
            })
            .collect();
        let (mut error, mut total) = (0.0, 0.0);
        for w in directions(100).filter(|w| w.z > 0.1) {
            let emission_view = |field: &VirtualLights| -> Rgb {
                (0..field.lights().len())
                    .map(|k| field.intensity(LightId(k as u32), w))
                    .sum()
            };
            let mean = fields.iter().map(emission_view).sum::<Rgb>() / sets as f32;
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

#[test]
fn nothing_shines_below_the_horizon_but_glass() {
    let prev = Vec3::new(0.3, 0.2, 1.0);
    let mut below = [0.0f32; 2];
    for (i, material) in [rough_plastic(0.2, Rgb::splat(0.5)), rough_glass(0.3)]
        .into_iter()
        .enumerate()
    {
        let scene = floor(material);
        let photons = [falling(&scene, Vec3::Z, Vec3::Z, prev, Rgb::WHITE)];
        let shares = twice(&[Site {
            photon: 0,
            probability: 1.0,
        }]);
        let field = VirtualLights::rich(&scene, unlimited(), &photons, &shares, TABLE);
        let under = directions(500).filter(|w| w.z < 0.0);
        below[i] = under
            .map(|w| field.intensity(LightId(0), w).max_channel())
            .fold(0.0, f32::max);
    }
    assert_eq!(below[0], 0.0);
    assert!(below[1] > 0.5, "{below:?}");
}

#[test]
fn lights_on_a_ball_stand_on_its_surface() {
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
    let (shares, _) = assign(&scene, &photons, &sites, &weights, 0.5);
    let field = VirtualLights::rich(&scene, unlimited(), &photons, &shares, TABLE);
    let light = field
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
fn lights_do_not_stand_in_holes() {
    // Photons on a ring: the middle of the floor is covered by something.
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
    let (shares, _) = assign(
        &scene,
        &photons,
        &[Site {
            photon: 0,
            probability: 1.0,
        }],
        &[1.0; 200],
        0.5,
    );
    let field = VirtualLights::rich(&scene, unlimited(), &photons, &shares, TABLE);
    for light in field.lights() {
        assert!((light.p.length() - 0.3).abs() < 0.05, "{light:?}");
    }
}

#[test]
fn depth_shares_accumulate_only_in_scenes_with_a_limit() {
    let scene = floor(diffuse(0.5, 0.5, 0.5));
    let photons = photons_on_floor(&scene, 2000, 7);
    let weights = vec![1.0; photons.len()];
    let sites = select(&photons, &weights, 10, 0.3);
    let (shares, _) = assign(&scene, &photons, &sites, &weights, 0.1);
    let share = |max_depth, depth| {
        let limits = PathLimits {
            max_depth,
            ..unlimited()
        };
        VirtualLights::rich(&scene, limits, &photons, &shares, TABLE).share_up_to(LightId(0), depth)
    };
    // Depths 1 to 4 alike.
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
    let field = VirtualLights::plain(&scene, unlimited(), &photons, &sites);
    let total: f32 = field.lights().iter().map(|light| light.area).sum();
    // Lights at the border see farther to find neighbors.
    assert!(total > 3.6 && total < 5.5, "{total}");
}

#[test]
fn the_ledger_of_a_furnished_room_balances() {
    use crate::particles::{for_lights, trace_photons};
    use crate::sampling::Pass;
    let scene = crate::testing::scenes::glossy_box(8).build();
    let photons = trace_photons(
        &scene,
        unlimited(),
        4000,
        Pass { index: 0, seed: 1 },
        for_lights,
    );
    let weights: Vec<f32> = photons.iter().map(|p| p.flux.luminance()).collect();
    let sites = select(&photons, &weights, 200, 0.3);
    let (shares, _) = assign(&scene, &photons, &sites, &weights, 0.1);
    let field = VirtualLights::rich(&scene, unlimited(), &photons, &shares, TABLE);
    let ledger = field.energy();
    for c in 0..3 {
        assert!(ledger.residual[c] < 0.1 * ledger.photons[c], "{ledger:?}");
        // The residual is thinned: its lights carry its flux on average.
        let noise = ledger.residual[c] + 1e-6 * ledger.photons[c];
        assert!(
            (ledger.lights[c] - ledger.photons[c]).abs() < noise,
            "{ledger:?}"
        );
        assert!(
            close(ledger.glossy[c], ledger.reflected[c], 1e-4),
            "{ledger:?}"
        );
    }
}

/// The light of one photon that falls from `prev` onto a floor of metal, and what it should reflect.
fn metal_light(alpha: f32, prev: Vec3, form: GlossyForm) -> ([f64; 3], [f64; 3], [f64; 3]) {
    let scene = floor(rough_metal(alpha));
    let flux = Rgb::new(1.0, 2.0, 3.0);
    let photons = [falling(&scene, Vec3::Z, Vec3::Z, prev, flux)];
    let shares = twice(&[Site {
        photon: 0,
        probability: 1.0,
    }]);
    let field = VirtualLights::rich(&scene, unlimited(), &photons, &shares, form);
    let ledger = field.energy();
    let emitted = emitted_in_squares(&field, LightId(0), 1025);
    (emitted, ledger.glossy, ledger.reflected)
}

/// The integral of what is looked up is the flux that should be reflected, in every form.
#[test]
fn every_form_holds_exactly_the_reflected_flux() {
    let table = |side, storage| GlossyForm::Table { side, storage };
    let forms = [
        table(32, TableStorage::Float),
        table(8, TableStorage::Shared),
        table(128, TableStorage::Shared),
        GlossyForm::Lobes { count: 1 },
        GlossyForm::Lobes { count: 5 },
        GlossyForm::Lobes { count: 8 },
    ];
    let mut rng = Pcg::new(21);
    for form in forms {
        for alpha in [0.1f32, 0.15, 0.3, 0.6, 1.0] {
            // Narrow lobes fall between the texels of coarse tables.
            let alpha = if form == forms[2] {
                alpha.max(0.3)
            } else {
                alpha
            };
            let u = Vec2::new(rng.next_f32(), rng.next_f32());
            let prev = warp::cosine_hemisphere(u) + Vec3::Z * 0.02;
            let (emitted, held, target) = metal_light(alpha, prev, form);
            for c in 0..3 {
                assert!(close(held[c], target[c], 1e-5), "{held:?} of {target:?}");
                // The horizon is integrated by sub-samples of texels.
                let tolerance = if form == forms[2] { 2e-3 } else { 1e-4 };
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
    let (shares, _) = assign(&scene, &photons, &sites, &weights, 0.1);
    let field = |storage| {
        let form = GlossyForm::Table { side: 32, storage };
        VirtualLights::rich(&scene, unlimited(), &photons, &shares, form)
    };
    let exact = field(TableStorage::Float);
    let mut sizes = Vec::new();
    for (storage, part) in [
        (TableStorage::Float, 1e-6),
        (TableStorage::Shared, 1.0 / 128.0),
    ] {
        let rounded = field(storage);
        sizes.push((rounded.bytes() - size_of_val(rounded.lights())) / rounded.lights().len());
        for k in 0..exact.lights().len() {
            for w in directions(200) {
                let a = exact.intensity(LightId(k as u32), w);
                let b = rounded.intensity(LightId(k as u32), w);
                let off = (a - b).map(f32::abs).max_channel();
                // The common exponent is that of the brightest texel nearby.
                let scale = if storage == TableStorage::Shared {
                    4.0
                } else {
                    1.0
                };
                assert!(off <= part * scale * a.max_channel() + 1e-9, "{a:?} {b:?}");
            }
        }
    }
    assert_eq!(sizes, [12_300, 6156, 4108]);
}

/// The part of `∫ |I - I_exact|` in the flux, for lights of 16 photons from near each other.
fn misplaced(alpha: f32, form: GlossyForm) -> f64 {
    let scene = floor(rough_metal(alpha));
    let (maker, mut rng) = (form.maker(), Pcg::new(7));
    let (mut error, mut total) = (0.0, 0.0);
    for _ in 0..5 {
        let mut next = || rng.next_f32();
        let base = Vec3::new(2.0 * next() - 1.0, 2.0 * next() - 1.0, 0.2 + next());
        let sources: Vec<Source> = (0..16)
            .map(|_| {
                let off = Vec3::new(next() - 0.5, next() - 0.5, next()) * 0.3;
                let photon = falling(&scene, Vec3::Z, Vec3::Z, base + off, Rgb::WHITE);
                Source {
                    bsdf: scene.bsdf(&scene.surface_point(photon.at)),
                    wi: photon.wi,
                    flux: Rgb::WHITE,
                }
            })
            .collect();
        let profile = maker.make(&sources, alpha, Vec3::Z, &mut Pcg::new(11));
        let mut profiles = form.store();
        let index = profiles.push(&profile);
        let n = 128;
        for i in 0..n * n {
            let uv = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let w = direction_from_square(uv);
            if w.z > 0.0 {
                let exact = |s: &Source| s.bsdf.f_cos_wo(s.wi, w, Lobes::GLOSSY).g;
                let exact: f32 = sources.iter().map(exact).sum();
                let solid_angle = solid_angle_density(uv);
                error += f64::from((profiles.get(index).lookup(w).g - exact).abs() * solid_angle);
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
    // Glossy reflection of no light, and none at all below the horizon of a one-sided light.
    let scene = floor(rough_plastic(0.2, Rgb::splat(0.5)));
    let prev = Vec3::new(0.3, 0.2, 1.0);
    let shares = twice(&[Site {
        photon: 0,
        probability: 1.0,
    }]);
    for flux in [Rgb::BLACK, Rgb::new(0.0, 1.0, 0.0)] {
        let photons = [falling(&scene, Vec3::Z, Vec3::Z, prev, flux)];
        let field = VirtualLights::rich(&scene, unlimited(), &photons, &shares, lobes);
        for w in directions(200) {
            let value = field.intensity(LightId(0), w);
            assert_eq!(value.is_black(), w.z <= 0.0 || flux.is_black(), "{w}");
            assert!(value.is_finite() && value.r == 0.0 && value.b == 0.0);
        }
        let bytes = field.bytes() - size_of_val(field.lights());
        assert_eq!(bytes, 5 * 20);
    }
    // Light that passes through is shown on both sides, and no flux of it is cut.
    let scene = floor(rough_glass(0.3));
    let photons = [falling(&scene, Vec3::Z, Vec3::Z, prev, Rgb::WHITE)];
    let field = VirtualLights::rich(&scene, unlimited(), &photons, &shares, lobes);
    let target = field.energy().reflected;
    assert!(close(emitted(&field, LightId(0))[1], target[1], 1e-4));
    assert!(directions(200).any(|w| w.z < -0.5 && field.intensity(LightId(0), w).g > 0.1));
}
