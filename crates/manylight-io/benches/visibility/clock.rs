//! Time that this thread spent on a core, so that other work on the machine disturbs little.
#![allow(unsafe_code, reason = "the standard library has no clock of this kind")]

/// In seconds, from some start.
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
    const THREAD: std::ffi::c_int = 3;
    let mut time = Time {
        seconds: 0,
        nanoseconds: 0,
    };
    // SAFETY: the declaration is that of the C library, and the structure outlives the call.
    unsafe { clock_gettime(THREAD, &mut time) };
    time.seconds as f64 + 1e-9 * time.nanoseconds as f64
}

/// In seconds, from the first call on.
#[cfg(not(all(target_os = "linux", target_pointer_width = "64")))]
pub(crate) fn thread_seconds() -> f64 {
    static START: std::sync::LazyLock<std::time::Instant> =
        std::sync::LazyLock::new(std::time::Instant::now);
    START.elapsed().as_secs_f64()
}
