//! The fuzz target `png`.
#![no_main]
manylight_fuzz_targets::program!(png);
