//! The command as a user meets it: what it says, how it ends, what it leaves behind.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on shall fail")]

mod browser;
mod compare;
mod describe;
#[cfg(unix)]
mod interrupt;
mod maps;
mod problems;
mod render;
mod study;
mod support;
