//! Absorbing media inside of closed surfaces.

use super::desc::MediumDesc;
use crate::color::Rgb;
use crate::ids::MaterialId;

/// The media of a scene, by the materials of the surfaces around them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Media {
    /// Absorption coefficients in 1/m; shorter than the list of materials, and empty without media.
    absorption: Vec<Option<Rgb>>,
}

impl Media {
    pub(super) fn new(media: &[MediumDesc]) -> Self {
        let mut absorption = Vec::new();
        for medium in media {
            let index = medium.material.index();
            if absorption.len() <= index {
                absorption.resize(index + 1, None);
            }
            absorption[index] = Some(medium.absorption);
        }
        Media { absorption }
    }

    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.absorption.is_empty()
    }

    /// The absorption coefficient inside of surfaces of this material, in 1/m; `None` if there is
    /// no medium.
    #[inline]
    pub(crate) fn absorption(&self, material: MaterialId) -> Option<Rgb> {
        self.absorption.get(material.index()).copied().flatten()
    }
}
