//! What an image file says about a render beyond the values of its film.

use manylight::film::IdLayer;
use manylight::scene::Scene;
use manylight::sensors::Sensor;
use manylight_io::image::ImageCamera;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Names, camera and metadata of a picture. Part files keep them, so that no scene is needed to
/// merge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PictureFacts {
    /// Names by id, of each recorded id layer.
    names: BTreeMap<String, Vec<String>>,
    /// Names of the light groups.
    #[serde(default)]
    light_groups: Vec<String>,
    camera: CameraFacts,
    /// Metadata (name, value).
    pub(crate) metadata: Vec<(String, String)>,
}

/// The fields of [`ImageCamera`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct CameraFacts {
    camera_from_world: [f32; 16],
    ndc_from_world: [f32; 16],
    screen_center: [f32; 2],
    screen_width: f32,
}

impl PictureFacts {
    /// Facts of pictures of `scene` by `camera`, with these id layers.
    pub(crate) fn new(
        scene: &Scene,
        camera: &Sensor,
        id_layers: &[IdLayer],
        metadata: Vec<(String, String)>,
    ) -> Self {
        let names = |layer: &IdLayer| {
            (
                layer.array_name().to_owned(),
                scene.names.names(*layer).to_vec(),
            )
        };
        let screen = camera.screen_window();
        PictureFacts {
            names: id_layers.iter().map(names).collect(),
            light_groups: scene.light_groups.names().to_vec(),
            camera: CameraFacts {
                camera_from_world: camera.camera_from_world().to_cols_array(),
                ndc_from_world: camera.film_from_world().to_cols_array(),
                screen_center: screen.map_or([0.0; 2], |(center, _)| center.to_array()),
                screen_width: screen.map_or(1.0, |(_, width)| width),
            },
            metadata,
        }
    }

    /// Names by id; empty if the layer is not recorded.
    pub(crate) fn names(&self, layer: IdLayer) -> &[String] {
        self.names
            .get(layer.array_name())
            .map_or(&[], Vec::as_slice)
    }

    /// Names of the light groups.
    pub(crate) fn light_groups(&self) -> &[String] {
        &self.light_groups
    }

    /// The camera.
    pub(crate) fn camera(&self) -> ImageCamera {
        let CameraFacts {
            camera_from_world,
            ndc_from_world,
            screen_center,
            screen_width,
        } = self.camera;
        ImageCamera {
            camera_from_world,
            ndc_from_world,
            screen_center,
            screen_width,
        }
    }
}
