//! z-scores of blocks: is a region biased, beyond what noise explains?

use super::Frame;
use serde::Serialize;

/// Edge of a block in pixels.
const BLOCK: usize = 8;

/// A z-score beyond which a block is counted: 0.27 % of blocks where only normal noise differs.
const LIMIT: f64 = 3.0;

/// Sums of 32-bit numbers are true to this share. It matters where there is no noise, as on emitters.
const ROUNDING: f64 = 1e-6;

/// z = (x - r) / sqrt(var x + var r + rounding²) over the means of blocks, per channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct BlockScores {
    /// Blocks with at least one kept pixel, times three channels, where there is noise or a difference.
    pub(crate) count: usize,
    /// Share of them with |z| > 3.
    pub(crate) share_beyond_3: f64,
    /// Mean of z: 0 without bias.
    pub(crate) mean: f64,
    /// Root of the mean of z²: 1 where only noise differs.
    pub(crate) rms: f64,
    /// Largest |z|.
    pub(crate) largest: f64,
}

/// Scores of all blocks; `None` unless both variances are known.
pub(crate) fn block_scores(image: &Frame, reference: &Frame, kept: &[bool]) -> Option<BlockScores> {
    let variances = image
        .variance
        .as_deref()
        .zip(reference.variance.as_deref())?;
    let mut scores = Vec::new();
    for y in (0..image.height).step_by(BLOCK) {
        for x in (0..image.width).step_by(BLOCK) {
            let pixels = block_pixels(image, x, y, kept);
            scores.extend((0..3).filter_map(|c| score(image, reference, variances, &pixels, c)));
        }
    }
    Some(summary(&scores))
}

fn block_pixels(frame: &Frame, x0: usize, y0: usize, kept: &[bool]) -> Vec<usize> {
    let rows = y0..(y0 + BLOCK).min(frame.height);
    let columns = x0..(x0 + BLOCK).min(frame.width);
    let all = rows.flat_map(|y| columns.clone().map(move |x| y * frame.width + x));
    all.filter(|&i| kept[i]).collect()
}

/// Of one block in one channel. The number of pixels cancels: Σ(x - r) / sqrt(Σ var). `None` if both images are the same there and
/// without noise.
fn score(
    image: &Frame,
    reference: &Frame,
    variances: (&[[f32; 3]], &[[f32; 3]]),
    pixels: &[usize],
    c: usize,
) -> Option<f64> {
    let sum = |term: &dyn Fn(usize) -> f64| pixels.iter().map(|&i| term(i)).sum::<f64>();
    let value = |frame: &Frame, i: usize| f64::from(frame.rgb[i][c]);
    let difference = sum(&|i| value(image, i) - value(reference, i));
    let variance = sum(&|i| f64::from(variances.0[i][c]) + f64::from(variances.1[i][c]));
    // Rounding goes the same way in pixels of the same value, so it is summed before it is squared.
    let rounding = ROUNDING * sum(&|i| value(image, i).abs().max(value(reference, i).abs()));
    (difference != 0.0 || variance > 0.0).then(|| difference / variance.sqrt().hypot(rounding))
}

fn summary(scores: &[f64]) -> BlockScores {
    let average = |f: &dyn Fn(f64) -> f64| {
        scores.iter().map(|&z| f(z)).sum::<f64>() / scores.len().max(1) as f64
    };
    BlockScores {
        count: scores.len(),
        share_beyond_3: average(&|z| f64::from(u8::from(z.abs() > LIMIT))),
        mean: average(&|z| z),
        rms: average(&|z| z * z).sqrt(),
        largest: scores
            .iter()
            .fold(0.0, |largest: f64, z| largest.max(z.abs())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(width: usize, height: usize, value: f32, variance: Option<f32>) -> Frame {
        let count = width * height;
        Frame {
            width,
            height,
            rgb: vec![[value; 3]; count],
            variance: variance.map(|v| vec![[v; 3]; count]),
            emission: None,
        }
    }

    #[test]
    fn blocks_at_the_edges_are_smaller() {
        // 8x8, 2x8, 8x1, 2x1 pixels; z = n d / sqrt(n (v + v)) = d sqrt(n / 2v).
        let reference = frame(10, 9, 1.0, Some(0.5));
        let image = frame(10, 9, 1.5, Some(0.5));
        let scores = block_scores(&image, &reference, &[true; 90]).unwrap();
        assert_eq!(scores.count, 12);
        let expected = [64.0_f64, 16.0, 8.0, 2.0].map(|n| 0.5 * n.sqrt());
        assert!((scores.mean - expected.iter().sum::<f64>() / 4.0).abs() < 1e-9);
        assert!((scores.largest - 4.0).abs() < 1e-9);
        assert_eq!(scores.share_beyond_3, 0.25);
    }

    #[test]
    fn no_variance_no_scores() {
        let reference = frame(8, 8, 1.0, None);
        assert_eq!(
            block_scores(&reference, &frame(8, 8, 1.0, Some(1.0)), &[true; 64]),
            None
        );
    }

    #[test]
    fn blocks_without_noise() {
        let reference = frame(8, 8, 1.0, Some(0.0));
        let same = block_scores(&reference, &reference, &[true; 64]).unwrap();
        assert_eq!((same.count, same.share_beyond_3), (0, 0.0));
        let other = frame(8, 8, 2.0, Some(0.0));
        let scores = block_scores(&other, &reference, &[true; 64]).unwrap();
        assert_eq!((scores.count, scores.share_beyond_3), (3, 1.0));
        let rounded = frame(8, 8, 1.0 + f32::EPSILON, Some(0.0));
        let scores = block_scores(&rounded, &reference, &[true; 64]).unwrap();
        assert!(scores.largest < 0.2, "a difference of one bit: {scores:?}");
    }
}
