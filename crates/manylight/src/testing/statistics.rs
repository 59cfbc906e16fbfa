//! Statistics of noisy images.

use crate::film::{Film, Layer};

/// Mean of a layer over all pixels and channels.
///
/// # Panics
/// If the film does not record the layer.
pub fn layer_mean(film: &Film, layer: Layer) -> f64 {
    let image = film.image(layer).expect("the film records this layer");
    image.data.iter().map(|&v| f64::from(v)).sum::<f64>() / image.data.len() as f64
}

/// Mean of a term of the path partition over all pixels and channels: of virtual lights the sum
/// with their compensation, which shares the paths of that term.
///
/// # Panics
/// If the film does not record the layer.
pub fn term_mean(film: &Film, term: Layer) -> f64 {
    let compensated = term == Layer::VirtualLights && film.image(Layer::Compensation).is_some();
    let shared = if compensated {
        layer_mean(film, Layer::Compensation)
    } else {
        0.0
    };
    layer_mean(film, term) + shared
}

/// Mean of the beauty over pixels by channel, with its standard error for independent pixels.
pub fn channel_means(film: &Film) -> [(f64, f64); 3] {
    let (image, variance) = (
        film.image(Layer::Beauty)
            .expect("every film records the beauty"),
        film.variance(),
    );
    let n = (image.width * image.height) as f64;
    std::array::from_fn(|c| {
        let channel = |data: &[f32]| {
            data.iter()
                .skip(c)
                .step_by(3)
                .map(|&v| f64::from(v))
                .sum::<f64>()
        };
        (channel(&image.data) / n, channel(&variance.data).sqrt() / n)
    })
}

/// z-scores of the beauty between two films, by block of `size` x `size` pixels and channel: the
/// difference of the means over its standard error. Valid for independent pixels.
pub fn block_z_scores(a: &Film, b: &Film, size: usize) -> Vec<f64> {
    let (image_a, image_b) = (
        a.image(Layer::Beauty).unwrap_or_default(),
        b.image(Layer::Beauty).unwrap_or_default(),
    );
    let (var_a, var_b) = (a.variance(), b.variance());
    let mut scores = Vec::new();
    for by in (0..image_a.height).step_by(size) {
        for bx in (0..image_a.width).step_by(size) {
            let mut difference = [0.0; 3];
            let mut variance = [0.0; 3];
            for y in by..(by + size).min(image_a.height) {
                for x in bx..(bx + size).min(image_a.width) {
                    for c in 0..3 {
                        difference[c] +=
                            f64::from(image_a.pixel(x, y)[c]) - f64::from(image_b.pixel(x, y)[c]);
                        variance[c] +=
                            f64::from(var_a.pixel(x, y)[c]) + f64::from(var_b.pixel(x, y)[c]);
                    }
                }
            }
            for c in 0..3 {
                if variance[c] > 0.0 {
                    scores.push(difference[c] / f64::sqrt(variance[c]));
                }
            }
        }
    }
    scores
}
