//! Size, crop window and filter of a film.

use super::Filter;
use crate::math::UVec2;

/// Size, crop window and reconstruction filter of a film, as a scene file gives them.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmDesc {
    /// Full size in pixels.
    pub size: UVec2,
    /// Upper left corner of the crop window, in pixels.
    pub crop_offset: UVec2,
    /// Size of the crop window, in pixels; `crop_offset + crop_size <= size`. Only this window is
    /// rendered.
    pub crop_size: UVec2,
    /// Reconstruction filter.
    pub filter: Filter,
}

impl FilmDesc {
    /// The same film with `size` pixels, without a crop.
    pub fn with_size(&self, size: UVec2) -> Self {
        FilmDesc {
            size,
            crop_offset: UVec2::ZERO,
            crop_size: size,
            ..self.clone()
        }
    }
}
