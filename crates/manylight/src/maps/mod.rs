//! Particles found by position: nearest neighbors, densities, and which particles belong together.

pub mod compatible;
pub mod coverage;
pub mod density;
pub mod incident;
pub mod kd_tree;
pub mod kernel;

pub use compatible::Patch;
pub use coverage::{FEW_PROBES, PROBES, covered};
pub use incident::{INCIDENT_NEIGHBORS, Incident, IncidentGuide, IncidentMap};
pub use kd_tree::{KdTree, Located, Neighbors};
pub use kernel::DensityKernel;
