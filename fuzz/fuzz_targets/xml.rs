//! The fuzz target `xml`.
#![no_main]
manylight_fuzz_targets::program!(xml);
