//! The header of a part file.

use super::FORMAT;
use super::array_file::Kind;
use manylight::film::blocks::BLOCK_STEP;
use manylight::film::{Film, FilmDesc, Filter, IdLayer, Layer};
use manylight::math::UVec2;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::num::NonZeroU32;

/// Part files.
pub(super) const PART: Kind = Kind {
    key: "manylight.part",
    format: FORMAT,
    name: "a part of a render",
};

/// What a part file says about its sums. See the [module](super).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartHeader {
    /// Version of the layout.
    pub format: u32,
    /// What decides about the bits of the render.
    pub render: Map<String, Value>,
    /// The film.
    pub film: PartFilm,
    /// What a resumed render continues with.
    pub state: Value,
    /// What image files say about the render.
    pub picture: Value,
}

/// Size and layers of a film.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartFilm {
    /// Full size in pixels.
    pub size: [u32; 2],
    /// Upper left corner of the crop window, in pixels.
    pub crop_offset: [u32; 2],
    /// Size of the crop window, in pixels.
    pub crop_size: [u32; 2],
    /// Names of the layers, the beauty first.
    pub layers: Vec<String>,
    /// Names of the id layers.
    pub id_layers: Vec<String>,
    /// Passes of a block.
    pub block: NonZeroU32,
}

impl PartHeader {
    /// The header of a part of `film`.
    pub fn new(film: &Film, render: Map<String, Value>, state: Value, picture: Value) -> Self {
        PartHeader {
            format: FORMAT,
            render,
            film: PartFilm::of(film),
            state,
            picture,
        }
    }
}

impl PartFilm {
    fn of(film: &Film) -> Self {
        let desc = film.desc();
        PartFilm {
            size: desc.size.to_array(),
            crop_offset: desc.crop_offset.to_array(),
            crop_size: desc.crop_size.to_array(),
            layers: film
                .layers()
                .iter()
                .map(|layer| layer.array_name().into())
                .collect(),
            id_layers: film
                .id_layers()
                .iter()
                .map(|layer| layer.array_name().into())
                .collect(),
            block: film.block(),
        }
    }

    /// An empty film of this size and these layers. Its filter, which no sum depends on, is the
    /// box.
    ///
    /// # Errors
    /// What is wrong with the size or the layers.
    pub(super) fn film(&self) -> Result<Film, String> {
        let [size, offset, crop] =
            [self.size, self.crop_offset, self.crop_size].map(UVec2::from_array);
        let fits = (0..2).all(|i| {
            crop[i] > 0 && u64::from(offset[i]) + u64::from(crop[i]) <= u64::from(size[i])
        });
        if !fits {
            return Err(format!(
                "found a window of {crop} pixels at {offset} in {size} pixels, expected one inside"
            ));
        }
        let layers = known(&self.layers, Layer::from_array_name)?;
        let id_layers = known(&self.id_layers, IdLayer::from_array_name)?;
        let repeats = |k: usize| layers[..k].contains(&layers[k]);
        let repeats_id = |k: usize| id_layers[..k].contains(&id_layers[k]);
        if layers.first() != Some(&Layer::Beauty) || (0..layers.len()).any(repeats) {
            return Err(format!(
                "found the layers {}, expected distinct ones, beauty first",
                self.layers.join(", ")
            ));
        }
        if (0..id_layers.len()).any(repeats_id) {
            return Err(format!(
                "found the id layers {}, expected distinct ones",
                self.id_layers.join(", ")
            ));
        }
        let block = self.block.get();
        if !block.is_multiple_of(BLOCK_STEP) {
            return Err(format!(
                "found blocks of {block} passes, expected a multiple of {BLOCK_STEP}"
            ));
        }
        let desc = FilmDesc {
            size,
            crop_offset: offset,
            crop_size: crop,
            filter: Filter::Box,
        };
        Ok(Film::with_blocks(desc, &layers, &id_layers, self.block, 0))
    }
}

/// The layers of these names.
fn known<L>(names: &[String], find: impl Fn(&str) -> Option<L>) -> Result<Vec<L>, String> {
    let layer = |name: &String| {
        find(name)
            .ok_or_else(|| format!("found the layer {name}, which this version does not know"))
    };
    names.iter().map(layer).collect()
}
