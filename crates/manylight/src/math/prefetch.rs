//! Hints to the memory system.
#![expect(
    unsafe_code,
    reason = "the only way to ask for a cache line without waiting for it"
)]

/// Asks for the memory of `x`, if the machine can, so that a later look finds it near. Changes nothing else.
#[inline]
pub fn prefetch<T>(x: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        const LINE: usize = 64;
        let start = std::ptr::from_ref(x).cast::<i8>();
        for offset in (0..size_of::<T>()).step_by(LINE) {
            // SAFETY: all x86-64 has SSE, prefetching has no effect on memory and cannot fault, and the address lies within `x`.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(offset)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = x;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_any_size_are_left_alone() {
        prefetch(&());
        prefetch(&7u8);
        let many = [3u64; 100];
        prefetch(&many);
        assert_eq!(many, [3; 100]);
    }
}
