//! Mesh builders: solids, surfaces of revolution, sweeps along curves, patches. Lengths are in
//! meters, angles in degrees.

mod curve;
mod patch;
mod revolve;
mod solid;
mod sweep;

#[cfg(test)]
mod tests;

pub use curve::{arc, catmull_rom, smooth_table};
pub use patch::{Edges, grid, loft, polygon_triangles};
pub use revolve::{ball, bevelled_cylinder, cylinder, lathe, torus};
pub use solid::{bevelled_box, boxed, superellipsoid};
pub use sweep::{extrude, moulding, tube};
