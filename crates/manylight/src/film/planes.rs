//! All layers of a film at once, as planes.

use super::totals::TileTotals;
use super::{Film, TILE_SIZE};
use rayon::prelude::*;

impl Film {
    /// Means over passes of channels of the recorded layers. A channel is given by the index of its layer in [`Film::layers`] and 0, 1 or 2; its
    /// plane has a value per pixel, row by row from the top. The values are those of [`Film::image`], but the film is read once for all
    /// channels, in parallel.
    ///
    /// # Panics
    /// If an index is too large.
    pub fn planes(&self, channels: &[(usize, usize)]) -> Vec<Vec<f32>> {
        let size = self.image_size().as_usizevec2();
        let mut planes = vec![vec![0.0; size.x * size.y]; channels.len()];
        // The parts of all planes that a row of tiles fills.
        let edge = TILE_SIZE as usize;
        let mut bands: Vec<Vec<&mut [f32]>> = Vec::new();
        bands.resize_with(size.y.div_ceil(edge), Vec::new);
        for plane in &mut planes {
            for (band, part) in bands.iter_mut().zip(plane.chunks_mut(edge * size.x)) {
                band.push(part);
            }
        }
        let stride = self.layers.len();
        let passes = f64::from(self.passes().max(1));
        let tiles: Vec<TileTotals> = self.tile_totals().collect();
        let rows = tiles.par_chunks(size.x.div_ceil(edge));
        rows.zip(bands).for_each(|(tiles, mut band)| {
            for sums in tiles {
                for (i, pixel) in sums.tile().pixels().enumerate() {
                    let place = pixel.y as usize % edge * size.x + pixel.x as usize;
                    for (part, &(layer, channel)) in band.iter_mut().zip(channels) {
                        let value = sums.sum(i * stride + layer)[channel];
                        part[place] = (value / passes) as f32;
                    }
                }
            }
        });
        planes
    }
}

#[cfg(test)]
mod tests {
    use super::super::{FilmDesc, Filter, Layer};
    use super::*;
    use crate::color::Rgb;
    use crate::math::UVec2;
    use std::sync::atomic::{AtomicBool, AtomicU64};

    #[test]
    fn planes_are_the_channels_of_images() {
        let size = UVec2::new(37, 13);
        let desc = FilmDesc {
            size,
            crop_offset: UVec2::ZERO,
            crop_size: size,
            filter: Filter::Box,
        };
        let mut film = Film::new(desc, &[Layer::Beauty, Layer::Direct, Layer::Depth]);
        for pass in 1..4 {
            film.add_pass(&AtomicBool::new(false), &AtomicU64::new(0), |samples| {
                for (i, pixel) in samples.tile().pixels().enumerate() {
                    let place = (100 * pixel.y + pixel.x) as f32;
                    samples.add(i, Layer::Direct, Rgb::new(place, pass as f32, 0.1));
                    samples.add(i, Layer::Depth, Rgb::splat(place / pass as f32));
                }
            });
        }
        let channels = [(0, 1), (1, 0), (2, 2), (1, 1)];
        for (plane, (layer, channel)) in film.planes(&channels).into_iter().zip(channels) {
            let image = film.image(film.layers()[layer]).unwrap();
            let values = image.data.chunks_exact(3).map(|pixel| pixel[channel]);
            assert!(plane.into_iter().eq(values), "{layer} {channel}");
        }
    }
}
