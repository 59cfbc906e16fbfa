//! The fuzz target `lights`.
#![no_main]
manylight_fuzz_targets::program!(lights);
