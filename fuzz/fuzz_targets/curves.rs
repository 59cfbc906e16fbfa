//! The fuzz target `curves`.
#![no_main]
manylight_fuzz_targets::program!(curves);
