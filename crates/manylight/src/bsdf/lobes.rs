//! Classes of lobes, by which the path partition (docs/path_partition.md) distinguishes scattering
//! events.

use crate::lanes::{Float, Mask, One, Width, in_lanes};

/// Roughness alpha below which a microfacet lobe is near-delta: such a lobe is narrower than a
/// texel of a 32 x 32 octahedral table. It is a constant and no option, because the class of a lobe
/// must be the same at both ends of a connection.
pub const NEAR_DELTA_ALPHA: f32 = 0.1;

/// A set of classes of lobes.
///
/// `NON_SPECULAR` (`DIFFUSE` and `GLOSSY`) lobes carry virtual lights: lights are placed at events
/// of these lobes, and gather points sum the light of these lobes. `SPECULAR` (`NEAR_DELTA` and
/// `DELTA`) lobes are followed by rays instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobes(pub u8);

impl Lobes {
    /// The empty set.
    pub const NONE: Lobes = Lobes(0);
    /// Lobes of the form `a(wi) b(wo) / π` around the shading normal: Lambert, and the base of
    /// plastics. Such lobes count as `GLOSSY` under a bump or normal map, and in blends with a
    /// stronger lobe of another `b`.
    pub const DIFFUSE: Lobes = Lobes(1);
    /// All other lobes of high roughness: microfacets with alpha >= [`NEAR_DELTA_ALPHA`], sheen,
    /// Oren-Nayar, Phong, Ward.
    pub const GLOSSY: Lobes = Lobes(2);
    /// Finite lobes of low roughness: microfacets with alpha < [`NEAR_DELTA_ALPHA`], and Phong and
    /// Ward lobes of such a width.
    pub const NEAR_DELTA: Lobes = Lobes(4);
    /// Delta lobes: mirrors and smooth dielectrics. Straight-through transmission is not a lobe,
    /// see [`Bsdf::transmittance`](super::Bsdf::transmittance).
    pub const DELTA: Lobes = Lobes(8);
    /// `DIFFUSE` and `GLOSSY`: the lobes that carry virtual lights.
    pub const NON_SPECULAR: Lobes = Lobes(1 | 2);
    /// `NEAR_DELTA` and `DELTA`: the lobes that are followed by rays; events of caustic paths.
    pub const SPECULAR: Lobes = Lobes(4 | 8);
    /// All lobes that `f` evaluates: all but `DELTA`.
    pub const FINITE: Lobes = Lobes(1 | 2 | 4);
    /// All classes.
    pub const ALL: Lobes = Lobes(15);

    /// Set union.
    #[inline]
    pub const fn or(self, o: Lobes) -> Lobes {
        Lobes(self.0 | o.0)
    }

    /// Set intersection.
    #[inline]
    pub const fn and(self, o: Lobes) -> Lobes {
        Lobes(self.0 & o.0)
    }

    /// Whether the sets have a class in common.
    #[inline]
    pub const fn has(self, o: Lobes) -> bool {
        self.0 & o.0 != 0
    }
}

/// A set of classes per lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Classes<S: Width> {
    pub diffuse: Mask<S>,
    pub glossy: Mask<S>,
    pub near_delta: Mask<S>,
    pub delta: Mask<S>,
}

in_lanes!(Classes {
    diffuse,
    glossy,
    near_delta,
    delta
});

impl<S: Width> Classes<S> {
    /// The set `lobes` in all lanes.
    #[inline(always)]
    pub(super) fn splat(s: S, lobes: Lobes) -> Self {
        let has = |class| Mask::splat(s, lobes.has(class));
        Classes {
            diffuse: has(Lobes::DIFFUSE),
            glossy: has(Lobes::GLOSSY),
            near_delta: has(Lobes::NEAR_DELTA),
            delta: has(Lobes::DELTA),
        }
    }

    /// The class of microfacet lobes of roughness `alpha`: `NEAR_DELTA` or `GLOSSY`.
    #[inline(always)]
    pub(super) fn of_microfacets(alpha: Float<S>) -> Self {
        let near_delta = alpha.lt(NEAR_DELTA_ALPHA);
        Classes {
            glossy: !near_delta,
            near_delta,
            ..Classes::splat(alpha.width(), Lobes::NONE)
        }
    }

    /// Set union.
    #[inline(always)]
    pub(super) fn or(self, o: Self) -> Self {
        Classes {
            diffuse: self.diffuse | o.diffuse,
            glossy: self.glossy | o.glossy,
            near_delta: self.near_delta | o.near_delta,
            delta: self.delta | o.delta,
        }
    }

    /// Set intersection.
    #[inline(always)]
    pub(super) fn and(self, o: Self) -> Self {
        Classes {
            diffuse: self.diffuse & o.diffuse,
            glossy: self.glossy & o.glossy,
            near_delta: self.near_delta & o.near_delta,
            delta: self.delta & o.delta,
        }
    }

    /// The set in the lanes of `m`, the empty set elsewhere.
    #[inline(always)]
    pub(super) fn within(self, m: Mask<S>) -> Self {
        Classes {
            diffuse: self.diffuse & m,
            glossy: self.glossy & m,
            near_delta: self.near_delta & m,
            delta: self.delta & m,
        }
    }

    /// The lanes with a class.
    #[inline(always)]
    pub(super) fn any(self) -> Mask<S> {
        self.diffuse | self.glossy | self.near_delta | self.delta
    }

    /// The lanes in which both sets have a class in common.
    #[inline(always)]
    pub(super) fn has(self, o: Self) -> Mask<S> {
        self.and(o).any()
    }

    /// With `DIFFUSE` replaced by `GLOSSY` in the lanes of `m`.
    #[inline(always)]
    pub(super) fn diffuse_as_glossy(self, m: Mask<S>) -> Self {
        Classes {
            diffuse: self.diffuse & !m,
            glossy: self.glossy | (self.diffuse & m),
            ..self
        }
    }
}

impl<S: Width> Classes<S> {
    /// The set of each lane.
    #[inline(always)]
    pub(super) fn each(self) -> S::Each<Lobes> {
        let (diffuse, glossy) = (self.diffuse.bits(), self.glossy.bits());
        let (near_delta, delta) = (self.near_delta.bits(), self.delta.bits());
        self.delta.width().each(|i| {
            let bit = |bits: u32, class: Lobes| if bits >> i & 1 != 0 { class.0 } else { 0 };
            Lobes(
                bit(diffuse, Lobes::DIFFUSE)
                    | bit(glossy, Lobes::GLOSSY)
                    | bit(near_delta, Lobes::NEAR_DELTA)
                    | bit(delta, Lobes::DELTA),
            )
        })
    }
}

impl Classes<One> {
    /// The set of the only lane.
    #[inline(always)]
    pub(super) fn get(self) -> Lobes {
        self.each()[0]
    }
}

impl From<Lobes> for Classes<One> {
    #[inline(always)]
    fn from(lobes: Lobes) -> Self {
        Classes::splat(One, lobes)
    }
}
