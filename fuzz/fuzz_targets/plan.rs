//! The fuzz target `plan`.
#![no_main]
manylight_fuzz_targets::program!(plan);
