//! The scalar by which emitters and their elements are chosen.

use crate::color::Rgb;

/// A scalar in proportion to which a quantity with three channels is sampled.
pub(super) trait SelectionWeight {
    /// Positive for every color that is not black.
    fn selection_weight(self) -> f32;
}

impl SelectionWeight for Rgb {
    fn selection_weight(self) -> f32 {
        // The mean of luminance and largest channel: by luminance alone blue light would have few samples of large weight.
        0.5 * (self.luminance() + self.max_channel()).max(0.0)
    }
}
