//! The fuzz target `part`.
#![no_main]
manylight_fuzz_targets::program!(part);
