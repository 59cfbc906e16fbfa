//! The fuzz target `jpeg`.
#![no_main]
manylight_fuzz_targets::program!(jpeg);
