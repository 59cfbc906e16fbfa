//! Layers of an image file by their names.
//!
//! Blender calls the layers of a file `ViewLayer.Combined`, `ViewLayer.Denoising Albedo`: a layer
//! of the scene and one of its passes. The last part of such a name finds it, if only one layer has
//! it.

use manylight_io::image::{LayeredImage, is_combined, last_part, light_group};

/// A layer with colors.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found<'p> {
    /// Its full name: empty for the image itself, or `ViewLayer.Combined`.
    pub(super) name: &'p str,
    /// Red, green and blue, each by pixel.
    planes: [&'p [f32]; 3],
}

impl<'p> Found<'p> {
    pub(super) fn rgb(&self) -> Vec<[f32; 3]> {
        let [r, g, b] = self.planes;
        let pixels = r.iter().zip(g).zip(b);
        pixels.map(|((&r, &g), &b)| [r, g, b]).collect()
    }

    /// The layer `name` beside this one, in the same layer of Blender's scene.
    pub(super) fn beside(&self, picture: &'p LayeredImage, name: &str) -> Option<Found<'p>> {
        let beside = colored_layers(picture).into_iter();
        beside
            .filter(|other| other.scene_layer() == self.scene_layer())
            .find(|other| other.is(name))
    }

    /// The layers of light groups beside this one, with the names of the groups.
    pub(super) fn light_groups(&self, picture: &'p LayeredImage) -> Vec<(&'p str, Found<'p>)> {
        let beside = colored_layers(picture).into_iter();
        beside
            .filter(|other| other.scene_layer() == self.scene_layer())
            .filter_map(|other| Some((light_group(other.name)?, other)))
            .collect()
    }

    /// The layer of Blender's scene; `None` in files without them.
    fn scene_layer(&self) -> Option<&'p str> {
        self.name.rsplit_once('.').map(|(before, _)| before)
    }

    /// Whether this is the layer of this name in any layer of a scene.
    pub(super) fn is(&self, name: &str) -> bool {
        last_part(self.name) == name
    }

    /// Whether this is the image, not one of its layers.
    pub(super) fn is_image(&self) -> bool {
        self.name.is_empty() || is_combined(self.name)
    }
}

/// Why a file has no color channels of the image, or of the requested layer.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum NotFound {
    /// There are none, but these channels.
    Missing(Vec<String>),
    /// These layers have them.
    Several(Vec<String>),
}

/// The image, or the layer `layer`: by its full name, else by the end of it.
pub(super) fn find<'p>(
    picture: &'p LayeredImage,
    layer: Option<&str>,
) -> Result<Found<'p>, NotFound> {
    let colored = colored_layers(picture);
    let named = |name: &str| colored.iter().find(|found| found.name == name).cloned();
    if let Some(found) = named(layer.unwrap_or_default()) {
        return Ok(found);
    }
    let fits = |found: &&Found| match layer {
        None => found.is_image(),
        Some(layer) => (found.name.strip_suffix(layer)).is_some_and(|before| before.ends_with('.')),
    };
    let fitting: Vec<&Found> = colored.iter().filter(fits).collect();
    match (&fitting[..], named("")) {
        ([one], _) => Ok((*one).clone()),
        // A file of the image alone, compared with one of Blender's.
        ([], Some(image)) if layer.is_some_and(is_combined) => Ok(image),
        ([], _) => {
            let names = channels(picture).map(|(name, _)| name.to_owned());
            Err(NotFound::Missing(names.collect()))
        }
        _ => {
            let names = fitting.iter().map(|found| found.name.to_owned());
            Err(NotFound::Several(names.collect()))
        }
    }
}

