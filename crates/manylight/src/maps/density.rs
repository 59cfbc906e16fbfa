//! Density estimates: importance from importons, reflected radiance from photons.
//!
//! The bandwidth is the distance of the K-th particle on any surface; only particles on the
//! receiver's side and surface are summed. So the search stays local where other surfaces have all
//! nearby particles, and the sum is unbiased.

use super::compatible::MIN_COS;
use super::{KdTree, Located, Neighbors};
use crate::math::Vec3;
use crate::particles::{Importon, Photon};
use std::f32::consts::FRAC_1_PI;

/// K, the number of neighbors in an estimate of importance. Its noise affects the variance of the
/// image, not its mean; fewer neighbors take less time. With importons of equal importance, the
/// relative standard deviation is `√(4/(3K))`, 20 %: 29 % with half as many, 14 % with twice as
/// many.
pub const IMPORTANCE_NEIGHBORS: usize = 32;

/// Largest distance from the position of an estimate at which it is reused, relative to its
/// bandwidth. At 0.1 and 0.4 (2 passes of 128 lights at 72x40, 6 seeds; Kitchen, Glossy Room,
/// U-Shape): relMSE -2.0 and +1.1 % (standard error 2 %).
const REUSE_RADIUS: f32 = 0.2;
/// Smallest cosine between the normals of an estimate and its reuse: 8°. At 4° and 16° (likewise, 6
/// and 18 seeds): relMSE -1.2 and -1.4 % (standard error 2 and 1.4 %).
const REUSE_MIN_COS: f32 = 0.99;
/// Smallest cosine between normals of importons on one surface: 60°. Wide enough for facets of one
/// smooth object, and it excludes the other side of a wall.
const IMPORTON_MIN_COS: f32 = 0.5;
/// Largest distance of importons from the tangent plane relative to the bandwidth: on a sphere,
/// normals differ by the 60° of [`IMPORTON_MIN_COS`] where this is sin 30°, a half.
const IMPORTON_SLAB: f32 = 0.5;
/// Largest distance of photons from the tangent plane relative to the bandwidth. On a sphere,
/// normals differ by the 25° that end a surface where this is sin 12.5°, 0.22. At 0.1 and 0.4 (2
/// passes of `photon-map` at 72x40, 3 seeds; Glossy Room, Kitchen): relMSE -1.7 and +4.6 %
/// (standard error 1 %), mean -0.3 and +0.5 %.
const PHOTON_SLAB: f32 = 0.2;

/// The Epanechnikov kernel `2 / (π r²) (1 - d²/r²)` on a surface, in 1/m², at the squared distance
/// `d2` within the squared radius `r2`; 0 for an empty disc. Unbiased for homogeneous particles,
/// both for a fixed radius and for the distance of the K-th neighbor.
#[inline]
pub fn epanechnikov(d2: f32, r2: f32) -> f32 {
    if r2 <= 0.0 {
        return 0.0;
    }
    2.0 * FRAC_1_PI / r2 * (1.0 - d2 / r2).max(0.0)
}

/// Incident importance per area at `p` on the side of the unit normal `n`, in 1/m²; never negative.
/// Estimated from the K nearest importons with importance `Ψ_i` at distance `d_i` (Simon et al.
/// 2015):
///
/// ```text
/// Ŵ(x) = 2/(π d_K²) Σ_i Ψ_i (1 − d_i²/d_K²)
/// ```
///
/// K is the size of `found`, usually [`IMPORTANCE_NEIGHBORS`].
pub fn importance_at(importons: &KdTree<Importon>, p: Vec3, n: Vec3, found: &mut Neighbors) -> f32 {
    importance_within(importons, (p, n), f32::INFINITY, found)
}

/// [`importance_at`] with a bandwidth of at most `max_radius` m.
pub fn importance_within(
    importons: &KdTree<Importon>,
    (p, n): (Vec3, Vec3),
    max_radius: f32,
    found: &mut Neighbors,
) -> f32 {
    importons.nearest(p, max_radius, found);
    let r2 = found.radius_squared();
    let mut sum = 0.0;
    for (i, d2) in found.iter() {
        let importon = &importons.items()[i as usize];
        let height = n.dot(importon.p - p);
        if n.dot(importon.n) >= IMPORTON_MIN_COS
            && height * height <= IMPORTON_SLAB * IMPORTON_SLAB * r2
        {
            sum += importon.importance * epanechnikov(d2, r2);
        }
    }
    sum.max(0.0)
}

/// [`importance_at`] for a sequence of nearby positions: the last estimate is reused within a small
/// part of its bandwidth.
///
/// Where lights are placed, photons are many times as dense as importons, so that most searches
/// would find the same importons. Takes a fifth of the time of separate estimates.
#[derive(Debug)]
pub struct NearbyImportance<'m> {
    importons: &'m KdTree<Importon>,
    found: Neighbors,
    /// Position, normal and result of the last estimate.
    last: Option<(Vec3, Vec3, f32)>,
}

