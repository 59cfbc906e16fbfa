//! Scenes with known solutions, and statistical tests.

pub mod chi_square;
pub mod scenes;
pub mod statistics;
