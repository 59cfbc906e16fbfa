//! All instruction sets against the portable one.
#![expect(unsafe_code, reason = "reads the output of `compress_ordered`")]

use super::*;
use crate::sampling::rng::Pcg;
use std::mem::MaybeUninit;

#[test]
fn set_bits_are_found_in_order() {
    let found = |bits: u64| set_bits(bits).collect::<Vec<_>>();
    assert!(found(0).is_empty());
    assert_eq!(found(1 | 1 << 5 | 1 << 63), [0, 5, 63]);
    assert_eq!(found(u64::MAX).len(), 64);
}

/// Operands of the tested operations.
struct Operands<const N: usize> {
    a: [f32; N],
    b: [f32; N],
    bits: u32,
}

impl<const N: usize> Operands<N> {
    /// Multiples of a third, often equal, and one infinity.
    fn new(rng: &mut Pcg, bits: u32) -> Self {
        let mut number = || (8.0 * rng.next_f32()).round() / 3.0 - 1.0;
        let mut a: [f32; N] = std::array::from_fn(|_| number());
        let b = std::array::from_fn(|_| number());
        a[bits as usize % N] = f32::INFINITY;
        Operands { a, b, bits }
    }

    /// Results of all operations that agree between instruction sets, as bits.
    #[inline(always)]
    fn results<V>(&self, v: V) -> Vec<u32>
    where
        V: Width<Each<f32> = [f32; N], Each<u32> = [u32; N]>,
    {
        let (a, b) = (v.load(&self.a), v.load(&self.b));
        let mut results: Vec<u32> = [
            v.add(a, b),
            v.sub(a, b),
            v.mul(a, b),
            v.div(b, a),
            v.min(a, b),
            v.max(a, b),
            v.abs(b),
            v.sqrt(v.abs(b)),
            v.select(v.mask(self.bits), a, b),
            v.mul_sign(a, b),
            v.copy_sign(a, v.sub(b, a)),
            v.floats_of_bits(v.float_bits(a)),
            v.splat(self.a[3]),
        ]
        .into_iter()
        .flat_map(|x| v.store(x).map(f32::to_bits))
        .collect();
        results.extend(self.words(v));
        results.extend(self.quads(v));
        results.push(v.lowest(self.bits | 1 << (N - 1), b));
        let (le, lt) = (v.le(a, b), v.lt(a, b));
        results.extend([
            v.bits(le),
            v.bits(lt),
            v.bits(v.and(le, v.le(b, a))),
            v.bits(v.or(lt, v.lt(b, a))),
            v.bits(v.not(le)),
            v.bits(v.equal_words(v.float_bits(a), v.float_bits(b))),
            v.bits(v.mask(self.bits)),
        ]);
        let count = (self.bits & (u32::MAX >> (32 - N))).count_ones() as usize;
        results.extend(&v.compress(self.bits, a).map(f32::to_bits)[..count]);
        let words = v.load_words(&std::array::from_fn(|i| 10 + i as u32));
        results.extend(&v.compress_words(self.bits, words)[..count]);
        results
    }

    /// Results of arithmetic with words.
    #[inline(always)]
    fn words<V>(&self, v: V) -> Vec<u32>
    where
        V: Width<Each<f32> = [f32; N], Each<u32> = [u32; N]>,
    {
        let (a, b) = (
            v.load_words(&self.a.map(f32::to_bits)),
            v.float_bits(v.load(&self.b)),
        );
        let results = [
            v.add_words(a, b),
            v.sub_words(a, b),
            v.mul_words(a, b),
            v.and_words(a, b),
            v.xor_words(a, b),
            v.reverse_bits(a),
            v.shift_left(a, self.bits % 32),
            v.shift_right(a, self.bits % 32),
            v.select_words(v.mask(self.bits), a, b),
            v.splat_word(self.bits),
        ];
        results.into_iter().flat_map(|x| v.store_words(x)).collect()
    }

