//! Sixteen floats at a time, with one implementation per instruction set.
//!
//! Kernels are generic over [`Lanes`] and written once; [`Isa::run`] compiles them for each instruction set and calls
//! the one that was chosen. The value of an implementing type is the proof that the machine has the instructions, so that
//! the operations are safe to call. Everything here and in the kernels is `inline(always)`, because only what is inlined
//! into the function with `target_feature` is compiled for it.
//!
//! No operation fuses or reorders arithmetic: every instruction set gives the same bits.

/// Lanes per vector.
pub(super) const WIDTH: usize = 16;

/// Operations on sixteen floats. A mask has bit `i` for lane `i`; comparisons with NaN are false.
pub(super) trait Lanes: Copy {
    /// Sixteen floats.
    type F: Copy;

    fn splat(self, x: f32) -> Self::F;
    fn load(self, x: &[f32; WIDTH]) -> Self::F;
    fn store(self, x: Self::F) -> [f32; WIDTH];
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// `b` where either is NaN.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    fn le(self, a: Self::F, b: Self::F) -> u32;
    /// The lanes of `mask` in rising order; what follows them is unspecified.
    fn compress(self, mask: u32, x: Self::F) -> [f32; WIDTH];
    /// The same for integers.
    fn compress_index(self, mask: u32, x: &[u32; WIDTH]) -> [u32; WIDTH];
    /// The first lane with the lowest value among those in `mask`, which has one at least.
    fn lowest(self, mask: u32, x: Self::F) -> u32;
}

/// Plain Rust on arrays, for the compiler to vectorize as far as the target allows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

#[inline(always)]
fn map2(a: [f32; WIDTH], b: [f32; WIDTH], f: impl Fn(f32, f32) -> f32) -> [f32; WIDTH] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

#[inline(always)]
fn compress<T: Copy>(mask: u32, x: &[T; WIDTH]) -> [T; WIDTH] {
    let mut out = *x;
    for (slot, i) in set_bits(mask).enumerate() {
        out[slot] = x[i];
    }
    out
}

impl Lanes for Portable {
    type F = [f32; WIDTH];

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F {
        [x; WIDTH]
    }
    #[inline(always)]
    fn load(self, x: &[f32; WIDTH]) -> Self::F {
        *x
    }
    #[inline(always)]
    fn store(self, x: Self::F) -> [f32; WIDTH] {
        x
    }
    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| a * b)
    }
    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn le(self, a: Self::F, b: Self::F) -> u32 {
        (0..WIDTH).fold(0, |mask, i| mask | u32::from(a[i] <= b[i]) << i)
    }
    #[inline(always)]
    fn compress(self, mask: u32, x: Self::F) -> [f32; WIDTH] {
        compress(mask, &x)
    }
    #[inline(always)]
    fn compress_index(self, mask: u32, x: &[u32; WIDTH]) -> [u32; WIDTH] {
        compress(mask, x)
    }
    #[inline(always)]
    fn lowest(self, mask: u32, x: Self::F) -> u32 {
        let first = mask.trailing_zeros() as usize;
        let lowest = set_bits(mask).fold(first, |best, i| if x[i] < x[best] { i } else { best });
        lowest as u32
    }
}

/// Positions of the set bits, lowest first.
#[inline(always)]
pub(super) fn set_bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros();
        mask &= mask.wrapping_sub(1);
        (bit < 32).then_some(bit as usize)
    })
}

/// Code that is compiled once per instruction set.
pub(super) trait Kernel {
    /// What it computes.
    type Output;
    /// The body; must be `inline(always)`, like all it calls with `lanes`.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// The instruction set to use.
#[derive(Clone, Copy, Debug)]
pub(super) enum Isa {
    /// No assumption.
    Portable,
    /// Eight lanes per register.
    #[cfg(target_arch = "x86_64")]
    Avx2(super::avx2::Avx2),
    /// Sixteen lanes per register.
    #[cfg(target_arch = "x86_64")]
    Avx512(super::avx512::Avx512),
}

impl Isa {
    /// All that this machine can run, the best first.
    pub(super) fn available() -> Vec<Isa> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            all.extend(super::avx512::Avx512::detect().map(Isa::Avx512));
            all.extend(super::avx2::Avx2::detect().map(Isa::Avx2));
        }
        all.push(Isa::Portable);
        all
    }

    /// The best that this machine can run.
    pub(super) fn best() -> Isa {
        Isa::available()[0]
    }

    /// Runs a kernel.
    #[inline]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Isa::Portable => kernel.run(Portable),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2(avx2) => avx2.run(kernel),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512(avx512) => avx512.run(kernel),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bits of everything that the operations give on one set of numbers.
    struct All<'a> {
        a: &'a [f32; WIDTH],
        b: &'a [f32; WIDTH],
        mask: u32,
    }

    impl Kernel for All<'_> {
        type Output = Vec<u32>;

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Vec<u32> {
            let (a, b) = (lanes.load(self.a), lanes.load(self.b));
            let mut bits: Vec<u32> = [
                lanes.add(a, b),
                lanes.sub(a, b),
                lanes.mul(a, b),
                lanes.max(a, b),
                lanes.splat(self.a[3]),
            ]
            .into_iter()
            .flat_map(|x| lanes.store(x).map(f32::to_bits))
            .collect();
            bits.push(lanes.le(a, b));
            let count = self.mask.count_ones() as usize;
            bits.extend(&lanes.compress(self.mask, a).map(f32::to_bits)[..count]);
            let index = std::array::from_fn(|i| i as u32);
            bits.extend(&lanes.compress_index(self.mask, &index)[..count]);
            bits.push(lanes.lowest(self.mask | 1 << 15, b));
            bits
        }
    }

    #[test]
    fn instruction_sets_agree_to_the_bit() {
        let mut rng = crate::sampling::rng::Pcg::new(1);
        for mask in (0..1 << WIDTH).step_by(7) {
            let mut number = || (8.0 * rng.next_f32()).round() / 3.0;
            let mut a: [f32; WIDTH] = std::array::from_fn(|_| number());
            let b = std::array::from_fn(|_| number());
            a[mask as usize % WIDTH] = f32::INFINITY;
            let run = |isa: Isa| isa.run(All { a: &a, b: &b, mask });
            for isa in Isa::available() {
                assert_eq!(run(isa), run(Isa::Portable), "{isa:?}");
            }
        }
    }
}
