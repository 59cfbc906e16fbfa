//! Bounds of the radiant intensity over cones of directions.

use super::*;
use crate::lanes::{LANES, Lanes3};
use crate::math::{Frame, Spread};
use crate::testing::scenes::{diffuse, rough_metal, rough_plastic};

/// For clusters of five lights and `count` random cones each: the summed intensity, with a random
/// direction within the cone for each light, is within the bound. Returns the sum of bounds over
/// the sum of intensities.
fn hold_bounds(set: &VirtualLights, count: u32) -> f64 {
    let ids: Vec<LightId> = (0..set.lights().len() as u32).map(LightId).collect();
    let mut rng = Pcg::new(6);
    let (mut bounds, mut values) = (0.0, 0.0);
    for cluster in ids.chunks(5) {
        let mut bound = IntensityBound::NONE;
        for &id in cluster {
            bound.add(&IntensityBound::of(set, id));
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
                .map(|&id| set.intensity(id, within()).luminance())
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
        tables(30, TableStorage::Blocks),
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
        let (clusters, _) = assign(&scene, &candidates(&photons, &weights), &sites, 0.5);
        for form in forms {
            let set = match form {
                None => single_lights(&scene, unlimited(), &photons, &clusters),
                Some(form) => rich_lights(&scene, unlimited(), &photons, &clusters, form),
            };
            let looseness = hold_bounds(&set, 2000);
            println!("{form:?}: bounds over values {looseness:.1}");
            assert!(looseness < 200.0, "{form:?}: {looseness}");
        }
    }
}
