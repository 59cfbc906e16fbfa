//! What the programs of the fuzz targets have in common.

pub use cap::Cap;
pub use libfuzzer_sys;
pub use manylight_fuzz as targets;

/// The program of the fuzz target `$name` of `manylight-fuzz`.
#[macro_export]
macro_rules! program {
    ($name:ident) => {
        #[global_allocator]
        static ALLOCATOR: $crate::Cap<std::alloc::System> =
            $crate::Cap::new(std::alloc::System, usize::MAX);

        $crate::libfuzzer_sys::fuzz_target!(
            init: $crate::targets::limited_allocator(&ALLOCATOR),
            |input: &[u8]| $crate::targets::$name(input)
        );
    };
}
