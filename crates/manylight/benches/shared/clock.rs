//! Processor time of the calling thread, in seconds: other load on the machine hardly changes it.
#![allow(unsafe_code, reason = "the standard library has no per-thread clock")]

/// Processor time of this thread in seconds, from an arbitrary origin.
#[cfg(all(target_os = "linux", target_pointer_width = "64"))]
pub(crate) fn thread_seconds() -> f64 {
    #[repr(C)]
    struct Time {
        seconds: i64,
        nanoseconds: i64,
    }
    unsafe extern "C" {
        fn clock_gettime(clock: std::ffi::c_int, time: *mut Time) -> std::ffi::c_int;
    }
    /// `CLOCK_THREAD_CPUTIME_ID` of Linux.
    const THREAD_CLOCK: std::ffi::c_int = 3;
    let mut time = Time {
        seconds: 0,
        nanoseconds: 0,
    };
    // SAFETY: the declaration matches the C library on 64-bit Linux, and `time` outlives the call.
    unsafe { clock_gettime(THREAD_CLOCK, &mut time) };
    time.seconds as f64 + 1e-9 * time.nanoseconds as f64
}

/// Wall-clock time in seconds since the first call; the fallback where no per-thread clock is
/// declared.
#[cfg(not(all(target_os = "linux", target_pointer_width = "64")))]
pub(crate) fn thread_seconds() -> f64 {
    static START: std::sync::LazyLock<std::time::Instant> =
        std::sync::LazyLock::new(std::time::Instant::now);
    START.elapsed().as_secs_f64()
}
