//! Sun and sky, and the list of supported plugins.

use crate::{load_version, problems};
use manylight::emitters::Emitter;
use manylight::math::Vec3;
use manylight::scene::SceneDesc;
use manylight_io::supported;

/// World-space direction of the brightest texel of the last emitter.
fn brightest(desc: &SceneDesc) -> Vec3 {
    let Some(Emitter::Environment(environment)) = desc.emitters.last() else {
        panic!()
    };
    let image = &environment.image;
    let pixels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    let (x, y) = pixels
        .max_by(|a, b| image.rgb(a.0, a.1).g.total_cmp(&image.rgb(b.0, b.1).g))
        .unwrap();
    let phi = (x as f32 + 0.5) / image.width as f32 * std::f32::consts::TAU;
    let theta = y as f32 / (image.height - 1) as f32 * std::f32::consts::PI;
    environment.world_from_emitter
        * Vec3::new(
            phi.sin() * theta.sin(),
            theta.cos(),
            -phi.cos() * theta.sin(),
        )
}

/// Tolerance: the radius of the disc of the sun plus a texel, in radians.
const SUN_RADIUS: f32 = 0.01;

#[test]
fn the_sun_is_placed_by_time_or_direction() {
    // Tokyo, 10 July 2010, 9:00. The same sky by time in 0.x (y up), and by a world-space direction
    // in version 3 (z up).
    let sun = Vec3::new(0.095_695, 0.782_867, -0.614_786);
    let old = load_version(
        "0.5.0",
        "<emitter type='sunsky'><transform name='toWorld'><rotate y='1' angle='90'/></transform>
        <float name='hour' value='9'/><float name='sunRadiusScale' value='1'/><float name='scale' value='50'/></emitter>",
    );
    let new = load_version(
        "3.0.0",
        "<emitter type='sunsky'><transform name='to_world'><rotate x='1' angle='-90'/><rotate y='1' angle='90'/></transform>
        <vector name='sun_direction' x='0.095695' y='0.782867' z='-0.614786'/></emitter>",
    );
    // A file of 0.x with the aperture of version 3 has the frame of version 3.
    let mixed = load_version(
        "0.5.0",
        "<emitter type='sunsky'><transform name='toWorld'><rotate x='1' angle='-90'/><rotate y='1' angle='90'/></transform>
        <float name='sunAperture' value='0.6'/><vector name='sunDirection' x='0.095695' y='0.782867' z='-0.614786'/></emitter>",
    );
    for desc in [&old, &new, &mixed] {
        assert!(
            brightest(desc).abs_diff_eq(sun, SUN_RADIUS),
            "{}",
            brightest(desc)
        );
    }
    // Without a transform, version 3 has z up: x is south, y west.
    let plain = load_version(
        "3.0.0",
        "<emitter type='sunsky'><float name='hour' value='9'/></emitter>",
    );
    let south_west_up = Vec3::new(0.095_695, -0.614_786, 0.782_867);
    assert!(
        brightest(&plain).abs_diff_eq(south_west_up, SUN_RADIUS),
        "{}",
        brightest(&plain)
    );
}

#[test]
fn a_sun_below_the_horizon_is_reported() {
    let found = problems(
        "3.0.0",
        "<emitter type='sunsky'><vector name='sun_direction' x='0' y='1' z='-0.1'/></emitter>",
    )
    .join("\n");
    assert!(found.contains("below the horizon"), "{found}");
}

#[test]
fn old_files_have_separate_sky_and_sun() {
    let peak = |xml: &str| match load_version("0.6.0", xml).emitters.last() {
        Some(Emitter::Environment(environment)) => {
            environment.image.data.iter().copied().fold(0.0, f32::max)
        }
        other => panic!("{other:?}"),
    };
    let (sky, sun) = (peak("<emitter type='sky'/>"), peak("<emitter type='sun'/>"));
    assert!(sky > 0.0 && sun > 100.0 * sky, "{sky} {sun}");
}

#[test]
fn every_supported_plugin_is_known() {
    for family in supported().filter(|family| family.format == "mitsuba") {
        assert!(family.plugins.is_sorted(), "{}", family.name);
        for plugin in family.plugins {
            let tag = match family.name {
                "filters" => "rfilter",
                plural => plural.trim_end_matches('s'),
            };
            let object = format!("<{tag} type='{plugin}'/>");
            let content = match tag {
                "rfilter" => format!(
                    "<sensor type='perspective'><film type='hdrfilm'>{object}</film></sensor>"
                ),
                _ => object,
            };
            let found = problems("0.6.0", &content).join("\n");
            for refusal in ["unknown", "not supported"] {
                assert!(!found.contains(refusal), "{content}: {found}");
            }
        }
    }
}
