//! Denoising of rendered films by Open Image Denoise, and of the frames of walkthroughs in time.
//!
//! The library is searched and loaded at run time ([`SearchPlaces`], [`Oidn`]), so that the
//! renderer neither links nor ships it. What is filtered, and where the noisy image is kept, is
//! decided in [`denoise_film`]. [`steady`] averages successive frames, and needs no library.
//!
//! # Layers
//!
//! A module imports only from layers with smaller numbers.
//!
//! ```text
//!  3 reconstruct
//!  2 features symmetries
//!  1 oidn
//!  0 api search blend outliers frames
//! ```

mod api;
mod blend;
mod features;
mod frames;
mod oidn;
mod outliers;
mod reconstruct;
mod search;
mod symmetries;
#[cfg(test)]
mod tests;

pub use features::{FEATURE_PASSES, FeatureImages, render_features};
pub use frames::{REACH, WalkFrame, steady};
pub use oidn::{Features, FilterError, Oidn, Unavailable, Version};
pub use reconstruct::{DenoisedImage, denoise_film, denoise_picture};
pub use search::{LIBRARY_NAME, SearchPlaces};
