//! Integration tests of the core, in one binary.

mod adjoint;
mod agreement;
mod common;
mod determinism;
mod furnace;
mod hidden_emitters;
mod layers;
