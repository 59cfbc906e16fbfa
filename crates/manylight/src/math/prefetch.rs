//! Hints to the memory system.
#![expect(
    unsafe_code,
    reason = "the only way to ask for a cache line without waiting for it"
)]

/// Asks for the memory of `x`, if the machine can, so that a later look finds it near. Changes nothing else.
#[inline]
pub fn prefetch<T>(x: &T) {
    prefetch_at(std::ptr::from_ref(x).cast(), size_of::<T>());
}

/// The same for `bytes` bytes from `start` on, which may be anywhere.
#[inline(always)]
pub fn prefetch_at(start: *const u8, bytes: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        const LINE: usize = 64;
        for offset in (0..bytes).step_by(LINE) {
            // SAFETY: all x86-64 has SSE, and prefetching has no effect on memory and cannot fault, whatever the address.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(offset).cast()) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (start, bytes);
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
        prefetch_at(std::ptr::null(), 100);
        assert_eq!(many, [3; 100]);
    }
}
