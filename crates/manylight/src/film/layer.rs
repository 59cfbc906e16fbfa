//! The quantities that a film records.

use crate::ids::LightGroup;
use std::borrow::Cow;

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
    /// Position of the first surface that scatters, in world space, in m, times the covered
    /// fraction of the sample.
    Position,
    /// Distance to the first surface along the camera ray, in m; 0 where the ray hits nothing.
    Depth,
    /// Size of the light cuts of a sample: number of lights and clusters that its sums over virtual
    /// lights evaluate.
    CutSize,
    /// Largest error bound among the clusters of these cuts, in radiance; the whole radiance where
    /// no bound is known.
    CutBound,
    /// Radiance over all light paths from the emitters of one light group. The groups of a scene
    /// sum to the beauty.
    LightGroup(LightGroup),
}

impl Layer {
    /// All layers but those of light groups, in the order of their declaration.
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

    /// The layers of `count` light groups.
    pub fn of_light_groups(count: usize) -> impl Iterator<Item = Layer> {
        (0..count.min(LightGroup::MAX)).map(|group| Layer::LightGroup(LightGroup(group as u8)))
    }

    /// Name in image files; empty for the beauty. Light groups are numbered: their names are those
    /// of the scene.
    pub fn name(self) -> Cow<'static, str> {
        if let Layer::LightGroup(group) = self {
            return format!("{LIGHT_GROUP}{}", group.0).into();
        }
        self.fixed_name().into()
    }

    /// [`Layer::name`] of all layers but those of light groups.
    fn fixed_name(self) -> &'static str {
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
            Layer::LightGroup(_) => LIGHT_GROUP,
        }
    }

    /// The light group with the name of its layer.
    pub(super) fn light_group_of_name(name: &str) -> Option<Layer> {
        let number: u8 = name.strip_prefix(LIGHT_GROUP)?.parse().ok()?;
        (usize::from(number) < LightGroup::MAX).then_some(Layer::LightGroup(LightGroup(number)))
    }

    /// Index in [`Layer::ALL`]; the number of these for light groups.
    #[inline]
    pub(super) fn index(self) -> usize {
        match self {
            Layer::Beauty => 0,
            Layer::Emission => 1,
            Layer::Direct => 2,
            Layer::VirtualLights => 3,
            Layer::Compensation => 4,
            Layer::Caustics => 5,
            Layer::Albedo => 6,
            Layer::Normal => 7,
            Layer::Alpha => 8,
            Layer::Position => 9,
            Layer::Depth => 10,
            Layer::CutSize => 11,
            Layer::CutBound => 12,
            Layer::LightGroup(_) => LAYERS,
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

    /// Whether the film estimates the variance of the layer: of the beauty, its terms and light
    /// groups.
    pub fn has_variance(self) -> bool {
        self == Layer::Beauty || self.is_term() || matches!(self, Layer::LightGroup(_))
    }
}

/// Start of the names of the layers of light groups.
const LIGHT_GROUP: &str = "light_group_";

/// Number of variants of [`Layer`] but that of light groups.
pub(super) const LAYERS: usize = 13;

/// Index of each layer among the recorded layers of a film. Layers of light groups follow each other
/// in the order of their groups.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slots {
    /// By index in [`Layer::ALL`].
    of_layers: [u8; LAYERS],
    /// Of the first light group.
    first_group: u8,
    /// Number of light groups.
    groups: u8,
}

impl Slots {
    /// Entry of a layer that the film does not record.
    const NONE: u8 = u8::MAX;

    /// # Panics
    /// If the light groups are not in their order, from the first on.
    pub(super) fn new(layers: &[Layer]) -> Self {
        let mut slots = Slots {
            of_layers: [Slots::NONE; LAYERS],
            first_group: 0,
            groups: 0,
        };
        for (slot, &layer) in layers.iter().enumerate() {
            match layer {
                Layer::LightGroup(group) => {
                    if group.0 == 0 {
                        slots.first_group = slot as u8;
                    }
                    let expected = usize::from(slots.first_group) + group.index();
                    assert!(
                        group.0 == slots.groups && slot == expected,
                        "the layers of light groups must follow each other"
                    );
                    slots.groups += 1;
                }
                _ => slots.of_layers[layer.index()] = slot as u8,
            }
        }
        slots
    }

    #[inline]
    pub(super) fn of(&self, layer: Layer) -> Option<usize> {
        let slot = match layer {
            Layer::LightGroup(group) => return self.of_group(group),
            _ => self.of_layers[layer.index()],
        };
        (slot != Slots::NONE).then_some(slot.into())
    }

    /// Index of the layer of a light group.
    #[inline]
    pub(super) fn of_group(&self, group: LightGroup) -> Option<usize> {
        (group.0 < self.groups).then_some((self.first_group + group.0).into())
    }

    /// Number of light groups.
    #[inline]
    pub(super) fn groups(&self) -> usize {
        self.groups.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_layer_has_its_index_and_slot() {
        for (i, layer) in Layer::ALL.into_iter().enumerate() {
            assert_eq!(layer.index(), i, "{layer:?}");
        }
        let groups: Vec<Layer> = Layer::of_light_groups(3).collect();
        let layers = [
            &[Layer::Beauty, Layer::Direct],
            &groups[..],
            &[Layer::Depth],
        ]
        .concat();
        let slots = Slots::new(&layers);
        for (slot, &layer) in layers.iter().enumerate() {
            assert_eq!(slots.of(layer), Some(slot), "{layer:?}");
            assert_eq!(Layer::from_array_name(&layer.array_name()), Some(layer));
        }
        assert_eq!((slots.groups(), slots.of_group(LightGroup(3))), (3, None));
        assert_eq!(slots.of(Layer::Emission), None);
        assert_eq!(Layer::from_array_name("light_group_64"), None);
    }
}
