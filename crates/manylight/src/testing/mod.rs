//! Analytic scenes and statistics for tests.

pub mod chi_square;
pub mod scenes;
pub mod statistics;
