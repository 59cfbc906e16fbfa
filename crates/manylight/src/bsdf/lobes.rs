//! Classes of lobes: what the path partition tells apart.

/// Classes of lobes, as a set.
///
/// `DIFFUSE` and `GLOSSY` together are the "n" events of the path partition (virtual lights stand there and are summed there),
/// `NEAR_DELTA` are microfacet lobes too narrow for virtual lights, `DELTA` are mirrors and smooth glass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobes(pub u8);

impl Lobes {
    /// Nothing.
    pub const NONE: Lobes = Lobes(0);
    /// Lobes of the form `a(wi) b(wo) / π`: Lambert, and the base of plastics. Under a bump or normal map, or beside a stronger
    /// lobe with another `b`, they are not of this form and count as `GLOSSY`.
    pub const DIFFUSE: Lobes = Lobes(1);
    /// Everything else that is not narrow: microfacets with alpha >= [`NEAR_DELTA_ALPHA`], sheen, Oren-Nayar, Phong, ...
    pub const GLOSSY: Lobes = Lobes(2);
    /// Microfacet lobes with alpha < [`NEAR_DELTA_ALPHA`] (or as narrow).
    pub const NEAR_DELTA: Lobes = Lobes(4);
    /// Dirac lobes, straight-through transmission excluded (that is [`Bsdf::transmittance`]).
    pub const DELTA: Lobes = Lobes(8);
    /// Where virtual lights stand and are summed.
    pub const NON_SPECULAR: Lobes = Lobes(1 | 2);
    /// Where camera paths are continued and caustic photons come from.
    pub const SPECULAR: Lobes = Lobes(4 | 8);
    /// All that `f` can be asked for: everything but `DELTA`.
    pub const FINITE: Lobes = Lobes(1 | 2 | 4);
    /// Everything.
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

    /// Whether the sets share an element.
    #[inline]
    pub const fn has(self, o: Lobes) -> bool {
        self.0 & o.0 != 0
    }
}
