//! Functions in lanes beside those of the standard library, in all instruction sets.

use super::{
    Float, Mask, One, Pair, Vector, Width, Word, disc, power, sample_linear, sphere, split,
    triangle,
};
use crate::math::{Vec2, Vec3};
use crate::simd::{Instructions, Isa, Simd, SimdKernel};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// A check of `f(x)` for many `x`.
struct Check<'a> {
    inputs: &'a [f32],
    test: fn(&[f32], &[f32; 6]),
}

/// Values of the functions at `x`.
#[inline(always)]
fn values<S: Width>(x: Float<S>) -> [Float<S>; 6] {
    let (sin, cos) = x.sin_cos_turns();
    [
        x.exp(),
        x.abs().ln(),
        x.abs().powf(x.same(2.5)),
        sin,
        cos,
        x.safe_sqrt(),
    ]
}

impl SimdKernel for Check<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        for &x in self.inputs {
            let wide = values(Float::splat(s.wide(), x)).map(|v| v.store()[13]);
            let one = values(Float::splat(One, x)).map(|v| v.get());
            (self.test)(&[x], &wide);
            (self.test)(&[x], &one);
        }
    }
}

fn in_all_instruction_sets(inputs: &[f32], test: fn(&[f32], &[f32; 6])) {
    for set in Instructions::available() {
        let isa = Isa::new(set).expect("available");
        isa.run(Check { inputs, test });
    }
}

#[test]
fn functions_are_those_of_the_standard_library() {
    let inputs: Vec<f32> = (-8000..8000).map(|i| i as f32 * 0.0107 + 1e-4).collect();
    in_all_instruction_sets(&inputs, |x, [exp, ln, pow, sin, cos, root]| {
        let x = f64::from(x[0]);
        let near = |a: f32, b: f64, absolute: f64, relative: f64| {
            let error = (f64::from(a) - b).abs();
            assert!(
                error <= absolute + relative * b.abs(),
                "{a} instead of {b} at {x}"
            );
        };
        near(*exp, x.exp(), 1e-37, 3e-7);
        near(*ln, x.abs().ln(), 1e-7, 2e-7);
        near(*pow, x.abs().powf(2.5), 0.0, 5e-6);
        near(*sin, (x * std::f64::consts::TAU).sin(), 2e-7, 0.0);
        near(*cos, (x * std::f64::consts::TAU).cos(), 2e-7, 0.0);
        near(*root, x.max(0.0).sqrt(), 0.0, 2e-7);
    });
}

#[test]
fn logarithms_of_small_and_large_numbers() {
    let inputs: Vec<f32> = (-37..=38).map(|i| 10f32.powi(i) * 1.3).collect();
    in_all_instruction_sets(&inputs, |x, [_, ln, ..]| {
        let exact = f64::from(x[0]).ln();
        assert!(
            (f64::from(*ln) - exact).abs() <= 2e-7 * exact.abs(),
            "{ln} at {}",
            x[0]
        );
    });
    assert_eq!(Float::splat(One, 0.0).powf(0.5.into()).get(), 0.0);
    assert!(Float::splat(One, 0.0).ln().get() < -87.0);
}

#[test]
fn squares_map_to_discs_by_octants() {
    for i in 0..1000 {
        let u = Vec2::new(i as f32 / 1000.0, (i as f32 * 0.618_034).fract());
        let [x, y] = u.to_array().map(|x| 2.0 * f64::from(x) - 1.0);
        let (r, angle) = match x.abs() > y.abs() {
            true => (x, FRAC_PI_4 * y / x),
            false => (y, FRAC_PI_2 - FRAC_PI_4 * x / y),
        };
        let point: Vec2 = disc(Pair::from(u)).into();
        let expected = [r * angle.cos(), r * angle.sin()].map(|x| x as f32);
        assert!(point.abs_diff_eq(expected.into(), 1e-6), "{u}");
    }
    let center = disc(Pair::from(Vec2::splat(0.5)));
    assert_eq!([center.x.get(), center.y.get()], [0.0, 0.0]);
}

#[test]
fn angles_of_cosines_are_within_their_error() {
    for i in -10_000..=10_000 {
        let x = i as f32 / 10_000.0;
        let error = f64::from(Float::<One>::from(x).acos().get()) - f64::from(x).acos();
        assert!(error.abs() < 4e-7, "{x}: {error}");
    }
}

