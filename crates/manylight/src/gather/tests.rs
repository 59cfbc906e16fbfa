//! Sums in lanes against single connections, written out.

use super::light_points::light_part;
use super::points::{Batch, LightCylinder};
use super::*;
use crate::bsdf::material::ColorShift;
use crate::bsdf::{Lobes, Material};
use crate::color::Rgb;
use crate::geometry::Segment;
use crate::ids::LightId;
use crate::lanes::{LANES, LaneMask, Lanes3, Mask};
use crate::math::{Vec2, Vec3};
use crate::particles::{trace_photons, usable_by_virtual_lights};
use crate::sampling::rng::Pcg;
use crate::sampling::{Pass, warp};
use crate::scene::PathLimits;
use crate::simd::{self, Isa, Simd};
use crate::testing::scenes::{Builder, diffuse, glass, glossy_box, rough_metal, rough_plastic};
use crate::texture::ColorInput;
use crate::virtual_lights::moments::POINTS;
use crate::virtual_lights::testing::{candidates, rich_lights, single_lights};
use crate::virtual_lights::{
    EmissionView, GlossyForm, PhotonClusters, RadiantIntensity, TableStorage, VirtualLight,
    VirtualLights, assign, select,
};

pub(super) const PASS: Pass = Pass { seed: 3, index: 1 };
pub(super) const UNLIMITED: PathLimits = PathLimits {
    max_depth: None,
    rr_depth: 5,
    hide_emitters: false,
};

/// Tables of `side`² texels.
pub(super) fn table(side: u32) -> Option<GlossyForm> {
    let storage = TableStorage::Shared;
    Some(GlossyForm::Table { side, storage })
}

/// Lights of 2000 photon paths: with glossy parts of this form, or plain ones.
pub(super) fn lights(
    scene: &Scene,
    form: Option<GlossyForm>,
    limits: PathLimits,
) -> LightIndex<'_> {
    let photons = trace_photons(
        scene,
        &scene.infinite_light_guide(),
        limits,
        2000,
        PASS,
        usable_by_virtual_lights,
    );
    let fluxes: Vec<f32> = photons.iter().map(|p| p.flux.luminance()).collect();
    let sites = select(&photons, &fluxes, 90, 0.4);
    LightIndex::new(match form {
        None => single_lights(
            scene,
            limits,
            &photons,
            &PhotonClusters::single_photons(&sites),
        ),
        Some(form) => {
            let (shares, _) = assign(scene, &candidates(&photons, &fluxes), &sites, 0.7);
            rich_lights(scene, limits, &photons, &shares, form)
        }
    })
}

/// What the camera sees in a film's pixels; off their centers, some of which see the very edges of
/// the room.
pub(super) fn points(scene: &Scene, depths: bool) -> Vec<ShadingPoint<'_>> {
    let size = scene.sensor.desc().film.size;
    (0..size.x * size.y)
        .filter_map(|i| {
            let pixel = Vec2::new((i % size.x) as f32 + 0.37, (i / size.x) as f32 + 0.61);
            let ray = scene.sensor.ray(pixel, Vec2::splat(0.5));
            let (_, x) = scene.intersect(&ray)?;
            Some(ShadingPoint {
                x,
                wo: -ray.d,
                bsdf: scene.bsdf(&x),
                max_photon_depth: depths.then_some(i % 3),
                u: i as f32 / 1000.0 % 1.0,
                lights: if i % 5 == 0 {
                    Subset::ALL.part(i % 2, 2).part(i % 11, 4)
                } else {
                    Subset::ALL
                },
                tolerance: 0.0,
                lit_from: (i % 7 == 0).then_some(Vec3::new(0.6, 0.0, 0.8)),
            })
        })
        .collect()
}