impl<'m> NearbyImportance<'m> {
    /// No estimate yet.
    pub fn new(importons: &'m KdTree<Importon>) -> Self {
        NearbyImportance {
            importons,
            found: Neighbors::new(IMPORTANCE_NEIGHBORS),
            last: None,
        }
    }

    /// Incident importance per area at `p` on the side of the unit normal `n`, or nearby, in 1/m².
    pub fn at(&mut self, p: Vec3, n: Vec3) -> f32 {
        let reused = self.last.filter(|&(position, normal, _)| {
            let radius2 = REUSE_RADIUS * REUSE_RADIUS * self.found.radius_squared();
            position.distance_squared(p) <= radius2 && normal.dot(n) >= REUSE_MIN_COS
        });
        if let Some((_, _, importance)) = reused {
            return importance;
        }
        let importance = importance_at(self.importons, p, n, &mut self.found);
        self.last = Some((p, n, importance));
        importance
    }
}

/// Radius of the kernel of a density estimate: `radius_scale · min(largest, d_K)`.
#[derive(Clone, Copy, Debug)]
pub struct Bandwidth {
    /// Largest radius of the search for the K-th neighbor, in m.
    pub largest: f32,
    /// Factor in (0, 1].
    pub radius_scale: f32,
}

/// Factor on the bandwidth in pass `pass` >= 1: `pass^(-1/6)`. Radii shrink so that the mean over
/// passes is consistent; with squared radii in proportion to `pass^(-1/3)`, bias and standard
/// deviation of the mean converge at the same rate.
///
/// Source: Knaus, Zwicker, "Progressive Photon Mapping: A Probabilistic Approach", ACM TOG 2011,
/// with alpha = 2/3.
pub fn progressive_radius_scale(pass: u32) -> f32 {
    (pass as f32).powf(-1.0 / 6.0)
}

/// The surface point at which a density is estimated.
#[derive(Clone, Copy, Debug)]
pub struct DensityReceiver {
    /// Position.
    pub p: Vec3,
    /// Geometric normal on the lit side, unit.
    pub n: Vec3,
}

impl DensityReceiver {
    /// Largest distance from the tangent plane, in m, of points on the receiver's surface within
    /// `radius`.
    #[inline]
    pub fn slab(&self, radius: f32) -> f32 {
        PHOTON_SLAB * radius
    }

    /// Whether the point `p` within `radius`, with unit normal `n` on its lit side, is on the
    /// receiver's surface.
    #[inline]
    pub fn shares_surface(&self, p: Vec3, n: Vec3, radius: f32) -> bool {
        self.n.dot(n) >= MIN_COS && self.n.dot(p - self.p).abs() <= self.slab(radius)
    }
}

/// A photon that arrives on a surface; the values are those of [`Photon`].
pub trait OnSurface: Located {
    /// Geometric normal on the side from which it arrives, unit.
    fn normal(&self) -> Vec3;
    /// Unit direction to the previous vertex.
    fn wi(&self) -> Vec3;
    /// Number of segments from the emitter.
    fn depth(&self) -> u32;
}

impl OnSurface for Photon {
    #[inline]
    fn normal(&self) -> Vec3 {
        self.n
    }
    #[inline]
    fn wi(&self) -> Vec3 {
        self.wi
    }
    #[inline]
    fn depth(&self) -> u32 {
        u32::from(self.depth)
    }
}

