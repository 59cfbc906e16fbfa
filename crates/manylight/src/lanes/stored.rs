//! Sixteen lanes in memory, which are written and read one by one.

use super::numbers::Mask;
use super::vector::{Axes, Color, Pair, Vector};
use crate::simd::{One, Width};
use std::ops::{Deref, DerefMut};

/// A structure of [`Stored`] numbers at the start of a cache line, so that vectors are loaded from
/// one line each.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct CacheAligned<T>(pub(crate) T);

impl<T> Deref for CacheAligned<T> {
    type Target = T;

    #[inline(always)]
    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T> DerefMut for CacheAligned<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut T {
        &mut self.0
    }
}

impl Mask<One> {
    /// The value in all lanes of `s`.
    #[inline(always)]
    pub(crate) fn in_lanes<S: Width>(&self, s: S) -> Mask<S> {
        Mask::splat(s, self.any())
    }
}

/// A structure of numbers in lanes from a single one, which all lanes get: `in_lanes`. Fields after
/// a semicolon are common to the lanes.
macro_rules! in_lanes {
    ($name:ident $(<$life:lifetime>)? { $($field:ident),* $(,)? $(; $($common:ident),* $(,)?)? }) => {
        impl $(<$life>)? $name<$($life,)? $crate::lanes::One> {
            #[inline(always)]
            pub(crate) fn in_lanes<S: $crate::lanes::Width>(&self, s: S) -> $name<$($life,)? S> {
                $name { $($field: self.$field.in_lanes(s),)* $($($common: self.$common,)*)? }
            }
        }
    };
}

pub(crate) use in_lanes;

/// Conversions of a structure of numbers in lanes, by fields: [`in_lanes`]; `set_lane` and `lane`
/// write and read one lane of a [`Stored`] one, and `in_vectors` loads it into vectors.
macro_rules! lanewise {
    ($name:ident $(<$life:lifetime>)? { $($field:ident),* $(,)? $(; $($common:ident),*)? }) => {
        $crate::lanes::in_lanes!(
            $name $(<$life>)? { $($field),* $(; $($common),*)? }
        );

        #[allow(dead_code, reason = "not all structures need all conversions")]
        impl $(<$life>)? $name<$($life,)? $crate::lanes::Stored> {
            #[inline(always)]
            pub(crate) fn set_lane(
                &mut self,
                i: usize,
                single: $name<$($life,)? $crate::lanes::One>,
            ) {
                $(self.$field.set_lane(i, single.$field);)*
            }

            #[inline(always)]
            pub(crate) fn lane(&self, i: usize) -> $name<$($life,)? $crate::lanes::One> {
                $name { $($field: self.$field.lane(i),)* $($($common: self.$common,)*)? }
            }

            #[inline(always)]
            pub(crate) fn in_vectors<S: $crate::lanes::Sixteen>(
                &self,
                s: S,
            ) -> $name<$($life,)? S> {
                $name { $($field: self.$field.in_vectors(s),)* $($($common: self.$common,)*)? }
            }
        }
    };
}

pub(crate) use lanewise;

lanewise!(Pair { x, y });
lanewise!(Vector { x, y, z });
lanewise!(Color { r, g, b });
lanewise!(Axes { s, t, n });