/// `Σ_k f |w·n| I_k(-w) V / d²` over lights as points, one connection at a time.
fn written_out(scene: &Scene, lights: &LightIndex, at: &ShadingPoint) -> Rgb {
    let mut sum = Rgb::BLACK;
    let all = lights.set.lights();
    for k in at.lights.indices(all.len()) {
        let light = &all[k];
        let stands_for = at.lights.lights_per_member();
        let id = LightId(k as u32);
        let d2 = light.p.distance_squared(at.x.p);
        let w = (light.p - at.x.p) / d2.sqrt();
        let share = at
            .max_photon_depth
            .map_or(1.0, |m| lights.set.share_up_to(id, m));
        let value = at.bsdf.f_cos_wi(w, at.wo, Lobes::NON_SPECULAR) * lights.set.intensity(id, -w);
        let wanted = at.lit_from.is_none_or(|n| w.dot(n) > 0.0);
        if wanted && d2 > 0.0 && !value.is_black() {
            let segment = Segment {
                from: at.x.offset_towards(w),
                to: light.p + light.n * light.offset.copysign(-w.dot(light.n)),
            };
            sum += value * scene.transmittance(&segment) * (share * stands_for / d2);
        }
    }
    sum
}

fn assert_sums_agree(scene: &Scene, form: Option<GlossyForm>, limits: PathLimits) {
    let lights = lights(scene, form, limits);
    let points = points(scene, limits.max_depth.is_some());
    assert!(points.len() > 200);
    let gather = Gather {
        kernel: Kernel::Point,
        strategy: Strategy::All,
        clamp: Clamp::None,
        refinement: 1.0,
        roulette: 0.0,
    };
    let mut rays = 0;
    // Of every size: batches of all numbers of lanes, and groups of several batches.
    let mut rest = points.as_slice();
    for size in (1..).step_by(7) {
        let (tile, left) = rest.split_at(size.min(rest.len()));
        for (at, sum) in tile.iter().zip(gather.sum(scene, &lights, tile)) {
            let expected = written_out(scene, &lights, at);
            for (a, b) in sum.radiance.to_array().into_iter().zip(expected.to_array()) {
                assert!((a - b).abs() <= 2e-3 * b + 1e-5, "{a} and {b}");
            }
            rays += sum.shadow_rays;
        }
        rest = left;
        if rest.is_empty() {
            break;
        }
    }
    assert!(rays > 1000);
}

/// One point stands for four here: then their mean is the sum over all lights, whatever the clamp.
/// Four choices of lights for a point by itself are clamped as lights of four times the surface.
#[test]
fn lights_divided_among_points_are_clamped_as_all_of_them() {
    let scene = glossy_box(20).build();
    let lights = lights(&scene, table(16), UNLIMITED);
    let gather = Gather {
        kernel: Kernel::Disc,
        strategy: Strategy::All,
        clamp: Clamp::Auto(1.0),
        refinement: 1.0,
        roulette: 0.0,
    };
    let mut points = points(&scene, false);
    let mut sum = |lights_there: Subset| -> Vec<Rgb> {
        points.iter_mut().for_each(|at| at.lights = lights_there);
        let sums = gather.sum(&scene, &lights, &points);
        sums.iter().map(|sum| sum.radiance).collect()
    };
    let all = sum(Subset::ALL);
    let mut mean = |of: &dyn Fn(u32) -> Subset| {
        let mut mean = vec![Rgb::BLACK; all.len()];
        for k in 0..4 {
            for (m, s) in mean.iter_mut().zip(sum(of(k))) {
                *m += s * 0.25;
            }
        }
        mean
    };
    let divided = mean(&|k| Subset::ALL.divided(k, 4));
    let alone = mean(&|k| Subset::ALL.part(k, 4));
    let mut darker = 0;
    for ((all, divided), alone) in all.iter().zip(&divided).zip(&alone) {
        let [a, d, s] = [all, divided, alone].map(|radiance| radiance.luminance());
        assert!((d / a - 1.0).abs() < 1e-4, "{d} and {a}");
        assert!(s < a * 1.0001, "{s} and {a}");
        darker += u32::from(s < 0.99 * a);
    }
    assert!(darker > 50, "{darker}");
}

