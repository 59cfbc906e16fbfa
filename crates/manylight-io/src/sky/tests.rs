//! Comparison with values of Mitsuba 3.9.1's `sunsky`.

use super::*;

fn assert_near(actual: Rgb, expected: [f32; 3], tolerance: f32) {
    let error = actual
        .zip(expected.into(), |a, e| (a - e).abs() / e.abs().max(1e-6))
        .max_channel();
    assert!(error <= tolerance, "{actual:?} is not {expected:?}");
}

/// A sky of turbidity 4 with the sun in the west at this elevation.
fn elevated(radians: f32) -> SunSky {
    let sun_direction = Vec3::new(0.0, radians.cos(), radians.sin());
    SunSky {
        sun_direction,
        turbidity: 4.0,
        ..SunSky::default()
    }
}

/// Integral of the bilinearly interpolated map over the sphere.
fn total(image: &Image) -> Rgb {
    (0..image.height)
        .flat_map(|row| (0..image.width).map(move |column| (column, row)))
        .map(|(column, row)| image.rgb(column, row) * texel_solid_angle(image, row))
        .sum()
}

#[test]
fn sky_radiance_agrees_with_mitsuba() {
    let sky = Sky::new(&SunSky {
        albedo: Rgb::new(0.1, 0.3, 0.6),
        ..elevated(0.7)
    })
    .unwrap();
    let cases = [
        ([0.0, 0.0, 1.0], [0.025_110_63, 0.043_724_44, 0.092_795_8]),
        ([0.6, 0.0, 0.8], [0.028_117_87, 0.052_066_53, 0.109_612_86]),
        ([0.0, 0.8, 0.6], [0.350_913_58, 0.376_508_2, 0.369_804_17]),
        (
            [0.309_426_4, -0.928_279_1, 0.206_284_25],
            [0.073_965_83, 0.134_274_35, 0.238_358_2],
        ),
        ([0.0, -1.0, 1e-4], [0.136_203_4, 0.176_106_3, 0.209_022_95]),
    ];
    for (d, expected) in cases {
        assert_near(sky.radiance(d.into()), expected, 1e-4);
    }
}

#[test]
fn sun_radiance_agrees_with_mitsuba() {
    let cases = [
        (3.0, 40.0, [21_099.65, 17_149.725, 12_325.094]),
        (3.0, 90.0, [22_181.02, 18_786.312, 14_859.581]),
        (3.0, 5.0, [9361.6, 4174.9, 563.8]),
        (3.0, 0.5, [3818.7, 1031.5, 0.0]),
        (3.5, 40.0, [20_690.508, 16_783.844, 12_074.75]),
        (10.0, 40.0, [11_438.458, 8722.89, 6489.68]),
    ];
    for (turbidity, elevation, expected) in cases {
        assert_near(solar::disc_radiance(turbidity, elevation), expected, 2e-4);
    }
}

#[test]
fn sun_positions_agree_with_mitsuba() {
    // Mitsuba computes days in single precision, an error of up to 20 seconds.
    let at = |place: PlaceAndTime, expected: [f32; 3]| {
        let d = place.sun_direction();
        assert!(
            (d - Vec3::from(expected)).length() < 4e-4,
            "{d} is not {expected:?}"
        );
    };
    let tokyo = PlaceAndTime::default();
    at(tokyo, [0.051_385, 0.691_748, 0.720_308]);
    at(
        PlaceAndTime { hour: 9.0, ..tokyo },
        [0.095_695, -0.614_786, 0.782_867],
    );
    at(
        PlaceAndTime {
            hour: 12.0,
            minute: 30.0,
            second: 20.0,
            ..tokyo
        },
        [0.222_764, 0.175_71, 0.958_907],
    );
    let cape_town = PlaceAndTime {
        latitude: -33.9,
        longitude: 18.4,
        timezone: 2.0,
        year: 2024,
        month: 12,
        day: 21,
        hour: 8.0,
        ..tokyo
    };
    at(cape_town, [0.164_762, -0.868_285, 0.467_905]);
    let north = PlaceAndTime {
        latitude: 60.0,
        longitude: -20.0,
        timezone: -1.0,
        year: 2000,
        month: 1,
        day: 1,
        hour: 12.0,
        ..tokyo
    };
    at(north, [0.988_507, -0.093_374, 0.118_888]);
}

