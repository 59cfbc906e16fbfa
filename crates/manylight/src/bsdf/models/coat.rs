//! Tables of rough dielectric coats: transmittance from outside, reflectance from inside.

use super::fresnel::{self, reflect, refract};
use super::microfacet::Microfacets;
use crate::bsdf::material::Distribution;
use crate::lanes::{
    Float, LANES, LaneKernel, Mask, One, Pair, Sixteen, Stored, Vector, Width, Word,
};
use crate::simd::Isa;
use rayon::prelude::*;

/// Quadrature points per dimension for light into a denser medium; an even number. The mean radiance
/// of a lit sphere is off by at most 7·10⁻⁵, with 16 points by 2·10⁻⁴ (alpha 0.02 to 0.7, index 1.3
/// to 2.4, against 256 points).
const NODES: usize = 32;
/// Quadrature points per dimension for light into a thinner medium; an even number. Total
/// reflection makes the integrand discontinuous; with 64 points the error is below 10⁻³.
const NODES_WITH_TOTAL_REFLECTION: usize = 64;
/// Cosine that replaces 0, where the distribution of visible normals has no limit.
const MIN_COSINE: f32 = 1e-6;

/// Tables of a rough coat.
#[derive(Debug)]
pub(in crate::bsdf) struct Coat {
    /// Transmittance from outside over the cosine on [0, 1].
    pub transmittance: [f32; COSINES],
    /// Reflectance from inside, averaged over diffuse light.
    pub internal_reflectance: f32,
}

/// Entries of a table over the cosine on [0, 1], with linear interpolation. For GGX and indices of
/// 1.3 to 2.4, its error is at most 5·10⁻⁵ from alpha 0.3 on, 6·10⁻⁴ at 0.1, and 4·10⁻³ at 0.02, but
/// for 10⁻² in the last entry before the horizon; with half the entries, four times as much.
pub const COSINES: usize = 64;

/// Linear interpolation in a table.
#[inline(always)]
pub(in crate::bsdf) fn interpolate<S: Width>(table: &[f32; COSINES], cos: Float<S>) -> Float<S> {
    interpolate_tables(&[table; LANES], cos)
}

/// [`interpolate`] for cosines of which many lie between the same entries: towards a light, those
/// of sixteen neighboring points. Entries are read once for all lanes that need them.
#[inline(always)]
pub(in crate::bsdf) fn interpolate_near<S: Width>(
    table: &[f32; COSINES],
    cos: Float<S>,
) -> Float<S> {
    let (index, fraction) = place(cos);
    let s = cos.width();
    let (mut low, mut high) = (Float::splat(s, 0.0), Float::splat(s, 0.0));
    for (index, lanes) in index.groups(Mask::splat(s, true)) {
        let entry = |step: usize| table[(index as usize + step) % COSINES];
        low = lanes.select(entry(0), low);
        high = lanes.select(entry(1), high);
    }
    fraction.mul_add(high - low, low)
}

/// The entry before a cosine, and the place between it and the next.
#[inline(always)]
fn place<S: Width>(cos: Float<S>) -> (Word<S>, Float<S>) {
    // The factor makes a cosine of 1 lie between the last two entries.
    let at = cos.clamp(0.0, 1.0) * ((COSINES - 1) as f32 * (1.0 - f32::EPSILON));
    let below = at.floor();
    (below.to_word(), at - below)
}

/// Linear interpolation in one table per lane: those of the first lanes.
#[inline(always)]
fn interpolate_tables<S: Width>(tables: &[&[f32; COSINES]; LANES], cos: Float<S>) -> Float<S> {
    let (index, fraction) = place(cos);
    let (s, index) = (cos.width(), index.store());
    let entry = |i: usize, step: usize| tables[i][(index.as_ref()[i] as usize + step) % COSINES];
    let low = Float::from_fn(s, |i| entry(i, 0));
    let high = Float::from_fn(s, |i| entry(i, 1));
    fraction.mul_add(high - low, low)
}

/// The transmittance of a coat from outside in each lane.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct CoatTables<'s, S: Width> {
    /// Over the cosine on [0, 1]; with fewer lanes, the first ones count.
    tables: [&'s [f32; COSINES]; LANES],
    /// Whether all tables are the same.
    are_same: bool,
    /// The largest entry of each table.
    largest: Float<S>,
}

impl<'s, S: Width> CoatTables<'s, S> {
    /// The same table in all lanes.
    #[inline(always)]
    pub(in crate::bsdf) fn same(s: S, table: &'s [f32; COSINES]) -> Self {
        CoatTables {
            tables: [table; LANES],
            are_same: true,
            largest: Float::splat(s, table.iter().copied().fold(0.0, f32::max)),
        }
    }