/// One, four or all points stand for a light; in sixteen turns, each as often as the others.
#[test]
fn points_stand_for_a_light_in_turn() {
    let scene = glossy_box(8).build();
    let lights = lights(&scene, table(16), UNLIMITED);
    let gather = Gather {
        kernel: Kernel::Disc,
        strategy: Strategy::All,
        clamp: Clamp::None,
        refinement: 1.0,
        roulette: 0.0,
    };
    let light = &lights.set.lights()[0];
    for count in [1, 4, POINTS] {
        let mut seen = [0; POINTS];
        for turn in 0..POINTS as u32 {
            let subset = Subset::ALL.from_point(turn);
            for k in 0..count {
                let part = light_part(&gather, light, subset, (k, count));
                seen[light.points.iter().position(|&p| p == part.p).unwrap()] += 1;
            }
        }
        assert_eq!(seen, [count; POINTS]);
    }
    let mut points = points(&scene, false);
    let [first, other] = [0, 5].map(|turn| {
        points
            .iter_mut()
            .for_each(|at| at.lights = Subset::ALL.from_point(turn));
        gather.sum(&scene, &lights, &points)
    });
    assert!(
        first
            .iter()
            .zip(&other)
            .any(|(a, b)| a.radiance != b.radiance)
    );
}

/// A room with coats smooth and rough, metals and glass, so that every form of receiver is there.
pub(super) fn many_materials() -> Scene {
    let mut b = glossy_box(24);
    let (metal, coat) = (
        b.material(rough_metal(0.4)),
        b.material(rough_plastic(0.5, Rgb::WHITE)),
    );
    let smooth = b.material(Material::Plastic {
        eta: 1.5,
        diffuse_reflectance: ColorInput::Constant(Rgb::new(0.5, 0.3, 0.4)),
        specular_reflectance: ColorInput::Constant(Rgb::WHITE),
        color_shift: ColorShift::Nonlinear,
        roughness: None,
    });
    let pane = b.material(glass());
    for (i, material) in [metal, coat, smooth, pane].into_iter().enumerate() {
        let center = Vec3::new(-0.6 + 0.4 * i as f32, 0.3, 0.6);
        b.rectangle(center, Vec3::X * 0.15, Vec3::Y * 0.3, material, None);
    }
    b.build()
}

#[test]
fn rich_lights_are_summed_as_written() {
    assert_sums_agree(&many_materials(), table(16), UNLIMITED);
    let lobes = GlossyForm::Lobes { count: 5 };
    assert_sums_agree(&many_materials(), Some(lobes), UNLIMITED);
}

#[test]
fn plain_lights_are_summed_as_written() {
    assert_sums_agree(&many_materials(), None, UNLIMITED);
}

#[test]
fn path_limits_hold_in_every_lane() {
    let limits = PathLimits {
        max_depth: Some(4),
        ..UNLIMITED
    };
    assert_sums_agree(&glossy_box(24).build(), table(16), limits);
}

#[test]
fn light_through_panes_arrives_dimmed() {
    let window = Material::ThinDielectric {
        eta: 1.5,
        specular_reflectance: ColorInput::Constant(Rgb::WHITE),
        specular_transmittance: ColorInput::Constant(Rgb::WHITE),
        roughness: None,
    };
    let mut b = Builder::new(Vec3::new(0.0, 0.0, -0.95), Vec3::Z, 80.0, 20);
    let (white, pane) = (b.material(diffuse(0.6, 0.6, 0.6)), b.material(window));
    b.room([white; 6], None);
    let light = b.area_light(Rgb::splat(5.0));
    b.rectangle(
        Vec3::new(0.0, 0.9, 0.3),
        Vec3::X * 0.3,
        Vec3::Z * 0.3,
        white,
        Some(light),
    );
    b.rectangle(
        Vec3::new(0.0, 0.0, 0.2),
        Vec3::X * 0.5,
        Vec3::Y * 0.5,
        pane,
        None,
    );
    assert_sums_agree(&b.build(), table(8), UNLIMITED);
}

/// The lanes of a batch that a light may reach.
struct Facing<'a>(&'a Batch<'a, 'a>, &'a VirtualLight<'a>, &'a LightCylinder);

impl simd::SimdKernel for Facing<'_> {
    type Output = LaneMask;

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) -> LaneMask {
        let Facing(batch, light, reach) = self;
        let to = batch.towards(isa.wide(), light.p);
        batch.facing(to, light, reach)
    }
}

