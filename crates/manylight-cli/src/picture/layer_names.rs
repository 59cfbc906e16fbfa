//! Names of the layers of EXR files.

use crate::names::AovNames;

/// The layer of Blender's default view.
const VIEW_LAYER: &str = "ViewLayer";

impl AovNames {
    /// The name of a layer; `name` is empty for the image itself. Layers that Blender has as well
    /// get its names, which Blender 5.0 writes; the others keep theirs inside of the view layer.
    pub(crate) fn layer(self, name: &str) -> String {
        if self == AovNames::Manylight {
            return name.to_owned();
        }
        let pass = match name {
            "" => "Combined",
            "depth" => "Depth",
            "normal" => "Normal",
            "position" => "Position",
            "albedo" => "Denoising Albedo",
            other => other,
        };
        format!("{VIEW_LAYER}.{pass}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_called_as_in_blender() {
        let blender = |name| AovNames::Blender.layer(name);
        assert_eq!(blender(""), "ViewLayer.Combined");
        assert_eq!(blender("albedo"), "ViewLayer.Denoising Albedo");
        assert_eq!(blender("CryptoObject"), "ViewLayer.CryptoObject");
        assert_eq!(AovNames::Manylight.layer("normal"), "normal");
    }
}
