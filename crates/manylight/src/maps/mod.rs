//! Particles found by position: nearest neighbors, density estimates, and the compatibility test of
//! surfaces.

mod arriving;
pub mod compatible;
pub mod coverage;
pub mod density;
pub mod incident;
pub mod kd_tree;

pub use arriving::{ArrivingPhotons, PhotonReceiver};
pub use compatible::Patch;
pub use coverage::{COVERAGE_PROBES, COVERAGE_PROBES_INDIRECT, covered_fraction};
pub use incident::{Incident, IncidentMap};
pub use kd_tree::{KdTree, Located, Neighbors};