#[test]
fn no_point_is_left_out_that_sees_a_part_of_a_light() {
    let scene = many_materials();
    let lights = lights(&scene, table(8), UNLIMITED);
    let points = points(&scene, false);
    let (mut seen, mut in_plane) = (0, 0);
    for batch in Batch::all(&points) {
        for (light, reach) in lights.set.lights().iter().zip(&lights.cylinders) {
            let facing = Isa::best().run(Facing(&batch, light, reach));
            for (i, &member) in batch.members.iter().enumerate() {
                let at = &points[member];
                let Some(n) = at.bsdf.receiving_normal(at.wo) else {
                    continue;
                };
                let heights = light.points.map(|q| {
                    let to = q - at.x.p;
                    let before = if light.one_sided {
                        -to.dot(light.n)
                    } else {
                        1.0
                    };
                    (to.dot(n), before)
                });
                let is_facing = facing >> i & 1 == 1;
                if heights.iter().any(|&(a, b)| a > 1e-5 && b > 1e-5) {
                    assert!(is_facing, "{heights:?}");
                    seen += 1;
                } else if heights.iter().all(|&(a, _)| a == 0.0) && n == light.n {
                    assert!(!is_facing);
                    in_plane += 1;
                }
            }
        }
    }
    assert!(seen > 1000 && in_plane > 100, "{seen} and {in_plane}");
}

/// Of one light, in given directions.
struct Intensities<'a>(&'a VirtualLights<'a>, LightId, &'a Lanes3);

impl simd::SimdKernel for Intensities<'_> {
    type Output = Lanes3;

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) -> Lanes3 {
        let s = isa.wide();
        let emission = EmissionView::of(s, self.0, self.1);
        Lanes3::of_colors(emission.intensity(self.2.vectors(s), Mask::splat(s, true)))
    }
}

#[test]
fn intensities_in_lanes_are_single_intensities() {
    let scene = glossy_box(16).build();
    let storages = [
        TableStorage::Float,
        TableStorage::Shared,
        TableStorage::Blocks,
    ];
    let tables = storages.map(|storage| Some(GlossyForm::Table { side: 32, storage }));
    let lobes = [1, 5, 8].map(|count| Some(GlossyForm::Lobes { count }));
    let others = [table(8), table(64), None];
    for form in tables.into_iter().chain(lobes).chain(others) {
        let lights = lights(&scene, form, UNLIMITED);
        for k in 0..lights.set.lights().len() {
            let id = LightId(k as u32);
            let u = |i: usize| {
                Vec2::new(
                    (i as f32 + 0.5) / 16.0,
                    (i as f32 * 0.618 + 0.1 * k as f32) % 1.0,
                )
            };
            let w = Lanes3::from_fn(|i| warp::sphere(u(i)));
            let values = Isa::best().run(Intensities(&lights.set, id, &w));
            for i in 0..LANES {
                let single = lights.set.intensity(id, w.vec(i));
                for (a, b) in values.rgb(i).to_array().into_iter().zip(single.to_array()) {
                    assert!((a - b).abs() <= 1e-5 * b.abs() + 1e-9, "{a} and {b}");
                }
            }
        }
    }
}

/// `1/(π r²) ∫ f |w·n| I(-w) dw` over the directions from `at` to a sphere, by the midpoint rule.
fn seen_as_sphere(field: &VirtualLights, id: LightId, radius: f32, at: &ShadingPoint) -> Rgb {
    let to = field.lights()[id.index()].p - at.x.p;
    let sin2 = radius * radius / to.length_squared();
    let cos = if sin2 < 1.0 {
        (1.0 - sin2).sqrt()
    } else {
        -1.0
    };
    let frame = crate::math::Frame::from_normal(to.normalize());
    let n = 160;
    let mut sum = Rgb::BLACK;
    for i in 0..n * n {
        let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
        let w = frame.to_world(warp::cone(u, cos));
        sum += at.bsdf.f_cos_wi(w, at.wo, Lobes::NON_SPECULAR) * field.intensity(id, -w);
    }
    sum / (n * n) as f32 / warp::cone_pdf(cos) / (std::f32::consts::PI * radius * radius)
}

