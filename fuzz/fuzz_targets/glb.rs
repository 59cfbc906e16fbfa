//! The fuzz target `glb`.
#![no_main]
manylight_fuzz_targets::program!(glb);
