//! The fuzz target `gltf`.
#![no_main]
manylight_fuzz_targets::program!(gltf);