#[test]
fn choices_are_those_of_single_numbers() {
    let float = |x: f32| Float::from(x);
    for i in 0..1000 {
        let u = Vec2::new(i as f32 / 1000.0, (i as f32 * 0.618_034).fract());
        let (a, b) = (4.0 * u.x - 1.0, 4.0 * u.y - 1.0);
        let expected = if a > 0.0 {
            a * a / (a * a + b * b)
        } else {
            0.0
        };
        assert!((power(float(a), float(b)).get() - expected).abs() < 1e-6);
        let floor = float(100.0 * a).floor();
        assert_eq!(floor.get(), (100.0 * a).floor());
        let word = floor.abs().to_word().store()[0];
        assert_eq!(word as f32, floor.get().abs());
        let (is_below, rest) = split(float(u.x), u.y);
        let expected = if u.x < u.y {
            u.x / u.y
        } else {
            (u.x - u.y) / (1.0 - u.y)
        };
        assert_eq!(is_below.any(), u.x < u.y);
        assert!((rest.get() - expected).abs() < 1e-6 && rest.get() < 1.0);
        // The integral of the line up to the number is the given fraction of the whole.
        let x = sample_linear(float(u.x), float(0.3), float(u.y)).get();
        let below = |x: f32| 0.3 * x + 0.5 * (u.y - 0.3) * x * x;
        assert!((below(x) / below(1.0) - u.x).abs() < 1e-5);
        for unit in [2.0f32.powi(-120), 2.0f32.powi(-70), 2.0f32.powi(110)] {
            let scaled = sample_linear(float(u.x), float(0.3 * unit), float(u.y * unit));
            assert_eq!(scaled.get(), x, "in units of {unit}");
        }
    }
    assert_eq!(sample_linear(float(0.4), float(0.0), float(0.0)).get(), 0.4);
    assert_eq!(float(0.0).atan2_turns(float(0.0)).get(), 0.0);
    for (u, p) in [(0.25, 0.0), (0.25, 1.0)] {
        assert_eq!(split(float(u), p).1.get(), u);
    }
}

#[test]
fn groups_are_the_lanes_of_equal_words() {
    struct Groups;
    impl SimdKernel for Groups {
        type Output = Vec<(u32, u32)>;
        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> Vec<(u32, u32)> {
            let s = s.wide();
            let words = Word::load(s, &s.each(|i| [7, 0, 7, 3][i % 4] + i as u32 / 12));
            let within = Mask::from_bits(s, 0xfff6);
            words.groups(within).map(|(w, m)| (w, m.bits())).collect()
        }
    }
    for set in Instructions::available() {
        let groups = Isa::new(set).expect("available").run(Groups);
        let expected = [
            (0, 0x0222),
            (7, 0x0554),
            (3, 0x0880),
            (8, 0x5000),
            (1, 0x2000),
            (4, 0x8000),
        ];
        assert_eq!(groups, expected);
    }
}

#[test]
fn masks_select_lanes() {
    struct Masks;
    impl SimdKernel for Masks {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, s: S) {
            let s = s.wide();
            let x = Float::from_fn(s, |i| i as f32 - 7.5);
            assert_eq!(x.lt(0.0).bits(), 0x00ff);
            assert_eq!((!x.lt(0.0)).bits(), 0xff00);
            assert_eq!((x.gt(-2.0) & x.lt(2.0)).bits(), 0x03c0);
            assert_eq!(x.lt(0.0).select(-x, x).store(), x.abs().store());
            assert_eq!(
                x.sign().store(),
                s.each(|i| if i < 8 { -1.0_f32 } else { 1.0 })
            );
            assert!(x.lt(8.0).all() && x.gt(8.0).none());
            let (w, valid) = Vector::new(x.max(0.0), x.same(0.0), x.same(0.0)).try_normalize();
            assert_eq!(valid.bits(), 0xff00);
            assert_eq!(w.x.store()[9], 1.0);
        }
    }
    for set in Instructions::available() {
        Isa::new(set).expect("available").run(Masks);
    }
}

#[test]
fn points_are_inside_of_their_domains() {
    for i in 0..1000 {
        let u = Vec2::new(i as f32 / 1000.0, (i as f32 * 0.618_034).fract());
        // Shirley and Chiu's map keeps concentric squares: the radius is the larger coordinate.
        let p = (2.0 * u - 1.0).abs();
        let d: Vec2 = disc(Pair::from(u)).into();
        assert!((d.length() - p.max_element()).abs() < 1e-6, "{u}");
        let w: Vec3 = sphere(Pair::from(u)).into();
        assert!(w.is_normalized() && (w.z - (1.0 - 2.0 * u.y)).abs() < 1e-6);
        let at: Vec2 = triangle(Pair::from(u)).into();
        assert!(at.min_element() >= 0.0 && at.x + at.y <= 1.0);
    }
}

#[test]
fn sines_and_cosines() {
    for i in -40_000..=40_000 {
        let x = i as f32 / 10_000.0;
        let (sin, cos) = Float::from(x).sin_cos_turns();
        let (sin, cos) = (sin.get(), cos.get());
        let exact = (f64::from(x) * std::f64::consts::TAU).sin_cos();
        assert!((f64::from(sin) - exact.0).abs() < 2e-7, "sin({x})");
        assert!((f64::from(cos) - exact.1).abs() < 2e-7, "cos({x})");
        assert!((sin * sin + cos * cos - 1.0).abs() < 4e-7);
    }
}

#[test]
fn angles() {
    let turns = |y: f32, x: f32| Float::from(y).atan2_turns(Float::from(x)).get();
    for i in -1000..=1000 {
        for radius in [1e-10, 1.0, 1e10] {
            let angle = f64::from(i) / 1000.0 * std::f64::consts::PI;
            let (y, x) = (radius * angle.sin() as f32, radius * angle.cos() as f32);
            let exact = f64::from(y).atan2(f64::from(x)) / std::f64::consts::TAU;
            assert!((f64::from(turns(y, x)) - exact).abs() < 1e-7, "{angle}");
        }
    }
    assert_eq!(turns(0.0, 0.0), 0.0);
    assert_eq!(turns(0.0, -2.0), 0.5);
    assert_eq!(turns(3.0, 0.0), 0.25);
}