#[test]
fn spheres_are_integrals_over_their_directions() {
    let scene = many_materials();
    let gather = Gather {
        kernel: Kernel::Sphere,
        strategy: Strategy::All,
        clamp: Clamp::None,
        refinement: 1.0,
        roulette: 0.0,
    };
    for form in [None, table(16)] {
        let lights = lights(&scene, form, UNLIMITED);
        let all = lights.set.lights();
        let (mut near, mut expected_sum, mut sum) = (0, 0.0, 0.0);
        for (p, point) in points(&scene, false).into_iter().enumerate().step_by(2) {
            // Of many lights one: the nearest, or any.
            let away = |k: &usize| all[*k].p.distance(point.x.p);
            let nearest = (0..all.len()).min_by(|a, b| away(a).total_cmp(&away(b)));
            let k = if p % 2 == 0 {
                nearest.unwrap()
            } else {
                p * 7 % all.len()
            };
            let light = &all[k];
            let stands_for = all.len() as f32;
            let radius = sphere::sphere_radius(light, stands_for);
            let at = ShadingPoint {
                lights: Subset::ALL.part(k as u32, all.len() as u32),
                lit_from: None,
                ..point
            };
            let segment = Segment {
                from: at.x.offset_towards(light.p - at.x.p),
                to: light.p + light.n * light.offset.copysign((at.x.p - light.p).dot(light.n)),
            };
            // A light with its center behind the horizon is dark.
            let to = (light.p - at.x.p).normalize();
            let above = |n: Vec3| to.dot(n) > 1e-3;
            let lit = at.bsdf.receiving_normal(at.wo).is_none_or(above)
                && (!light.one_sided || above(-light.n));
            if !lit || radius == 0.0 || scene.transmittance(&segment).is_black() {
                continue;
            }
            let id = LightId(k as u32);
            let expected = seen_as_sphere(&lights.set, id, radius, &at) * stands_for;
            let trials = 4096;
            let tile: Vec<ShadingPoint> = (0..trials)
                .map(|t| ShadingPoint {
                    u: (t as f32 * 0.618_034).fract(),
                    ..at
                })
                .collect();
            let mean: Rgb = gather
                .sum(&scene, &lights, &tile)
                .into_iter()
                .map(|one| one.radiance / trials as f32)
                .sum();
            let inside = light.p.distance(at.x.p) < 2.0 * radius;
            near += usize::from(inside);
            expected_sum += expected.luminance();
            sum += mean.luminance();
            let error = (mean.luminance() - expected.luminance()).abs();
            assert!(
                error <= 0.15 * expected.luminance() + 2e-3,
                "{mean:?} and {expected:?} at {} radii",
                light.p.distance(at.x.p) / radius
            );
        }
        assert!(near > 10, "{near}");
        assert!(
            (sum / expected_sum - 1.0).abs() < 0.02,
            "{sum} {expected_sum}"
        );
    }
}

/// Roulette keeps the expectation, with fewer shadow rays.
#[test]
fn roulette_keeps_the_mean() {
    let scene = many_materials();
    let lights = lights(&scene, table(16), UNLIMITED);
    let mut points = points(&scene, false);
    points.iter_mut().for_each(|at| at.lights = Subset::ALL);
    let gather = |roulette| Gather {
        kernel: Kernel::Disc,
        strategy: Strategy::All,
        clamp: Clamp::Auto(1.0),
        refinement: 1.0,
        roulette,
    };
    let draws = 200;
    let mut rng = Pcg::new(7);
    let (mut sums, mut rays) = ([vec![], vec![]], [0, 0]);
    for _ in 0..draws {
        points.iter_mut().for_each(|at| at.u = rng.next_f32());
        for (k, roulette) in [0.0, 4.0].into_iter().enumerate() {
            let found = gather(roulette).sum(&scene, &lights, &points);
            rays[k] += found.iter().map(|sum| sum.shadow_rays).sum::<u64>();
            sums[k].push(
                found
                    .iter()
                    .map(|sum| f64::from(sum.radiance.luminance()))
                    .sum::<f64>(),
            );
        }
    }
    let mean = |sums: &[f64]| sums.iter().sum::<f64>() / f64::from(draws);
    let differences: Vec<f64> = sums[1].iter().zip(&sums[0]).map(|(a, b)| a - b).collect();
    let difference = mean(&differences);
    let variance = mean(
        &differences
            .iter()
            .map(|d| (d - difference).powi(2))
            .collect::<Vec<_>>(),
    );
    let z = difference / (variance / f64::from(draws)).sqrt();
    println!("z {z}, {difference} of {}; rays {rays:?}", mean(&sums[0]));
    assert!(variance > 0.0, "some rays are drawn");
    assert!(z.abs() < 4.0, "{z}");
    assert!((difference / mean(&sums[0])).abs() < 0.01);
    assert!(rays[1] * 10 < rays[0] * 8, "{rays:?}");
}