    /// The transmittance at the cosine `cos` >= 0. Fastest where it differs little between lanes, as
    /// towards a light.
    #[inline(always)]
    pub(in crate::bsdf) fn interpolate(&self, cos: Float<S>) -> Float<S> {
        if self.are_same {
            interpolate_near(self.tables[0], cos)
        } else {
            interpolate_tables(&self.tables, cos)
        }
    }

    /// The largest transmittance.
    #[inline(always)]
    pub(in crate::bsdf) fn largest(&self) -> Float<S> {
        self.largest
    }
}

/// The tables as a field of a structure in lanes: see [`lanewise`](crate::lanes::lanewise).
impl<'s> CoatTables<'s, One> {
    #[inline(always)]
    pub(in crate::bsdf) fn in_lanes<S: Width>(&self, s: S) -> CoatTables<'s, S> {
        CoatTables {
            tables: [self.tables[0]; LANES],
            are_same: true,
            largest: self.largest.in_lanes(s),
        }
    }
}

impl<'s> CoatTables<'s, Stored> {
    #[inline(always)]
    pub(in crate::bsdf) fn set_lane(&mut self, i: usize, single: CoatTables<'s, One>) {
        self.are_same &= std::ptr::eq(self.tables[i], single.tables[0]);
        self.tables[i] = single.tables[0];
        self.largest.set_lane(i, single.largest);
    }

    #[inline(always)]
    pub(in crate::bsdf) fn lane(&self, i: usize) -> CoatTables<'s, One> {
        CoatTables {
            tables: [self.tables[i]; LANES],
            are_same: true,
            largest: self.largest.lane(i),
        }
    }

    #[inline(always)]
    pub(in crate::bsdf) fn in_vectors<S: Sixteen>(&self, s: S) -> CoatTables<'s, S> {
        CoatTables {
            tables: self.tables,
            are_same: self.are_same,
            largest: self.largest.in_vectors(s),
        }
    }
}

impl Coat {
    /// Tabulates a coat with index `eta` relative to the outside.
    pub(in crate::bsdf) fn new(distribution: Distribution, alpha: f32, eta: f32) -> Self {
        let cosines: Vec<f32> = (0..COSINES)
            .map(|i| (i as f32 / (COSINES - 1) as f32).max(MIN_COSINE))
            .collect();
        let average = |eta, event| {
            average(&FacetMean {
                cosines: &cosines,
                rule: &gauss_legendre(if eta > 1.0 {
                    NODES
                } else {
                    NODES_WITH_TOTAL_REFLECTION
                }),
                distribution,
                alpha,
                eta,
                event,
            })
        };
        let transmittance = average(eta, FacetEvent::Transmission);
        // Over cosine-weighted directions: 2 ∫ r(μ) μ dμ.
        let reflectance = average(1.0 / eta, FacetEvent::Reflection);
        let sum: f32 = cosines.iter().zip(&reflectance).map(|(c, r)| c * r).sum();
        Coat {
            transmittance: transmittance
                .try_into()
                .expect("invariant: one value per cosine"),
            internal_reflectance: 2.0 * sum / COSINES as f32,
        }
    }
}

/// What happens to light at a visible facet.
#[derive(Clone, Copy, Debug)]
enum FacetEvent {
    Reflection,
    Transmission,
}

impl FacetEvent {
    /// Fraction of light from `w` that facets with normal `m` reflect or transmit.
    #[inline(always)]
    fn fraction<S: Width>(
        self,
        facets: &Microfacets<S>,
        w: Vector<S>,
        m: Vector<S>,
        eta: f32,
    ) -> Float<S> {
        let interface = fresnel::dielectric(w.dot(m), w.z.same(eta));
        match self {
            FacetEvent::Reflection => {
                let out = reflect(w, m);
                let unmasked = interface.reflectance * facets.masking(out, m);
                out.z.gt(0.0).select(unmasked, 0.0)
            }
            FacetEvent::Transmission => {
                let out = refract(w, m, &interface);
                let unmasked = (1.0 - interface.reflectance) * facets.masking(out, m);
                out.z.lt(0.0).select(unmasked, 0.0)
            }
        }
    }
}

/// The mean of an event over the visible facets, for each cosine.
///
/// The integrand is symmetric to the plane of incidence, and mirroring one random number mirrors
/// the facet. So half of the points in that dimension are evaluated.
#[derive(Clone, Copy)]
struct FacetMean<'a> {
    cosines: &'a [f32],
    rule: &'a [(f32, f32)],
    distribution: Distribution,
    alpha: f32,
    eta: f32,
    event: FacetEvent,
}

