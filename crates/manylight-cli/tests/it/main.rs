//! Tests of the program from outside: output, exit codes and files.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on shall fail")]

mod auto;
mod browser;
mod compare;
mod denoise;
mod describe;
mod error_bars;
#[cfg(unix)]
mod faults;
mod frames;
#[cfg(unix)]
mod interrupt;
mod kept_lights;
mod light_groups;
mod links;
mod maps;
mod parts;
mod pictures;
mod preview;
mod problems;
mod quoted_figures;
mod render;
mod study;
mod support;
