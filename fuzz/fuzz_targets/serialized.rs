//! The fuzz target `serialized`.
#![no_main]
manylight_fuzz_targets::program!(serialized);
