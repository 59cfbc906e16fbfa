//! The order of virtual lights: a Hilbert curve through the scene, interrupted so that opposite
//! facing surfaces are apart.
//!
//! Consecutive lights stand close together and face the same way. Systematic selection in this
//! order spreads sites evenly over each surface, and a batch of consecutive lights is compact and
//! is visible or culled as a whole.

use crate::ids::LightGroup;
use crate::math::hilbert::{BITS, HilbertCurve};
use crate::math::{Aabb, Vec3};
use crate::particles::Photon;
use rayon::prelude::*;

/// Bits per axis that precede the facing in a key. More bits mix fewer facings within a batch of
/// some dozens of lights, fewer bits let a batch extend over less of the scene. At 1 and 3 (2
/// passes of 128 lights at 72x40, 2 seeds; Kitchen, Glossy Room): relMSE +6.5 and -2.4 % (standard
/// error 6 %).
const COARSE_BITS: u32 = 2;

/// A Hilbert curve that facings interrupt.
#[derive(Clone, Copy, Debug)]
pub struct Curve(HilbertCurve);

impl Curve {
    /// The curve through the bounding box of all photons.
    pub fn around(photons: &[Photon]) -> Self {
        let bounds = photons
            .par_iter()
            .fold(|| Aabb::EMPTY, |b, photon| b.include(photon.p))
            .reduce(|| Aabb::EMPTY, Aabb::union);
        Curve(HilbertCurve::through(bounds))
    }

    /// Sort key of the position `p` on a surface with unit normal `n`: the coarse part of the
    /// Hilbert index, then one of six facings, then the rest of the index. Positions outside of the
    /// box are moved onto its boundary.
    pub fn key(&self, p: Vec3, n: Vec3) -> u64 {
        let h = self.0.index(p);
        let fine = 3 * (BITS - COARSE_BITS);
        (h >> fine) << (fine + 3) | facing(n) << fine | h & ((1 << fine) - 1)
    }

    /// Sort key of a photon: light groups follow each other.
    pub fn photon_key(&self, photon: &Photon) -> (LightGroup, u64) {
        (photon.group, self.key(photon.p, photon.n))
    }

    /// The photons in the order of the curve, so that neighbors in space are neighbors in memory.
    pub fn sorted(&self, photons: &[Photon]) -> Vec<Photon> {
        let mut keyed: Vec<((LightGroup, u64), u32)> = photons
            .par_iter()
            .enumerate()
            .map(|(i, photon)| (self.photon_key(photon), i as u32))
            .collect();
        keyed.par_sort_unstable();
        let sorted = keyed.into_par_iter().map(|(_, i)| photons[i as usize]);
        sorted.collect()
    }
}

/// Index, 0 to 5, of the axis direction nearest to `n`.
fn facing(n: Vec3) -> u64 {
    let axis = n.abs().max_position();
    2 * axis as u64 + u64::from(n[axis] < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_sides_of_a_wall_are_apart() {
        let curve = Curve(HilbertCurve::through(Aabb {
            min: Vec3::ZERO,
            max: Vec3::ONE,
        }));
        let p = Vec3::new(0.3, 0.4, 0.5);
        let (front, back) = (curve.key(p, Vec3::X), curve.key(p, -Vec3::X));
        assert!(front.abs_diff(back) >= 1 << (3 * (BITS - COARSE_BITS)));
        assert_eq!(front, curve.key(p, Vec3::new(0.9, 0.3, 0.1)));
    }
}
