//! The fuzz target `tga`.
#![no_main]
manylight_fuzz_targets::program!(tga);
