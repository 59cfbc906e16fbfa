//! The fuzz target `obj`.
#![no_main]
manylight_fuzz_targets::program!(obj);
