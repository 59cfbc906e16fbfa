//! Sixteen values side by side: code that does the same for sixteen points is written as loops over lanes, which the compiler
//! turns into vector instructions. Such a loop has no calls, no early exits and no conversions that saturate.

pub(crate) mod vectors;

use crate::color::Rgb;
use crate::math::Vec3;
use crate::math::float;
use crate::simd::{Wide, set_bits};
use vectors::{load3, store3};

/// Values side by side.
pub const LANES: usize = 16;

/// One value per lane.
pub type Lanes = [f32; LANES];

/// One bit per lane.
pub type LaneMask = u16;

/// The lanes for which `test` holds.
#[inline(always)]
pub fn mask(test: impl Fn(usize) -> bool) -> LaneMask {
    // Two loops, of which the compiler knows the second as a reduction.
    let mut bits = [0u32; LANES];
    for (i, bit) in bits.iter_mut().enumerate() {
        *bit = if test(i) { 1 << i } else { 0 };
    }
    bits.iter().fold(0, |all, bit| all | bit) as LaneMask
}

/// The set lanes of a mask, ascending.
#[inline(always)]
pub fn lanes_of(mask: LaneMask) -> impl Iterator<Item = usize> {
    set_bits(mask)
}

/// Lane 0 in all lanes.
#[inline(always)]
pub(crate) fn spread<T: Copy>(lanes: &mut [T; LANES]) {
    *lanes = [lanes[0]; LANES];
}

/// [`float::exp`] of each lane.
#[inline(always)]
pub(crate) fn exp<W: Wide>(w: W, x: W::F) -> W::F {
    let mut lanes = w.store(x);
    for x in &mut lanes {
        *x = float::exp(*x);
    }
    w.load(&lanes)
}

/// Three values per lane: a vector or a colour.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Lanes3(pub [Lanes; 3]);

impl Lanes3 {
    /// Zero in all lanes.
    pub const ZERO: Lanes3 = Lanes3([[0.0; LANES]; 3]);

    /// The vector of each lane.
    #[inline(always)]
    pub fn from_fn(value: impl Fn(usize) -> Vec3) -> Self {
        let mut all = Lanes3::ZERO;
        for i in 0..LANES {
            all.set(i, value(i));
        }
        all
    }

    /// The vector in lane `i`.
    #[inline(always)]
    pub fn vec(&self, i: usize) -> Vec3 {
        Vec3::new(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    /// The colour in lane `i`.
    #[inline(always)]
    pub fn rgb(&self, i: usize) -> Rgb {
        Rgb::new(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    /// All lanes in registers.
    #[inline(always)]
    pub(crate) fn load<W: Wide>(&self, w: W) -> [W::F; 3] {
        load3(w, &self.0)
    }

    /// All lanes from registers.
    #[inline(always)]
    pub(crate) fn store<W: Wide>(w: W, v: [W::F; 3]) -> Self {
        Lanes3(store3(w, v))
    }

    /// Lane 0 in all lanes.
    #[inline(always)]
    pub(crate) fn spread(&mut self) {
        self.0.iter_mut().for_each(spread);
    }

    /// Writes lane `i`.
    #[inline(always)]
    pub fn set(&mut self, i: usize, value: impl Into<[f32; 3]>) {
        let [x, y, z] = value.into();
        self.0[0][i] = x;
        self.0[1][i] = y;
        self.0[2][i] = z;
    }
}