/// The layers with the channels `R`, `G` and `B`, and a gray image.
fn colored_layers(picture: &LayeredImage) -> Vec<Found<'_>> {
    let values = |name: &str| channels(picture).find(|(n, _)| *n == name).map(|(_, v)| v);
    let colored = |(name, r)| {
        let before = str::strip_suffix(name, "R")?;
        let name = match before {
            "" => "",
            before => before.strip_suffix('.')?,
        };
        let [g, b] = ["G", "B"].map(|channel| values(&format!("{before}{channel}")));
        let planes = [r, g?, b?];
        Some(Found { name, planes })
    };
    let mut found: Vec<Found> = channels(picture).filter_map(colored).collect();
    if let (Some(y), false) = (values("Y"), found.iter().any(|f| f.name.is_empty())) {
        found.push(Found {
            name: "",
            planes: [y; 3],
        });
    }
    found
}

fn channels(picture: &LayeredImage) -> impl Iterator<Item = (&str, &[f32])> {
    let channels = picture.layers.iter().flat_map(|layer| &layer.channels);
    channels.map(|(name, values)| (name.as_str(), values.as_slice()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with color channels in these layers, and with depth.
    fn picture(layers: &[&str]) -> LayeredImage {
        let channels = layers.iter().flat_map(|layer| {
            let dot = if layer.is_empty() { "" } else { "." };
            ["R", "G", "B"].map(|channel| (format!("{layer}{dot}{channel}"), vec![0.0]))
        });
        let depth = ("ViewLayer.Depth.Z".to_owned(), vec![0.0]);
        LayeredImage::from_channels(1, 1, channels.chain([depth]).collect())
    }

    fn name(layers: &[&str], layer: Option<&str>) -> Result<String, NotFound> {
        find(&picture(layers), layer).map(|found| found.name.to_owned())
    }

    #[test]
    fn ends_of_names_find_layers() {
        let blender = ["ViewLayer.Combined", "ViewLayer.Diffuse Color"];
        let found = |layer| name(&blender, layer).unwrap();
        assert_eq!(found(None), "ViewLayer.Combined");
        assert_eq!(found(Some("Combined")), "ViewLayer.Combined");
        assert_eq!(found(Some("Diffuse Color")), "ViewLayer.Diffuse Color");
        let whole = Some("ViewLayer.Diffuse Color");
        assert_eq!(found(whole), "ViewLayer.Diffuse Color");
        for layer in ["Color", "Depth", "diffuse color", ""] {
            let missing = name(&blender, Some(layer)).unwrap_err();
            assert!(
                matches!(&missing, NotFound::Missing(channels) if channels.len() == 7),
                "{layer}: {missing:?}"
            );
        }
    }

    #[test]
    fn the_image_comes_first() {
        let layers = ["", "direct", "ViewLayer.Combined", "ViewLayer.direct"];
        assert_eq!(name(&layers, None).unwrap(), "");
        assert_eq!(name(&layers, Some("direct")).unwrap(), "direct");
        // A plain file beside one of Blender's.
        assert_eq!(name(&[""], Some("ViewLayer.Combined")).unwrap(), "");
    }

    #[test]
    fn several_layers_of_one_name_are_reported() {
        let layers = ["A.Combined", "B.Combined", "B.direct"];
        for layer in [None, Some("Combined")] {
            let names = layers[..2].iter().map(|name| (*name).to_owned());
            let several = NotFound::Several(names.collect());
            assert_eq!(name(&layers, layer), Err(several));
        }
        assert_eq!(name(&layers, Some("direct")).unwrap(), "B.direct");
    }

    #[test]
    fn layers_beside_are_of_the_same_layer_of_the_scene() {
        let picture = picture(&["", "A.Combined", "B.Combined", "B.noisy", "noisy"]);
        let beside = |layer, other| {
            let found = find(&picture, layer).unwrap();
            found.beside(&picture, other).map(|found| found.name)
        };
        assert_eq!(beside(None, "noisy"), Some("noisy"));
        assert_eq!(beside(Some("B.Combined"), "noisy"), Some("B.noisy"));
        assert_eq!(beside(Some("A.Combined"), "noisy"), None);
        let [image, combined, noisy] =
            [None, Some("A.Combined"), Some("B.noisy")].map(|layer| find(&picture, layer).unwrap());
        assert!(image.is_image() && combined.is_image() && !noisy.is_image());
        assert!(noisy.is("noisy") && !image.is("noisy"));
    }
}
