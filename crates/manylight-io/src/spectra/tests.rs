//! Comparison with values of Mitsuba 3.9.1 for the same spectra.

use super::*;

fn assert_near(actual: Rgb, expected: [f32; 3], tolerance: f32) {
    let difference = actual
        .zip(expected.into(), |a, e| (a - e).abs() / e.max(1.0))
        .max_channel();
    assert!(difference <= tolerance, "{actual:?} is not {expected:?}");
}

const RAMP: [(f32, f32); 4] = [(400.0, 0.0), (500.0, 8.0), (600.0, 15.6), (700.0, 18.4)];

/// Wavelengths and values.
type Pairs = &'static [(f32, f32)];

#[test]
fn reflectances_agree_with_mitsuba() {
    let cases: [(Pairs, [f32; 3]); 6] = [
        (
            &[(400.0, 0.5), (700.0, 0.5)],
            [0.497_671, 0.499_878, 0.497_455],
        ),
        (
            &[(400.0, 1.0), (700.0, 0.0)],
            [0.191_194, 0.523_301, 0.858_867],
        ),
        (&[(500.0, 0.5), (600.0, 0.5)], [0.104_902, 0.511_832, 0.0]),
        (
            &[(300.0, 0.0), (800.0, 1.0)],
            [0.684_154, 0.485_452, 0.281_32],
        ),
        (
            &[(400.0, 0.78), (500.0, 0.78), (600.0, 0.78), (700.0, 0.78)],
            [0.776_366_8, 0.779_81, 0.776_029_1],
        ),
        (&RAMP, [1.0; 3]),
    ];
    for (spectrum, expected) in cases {
        assert_near(reflectance_rgb(spectrum), expected, 1e-4);
    }
}

#[test]
fn emission_agrees_with_mitsuba() {
    assert_near(emission_rgb(&RAMP), [20.7108, 10.8546, 2.771_15], 1e-4);
    assert_near(
        emission_rgb(&[(400.0, 1.0), (700.0, 0.0)]),
        [0.259_387, 0.4948, 0.789_747],
        1e-4,
    );
    assert_near(
        constant_emission_rgb(2.5),
        [3.011_98, 2.370_73, 2.272_29],
        1e-4,
    );
}

#[test]
fn coefficients_have_no_upper_bound() {
    assert_near(
        coefficient_rgb(&[(400.0, 3.0), (700.0, 0.0)]),
        [0.573_581, 1.5699, 2.5766],
        1e-4,
    );
    assert_near(
        coefficient_rgb(&[(500.0, -1.0), (600.0, 2.0)]),
        [0.974_248, 0.309_496, 0.0],
        1e-4,
    );
}

#[test]
fn black_bodies_have_the_luminance_of_the_old_candela() {
    let per_lumen = 683.002 * 106.750_26;
    // The candela was once defined by a black body at the freezing point of platinum (2041 K), with
    // 60 cd/cm².
    let luminance = blackbody_rgb(2041.4).luminance() * per_lumen;
    assert!((luminance / 6e5 - 1.0).abs() < 0.01, "{luminance}");
    let white = blackbody_rgb(6500.0);
    assert!((white.r / white.b - 1.0).abs() < 0.1, "{white:?}");
    assert_eq!(blackbody_rgb(0.0), Rgb::BLACK);
}

#[test]
fn named_materials() {
    assert_eq!(
        metal("Cu"),
        Some((
            Rgb::new(0.201_005_47, 0.923_749_5, 1.102_215_4),
            Rgb::new(3.913_262_1, 2.453_045_1, 2.142_089_8)
        ))
    );
    assert_eq!(metal("none"), Some((Rgb::BLACK, Rgb::WHITE)));
    assert_eq!(metal("cu"), None);
    assert_eq!(metal_names().count(), 72);
    assert!(metal_names().all(|name| metal(name).is_some()));
    assert_eq!(dielectric_ior("BK7"), Some(1.5046));
    assert_eq!(dielectric_ior("gold"), None);
    assert_eq!(dielectric_names().count(), 23);
}

#[test]
fn empty_and_single_valued_spectra_are_black() {
    assert_eq!(reflectance_rgb(&[]), Rgb::BLACK);
    assert_eq!(emission_rgb(&[(550.5, 1.0)]), Rgb::BLACK);
}

#[test]
fn spectrum_files() {
    let parse = |text: &str| {
        parse_spectrum(text.as_bytes()).map_err(|f| f.in_file(Path::new("f")).to_string())
    };
    assert_eq!(
        parse("# c\r\n400 3\n\n  500\t1.5 \n700 0").unwrap(),
        [(400.0, 3.0), (500.0, 1.5), (700.0, 0.0)]
    );
    assert_eq!(
        parse("400 1\n500").unwrap_err(),
        "f:2:1: expected a wavelength and a value, found '500'"
    );
    assert_eq!(
        parse("400 x").unwrap_err(),
        "f:1:1: expected a wavelength and a value, found '400 x'"
    );
    assert_eq!(
        parse("400 nan").unwrap_err(),
        "f:1:1: expected a wavelength and a value, found '400 nan'"
    );
    assert_eq!(
        parse("400 1\n400 2").unwrap_err(),
        "f:2:1: the wavelength 400 is not larger than the one before; expected increasing wavelengths"
    );
    assert_eq!(
        parse("# nothing\n").unwrap_err(),
        "f: expected lines with a wavelength and a value, found none"
    );
}

#[test]
fn all_metals_of_mitsuba_are_known() {
    let names: Vec<&str> = metal_names().collect();
    assert_eq!(names.len(), 72);
    // Two values that `mi.load_dict` of Mitsuba 3.9.1 gives.
    let (eta, k) = metal("Cu_palik").unwrap();
    assert_near(eta, [0.21323, 0.91972, 1.10241], 1e-4);
    assert_near(k, [3.92187, 2.45733, 2.13658], 1e-4);
    let (eta, k) = metal("TiO2-e_palik").unwrap();
    assert_near(eta, [3.10656, 2.51317, 2.58244], 1e-4);
    assert_near(k, [0.0; 3], 1e-3);
    for name in names {
        let (eta, k) = metal(name).unwrap();
        assert!(
            eta.zip(k, |eta, k| eta + k)
                .to_array()
                .iter()
                .all(|sum| *sum > 0.0),
            "{name}"
        );
    }
}
