//! Where things are: shapes, the acceleration structure over them, and the points that rays find.

pub mod bvh;
pub mod mesh;
pub mod ray;
pub mod shape;
pub mod surface_point;
pub mod world;

pub use mesh::Mesh;
pub use ray::{Ray, Segment};
pub use shape::Shape;
pub use surface_point::{SurfacePoint, SurfaceRef};
pub use world::{AreaSample, Geometry, Hit, Instance, Primitive};
