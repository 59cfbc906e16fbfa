//! Images as textures.

use crate::image::Image;
use crate::math::Mat3;

/// How texels are blended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filtering {
    /// The texel that holds the point.
    Nearest,
    /// The four texels around the point.
    Bilinear,
}

/// What lies outside [0, 1]².
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    Repeat,
    /// The image mirrored.
    Mirror,
    /// The nearest edge texel.
    Clamp,
}

/// An image over the uv square. Values are linear (decoded by the loader); the image's top row is at v = 1,
/// that is, loaders keep rows top to bottom and lookups use 1 - v.
#[derive(Clone, Debug)]
pub struct Bitmap {
    /// One or three channels, linear.
    pub image: Image,
    /// How texels are blended.
    pub filtering: Filtering,
    /// What lies outside.
    pub wrap: Wrap,
    /// Applied to (u, v, 1).
    pub uv_transform: Mat3,
}