#[test]
fn baked_flux_agrees_with_mitsuba() {
    let sky = bake_sunsky(
        &SunSky {
            sun_scale: 0.0,
            ..elevated(0.7)
        },
        256,
    );
    assert_near(total(&sky), [0.571_208_9, 0.755_999, 1.036_63], 2e-3);
    let sun = SunSky {
        sky_scale: 0.0,
        ..elevated(0.7)
    };
    for width in [16, 256, 2048] {
        assert_near(
            total(&bake_sunsky(&sun, width)),
            [1.393_553, 1.128_405, 0.813_182],
            5e-4,
        );
    }
    // Mitsuba computes the size of the disc in single precision, an error of 0.2 %.
    assert_near(
        total(&bake_sunsky(
            &SunSky {
                sun_aperture: 2.0,
                ..sun
            },
            256,
        )),
        [1.3907, 1.1261, 0.8115],
        1e-3,
    );
}

#[test]
fn the_sun_keeps_its_flux_at_the_zenith_and_across_the_seam() {
    for sun_direction in [
        Vec3::Z,
        Vec3::new(1e-3, 0.6, 0.8),
        Vec3::new(-1e-3, 0.6, 0.8),
        Vec3::new(0.0, -0.6, 0.8),
    ] {
        let sun = SunSky {
            sun_direction,
            sky_scale: 0.0,
            ..SunSky::default()
        };
        let elevation = sun_direction.normalize().z.asin().to_degrees();
        let expected =
            solar::disc_radiance(3.0, elevation) * cap((0.5 * SUN_DIAMETER).to_radians());
        assert_near(total(&bake_sunsky(&sun, 128)), expected.to_array(), 5e-3);
    }
}

#[test]
fn the_frame_of_the_map_is_as_documented() {
    let sun_direction = Vec3::new(0.48, 0.64, 0.6);
    let image = bake_sunsky(
        &SunSky {
            sun_direction,
            ..SunSky::default()
        },
        512,
    );
    let brightest = |&(column, row): &(usize, usize)| image.rgb(column, row).luminance();
    let texels =
        (0..image.height).flat_map(|row| (0..image.width).map(move |column| (column, row)));
    let (column, row) = texels
        .max_by(|a, b| brightest(a).total_cmp(&brightest(b)))
        .unwrap();
    // The parametrization of `Environment`: u = atan2(d.x, -d.z) / 2π, rows from pole to pole.
    let (phi, theta) = ((column as f32 + 0.5) / 512.0 * TAU, row as f32 / 256.0 * PI);
    let d = Vec3::new(
        phi.sin() * theta.sin(),
        theta.cos(),
        -phi.cos() * theta.sin(),
    );
    assert!((sky_from_environment() * d).dot(sun_direction) > 0.9999);
    assert!((sky_from_environment().determinant() - 1.0).abs() < 1e-6);
}

#[test]
fn there_is_no_light_from_below_or_at_night() {
    let image = bake_sunsky(&elevated(0.3), 64);
    assert_eq!((image.width, image.height), (64, 33));
    assert!((0..64).all(|x| !image.rgb(x, 16).is_black() && image.rgb(x, 17).is_black()));
    let night = bake_sunsky(
        &SunSky {
            sun_direction: Vec3::new(0.0, 1.0, -0.1),
            ..SunSky::default()
        },
        64,
    );
    assert!(night.data.iter().all(|&v| v == 0.0));
}

#[test]
fn parameters_out_of_range_are_clamped() {
    let hazy = SunSky {
        turbidity: 50.0,
        albedo: Rgb::splat(2.0),
        sun_aperture: 0.0,
        ..elevated(0.5)
    };
    assert!(
        bake_sunsky(&hazy, 0)
            .data
            .iter()
            .all(|v| v.is_finite() && *v >= 0.0)
    );
}

#[test]
fn the_limb_of_the_sun_agrees_with_mitsuba() {
    // The `complex_sun` over the uniform one, at these parts of the radius of the disc, for an
    // elevation of 85 degrees.
    let cases = [
        (0.0, [1.2054, 1.2508, 1.3232]),
        (0.6, [1.0945, 1.1129, 1.141]),
        (0.9, [0.8572, 0.826, 0.7756]),
        (0.99, [0.5941, 0.5217, 0.421]),
    ];
    for (radius, expected) in cases {
        let cos = (1.0_f32 - radius * radius).sqrt();
        assert_near(solar::limb_darkening(cos), expected, 3e-3);
    }
    let sun = |sun_disc| {
        let parameters = SunSky {
            sky_scale: 0.0,
            sun_aperture: 30.0,
            sun_disc,
            ..elevated(0.8)
        };
        bake_sunsky(&parameters, 256)
    };
    let (uniform, darkened) = (sun(SunDisc::Uniform), sun(SunDisc::Darkened));
    let ratio = total(&darkened).zip(total(&uniform), |a, b| a / b);
    assert_near(ratio, [1.0; 3], 2e-3);
    let brightest = |image: &Image| image.data.iter().copied().fold(0.0, f32::max);
    assert!((brightest(&darkened) / brightest(&uniform) - 1.2).abs() < 0.05);
}
