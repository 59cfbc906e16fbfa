//! Classes of lobes, by which the path partition (docs/path_partition.md) distinguishes scattering events.

/// Roughness alpha below which a microfacet lobe is near-delta: such a lobe is narrower than a texel of a 32 x 32 octahedral table. It is a
/// constant and no option, because the class of a lobe must be the same at both ends of a connection.
pub const NEAR_DELTA_ALPHA: f32 = 0.1;

/// A set of classes of lobes.
///
/// `NON_SPECULAR` (`DIFFUSE` and `GLOSSY`) lobes carry virtual lights: lights are placed at events of these lobes, and gather points sum
/// the light of these lobes. `SPECULAR` (`NEAR_DELTA` and `DELTA`) lobes are followed by rays instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobes(pub u8);

impl Lobes {
    /// The empty set.
    pub const NONE: Lobes = Lobes(0);
    /// Lobes of the form `a(wi) b(wo) / π` around the shading normal: Lambert, and the base of plastics. Such lobes count as `GLOSSY`
    /// under a bump or normal map, and in blends with a stronger lobe of another `b`.
    pub const DIFFUSE: Lobes = Lobes(1);
    /// All other lobes of high roughness: microfacets with alpha >= [`NEAR_DELTA_ALPHA`], sheen, Oren-Nayar, Phong, Ward.
    pub const GLOSSY: Lobes = Lobes(2);
    /// Finite lobes of low roughness: microfacets with alpha < [`NEAR_DELTA_ALPHA`], and Phong and Ward lobes of such a width.
    pub const NEAR_DELTA: Lobes = Lobes(4);
    /// Delta lobes: mirrors and smooth dielectrics. Straight-through transmission is not a lobe, see
    /// [`Bsdf::transmittance`](super::Bsdf::transmittance).
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

    /// `value` if the sets have a class in common, else 0.
    #[inline]
    pub(super) fn pick(self, o: Lobes, value: f32) -> f32 {
        if self.has(o) { value } else { 0.0 }
    }

    /// Whether the sets have a class in common.
    #[inline]
    pub const fn has(self, o: Lobes) -> bool {
        self.0 & o.0 != 0
    }
}

/// The class of a microfacet lobe of roughness `alpha`.
#[inline]
pub(super) fn microfacet_class(alpha: f32) -> Lobes {
    if alpha < NEAR_DELTA_ALPHA {
        Lobes::NEAR_DELTA
    } else {
        Lobes::GLOSSY
    }
}
