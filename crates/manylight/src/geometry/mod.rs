//! Where things are: shapes, the acceleration structure over them, and the points that rays find.

mod analytic;
mod block;
mod bvh;
pub mod mesh;
mod occluder;
mod placement;
pub mod ray;
pub mod shape;
pub mod surface_point;
mod surface_set;
#[cfg(test)]
mod tests;
mod unit_rows;
pub mod world;

pub use crate::simd::Instructions;
pub use block::BLOCK;
use bvh::Shaft;
pub use mesh::Mesh;
pub use occluder::Occluder;
pub use ray::{Ray, Segment};
pub use shape::Shape;
pub use surface_point::{SurfacePoint, SurfaceRef};
pub use world::{AreaSample, Geometry, Hit, Instance, Primitive};