/// Calls `visit` with each of the nearest photons on the receiver's side and surface and its kernel
/// weight in 1/m²: `Σ weight · flux · f` estimates reflected radiance. K is the size of `found`.
/// Returns the radius of the kernel in m.
pub fn density_estimate<'m, P: OnSurface + Sync>(
    photons: &'m KdTree<P>,
    receiver: DensityReceiver,
    bandwidth: Bandwidth,
    found: &mut Neighbors,
    mut visit: impl FnMut(&'m P, f32),
) -> f32 {
    photons.nearest(receiver.p, bandwidth.largest, found);
    let radius = found.radius_squared().sqrt() * bandwidth.radius_scale;
    for (i, d2) in found.iter() {
        let item = &photons.items()[i as usize];
        if receiver.shares_surface(item.position(), item.normal(), radius) {
            let weight = epanechnikov(d2, radius * radius);
            if weight > 0.0 {
                visit(item, weight);
            }
        }
    }
    radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::Pcg;

    fn importon(p: Vec3, n: Vec3) -> Importon {
        Importon {
            p,
            n,
            importance: 1.0,
        }
    }

    /// A kernel with equal weights. With the distance of the K-th neighbor, the density is
    /// overestimated by the factor K/(K-1).
    fn constant(_: f32, r2: f32) -> f32 {
        FRAC_1_PI / r2
    }

    #[test]
    fn kernels_integrate_to_one_over_the_disc() {
        let (r, steps) = (0.3f32, 10_000);
        for kernel in [constant, epanechnikov] {
            let sum: f64 = (0..steps)
                .map(|i| {
                    let d = r * (i as f32 + 0.5) / steps as f32;
                    let ring =
                        std::f64::consts::TAU * f64::from(d) * f64::from(r) / f64::from(steps);
                    ring * f64::from(kernel(d * d, r * r))
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-4, "{sum}");
        }
    }

    /// Mean of `sum / true density` over homogeneous point sets on the unit square, seen from its
    /// center.
    fn mean_density(kernel: fn(f32, f32) -> f32, k: usize, trials: usize) -> f64 {
        let count = 400;
        let mut rng = Pcg::new(11);
        let mut found = Neighbors::new(k);
        let mut sum = 0.0;
        for _ in 0..trials {
            let points = (0..count)
                .map(|_| Vec3::new(rng.next_f32(), rng.next_f32(), 0.0))
                .collect();
            let tree = KdTree::build(points);
            tree.nearest(Vec3::new(0.5, 0.5, 0.0), f32::INFINITY, &mut found);
            let r2 = found.radius_squared();
            sum += found
                .iter()
                .map(|(_, d2)| f64::from(kernel(d2, r2)))
                .sum::<f64>();
        }
        sum / trials as f64 / count as f64
    }

    /// With `count` points in the square instead of a Poisson process, E[(K-1)/(π d_K²)] is exactly
    /// the density (order statistics of a Beta variable). The standard error is 1/sqrt(K-2) per
    /// trial, 0.19 % here.
    #[test]
    fn epanechnikov_is_unbiased_and_the_constant_kernel_is_not() {
        let k = 30;
        let epanechnikov = mean_density(epanechnikov, k, 10_000);
        assert!((epanechnikov - 1.0).abs() < 0.005, "{epanechnikov}");
        let constant = mean_density(constant, k, 10_000);
        let expected = k as f64 / (k as f64 - 1.0);
        assert!(
            (constant - expected).abs() < 0.005,
            "{constant} instead of {expected}"
        );
    }

    #[test]
    fn importance_does_not_pass_through_walls() {
        let mut rng = Pcg::new(3);
        let above: Vec<Importon> = (0..2000)
            .map(|_| importon(Vec3::new(rng.next_f32(), rng.next_f32(), 0.0), Vec3::Z))
            .collect();
        let tree = KdTree::build(above);
        let mut found = Neighbors::new(IMPORTANCE_NEIGHBORS);
        let p = Vec3::new(0.5, 0.5, 0.0);
        let front = importance_at(&tree, p, Vec3::Z, &mut found);
        assert!((front / 2000.0 - 1.0).abs() < 0.3, "{front}");
        assert_eq!(
            importance_at(&tree, p - Vec3::Z * 0.001, -Vec3::Z, &mut found),
            0.0
        );
    }

    #[test]
    fn estimates_are_reused_nearby_only() {
        let mut rng = Pcg::new(5);
        // Twice as dense on the right.
        let place = |rng: &mut Pcg| {
            let from = if rng.next_f32() < 2.0 / 3.0 { 0.0 } else { 0.5 };
            let x = from + (1.0 - from) * rng.next_f32();
            Vec3::new(x, rng.next_f32(), 0.0)
        };
        let floor: Vec<Importon> = (0..4000)
            .map(|_| importon(place(&mut rng), Vec3::Z))
            .collect();
        let tree = KdTree::build(floor);
        let mut reused = NearbyImportance::new(&tree);
        let mut found = Neighbors::new(IMPORTANCE_NEIGHBORS);
        let (mut sum, mut sum_reused, mut searches) = (0.0, 0.0, 0);
        for i in 0..40_000 {
            let p = Vec3::new((i / 200) as f32 / 200.0, (i % 200) as f32 / 200.0, 0.0);
            let own = importance_at(&tree, p, Vec3::Z, &mut found);
            let near = reused.at(p, Vec3::Z);
            assert!((near / own).ln().abs() < 1.5, "{near} for {own} at {p}");
            searches += u32::from(near == own);
            sum += f64::from(own);
            sum_reused += f64::from(near);
        }
        assert!(
            (sum_reused / sum - 1.0).abs() < 0.01,
            "{sum_reused} for {sum}"
        );
        assert!(searches < 20_000, "{searches}");
        let p = Vec3::new(0.5, 0.5, 0.0);
        assert!(reused.at(p, Vec3::Z) > 0.0);
        assert_eq!(reused.at(p, -Vec3::Z), 0.0);
    }

    #[test]
    fn no_importons_mean_no_importance() {
        let tree: KdTree<Importon> = KdTree::build(Vec::new());
        assert_eq!(
            importance_at(&tree, Vec3::ZERO, Vec3::Z, &mut Neighbors::new(8)),
            0.0
        );
    }
}
