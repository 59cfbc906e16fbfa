//! The fuzz target `exr`.
#![no_main]
manylight_fuzz_targets::program!(exr);
