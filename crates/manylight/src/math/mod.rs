//! Vectors (from `glam`), boxes, frames, cones, octahedral maps, a space-filling curve and small
//! numeric helpers.

pub mod aabb;
pub mod bits;
pub mod cone;
pub mod float;
pub mod frame;
pub(crate) mod hilbert;
pub mod octahedral;
pub mod prefetch;

pub use aabb::Aabb;
pub use cone::{Cone, Spread};
pub use frame::Frame;
pub use glam::{Affine3A, Mat3, Mat4, UVec2, Vec2, Vec3, Vec3A, Vec4};
