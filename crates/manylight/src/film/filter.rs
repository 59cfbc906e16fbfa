//! Reconstruction filters by importance sampling. A sample is drawn around the center of one pixel
//! and contributes to that pixel only.

use crate::lanes::{Float, Pair, Width};

/// A reconstruction filter, as scene files name it. Radii and deviations are in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// Constant over the square of the pixel.
    Box,
    /// Falls linearly to 0 at `radius`.
    Tent {
        /// Radius in pixels.
        radius: f32,
    },
    /// Gaussian, cut at 4 deviations and lowered to 0 there, as in Mitsuba.
    Gaussian {
        /// Standard deviation in pixels.
        stddev: f32,
    },
    /// Mitchell-Netravali, radius 2.
    Mitchell {
        /// Parameter B of Mitchell and Netravali.
        b: f32,
        /// Parameter C of Mitchell and Netravali.
        c: f32,
    },
    /// Catmull-Rom, radius 2.
    CatmullRom,
    /// Windowed sinc.
    Lanczos {
        /// Number of lobes; equal to the radius in pixels.
        lobes: f32,
    },
}

impl Filter {
    /// Half the edge of the support of the filter, a square, in pixels.
    pub fn radius(&self) -> f32 {
        match *self {
            Filter::Box => 0.5,
            Filter::Tent { radius } => radius,
            Filter::Gaussian { stddev } => GAUSSIAN_RADIUS_IN_DEVIATIONS * stddev,
            Filter::Mitchell { .. } | Filter::CatmullRom => 2.0,
            Filter::Lanczos { lobes } => lobes,
        }
    }

    /// Profile of the filter along one axis at `x` pixels from the center, not normalized. Filters
    /// are separable.
    pub fn eval(&self, x: f32) -> f32 {
        let x = x.abs();
        if x > self.radius() {
            return 0.0;
        }
        match *self {
            Filter::Box => 1.0,
            Filter::Tent { radius } => (1.0 - x / radius).max(0.0),
            Filter::Gaussian { stddev } => {
                let gaussian = |x: f32| (-0.5 * (x / stddev).powi(2)).exp();
                (gaussian(x) - gaussian(self.radius())).max(0.0)
            }
            Filter::Mitchell { b, c } => mitchell(x, b, c),
            Filter::CatmullRom => mitchell(x, 0.0, 0.5),
            Filter::Lanczos { lobes } => sinc(x) * sinc(x / lobes),
        }
    }

    /// Tabulates the filter for importance sampling.
    pub(super) fn sampler(&self) -> FilterSampler {
        FilterSampler::new(self)
    }
}

/// Support radius of a Gaussian in standard deviations, as in Mitsuba.
const GAUSSIAN_RADIUS_IN_DEVIATIONS: f32 = 4.0;

/// Number of cells of the table across the filter. For a radius of 2 pixels a cell is 1/128 pixel,
/// far below what an image resolves.
const TABLE_CELLS: usize = 512;

/// Profile of the Mitchell-Netravali filters for `0 <= x <= 2`.
///
/// Source: Mitchell and Netravali, "Reconstruction Filters in Computer Graphics", 1988, eq. (8).
fn mitchell(x: f32, b: f32, c: f32) -> f32 {
    let (x2, x3) = (x * x, x * x * x);
    let sixfold = if x < 1.0 {
        (12.0 - 9.0 * b - 6.0 * c) * x3 + (-18.0 + 12.0 * b + 6.0 * c) * x2 + (6.0 - 2.0 * b)
    } else {
        (-b - 6.0 * c) * x3
            + (6.0 * b + 30.0 * c) * x2
            + (-12.0 * b - 48.0 * c) * x
            + (8.0 * b + 24.0 * c)
    };
    sixfold / 6.0
}

/// sin(πx) / (πx).
fn sinc(x: f32) -> f32 {
    /// Argument below which the quotient rounds to its limit 1.
    const LIMIT: f32 = 1e-4;
    let a = std::f32::consts::PI * x;
    if a.abs() < LIMIT { 1.0 } else { a.sin() / a }
}

/// Draws offsets from a pixel's center with a density proportional to the absolute value of the
/// filter.
#[derive(Clone, Debug)]
pub(super) struct FilterSampler {
    radius: f32,
    /// Cumulative sum of the absolute values of the cells, normalized to end at 1; empty for a box,
    /// which needs no table.
    cdf: Vec<f32>,
    /// By interval of the CDF's values, all of one size: the last cell that starts below all values
    /// of the interval.
    guide: Vec<u16>,
    cells: Vec<Cell>,
}

/// A cell of the table, within which the filter is constant: value of the CDF at its start, inverse
/// of the CDF's increase within it, offset of its start from the pixel's center, and the weight of
/// samples: the sign of the filter times the integral of its absolute value over its integral.
type Cell = [f32; 4];

/// An interval of a filter along one axis from which samples are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window {
    /// Value of the CDF at the start of the interval.
    pub(super) start: f32,
    /// Increase of the CDF over the interval.
    pub(super) share: f32,
    /// Factor on sample weights that makes their mean 1.
    pub(super) gain: f32,
}

