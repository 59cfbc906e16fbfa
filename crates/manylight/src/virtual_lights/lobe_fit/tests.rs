//! Fits of known mixtures, of mixtures cut by a horizon, and of degenerate samples.

use super::*;
use crate::math::{Frame, Vec2};
use crate::sampling::warp;

/// Lobes of `(axis, kappa, share, color)` in samples of equal luminance.
fn draw_samples(
    lobes: &[(Vec3, f32, f32, Rgb)],
    count: usize,
    rng: &mut Pcg,
) -> WeightedDirections {
    let mut samples = WeightedDirections::default();
    for &(axis, kappa, share, color) in lobes {
        for _ in 0..(share * count as f32).round() as usize {
            let u = Vec2::new(rng.next_f32(), rng.next_f32());
            let w = Frame::from_normal(axis).to_world(warp::von_mises_fisher(u, kappa));
            samples.all.push((w, color / color.luminance()));
        }
    }
    samples
}

#[test]
fn known_mixtures_are_recovered() {
    let axis = |x, y, z| Vec3::new(x, y, z).normalize();
    let (red, green, blue) = (
        Rgb::new(1.0, 0.1, 0.2),
        Rgb::new(0.2, 1.0, 0.3),
        Rgb::new(0.3, 0.2, 1.0),
    );
    let mixtures: [&[(Vec3, f32, f32, Rgb)]; 4] = [
        &[(axis(0.3, -0.2, 0.9), 6.0, 1.0, red)],
        &[(axis(-0.5, 0.2, 0.6), 1e4, 1.0, blue)],
        &[
            (axis(1.0, 0.0, 0.2), 200.0, 0.5, red),
            (axis(0.0, 1.0, 0.5), 50.0, 0.3, green),
            (axis(-0.5, -1.0, 0.5), 15.0, 0.2, blue),
        ],
        // One lobe within another, like a peak with tails.
        &[
            (axis(0.1, 0.1, 1.0), 400.0, 0.6, red),
            (axis(0.1, 0.1, 1.0), 10.0, 0.4, green),
        ],
    ];
    let mut rng = Pcg::new(1);
    for mixture in mixtures {
        let samples = draw_samples(mixture, 20_000, &mut rng);
        let total: Rgb = samples.all.iter().map(|s| s.1).sum();
        let fitted = samples.fit(mixture.len(), 1e5, None, &mut rng);
        assert_eq!(fitted.len(), mixture.len());
        let got: Rgb = fitted.iter().map(|c| c.flux).sum();
        assert!(
            (got / total.max_channel() - total / total.max_channel())
                .g
                .abs()
                < 1e-4
        );
        for &(axis, kappa, share, color) in mixture {
            let lobe = fitted
                .iter()
                .min_by(|a, b| {
                    let off =
                        |c: &Component| (c.axis - axis).length() + (c.kappa / kappa).ln().abs();
                    off(a).total_cmp(&off(b))
                })
                .expect("lobes");
            assert!((lobe.axis - axis).length() < 0.05, "{lobe:?}, not {axis}");
            assert!(
                (lobe.kappa / kappa - 1.0).abs() < 0.1,
                "{lobe:?}, not {kappa}"
            );
            assert!((lobe.weight - share).abs() < 0.02, "{lobe:?}, not {share}");
            let hue = (lobe.flux.r / lobe.flux.g) / (color.r / color.g);
            assert!(mixture.len() == 2 || (0.8..1.25).contains(&hue), "{lobe:?}");
        }
    }
}

#[test]
fn lobes_that_the_horizon_cuts_are_recovered() {
    let mut rng = Pcg::new(2);
    for (elevation, kappa) in [(0.2f32, 4.0), (0.1, 30.0), (0.6, 2.0)] {
        let axis = Vec3::new(elevation.cos(), 0.0, elevation.sin());
        let mut samples = draw_samples(&[(axis, kappa, 1.0, Rgb::WHITE)], 20_000, &mut rng);
        samples.all.retain(|(w, _)| w.z > 0.0);
        let fitted = samples.fit(1, 1e5, Some(Vec3::Z), &mut rng);
        let lobe = fitted[0];
        assert!((lobe.axis - axis).length() < 0.1, "{lobe:?}, not {axis}");
        assert!(
            (lobe.kappa / kappa - 1.0).abs() < 0.15,
            "{lobe:?}, not {kappa}"
        );
    }
}

#[test]
fn few_samples_give_bounded_lobes() {
    let mut rng = Pcg::new(3);
    let none = WeightedDirections::default();
    assert!(none.fit(5, 100.0, None, &mut rng).is_empty());
    let black = WeightedDirections {
        all: vec![(Vec3::Z, Rgb::BLACK); 20],
    };
    assert!(black.fit(5, 100.0, None, &mut rng).is_empty());
    // All in one direction: one lobe, although the limit is 5.
    let one = WeightedDirections {
        all: vec![(Vec3::Z, Rgb::WHITE); 20],
    };
    for max_kappa in [10.0, 1e6] {
        let lobes = one.fit(5, max_kappa, Some(Vec3::Z), &mut rng);
        assert_eq!(lobes.len(), 1);
        assert!(lobes[0].kappa <= max_kappa && lobes[0].kappa.is_finite());
        assert!((lobes[0].axis - Vec3::Z).length() < 1e-5);
        assert!((lobes[0].flux.g - 20.0).abs() < 1e-3, "{lobes:?}");
    }
}
