//! Families of plugins, and the elements that declare them.

use super::super::sink::Text;

/// The supported spectrum plugins. Their tag may be `texture` too.
pub(super) const SPECTRA: &[&str] = &[
    "blackbody",
    "d65",
    "irregular",
    "rawconstant",
    "regular",
    "srgb",
    "uniform",
];

/// The supported texture plugins. Their tag may be `spectrum` too.
pub(super) const TEXTURES: &[&str] = &["bitmap", "checkerboard", "mesh_attribute"];

/// The family of a plugin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum PluginFamily {
    Scene,
    Integrator,
    Sensor,
    Film,
    Filter,
    Sampler,
    Emitter,
    Shape,
    Bsdf,
    Texture,
    Spectrum,
    Medium,
    Phase,
    Volume,
    Subsurface,
}

/// Tags of objects, the current tag of a family first. `camera` and `luminaire` occur in old files.
const FAMILY_TAGS: [(&str, PluginFamily); 17] = [
    ("scene", PluginFamily::Scene),
    ("integrator", PluginFamily::Integrator),
    ("sensor", PluginFamily::Sensor),
    ("camera", PluginFamily::Sensor),
    ("film", PluginFamily::Film),
    ("rfilter", PluginFamily::Filter),
    ("sampler", PluginFamily::Sampler),
    ("emitter", PluginFamily::Emitter),
    ("luminaire", PluginFamily::Emitter),
    ("shape", PluginFamily::Shape),
    ("bsdf", PluginFamily::Bsdf),
    ("texture", PluginFamily::Texture),
    ("spectrum", PluginFamily::Spectrum),
    ("medium", PluginFamily::Medium),
    ("phase", PluginFamily::Phase),
    ("volume", PluginFamily::Volume),
    ("subsurface", PluginFamily::Subsurface),
];

impl PluginFamily {
    /// The tags of objects that may be nested anywhere, for suggestions.
    pub(super) fn nested_tags() -> impl Iterator<Item = &'static str> {
        let is_nested = |family: &PluginFamily| {
            !matches!(family, PluginFamily::Scene | PluginFamily::Subsurface)
        };
        let families = FAMILY_TAGS.iter().map(|(_, family)| *family);
        families.filter(is_nested).map(PluginFamily::tag)
    }

    /// The family of objects with this tag.
    pub(super) fn of_tag(tag: &str) -> Option<PluginFamily> {
        FAMILY_TAGS
            .iter()
            .find(|(name, _)| *name == tag)
            .map(|(_, family)| *family)
    }

    /// The family of an object with the tag of this one: plugins of textures and spectra may have
    /// either tag.
    pub(super) fn of_plugin(self, plugin: Option<&Text>) -> PluginFamily {
        let is_in = |list: &[&str]| plugin.is_some_and(|name| list.contains(&name.value.as_str()));
        match self {
            PluginFamily::Texture if is_in(SPECTRA) => PluginFamily::Spectrum,
            PluginFamily::Spectrum if is_in(TEXTURES) => PluginFamily::Texture,
            family => family,
        }
    }

    /// The current tag of the family.
    pub(super) fn tag(self) -> &'static str {
        FAMILY_TAGS
            .iter()
            .find(|(_, family)| *family == self)
            .map_or("", |(name, _)| *name)
    }
}
