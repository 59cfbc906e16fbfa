//! Shapes, instances and the acceleration structures over them; intersection, visibility, surface
//! points and sampling by area.

mod analytic;
mod block;
mod bvh;
mod level;
pub mod mesh;
mod occluder;
mod placement;
mod queries;
pub mod ray;
pub mod shape;
pub mod surface_point;
mod surface_points;
mod surface_set;
#[cfg(test)]
mod tests;
mod unit_rows;
pub mod world;

pub use crate::simd::Instructions;
pub use mesh::Mesh;
pub use occluder::Occluder;
pub use ray::{BLOCK, Ray, Segment};
pub use shape::{Instance, Primitive, Shape};
pub use surface_point::{Hit, SurfacePoint, SurfaceRef};
pub use surface_points::{Derivatives, SurfacePoints};
pub use world::{AreaSample, Geometry};