/// A [`Window`] per lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Windows<S: Width> {
    pub(super) start: Float<S>,
    pub(super) share: Float<S>,
    pub(super) gain: Float<S>,
}

impl Window {
    /// The window of the whole filter.
    const WHOLE: Window = Window {
        start: 0.0,
        share: 1.0,
        gain: 1.0,
    };
}

impl FilterSampler {
    fn new(filter: &Filter) -> Self {
        let radius = filter.radius();
        if *filter == Filter::Box {
            return FilterSampler {
                radius,
                cdf: Vec::new(),
                guide: Vec::new(),
                cells: Vec::new(),
            };
        }
        // Offset of the point `i` cells from the start.
        let offset = |i: f32| (i / TABLE_CELLS as f32 * 2.0 - 1.0) * radius;
        let values: Vec<f64> = (0..TABLE_CELLS)
            .map(|i| f64::from(filter.eval(offset(i as f32 + 0.5))))
            .collect();
        let total: f64 = values.iter().map(|v| v.abs()).sum();
        let mut running = 0.0;
        let mut cdf = vec![0.0];
        for v in &values {
            running += v.abs();
            cdf.push((running / total) as f32);
        }
        let guide = (0..TABLE_CELLS).map(|k| {
            let least = k as f32 / TABLE_CELLS as f32;
            cdf.partition_point(|&c| c <= least).saturating_sub(1) as u16
        });
        let guide = guide.collect();
        let gain = total / values.iter().sum::<f64>();
        let cell = |(i, v): (usize, &f64)| {
            let increase = cdf[i + 1] - cdf[i];
            let weight = (v.signum() * gain) as f32;
            if increase > 0.0 {
                [cdf[i], increase.recip(), offset(i as f32), weight]
            } else {
                [cdf[i], 0.0, offset(i as f32 + 0.5), weight]
            }
        };
        let cells = values.iter().enumerate().map(cell).collect();
        FilterSampler {
            radius,
            cdf,
            guide,
            cells,
        }
    }

    /// The interval of the filter between two offsets from the pixel's center, in pixels.
    pub(super) fn window(&self, from: f32, to: f32) -> Window {
        if from <= -self.radius && to >= self.radius {
            return Window::WHOLE;
        }
        let cells = TABLE_CELLS as f32;
        let place = |x: f32| ((x / self.radius + 1.0) * 0.5).clamp(0.0, 1.0) * cells;
        let (from, to) = (place(from), place(to));
        let share_within = |i: usize| {
            let inside = to.min(i as f32 + 1.0) - from.max(i as f32);
            inside.max(0.0) * (self.cdf[i + 1] - self.cdf[i])
        };
        let start: f32 = {
            let i = (from as usize).min(TABLE_CELLS - 1);
            self.cdf[i] + (from - i as f32) * (self.cdf[i + 1] - self.cdf[i])
        };
        let share: f32 = (0..TABLE_CELLS).map(share_within).sum();
        let integral: f32 = (0..TABLE_CELLS)
            .map(|i| share_within(i) * self.cells[i][3])
            .sum();
        Window {
            start,
            share,
            gain: share / integral,
        }
    }

    /// Offsets from the pixels' centers in pixels, and weights of the samples. The mean weight is
    /// 1: the pixel value is the mean of weight times radiance.
    #[inline(always)]
    pub(super) fn sample<S: Width>(
        &self,
        windows: [Windows<S>; 2],
        u: Pair<S>,
    ) -> (Pair<S>, Float<S>) {
        let (x, weight_x) = self.sample_1d(windows[0], u.x);
        let (y, weight_y) = self.sample_1d(windows[1], u.y);
        (Pair::new(x, y), weight_x * weight_y)
    }

    #[inline(always)]
    fn sample_1d<S: Width>(&self, window: Windows<S>, u: Float<S>) -> (Float<S>, Float<S>) {
        if self.cells.is_empty() {
            return ((2.0 * u - 1.0) * self.radius, u.same(1.0));
        }
        let u = window.start + window.share * u;
        let each = u.store();
        let [[start, per_increase, offset, weight]] =
            Float::gather_quads(u.width(), |i| [&self.cells[self.cell(each.as_ref()[i])]]);
        let fraction = ((u - start) * per_increase).min(1.0);
        let width = 2.0 * self.radius / TABLE_CELLS as f32;
        (offset + fraction * width, weight * window.gain)
    }

