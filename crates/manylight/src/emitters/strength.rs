//! How emitters and their parts are compared when one is chosen.

use crate::color::Rgb;

/// Positive for every color that is not black.
pub(super) trait Strength {
    fn strength(self) -> f32;
}

impl Strength for Rgb {
    fn strength(self) -> f32 {
        // Luminance alone would make blue light rare and its samples bright.
        0.5 * (self.luminance() + self.max_channel()).max(0.0)
    }
}
