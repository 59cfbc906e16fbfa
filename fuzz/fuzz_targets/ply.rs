//! The fuzz target `ply`.
#![no_main]
manylight_fuzz_targets::program!(ply);
