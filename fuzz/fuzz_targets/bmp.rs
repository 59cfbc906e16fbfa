//! The fuzz target `bmp`.
#![no_main]
manylight_fuzz_targets::program!(bmp);
