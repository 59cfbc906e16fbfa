//! Values of Mitsuba 3.9.1.

use super::*;

#[test]
fn values_are_those_of_mitsuba() {
    // Columns: case, wi, wo, f_s |wi·ns| in r, g, b; printed by Mitsuba 3.9.1.
    let mut count = 0;
    for line in include_str!("mitsuba.txt").lines() {
        let (name, rest) = line.split_once(' ').unwrap();
        let v: Vec<f32> = rest.split(' ').map(|x| x.parse().unwrap()).collect();
        let case = cases().iter().find(|case| case.name == name).unwrap();
        let (wi, wo) = (Vec3::from_slice(&v[0..3]), Vec3::from_slice(&v[3..6]));
        let f = case.bsdf(Vec3::Z).f_cos_wi(wi, wo, Lobes::ALL);
        for (ours, theirs) in f.to_array().into_iter().zip(&v[6..9]) {
            assert_close(ours, *theirs, 2e-4, line);
        }
        count += 1;
    }
    assert!(count > 200);
}

#[test]
fn delta_lobes_are_those_of_mitsuba() {
    let bsdf = |name: &str| {
        cases()
            .iter()
            .find(|case| case.name == name)
            .unwrap()
            .bsdf(Vec3::Z)
    };
    let w = Vec3::new(0.91f32.sqrt(), 0.0, 0.3);
    let close = |a: Rgb, b: [f32; 3]| {
        a.to_array()
            .iter()
            .zip(b)
            .all(|(a, b)| (a - b).abs() < 2e-5)
    };
    assert!(close(
        bsdf("conductor").albedo(w, Lobes::ALL),
        [0.941_965, 0.665_148, 0.591_406]
    ));
    assert!(close(
        bsdf("thin_glass").transmittance(w),
        [0.590_367, 0.524_77, 0.459_174]
    ));
    assert!(close(
        bsdf("thin_glass").transmittance(-w),
        [0.590_367, 0.524_77, 0.459_174]
    ));
    assert!(close(
        bsdf("thin_glass").albedo(-w, Lobes::DELTA),
        [0.344_037; 3]
    ));
    assert!(close(
        bsdf("plastic").albedo(w, Lobes::DELTA),
        [0.186_981, 0.166_205, 0.145_429]
    ));
    assert!(close(bsdf("mask").transmittance(-w), [0.7; 3]));
    assert!(close(bsdf("null").transmittance(w), [1.0; 3]));

    let through = BsdfNumbers {
        lobe: 0.9,
        direction: Vec2::splat(0.5),
    };
    let seen = bsdf("glass").sample_wi(w, through, Lobes::ALL).unwrap();
    assert!((seen.w - Vec3::new(-0.635_96, 0.0, -0.771_722)).length() < 1e-5);
    // Radiance is compressed on the way out, flux is not.
    assert!(close(seen.weight, [1.0 / 2.25; 3]) && (seen.eta - 1.5).abs() < 1e-6);
    let sent = bsdf("glass").sample_wo(w, through, Lobes::ALL).unwrap();
    assert!(close(sent.weight, [1.0; 3]) && (sent.w - seen.w).length() < 1e-6);
}
