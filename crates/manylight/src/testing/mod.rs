//! Scenes with known solutions, statistical tests, and kernels for benchmarks.

pub mod chi_square;
pub mod scenes;
pub mod sixteen_receivers;
pub mod statistics;
