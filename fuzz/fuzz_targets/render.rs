//! The fuzz target `render`.
#![no_main]
manylight_fuzz_targets::program!(render);
