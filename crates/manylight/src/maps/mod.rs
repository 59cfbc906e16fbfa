//! Particles found by position.
