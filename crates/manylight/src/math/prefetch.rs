//! Prefetching of memory.
#![expect(unsafe_code, reason = "prefetching a cache line needs an intrinsic")]

/// Prefetches the memory of `x` into the cache. No effect on machines without the instruction.
#[inline]
pub fn prefetch<T>(x: &T) {
    prefetch_at(std::ptr::from_ref(x).cast(), size_of::<T>());
}

/// Prefetches `bytes` bytes from `start` on. Any address is allowed.
#[inline(always)]
pub fn prefetch_at(start: *const u8, bytes: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        /// Bytes of a cache line.
        const LINE: usize = 64;
        for offset in (0..bytes).step_by(LINE) {
            // SAFETY: all x86-64 machines have SSE; prefetching never changes memory and never
            // faults.
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
    fn prefetching_changes_no_values() {
        prefetch(&());
        prefetch(&7u8);
        let many = [3u64; 100];
        prefetch(&many);
        prefetch_at(std::ptr::null(), 100);
        assert_eq!(many, [3; 100]);
    }
}
