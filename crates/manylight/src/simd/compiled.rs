//! Kernels compiled for an instruction set.
//!
//! Their functions are methods of the kernels. The compiler keeps the code of a method with that of
//! the module of its type, and after a change compiles only the modules again that it concerns. As
//! generic functions of one module, all kernels are compiled after every change: `cargo build` after
//! one in `bsdf/models/plastic` then takes 102 to 117 s, with methods 46 to 84 s.

/// Declares methods of kernels for the instructions `$isa`, of which `$features` are the names, and
/// methods of `$isa` that call them. A value of `$isa` must prove that the machine has them.
macro_rules! compiled_for {
    ($isa:ident, $features:literal) => {
        /// A kernel in vectors.
        trait KernelCode: SimdKernel + Sized {
            /// # Safety
            /// The machine has the instructions.
            unsafe fn kernel(self, isa: $isa) -> Self::Output;
        }

        impl<K: SimdKernel> KernelCode for K {
            #[target_feature(enable = $features)]
            unsafe fn kernel(self, isa: $isa) -> K::Output {
                self.run(isa)
            }
        }

        /// A kernel in sixteen lanes.
        trait LaneCode: LaneKernel + Sized {
            /// # Safety
            /// The machine has the instructions.
            unsafe fn lanes(self, isa: $isa) -> Self::Output;
        }

        impl<K: LaneKernel> LaneCode for K {
            #[target_feature(enable = $features)]
            unsafe fn lanes(self, isa: $isa) -> K::Output {
                self.run(isa.wide())
            }
        }

        /// Code that several kernels call.
        trait SharedCode: Outlined + Sized {
            /// # Safety
            /// The machine has the instructions.
            unsafe fn shared(self) -> Self::Output;
        }

        impl<K: Outlined> SharedCode for K {
            #[target_feature(enable = $features)]
            #[inline(never)]
            unsafe fn shared(self) -> K::Output {
                self.run()
            }
        }

        impl $isa {
            /// Runs a kernel compiled for these instructions.
            #[inline]
            pub(super) fn run<K: SimdKernel>(self, kernel: K) -> K::Output {
                // SAFETY: `self` exists only where `detect` found all that the kernel enables.
                unsafe { kernel.kernel(self) }
            }

            /// Runs a kernel with sixteen lanes, compiled for these instructions.
            #[inline]
            pub(super) fn run_lanes<K: LaneKernel>(self, kernel: K) -> K::Output {
                // SAFETY: as in `run`.
                unsafe { kernel.lanes(self) }
            }
        }
    };
}
pub(super) use compiled_for;