/// A few hundred lights with their tree.
pub(super) fn many_lights(scene: &Scene, form: Option<GlossyForm>) -> LightIndex<'_> {
    let photons = trace_photons(
        scene,
        &scene.infinite_light_guide(),
        UNLIMITED,
        8000,
        PASS,
        usable_by_virtual_lights,
    );
    let fluxes: Vec<f32> = photons.iter().map(|p| p.flux.luminance()).collect();
    let sites = select(&photons, &fluxes, 1500, 0.4);
    let field = match form {
        None => single_lights(
            scene,
            UNLIMITED,
            &photons,
            &PhotonClusters::single_photons(&sites),
        ),
        Some(form) => {
            let (shares, _) = assign(scene, &candidates(&photons, &fluxes), &sites, 0.7);
            rich_lights(scene, UNLIMITED, &photons, &shares, form)
        }
    };
    LightIndex::new(field).with_tree()
}

#[test]
fn cuts_are_as_good_as_promised() {
    let scene = glossy_box(16).build();
    for form in [None, table(16), Some(GlossyForm::Lobes { count: 3 })] {
        let lights = many_lights(&scene, form);
        let points: Vec<ShadingPoint> = points(&scene, false)
            .into_iter()
            .map(|point| ShadingPoint {
                lights: Subset::ALL,
                ..point
            })
            .collect();
        let sum = |strategy| {
            let gather = Gather {
                kernel: Kernel::Disc,
                strategy,
                clamp: Clamp::Auto(1.0),
                refinement: 1.0,
                roulette: 0.0,
            };
            gather.sum(&scene, &lights, &points)
        };
        let cut = |max_error, max_lights| {
            sum(Strategy::Cuts(CutLimits {
                max_error,
                max_lights,
            }))
        };
        let all = sum(Strategy::All);
        let mean = |f: &dyn Fn(usize) -> f64| (0..all.len()).map(f).sum::<f64>() / all.len() as f64;
        let off = |sums: &[Gathered], i: usize| {
            let (a, b) = (sums[i].radiance.luminance(), all[i].radiance.luminance());
            f64::from((a - b).abs() / b.max(1e-3))
        };
        // Without room for any error, every light that matters is summed by itself.
        let exact = cut(0.0, u32::MAX);
        for i in 0..all.len() {
            assert!(off(&exact, i) < 1e-3, "{:?} and {:?}", exact[i], all[i]);
            assert_eq!(exact[i].cluster_error, 0.0);
        }
        let (fine, coarse) = (cut(0.02, u32::MAX), cut(0.2, u32::MAX));
        let size = |sums: &[Gathered]| mean(&|i| f64::from(sums[i].terms));
        println!(
            "{form:?}: of {} lights {:.0} with errors of {:.4}, {:.0} with {:.4}",
            lights.set.lights().len(),
            size(&fine),
            mean(&|i| off(&fine, i)),
            size(&coarse),
            mean(&|i| off(&coarse, i)),
        );
        assert!(mean(&|i| off(&fine, i)) < 0.02);
        assert!(mean(&|i| off(&coarse, i)) < 0.1);
        assert!(size(&coarse) < 0.7 * size(&exact));
        // Darker points count as a hundredth as bright as the brightest point of their cut.
        let luminance = |sum: &Gathered| sum.radiance.luminance();
        let darkest = 0.01 * fine.iter().map(luminance).fold(0.0, f32::max);
        let is_within = |sum: &Gathered| {
            let allowed = 0.02 * luminance(sum).max(darkest) * 1.001;
            sum.cluster_error == 0.0 || sum.cluster_error * luminance(sum) <= allowed
        };
        assert!(fine.iter().all(is_within));
        // With fewer terms, errors may be larger.
        let small = cut(0.02, 60);
        assert!(small.iter().all(|sum| sum.terms <= 60));
        assert!(!small.iter().all(is_within));
        let (sum, expected) = (
            mean(&|i| f64::from(small[i].radiance.luminance())),
            mean(&|i| f64::from(all[i].radiance.luminance())),
        );
        assert!((sum / expected - 1.0).abs() < 0.2, "{sum} and {expected}");
    }
}
