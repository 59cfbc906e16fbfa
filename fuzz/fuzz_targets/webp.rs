//! The fuzz target `webp`.
#![no_main]
manylight_fuzz_targets::program!(webp);
