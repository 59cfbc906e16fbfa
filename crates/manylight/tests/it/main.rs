//! Integration tests of the core, in one binary.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod absorption;
mod adjoint;
mod agreement;
mod bidirectional;
mod blocks;
mod common;
mod compensation;
mod coverage;
mod determinism;
mod emission_guiding;
mod frosted_glass;
mod furnace;
mod glossy_caustics;
mod hidden_emitters;
mod interim;
mod interleaving;
mod invisible_emitters;
mod kept_lights;
mod layers;
mod light_groups;
mod mixed;
mod photon_map;
mod source;
mod unsafe_code;
mod walkthrough;
