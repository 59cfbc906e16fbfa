//! The quantities that a film records.

/// A quantity that a film records per pixel. The beauty is the sum of emission, direct light,
/// virtual lights, compensation and caustics. Virtual lights and compensation share light paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layer {
    /// Radiance over all light paths.
    Beauty,
    /// Radiance of emitters that the camera path hits, directly or after specular events alone.
    Emission,
    /// Radiance reflected from emitters at the first vertex with a non-specular lobe.
    Direct,
    /// Radiance reflected at the same vertex from virtual lights. Path tracing: all light that
    /// other surfaces reflect towards that vertex by non-specular lobes.
    VirtualLights,
    /// The part of that light which clamping removes from virtual lights.
    Compensation,
    /// Radiance from photons that come from a specular event.
    Caustics,
    /// Albedo of the first surface.
    Albedo,
    /// Shading normal of the first surface, in world space.
    Normal,
    /// Raw values of [`Film::alpha`](super::Film::alpha): filter weight times covered fraction,
    /// covered fraction, filter weight.
    Alpha,
    /// Position of the first surface that scatters, in world space, in the scene's unit, times the
    /// covered fraction of the sample.
    Position,
    /// Distance to the first surface along the camera ray, in the scene's unit; 0 where the ray
    /// hits nothing.
    Depth,
    /// Size of the light cuts of a sample: number of lights and clusters that its sums over virtual
    /// lights evaluate.
    CutSize,
    /// Largest error bound among the clusters of these cuts, in radiance; the whole radiance where
    /// no bound is known.
    CutBound,
}

impl Layer {
    /// All layers, in the order of their declaration.
    pub const ALL: [Layer; LAYERS] = [
        Layer::Beauty,
        Layer::Emission,
        Layer::Direct,
        Layer::VirtualLights,
        Layer::Compensation,
        Layer::Caustics,
        Layer::Albedo,
        Layer::Normal,
        Layer::Alpha,
        Layer::Position,
        Layer::Depth,
        Layer::CutSize,
        Layer::CutBound,
    ];

    /// Name in image files; empty for the beauty.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Beauty => "",
            Layer::Emission => "emission",
            Layer::Direct => "direct",
            Layer::VirtualLights => "virtual_lights",
            Layer::Compensation => "compensation",
            Layer::Caustics => "caustics",
            Layer::Albedo => "albedo",
            Layer::Normal => "normal",
            Layer::Alpha => "alpha",
            Layer::Position => "position",
            Layer::Depth => "depth",
            Layer::CutSize => "cut_size",
            Layer::CutBound => "cut_bound",
        }
    }

    /// Whether the layer is a term of the partition of light paths, so that its values are added to
    /// the beauty too.
    pub fn is_term(self) -> bool {
        matches!(
            self,
            Layer::Emission
                | Layer::Direct
                | Layer::VirtualLights
                | Layer::Compensation
                | Layer::Caustics
        )
    }

    /// Whether the film estimates the variance of the layer: of the beauty and its terms.
    pub fn has_variance(self) -> bool {
        self == Layer::Beauty || self.is_term()
    }
}

/// Index of each layer among the recorded layers of a film, by `Layer as usize`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slots([u8; LAYERS]);

/// Number of variants of [`Layer`].
const LAYERS: usize = Layer::CutBound as usize + 1;

impl Slots {
    /// Entry of a layer that the film does not record.
    const NONE: u8 = u8::MAX;

    pub(super) fn new(layers: &[Layer]) -> Self {
        let mut slots = [Slots::NONE; LAYERS];
        for (slot, &layer) in layers.iter().enumerate() {
            slots[layer as usize] = slot as u8;
        }
        Slots(slots)
    }

    #[inline]
    pub(super) fn of(self, layer: Layer) -> Option<usize> {
        let slot = self.0[layer as usize];
        (slot != Slots::NONE).then_some(slot.into())
    }
}
