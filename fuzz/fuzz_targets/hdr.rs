//! The fuzz target `hdr`.
#![no_main]
manylight_fuzz_targets::program!(hdr);
