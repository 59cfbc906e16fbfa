//! Images of textures. Their uses are collected first; then each image is decoded once, in
//! parallel.

use super::super::description::set_image;
use super::super::pixels::{of_size, pick};
use super::buffers::Buffers;
use super::document::Document;
use super::json::Json;
use super::uri::{self, Target};
use crate::image::{Transfer, decode_alpha, decode_image};
use crate::read::read_regular;
use manylight::ids::TextureId;
use manylight::image::Image;
use manylight::texture::Texture;
use rayon::prelude::*;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// What a texture takes from an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Content {
    /// Colors, stored with the sRGB curve.
    Color,
    /// The three channels as they are stored.
    Raw,
    /// One channel as it is stored.
    Channel(usize),
    /// Opacity.
    Opacity,
    /// 1 - opacity · `factor`: roughness from glossiness.
    OneMinusOpacity {
        /// Factor of the opacity.
        factor: f32,
    },
}

/// The textures that use each image.
#[derive(Default)]
pub(super) struct ImageUses {
    /// Image, content, texture.
    uses: Vec<(usize, Content, TextureId)>,
}

/// The bytes of an image file, and a path that says its format.
struct Source<'b> {
    bytes: Cow<'b, [u8]>,
    path: PathBuf,
}

impl ImageUses {
    pub(super) fn add(&mut self, image: usize, content: Content, texture: TextureId) {
        self.uses.push((image, content, texture));
    }

    /// Decodes all images that are used, and stores them in `textures`.
    pub(super) fn load(
        self,
        document: &Document<'_>,
        buffers: &Buffers<'_>,
        folder: &Path,
        textures: &mut [Texture],
    ) {
        let mut images: Vec<usize> = self.uses.iter().map(|(image, ..)| *image).collect();
        images.sort_unstable();
        images.dedup();
        let sources: Vec<(usize, Source<'_>)> = images
            .into_iter()
            .filter_map(|i| Some((i, source(&document.images[i], document, buffers, folder)?)))
            .collect();
        let decoded: Vec<_> = sources
            .par_iter()
            .map(|(i, source)| {
                let uses = self.uses.iter().filter(|(image, ..)| image == i);
                decode_uses(
                    source,
                    uses.map(|(_, content, texture)| (*content, *texture)),
                )
            })
            .collect();
        for ((i, _), images) in sources.iter().zip(decoded) {
            match images {
                Ok(images) => {
                    for (texture, image) in images {
                        set_image(textures, texture, image);
                    }
                }
                Err(message) => document.images[*i].error(message),
            }
        }
    }
}

/// The file of an image.
fn source<'b>(
    json: &Json<'_>,
    document: &Document<'_>,
    buffers: &'b Buffers<'_>,
    folder: &Path,
) -> Option<Source<'b>> {
    if let Some(text) = json.string("uri") {
        let at = json.get("uri")?;
        return match uri::target(&at, text, folder, "image")? {
            Target::Data(bytes) => Some(Source {
                bytes: bytes.into(),
                path: PathBuf::from("embedded image"),
            }),
            Target::File(path) => match read_regular(&path) {
                Ok(bytes) => {
                    json.reporter().note_read(&path);
                    Some(Source {
                        bytes: bytes.into(),
                        path,
                    })
                }
                Err(error) => {
                    let message = format!("`{}` cannot be read: {error}", path.display());
                    json.reporter().file_error(at.path(), &message, None);
                    None
                }
            },
        };
    }
    if !json.has("bufferView") {
        json.error("the image has neither a `uri` nor a `bufferView`");
        return None;
    }
    let view = json.index("bufferView", "bufferViews", document.views.len())?;
    Some(Source {
        bytes: buffers.view(view)?.bytes.into(),
        path: PathBuf::from("embedded image"),
    })
}

/// The images of all uses of one file.
fn decode_uses(
    source: &Source<'_>,
    uses: impl Iterator<Item = (Content, TextureId)>,
) -> Result<Vec<(TextureId, Image)>, String> {
    let mut decoded = Decoded {
        source,
        color: None,
        raw: None,
        opacity: None,
    };
    uses.map(|(content, texture)| Ok((texture, decoded.image(content)?)))
        .collect()
}

/// The forms of an image that have been decoded.
struct Decoded<'s> {
    source: &'s Source<'s>,
    color: Option<Image>,
    raw: Option<Image>,
    opacity: Option<Image>,
}

impl Decoded<'_> {
    fn image(&mut self, content: Content) -> Result<Image, String> {
        match content {
            Content::Color => Ok(self.color(Transfer::Srgb)?.clone()),
            Content::Raw => Ok(self.color(Transfer::Raw)?.clone()),
            Content::Channel(index) => Ok(channel(self.color(Transfer::Raw)?, index)),
            Content::Opacity => Ok(self.opacity()?.clone()),
            Content::OneMinusOpacity { factor } => {
                Ok(mapped(self.opacity()?, |a| 1.0 - a * factor))
            }
        }
    }

    fn color(&mut self, transfer: Transfer) -> Result<&Image, String> {
        let slot = match transfer {
            Transfer::Raw => &mut self.raw,
            _ => &mut self.color,
        };
        if let Some(image) = slot {
            return Ok(image);
        }
        let source = self.source;
        let image = decode_image(&source.bytes, &source.path, transfer);
        Ok(slot.insert(image.map_err(|error| error.to_string())?))
    }

    fn opacity(&mut self) -> Result<&Image, String> {
        if self.opacity.is_none() {
            let image = decode_alpha(&self.source.bytes, &self.source.path);
            self.opacity = Some(image.map_err(|error| error.to_string())?);
        }
        Ok(self.opacity.get_or_insert_default())
    }
}

/// One channel of an image; the only one of a gray image.
fn channel(image: &Image, index: usize) -> Image {
    pick(image, &[if image.channels < 3 { 0 } else { index }])
}

fn mapped(image: &Image, map: impl Fn(f32) -> f32) -> Image {
    let mapped = image.data.iter().map(|v| map(*v));
    of_size(image, image.channels, mapped.collect())
}
