//! Analytic scenes and statistics for tests.

pub mod scenes;
pub mod statistics;