/// The mean for all cosines, in parallel.
fn average(mean: &FacetMean<'_>) -> Vec<f32> {
    let chunks = mean.cosines.par_chunks(LANES);
    let of_chunk = |cosines| Isa::best().run_lanes(FacetMean { cosines, ..*mean });
    chunks.flat_map_iter(of_chunk).collect()
}

impl LaneKernel for FacetMean<'_> {
    type Output = Vec<f32>;

    #[inline(always)]
    fn run<S: Width>(self, s: S) -> Vec<f32> {
        let alpha = Float::splat(s, self.alpha);
        let facets = Microfacets::new(self.distribution, alpha, alpha);
        let mut means = Vec::with_capacity(self.cosines.len());
        for chunk in self.cosines.chunks(S::LANES) {
            let cos = Float::load(s, &s.each(|i| chunk[i.min(chunk.len() - 1)]));
            let w = Vector::new((1.0 - cos * cos).sqrt(), cos.same(0.0), cos);
            let mut sums = [0.0f64; LANES];
            for &(mirrored, weight_mirrored) in &self.rule[..self.rule.len() / 2] {
                for &(other, weight) in self.rule {
                    let u = match self.distribution {
                        Distribution::Ggx => Pair::new(cos.same(mirrored), cos.same(other)),
                        Distribution::Beckmann => Pair::new(cos.same(other), cos.same(mirrored)),
                    };
                    let m = facets.sample(w, u);
                    let value = self.event.fraction(&facets, w, m, self.eta);
                    let weighted = (value * weight_mirrored * weight).store();
                    for (sum, value) in sums.iter_mut().zip(weighted.as_ref()) {
                        *sum += f64::from(*value);
                    }
                }
            }
            let of_chunk = sums.iter().take(chunk.len());
            means.extend(of_chunk.map(|sum| (2.0 * sum) as f32));
        }
        means
    }
}

/// Nodes and weights of Gauss-Legendre quadrature on [0, 1].
fn gauss_legendre(n: usize) -> Vec<(f32, f32)> {
    let count = n as f64;
    (0..n)
        .map(|i| {
            // Newton's method from Tricomi's initial value.
            let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (count + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..8 {
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
                }
                slope = count * (x * p1 - p0) / (x * x - 1.0);
                x -= p1 / slope;
            }
            let weight = 2.0 / ((1.0 - x * x) * slope * slope);
            ((0.5 * (x + 1.0)) as f32, (0.5 * weight) as f32)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Vec2, Vec3};

    #[test]
    fn quadrature_is_exact_for_polynomials() {
        let rule = gauss_legendre(32);
        let integral: f64 = rule
            .iter()
            .map(|&(x, w)| f64::from(w) * f64::from(x).powi(20))
            .sum();
        assert!((integral - 1.0 / 21.0).abs() < 1e-6, "{integral}");
    }

    #[test]
    fn mirrored_numbers_give_mirrored_facets() {
        let w = Vector::from(Vec3::new(0.6, 0.0, 0.8));
        for distribution in [Distribution::Ggx, Distribution::Beckmann] {
            let facets = Microfacets::new(distribution, 0.4.into(), 0.4.into());
            for i in 0..100 {
                let u = Vec2::new((i % 10) as f32 + 0.4, (i / 10) as f32 + 0.3) / 10.0;
                let mirrored = match distribution {
                    Distribution::Ggx => Vec2::new(1.0 - u.x, u.y),
                    Distribution::Beckmann => Vec2::new(u.x, 1.0 - u.y),
                };
                let sample = |u: Vec2| Vec3::from(facets.sample(w, u.into()));
                let (a, b) = (sample(u), sample(mirrored));
                assert!(
                    (a - b * Vec3::new(1.0, -1.0, 1.0)).length() < 1e-4,
                    "{a} {b}"
                );
            }
        }
    }

    #[test]
    fn a_nearly_smooth_coat_transmits_what_fresnel_says() {
        let coat = Coat::new(Distribution::Ggx, 1e-3, 1.5);
        for i in [20, 40, 63] {
            let cos: Float<One> = (i as f32 / 63.0).into();
            let expected = fresnel::coat_transmittance(cos, 1.5).get();
            assert!((coat.transmittance[i] - expected).abs() < 1e-3);
        }
        assert!((coat.internal_reflectance - fresnel::diffuse_reflectance(1.0 / 1.5)).abs() < 0.02);
    }
}
