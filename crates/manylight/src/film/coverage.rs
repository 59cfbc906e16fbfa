//! Coverage of pixels by the named parts of a scene, for mattes: sums of sample weights by id.

/// A division of the surfaces into parts with names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum IdLayer {
    /// Placed shapes, or instances.
    Object,
    /// Materials.
    Material,
}

/// A part of one sample of a pixel that a surface covers.
#[derive(Clone, Copy, Debug)]
pub(super) struct IdSample {
    /// Index of the pixel in its tile.
    pub(super) pixel: u32,
    /// Index among the recorded id layers.
    pub(super) layer: u32,
    pub(super) id: u32,
    /// Covered fraction of the sample.
    pub(super) weight: f32,
}

/// Sums of one pixel in one id layer: id and sum of weights, in the order of appearance.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct CoverageSums(Vec<(u32, f64)>);

impl CoverageSums {
    /// Sums over no sample.
    pub(super) const fn new() -> Self {
        CoverageSums(Vec::new())
    }

    /// Adds a weight to the sum of `id`.
    pub(super) fn add(&mut self, id: u32, weight: f64) {
        match self.0.iter_mut().find(|(other, _)| *other == id) {
            Some((_, sum)) => *sum += weight,
            None => self.0.push((id, weight)),
        }
    }

    /// Id and sum of weights, in the order of appearance.
    pub(super) fn iter(&self) -> std::slice::Iter<'_, (u32, f64)> {
        self.0.iter()
    }
}

/// Ids with the fraction of a pixel that each covers, the largest first. Fractions are positive and
/// their sum is at most 1, but for rounding.
pub type RankedIds = Vec<(u32, f32)>;

/// Estimate of the memory of one pixel in one id layer, in bytes: the list with two entries, and
/// the samples of a pass.
pub(super) const BYTES_PER_PIXEL: usize =
    size_of::<CoverageSums>() + 2 * size_of::<(u32, f64)>() + 2 * size_of::<IdSample>();

/// Adds samples of pixel `pixel` out of `samples`, which are sorted by pixel. `sums` has an entry
/// per recorded id layer.
pub(super) fn add_samples(samples: &[IdSample], pixel: usize, sums: &mut [CoverageSums]) {
    let pixel = pixel as u32;
    let first = samples.partition_point(|sample| sample.pixel < pixel);
    for sample in samples[first..].iter().take_while(|s| s.pixel == pixel) {
        sums[sample.layer as usize].add(sample.id, f64::from(sample.weight));
    }
}
