//! Instruction sets, chosen at run time, and their vectors.
//!
//! Code over a [`Width`] is written once for any number of lanes. Kernels are compiled for each
//! instruction set, and the selected version is called: a [`SimdKernel`] by [`Isa::run`], a
//! [`LaneKernel`] by [`Isa::run_lanes`]. They may also ignore the vectors and consist of plain
//! loops, which the compiler then vectorizes.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod compiled;
mod portable;
#[cfg(test)]
mod tests;
mod width;

pub use portable::One;
pub use width::{LANES, Width};
pub(crate) use width::{LaneKernel, NARROW, Outlined, Simd, SimdKernel, Sixteen, array, set_bits};

pub(crate) use portable::Portable;
use std::sync::OnceLock;

/// The instruction set of this process. The first use selects the best, unless
/// [`select_instruction_set`] has selected another.
static SELECTED: OnceLock<Isa> = OnceLock::new();

/// Selects the instruction set of this process by its name: `avx512`, `avx2` or `portable`. Renders
/// by one instruction set have equal bits on all machines that have it. Call it before the first
/// scene is built.
///
/// # Errors
/// What was found and expected: the machine lacks these instructions, or the process uses others
/// already.
pub fn select_instruction_set(name: &str) -> Result<(), String> {
    let available: Vec<Isa> = Instructions::available()
        .into_iter()
        .filter_map(Isa::new)
        .collect();
    let Some(&isa) = available.iter().find(|isa| isa.name() == name) else {
        let names: Vec<&str> = available.iter().map(|isa| isa.name()).collect();
        return Err(format!(
            "found '{name}', expected one of {}",
            names.join(", ")
        ));
    };
    let selected = SELECTED.get_or_init(|| isa).name();
    if selected != name {
        return Err(format!(
            "found '{name}', but this process uses {selected} already"
        ));
    }
    Ok(())
}

/// The instruction set that renders use in this process, such as `x86_64 avx512`. Another one may
/// round otherwise.
pub fn instruction_set() -> String {
    format!("{} {}", std::env::consts::ARCH, Isa::best().name())
}

/// Declares functions that are [`Outlined`], with the value `$value`, for the instruction set of
/// `$s`.
macro_rules! outlined {
    ($(
        $(#[$attribute:meta])*
        $visible:vis fn $name:ident<$($generic:ident: $bound:path),*>($($arg:ident: $ty:ty),* $(,)?)
            -> $out:ty { $s:expr => $value:expr }
    )*) => {$(
        $(#[$attribute])*
        #[inline(always)]
        $visible fn $name<$($generic: $bound),*>($($arg: $ty),*) -> $out {
            struct Code<Arguments>(Arguments);
            impl<$($generic: $bound),*> $crate::simd::Outlined for Code<($($ty,)*)> {
                type Output = $out;

                #[inline(always)]
                fn run(self) -> $out {
                    let ($($arg,)*) = self.0;
                    $value
                }
            }
            $crate::simd::Width::outline($s, Code(($($arg,)*)))
        }
    )*};
}
pub(crate) use outlined;

/// Instruction sets for which kernels are compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// Instructions of every machine of the target.
    Portable,
    /// AVX2 and FMA.
    Avx2,
    /// AVX-512.
    Avx512,
}

impl Instructions {
    /// The instruction sets of this machine, the best first.
    pub fn available() -> Vec<Instructions> {
        let all = [
            Instructions::Avx512,
            Instructions::Avx2,
            Instructions::Portable,
        ];
        all.into_iter()
            .filter(|&set| Isa::new(set).is_some())
            .collect()
    }
}

/// A selected instruction set, with the proof that the machine has it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Isa {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(avx512::Avx512),
}

impl Isa {
    /// `None` if the machine lacks the instructions.
    pub(crate) fn new(instructions: Instructions) -> Option<Isa> {
        match instructions {
            Instructions::Portable => Some(Isa::Portable),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2 => avx2::Avx2::detect().map(Isa::Avx2),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 => avx512::Avx512::detect().map(Isa::Avx512),
            #[cfg(not(target_arch = "x86_64"))]
            Instructions::Avx2 | Instructions::Avx512 => None,
        }
    }

    /// The instruction set of this process: the best of this machine, unless another was selected.
    pub(crate) fn best() -> Isa {
        *SELECTED.get_or_init(|| {
            Isa::new(Instructions::Avx512)
                .or_else(|| Isa::new(Instructions::Avx2))
                .unwrap_or(Isa::Portable)
        })
    }

    fn name(self) -> &'static str {
        match self {
            Isa::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512(_) => "avx512",
        }
    }

    /// Runs a kernel in vectors.
    #[inline]
    pub(crate) fn run<K: SimdKernel>(self, kernel: K) -> K::Output {
        match self {
            Isa::Portable => portable::run(kernel),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2(avx2) => avx2.run(kernel),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512(avx512) => avx512.run(kernel),
        }
    }

    /// Runs a kernel with sixteen lanes, or with one in the portable instruction set.
    #[inline]
    pub(crate) fn run_lanes<K: LaneKernel>(self, kernel: K) -> K::Output {
        match self {
            Isa::Portable => portable::run_lanes(kernel),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2(avx2) => avx2.run_lanes(kernel),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512(avx512) => avx512.run_lanes(kernel),
        }
    }
}