    /// The cell within which the CDF has the value `u` in [0, 1].
    #[inline(always)]
    fn cell(&self, u: f32) -> usize {
        let interval = ((u * TABLE_CELLS as f32) as usize).min(TABLE_CELLS - 1);
        let mut i = usize::from(self.guide[interval]);
        while i + 1 < TABLE_CELLS && self.cdf[i + 1] <= u {
            i += 1;
        }
        i
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::One;
    use crate::math::Vec2;

    const ALL: [Filter; 7] = [
        Filter::Box,
        Filter::Tent { radius: 1.7 },
        Filter::Gaussian { stddev: 0.8 },
        Filter::Mitchell {
            b: 1.0 / 3.0,
            c: 1.0 / 3.0,
        },
        Filter::Mitchell { b: 0.2, c: 0.6 },
        Filter::CatmullRom,
        Filter::Lanczos { lobes: 3.0 },
    ];

    fn single(window: Window) -> Windows<One> {
        Windows {
            start: window.start.into(),
            share: window.share.into(),
            gain: window.gain.into(),
        }
    }

    /// Offset and weight of a sample along one axis.
    fn sample_1d(sampler: &FilterSampler, window: Window, u: f32) -> (f32, f32) {
        let (x, weight) = sampler.sample_1d(single(window), u.into());
        (x.get(), weight.get())
    }

    #[test]
    fn profiles_match_mitsuba() {
        // Mitsuba 3.9.1 approximates the Gaussian by a polynomial, with errors up to 8e-4.
        let expected: [[f32; 6]; 7] = [
            [1.0, 1.0, 0.0, 0.0, 0.0, 0.0],
            [1.0, 0.823_529_4, 0.588_235_3, 0.352_941_2, 0.0, 0.0],
            [
                0.999_256,
                0.931_630_7,
                0.681_867_7,
                0.388_219,
                0.059_271_5,
                0.004_749_3,
            ],
            [0.888_889, 0.740_389, 0.309_055_6, 0.0135, -0.002_944_2, 0.0],
            [
                0.933_333_3,
                0.783_033_3,
                0.330_633_3,
                -0.024_300_1,
                -0.005_367_1,
                0.0,
            ],
            [1.0, 0.8155, 0.2895, -0.040_499_8, -0.004_500_2, 0.0],
            [
                1.0,
                0.844_343_1,
                0.335_810_3,
                -0.070_916_8,
                -0.023_769_9,
                0.017_393_8,
            ],
        ];
        for (filter, values) in ALL.into_iter().zip(expected) {
            for (x, value) in [0.0, 0.3, 0.7, 1.1, 1.9, 2.6].into_iter().zip(values) {
                assert!(
                    (filter.eval(-x) - value).abs() < 8e-4,
                    "{filter:?} at {x}: {}",
                    filter.eval(x)
                );
            }
        }
    }

    #[test]
    fn weighted_samples_reproduce_the_filter() {
        for filter in ALL {
            let sampler = filter.sampler();
            let n = 20_000;
            let (mut one, mut second) = (0.0, 0.0);
            for i in 0..n {
                let (x, weight) = sample_1d(&sampler, Window::WHOLE, (i as f32 + 0.5) / n as f32);
                one += f64::from(weight) / f64::from(n);
                second += f64::from(weight * x * x) / f64::from(n);
            }
            let (mut integral, mut moment) = (0.0, 0.0);
            for i in 0..n {
                let x = ((i as f32 + 0.5) / n as f32 * 2.0 - 1.0) * filter.radius();
                integral += f64::from(filter.eval(x));
                moment += f64::from(filter.eval(x) * x * x);
            }
            assert!((one - 1.0).abs() < 1e-3, "{filter:?}: mean weight {one}");
            assert!(
                (second - moment / integral).abs() < 2e-3,
                "{filter:?}: {second} for {}",
                moment / integral
            );
        }
    }

    #[test]
    fn parts_of_a_filter_reproduce_it_with_mean_weight_one() {
        for (filter, (from, to)) in ALL
            .into_iter()
            .flat_map(|f| [(f, (-0.5, 9.0)), (f, (-1.5, 0.5)), (f, (-0.5, 0.5))])
        {
            let sampler = filter.sampler();
            let window = sampler.window(from, to);
            let n = 20_000;
            let (mut one, mut first) = (0.0, 0.0);
            for i in 0..n {
                let (x, weight) = sample_1d(&sampler, window, (i as f32 + 0.5) / n as f32);
                assert!(x > from - 1e-4 && x < to + 1e-4, "{filter:?}: {x}");
                one += f64::from(weight) / f64::from(n);
                first += f64::from(weight * x) / f64::from(n);
            }
            let (mut integral, mut moment) = (0.0, 0.0);
            for i in 0..n {
                let x = ((i as f32 + 0.5) / n as f32 * 2.0 - 1.0) * filter.radius();
                if x > from && x < to {
                    integral += f64::from(filter.eval(x));
                    moment += f64::from(filter.eval(x) * x);
                }
            }
            assert!((one - 1.0).abs() < 1e-3, "{filter:?}: mean weight {one}");
            let expected = moment / integral;
            assert!(
                (first - expected).abs() < 2e-3,
                "{filter:?}: {first} for {expected}"
            );
        }
    }

    #[test]
    fn samples_in_two_dimensions_stay_within_the_radius() {
        for filter in ALL {
            let windows = [single(Window::WHOLE); 2];
            let u = Vec2::new(0.0, 1.0 - f32::EPSILON);
            let (offset, _) = filter.sampler().sample(windows, u.into());
            let offset = Vec2::from(offset);
            assert!(offset.abs().max_element() <= filter.radius() * 1.000_001);
            assert!(offset.x < 0.0 && offset.y > 0.0);
        }
    }
}
