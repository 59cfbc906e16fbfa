//! A space-filling curve: neighbors along it are neighbors in space.

use super::{Aabb, Vec3};

/// Bits per axis of a position: 4096 steps along the longest edge of a box.
pub(crate) const BITS: u32 = 12;

/// A Hilbert curve through a cube.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HilbertCurve {
    origin: Vec3,
    /// Steps per m.
    scale: f32,
}

impl HilbertCurve {
    /// The curve through the cube with the lower corner and the longest edge of `bounds`.
    pub(crate) fn through(bounds: Aabb) -> Self {
        let edge = bounds.extent().max_element().max(f32::MIN_POSITIVE);
        HilbertCurve {
            origin: bounds.min,
            scale: (1 << BITS) as f32 / edge,
        }
    }

    /// Index of the position `p`; positions outside of the cube are moved onto its boundary.
    #[inline]
    pub(crate) fn index(&self, p: Vec3) -> u64 {
        let last = ((1 << BITS) - 1) as f32;
        let q = ((p - self.origin) * self.scale).clamp(Vec3::ZERO, Vec3::splat(last));
        hilbert([q.x as u32, q.y as u32, q.z as u32])
    }
}

/// Index of the cell `x` along the three-dimensional Hilbert curve. Source: Skilling, "Programming
/// the Hilbert curve", AIP 707, 2004.
fn hilbert(mut x: [u32; 3]) -> u64 {
    // Undo the rotations and reflections, from the coarsest level to the finest.
    for level in (1..BITS).rev() {
        let (bit, below) = (1 << level, (1 << level) - 1);
        for i in 0..3 {
            if x[i] & bit != 0 {
                x[0] ^= below;
            } else {
                let swapped = (x[0] ^ x[i]) & below;
                x[0] ^= swapped;
                x[i] ^= swapped;
            }
        }
    }
    // Gray code.
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut flips = 0;
    for level in (1..BITS).rev() {
        if x[2] & (1 << level) != 0 {
            flips ^= (1 << level) - 1;
        }
    }
    let mut h = 0;
    for level in (0..BITS).rev() {
        for axis in x {
            h = h << 1 | u64::from((axis ^ flips) >> level & 1);
        }
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_visits_every_cell_and_steps_to_neighbors() {
        // The 16³ cells of one corner are one connected piece of the curve.
        let mut cells: Vec<(u64, [u32; 3])> = Vec::new();
        for i in 0..16u32.pow(3) {
            let cell = [i % 16, i / 16 % 16, i / 256];
            cells.push((hilbert(cell), cell));
        }
        cells.sort_unstable();
        for (a, b) in cells.iter().zip(&cells[1..]) {
            assert_eq!(b.0, a.0 + 1);
            let step: u32 = (0..3).map(|i| a.1[i].abs_diff(b.1[i])).sum();
            assert_eq!(step, 1, "{:?} to {:?}", a.1, b.1);
        }
    }
}