    /// Rows of two quads, transposed.
    #[inline(always)]
    fn quads<V>(&self, v: V) -> Vec<u32>
    where
        V: Width<Each<f32> = [f32; N], Each<u32> = [u32; N]>,
    {
        let quad = |i: usize| [self.a[i], self.b[i], self.a[i] - 1.0, self.b[i] * 2.0];
        let rows: [[f32; 4]; N] = std::array::from_fn(quad);
        let gathered = v.gather_quads(|i| [&rows[i], &rows[N - 1 - i]]);
        let vectors = gathered.into_iter().flatten();
        (vectors.flat_map(|x| v.store(x).map(f32::to_bits))).collect()
    }
}

struct AllNarrow<'a>(&'a Operands<NARROW>);

impl SimdKernel for AllNarrow<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Vec<u32> {
        let mut results = self.0.results(s);
        // An arbitrary order.
        let order = self.0.bits.wrapping_mul(0x9e37_79b9);
        let words = std::array::from_fn(|i| 10 + i as u32);
        let span = (s.load(&self.0.a), s.load(&self.0.b));
        let mut kept = [MaybeUninit::new(0); NARROW];
        let mut near = [MaybeUninit::new(0.0); NARROW];
        let places = s.compress_ordered(order, &words, span, &mut kept, &mut near);
        results.push(places);
        let count = places.count_ones() as usize;
        for (kept, near) in kept.into_iter().zip(near).take(count) {
            // SAFETY: both arrays were initialized.
            let (kept, near): (u32, f32) = unsafe { (kept.assume_init(), near.assume_init()) };
            results.extend([kept, near.to_bits()]);
        }
        results
    }
}

struct AllWide<'a>(&'a Operands<LANES>);

impl SimdKernel for AllWide<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Vec<u32> {
        self.0.results(s.wide())
    }
}

fn isas() -> impl Iterator<Item = Isa> {
    Instructions::available().into_iter().filter_map(Isa::new)
}

#[test]
fn instruction_sets_agree_to_the_bit() {
    let mut rng = Pcg::new(1);
    for bits in 0..1 << NARROW {
        let operands = Operands::new(&mut rng, bits);
        let run = |isa: Isa| isa.run(AllNarrow(&operands));
        for isa in isas() {
            assert_eq!(run(isa), run(Isa::Portable), "{isa:?}");
        }
    }
    for bits in (0..1 << LANES).step_by(7) {
        let operands = Operands::new(&mut rng, bits);
        let run = |isa: Isa| isa.run(AllWide(&operands));
        for isa in isas() {
            assert_eq!(run(isa), run(Isa::Portable), "{isa:?}");
        }
    }
}

struct Fused;

impl SimdKernel for Fused {
    type Output = [[f32; LANES]; 2];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Self::Output {
        let w = s.wide();
        let a = w.load(&std::array::from_fn(|i| i as f32 - 7.0));
        let (b, c) = (w.splat(3.0), w.splat(5.0));
        [w.store(w.mul_add(a, b, c)), w.store(w.mul_sub(a, b, c))]
    }
}

/// Results are small integers, which are exact with one or two roundings.
#[test]
fn fused_operations_are_products_and_sums() {
    for isa in isas() {
        let [sum, difference] = isa.run(Fused);
        for i in 0..LANES {
            let product = 3.0 * (i as f32 - 7.0);
            assert_eq!((sum[i], difference[i]), (product + 5.0, product - 5.0));
        }
    }
}

#[test]
fn only_known_instructions_are_selected() {
    let selected = Isa::best().name();
    assert_eq!(select_instruction_set(selected), Ok(()));
    let unknown = select_instruction_set("mmx").unwrap_err();
    assert!(
        unknown.contains("'mmx'") && unknown.contains("portable"),
        "{unknown}"
    );
    if selected != "portable" {
        let late = select_instruction_set("portable").unwrap_err();
        assert!(late.contains(selected), "{late}");
    }
}
