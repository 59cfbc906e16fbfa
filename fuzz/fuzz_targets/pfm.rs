//! The fuzz target `pfm`.
#![no_main]
manylight_fuzz_targets::program!(pfm);
