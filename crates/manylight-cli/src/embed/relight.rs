//! Light groups of pictures in memory, weighed anew.

use crate::failure::Failure;
use crate::relight::{RelitContent, relight};
use crate::values::GroupWeight;
use manylight_io::image::LayeredImage;
use std::path::Path;

/// The picture with these factors on the light of groups, by name, as `manylight relight` makes it.
///
/// # Errors
/// The picture has no light groups, or none of a name; or a factor is negative or not finite.
pub fn relit(image: &LayeredImage, groups: &[(String, [f32; 3])]) -> Result<LayeredImage, Failure> {
    let is_factor = |factor: &f32| factor.is_finite() && *factor >= 0.0;
    if let Some((name, factors)) = (groups.iter()).find(|(_, f)| !f.iter().all(is_factor)) {
        return Err(Failure::usage(
            format!("the group `{name}` has the factors {factors:?}"),
            "expected numbers of at least 0",
        ));
    }
    let weights = groups.iter().map(|(name, factors)| GroupWeight {
        name: name.clone(),
        factors: *factors,
    });
    relight(
        Path::new("the picture"),
        image,
        &weights.collect::<Vec<_>>(),
        RelitContent::Layers,
    )
}
