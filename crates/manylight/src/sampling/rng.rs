//! A small keyed generator: each path has a key, from which its numbers can be generated again.

/// Mixes a 64-bit word: every input bit affects every output bit.
///
/// Source: the finaliser of SplitMix64, Steele et al., OOPSLA 2014.
#[inline]
pub const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Hash of three numbers, for example a direction: every input bit affects every output bit.
#[inline]
pub fn key(numbers: [f32; 3]) -> u64 {
    let [x, y, z] = numbers.map(|x| u64::from(x.to_bits()));
    mix(x ^ mix(y ^ (z << 32)))
}

/// The leading 24 bits of a word as a number in [0, 1).
#[inline]
pub fn unit(word: u64) -> f32 {
    (word >> 40) as f32 * (1.0 / 16_777_216.0)
}

/// PCG-XSH-RR with a 64-bit state. Source: O'Neill, "PCG", 2014.
#[derive(Clone, Debug)]
pub struct Pcg {
    state: u64,
    increment: u64,
}

impl Pcg {
    /// The generator with this key. Different keys give independent sequences.
    pub fn new(key: u64) -> Self {
        let mut rng = Pcg {
            state: mix(key),
            increment: mix(key ^ 0x9e37_79b9_7f4a_7c15) | 1,
        };
        rng.next_u32();
        rng
    }

    /// 32 uniform bits.
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let bits = Pcg::bits(self.state);
        self.state = Pcg::advance(self.state, self.increment);
        bits
    }

    /// A uniform number in [0, 1).
    #[inline]
    pub fn next_f32(&mut self) -> f32 {
        let number = Pcg::number(self.state);
        self.state = Pcg::advance(self.state, self.increment);
        number
    }

    /// The state after `state`.
    #[inline(always)]
    pub(crate) fn advance(state: u64, increment: u64) -> u64 {
        state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(increment)
    }

    /// The uniform number in [0, 1) of a state.
    #[inline(always)]
    pub(crate) fn number(state: u64) -> f32 {
        // As a signed number, which vector instructions convert.
        (Pcg::bits(state) >> 8) as i32 as f32 * (1.0 / 16_777_216.0)
    }

    /// The uniform bits of a state.
    #[inline(always)]
    fn bits(state: u64) -> u32 {
        let shifted = (((state >> 18) ^ state) >> 27) as u32;
        shifted.rotate_right((state >> 59) as u32)
    }

    /// State and increment.
    #[inline(always)]
    pub(super) fn parts(&self) -> (u64, u64) {
        (self.state, self.increment)
    }

    /// The inverse of [`Pcg::parts`].
    #[inline(always)]
    pub(super) fn from_parts(state: u64, increment: u64) -> Self {
        Pcg { state, increment }
    }
}
