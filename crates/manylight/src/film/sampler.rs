//! Film positions of samples, drawn from the reconstruction filter of their pixel.

use super::FilmDesc;
use super::filter::{FilterSampler, Window, Windows};
use crate::lanes::{Float, Pair, Width};
use crate::math::{UVec2, Vec2};

/// A film position per lane, with the weight of a sample there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilmSamples<S: Width> {
    /// In pixels from the upper left corner of the crop window.
    pub(crate) position: Pair<S>,
    /// Weight with mean 1; negative on negative lobes of the filter.
    pub(crate) weight: Float<S>,
}

/// A column or row of pixels: position of its center in the crop window in pixels, and the
/// [`Window`] of the filter inside: start, share and gain.
type Place = [f32; 4];

/// Draws film positions. Built once per pass.
#[derive(Clone, Debug)]
pub struct FilmSampler {
    filter: FilterSampler,
    /// By column, and by row.
    places: [Vec<Place>; 2],
    /// Edges of a pixel in pixels of the film.
    scale: Vec2,
}

impl FilmDesc {
    /// Prepares the reconstruction filter for sampling. Positions lie within the crop window, as in
    /// Mitsuba: at the border filters are cut and normalized to their part inside.
    pub fn sampler(&self) -> FilmSampler {
        self.sampler_of(self.crop_size.to_array().map(|count| (0..count).collect()))
    }

    /// As [`FilmDesc::sampler`], for a film with the same view and at most `pixels` pixels.
    pub fn reduced_sampler(&self, pixels: u32) -> FilmSampler {
        let full = self.crop_size.as_dvec2();
        let scale = (f64::from(pixels.max(1)) / (full.x * full.y))
            .sqrt()
            .min(1.0);
        let size = (full * scale).floor().as_uvec2().max(UVec2::ONE);
        let reduced = FilmDesc {
            crop_size: size,
            ..self.clone()
        };
        FilmSampler {
            scale: (full / size.as_dvec2()).as_vec2(),
            ..reduced.sampler()
        }
    }

    /// As [`FilmDesc::sampler`], for the pixels in some columns and rows alone: pixel `(i, j)` of
    /// the sampler is that in column `i` and row `j` of these.
    pub fn sampler_of(&self, [columns, rows]: [Vec<u32>; 2]) -> FilmSampler {
        let filter = self.filter.sampler();
        let places = |places: Vec<u32>, count: u32| {
            let window = |place: u32| {
                let center = place as f32 + 0.5;
                let Window { start, share, gain } = filter.window(-center, count as f32 - center);
                [center, start, share, gain]
            };
            places.into_iter().map(window).collect()
        };
        let places = [
            places(columns, self.crop_size.x),
            places(rows, self.crop_size.y),
        ];
        FilmSampler {
            filter,
            places,
            scale: Vec2::ONE,
        }
    }
}

impl FilmSampler {
    /// Number of columns and rows.
    pub fn size(&self) -> UVec2 {
        UVec2::from(self.places.each_ref().map(|places| places.len() as u32))
    }

    /// Draws film positions for `pixels` from their reconstruction filters.
    #[inline(always)]
    pub(crate) fn samples<S: Width>(&self, pixels: &S::Each<UVec2>, u: Pair<S>) -> FilmSamples<S> {
        let s = u.x.width();
        let [columns, rows] = &self.places;
        let [column, row] = Float::gather_quads(s, |i| {
            let UVec2 { x, y } = pixels.as_ref()[i];
            [&columns[x as usize], &rows[y as usize]]
        });
        let windows = [window_of(column), window_of(row)];
        let (offset, weight) = self.filter.sample(windows, u);
        FilmSamples {
            position: (Pair::new(column[0], row[0]) + offset) * Pair::splat(s, self.scale),
            weight,
        }
    }

    /// Index of a pixel in row order, to seed its random numbers.
    #[inline]
    pub fn index(&self, pixel: UVec2) -> u64 {
        u64::from(pixel.y) * self.places[0].len() as u64 + u64::from(pixel.x)
    }
}

/// The window of a [`Place`].
#[inline(always)]
fn window_of<S: Width>([_, start, share, gain]: [Float<S>; 4]) -> Windows<S> {
    Windows { start, share, gain }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Filter;
    use crate::lanes::One;

    fn film(filter: Filter) -> FilmDesc {
        let size = UVec2::new(19, 11);
        FilmDesc {
            size,
            crop_offset: UVec2::ZERO,
            crop_size: size,
            filter,
        }
    }

    /// The film position that `u` draws for `pixel`.
    fn position(sampler: &FilmSampler, pixel: UVec2, u: Vec2) -> Vec2 {
        sampler.samples::<One>(&[pixel], u.into()).position.into()
    }

    #[test]
    fn a_reduced_film_has_the_same_view() {
        let sampler = film(Filter::Box).reduced_sampler(60);
        assert_eq!(sampler.size(), UVec2::new(10, 5));
        let at = |pixel: UVec2, u: f32| position(&sampler, pixel, Vec2::splat(u));
        assert!(at(UVec2::ZERO, 0.0).distance(Vec2::ZERO) < 1e-5);
        assert!(at(UVec2::new(9, 4), 1.0).distance(Vec2::new(19.0, 11.0)) < 1e-4);
        let small = film(Filter::Box).reduced_sampler(10_000);
        assert_eq!(small.size(), UVec2::new(19, 11));
    }

    #[test]
    fn positions_stay_on_the_film() {
        for filter in [
            Filter::Box,
            Filter::Gaussian { stddev: 0.5 },
            Filter::CatmullRom,
        ] {
            let desc = film(filter);
            let sampler = desc.sampler();
            for pixel in [UVec2::ZERO, UVec2::new(9, 5), UVec2::new(18, 10)] {
                for i in 0..4096 {
                    let u = Vec2::new((i % 64) as f32 + 0.5, (i / 64) as f32 + 0.5) / 64.0;
                    let position = position(&sampler, pixel, u);
                    let beyond = (-position).max(position - desc.size.as_vec2());
                    assert!(beyond.max_element() < 1e-4, "{filter:?}: {}", position);
                }
            }
        }
        let [columns, rows] = film(Filter::Box).sampler().places;
        assert!(
            columns
                .iter()
                .chain(&rows)
                .all(|[_, window @ ..]| *window == columns[9][1..])
        );
    }
}
