//! The fuzz target `pbrt`.
#![no_main]
manylight_fuzz_targets::program!(pbrt);
