//! Maps of the unit interval to itself.

use crate::lanes::{Float, One, split as split_each};

/// Whether `u` is below `p`, and a number that is uniform in [0, 1) given that answer.
#[inline]
pub(super) fn split(u: f32, p: f32) -> (bool, f32) {
    let (is_below, rest) = split_each(Float::splat(One, u), p);
    (is_below.any(), rest.get())
}
