//! The fuzz target `spd`.
#![no_main]
manylight_fuzz_targets::program!(spd);
