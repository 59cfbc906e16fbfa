//! Packets of tev's protocol (its header `Ipc.h`; the Python package `tevclient` writes the same
//! bytes).
//!
//! A packet begins with its length in bytes, itself included, as `u32`, and its type as `u8`.
//! Numbers are little-endian, texts end with a zero byte.

use crate::picture::Picture;
use manylight_io::image::ImageLayer;

/// Type of the packet that creates an image, or replaces one of the same name.
const CREATE_IMAGE: u8 = 4;

/// Type of the packet that sets pixels of some channels, with an offset and a stride for each.
const UPDATE_IMAGE_V3: u8 = 6;

/// Edge of the tiles of an update, in pixels. tev shows a tile when its packet is complete.
const TILE_SIZE: usize = 128;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rectangle {
    pub(crate) x: usize,
    pub(crate) y: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// Names and values of all channels of `picture`, in the order of its layers.
fn channels(picture: &Picture) -> impl Iterator<Item = &(String, Vec<f32>)> {
    picture
        .layers
        .iter()
        .flat_map(|layer: &ImageLayer| &layer.channels)
}

/// Names of all channels of `picture`.
pub(crate) fn channel_names(picture: &Picture) -> Vec<String> {
    channels(picture).map(|(name, _)| name.clone()).collect()
}

/// The packet that creates an image with the size and the channels of `picture`, and selects it.
pub(crate) fn create_image(name: &str, picture: &Picture) -> Vec<u8> {
    let names = channel_names(picture);
    let mut packet = Packet::new(CREATE_IMAGE);
    packet.flag(true);
    packet.text(name);
    packet.integer(picture.width);
    packet.integer(picture.height);
    packet.integer(names.len());
    for name in &names {
        packet.text(name);
    }
    packet.complete()
}

/// The tiles of a picture, row by row.
pub(crate) fn tiles(width: usize, height: usize) -> impl Iterator<Item = Rectangle> {
    let starts = |length: usize| (0..length).step_by(TILE_SIZE);
    let tile = move |x: usize, y: usize| Rectangle {
        x,
        y,
        width: TILE_SIZE.min(width - x),
        height: TILE_SIZE.min(height - y),
    };
    starts(height).flat_map(move |y| starts(width).map(move |x| tile(x, y)))
}

/// The packet that sets the pixels of all channels within `tile`. The values of a pixel stand
/// together: the offset of a channel is its index, its stride the number of channels.
pub(crate) fn update_image(name: &str, picture: &Picture, tile: Rectangle) -> Vec<u8> {
    let channels: Vec<_> = channels(picture).collect();
    let count = channels.len();
    let mut packet = Packet::new(UPDATE_IMAGE_V3);
    packet.flag(false);
    packet.text(name);
    packet.integer(count);
    for (name, _) in &channels {
        packet.text(name);
    }
    for value in [tile.x, tile.y, tile.width, tile.height] {
        packet.integer(value);
    }
    for offset in 0..count {
        packet.long(offset);
    }
    for _ in 0..count {
        packet.long(count);
    }
    packet.0.reserve(4 * count * tile.width * tile.height);
    for y in tile.y..tile.y + tile.height {
        let row = y * picture.width;
        for i in row + tile.x..row + tile.x + tile.width {
            for (_, values) in &channels {
                packet.0.extend(values[i].to_le_bytes());
            }
        }
    }
    packet.complete()
}

/// A packet under construction.
struct Packet(Vec<u8>);

impl Packet {
    /// A packet with room for its length.
    fn new(kind: u8) -> Self {
        Packet(vec![0, 0, 0, 0, kind])
    }

    fn flag(&mut self, value: bool) {
        self.0.push(value.into());
    }

    /// Zero bytes in `text` would end it; they are left out.
    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|&byte| byte != 0));
        self.0.push(0);
    }

    /// An `i32`. Image sizes and numbers of channels are far below its limit.
    fn integer(&mut self, value: usize) {
        self.0.extend((value as i32).to_le_bytes());
    }

    /// An `i64`.
    fn long(&mut self, value: usize) {
        self.0.extend((value as i64).to_le_bytes());
    }

    fn complete(mut self) -> Vec<u8> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::testing::picture;

    #[test]
    fn tiles_cover_the_picture_once() {
        for (width, height) in [(1, 1), (128, 128), (129, 300), (640, 360)] {
            let mut hits = vec![0; width * height];
            for tile in tiles(width, height) {
                assert!(tile.width.max(tile.height) <= TILE_SIZE);
                for y in tile.y..tile.y + tile.height {
                    for x in tile.x..tile.x + tile.width {
                        hits[y * width + x] += 1;
                    }
                }
            }
            assert!(hits.iter().all(|&n| n == 1), "{width} x {height}");
        }
    }

    /// The bytes of `tevclient` 1.0.4: `packet.create_image("a", 2, 1, ["R", "depth.Z"])` and
    /// `packet.update_image("a", numpy.array([[[0, 1000], [1, 1001]]]) + 0.125, ["R", "depth.Z"])`.
    #[test]
    fn packets_are_those_of_tevclient() {
        let mut picture = picture(2, 1, 1);
        let depth = picture.layers.pop().unwrap();
        picture.layers.truncate(1);
        picture.layers[0].channels.truncate(1);
        picture.layers.push(depth);
        picture.layers[1].channels[0].1 = vec![1000.125, 1001.125];
        assert_eq!(
            hex(&create_image("a", &picture)),
            "1e00000004016100020000000100000002000000520064657074682e5a00"
        );
        let tile = tiles(2, 1).next().unwrap();
        assert_eq!(
            hex(&update_image("a", &picture, tile)),
            "560000000600610002000000520064657074682e5a00000000000000000002000000010000000000000000000000\
             0100000000000000020000000000000002000000000000000000003e00087a440000903f00487a44"
        );
    }

    fn hex(bytes: &[u8]) -> String {
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
