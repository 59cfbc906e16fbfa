//! Textures, and material inputs that are constant or textured.

mod bitmap;
mod bounds;
mod description;
mod evaluate;
mod inputs;
#[cfg(test)]
mod lanes_tests;
mod noise;
mod point;
mod solid;
#[cfg(test)]
mod tests;

pub use bitmap::{Bitmap, Filtering, Wrap};
pub(crate) use bounds::TextureBounds;
pub use description::Texture;
pub use inputs::{ColorInput, FloatInput};
pub use point::{TexturePoint, VertexValues};
pub use solid::{Pattern, Projection, ProjectionKind, Solid};
