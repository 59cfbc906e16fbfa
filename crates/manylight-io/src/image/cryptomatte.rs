//! Mattes by the names of objects and materials, as Cryptomatte layers.
//!
//! Source: Friedman and Jones, "Cryptomatte" (SIGGRAPH Talks 2015), and "Cryptomatte
//! Specification", version 1.2.0 (Psyop). A name is hashed by MurmurHash3_32, the hash is stored as
//! the bits of a float, and a pixel has ranks of pairs (id, coverage), the largest coverage first,
//! two pairs in each layer of four channels.

use super::layered::ImageLayer;
use manylight::film::RankedIds;
use serde_json::{Map, Value};
use std::collections::BTreeSet;

/// Layers of one matte: three, as most programs write.
const LAYERS: usize = 3;
/// Pairs of id and coverage in one layer.
const PAIRS: usize = 2;

/// The layers of a matte, and its metadata (name, value).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cryptomatte {
    /// `NAME00` to `NAME02`, with the channels r, g, b, a.
    pub layers: Vec<ImageLayer>,
    /// Name, hash, conversion, and the manifest: the names in the picture with their hashes.
    pub metadata: Vec<(String, String)>,
}

impl Cryptomatte {
    /// Number of channels.
    pub const CHANNELS: usize = 4 * LAYERS;

    /// The matte with the name `typename`, such as `CryptoObject`. `names` are the names by id,
    /// `pixels` the ids of every pixel with the fraction that each covers, the largest first. The
    /// stored fractions of a pixel do not exceed 1 in sum.
    pub fn new(typename: &str, names: &[String], pixels: &[RankedIds]) -> Self {
        let ids: Vec<f32> = names.iter().map(|name| id_of(name)).collect();
        let ranks = |pixel: &RankedIds| -> [(f32, f32); LAYERS * PAIRS] {
            let mut left = 1.0;
            std::array::from_fn(|rank| match pixel.get(rank) {
                Some(&(id, coverage)) => (ids[id as usize], take(coverage, &mut left)),
                None => (0.0, 0.0),
            })
        };
        let ranked: Vec<_> = pixels.iter().map(ranks).collect();
        let layer = |index: usize| {
            let name = format!("{typename}{index:02}");
            let channel = |(c, suffix): (usize, &str)| {
                let values = ranked.iter().map(|ranks| {
                    let (id, coverage) = ranks[index * PAIRS + c / 2];
                    if c % 2 == 0 { id } else { coverage }
                });
                (format!("{name}.{suffix}"), values.collect())
            };
            ImageLayer {
                channels: ["r", "g", "b", "a"]
                    .into_iter()
                    .enumerate()
                    .map(channel)
                    .collect(),
                name,
            }
        };
        Cryptomatte {
            layers: (0..LAYERS).map(layer).collect(),
            metadata: metadata(typename, names, pixels),
        }
    }
}

/// At most `left` of `coverage`, which is subtracted from `left`: sums of rounded fractions may
/// exceed 1.
fn take(coverage: f32, left: &mut f64) -> f32 {
    let mut taken = coverage.min(*left as f32);
    if f64::from(taken) > *left {
        taken = taken.next_down();
    }
    *left -= f64::from(taken);
    taken
}

fn metadata(typename: &str, names: &[String], pixels: &[RankedIds]) -> Vec<(String, String)> {
    let visible: BTreeSet<&str> = pixels
        .iter()
        .flatten()
        .map(|&(id, _)| names[id as usize].as_str())
        .collect();
    let entry = |name: &str| {
        let hash = format!("{:08x}", id_of(name).to_bits());
        (name.to_owned(), Value::String(hash))
    };
    let manifest: Map<String, Value> = visible.into_iter().map(entry).collect();
    let key = &format!("{:08x}", murmur3(typename.as_bytes()))[..7];
    let values = [
        ("name", typename.to_owned()),
        ("hash", "MurmurHash3_32".to_owned()),
        ("conversion", "uint32_to_float32".to_owned()),
        ("manifest", Value::Object(manifest).to_string()),
    ];
    values
        .map(|(name, value)| (format!("cryptomatte/{key}/{name}"), value))
        .to_vec()
}

/// The id of a name: its hash as the bits of a float. Where these would be a denormal, an infinity
/// or a NaN, the lowest bit of the exponent is changed, as the specification prescribes.
fn id_of(name: &str) -> f32 {
    let hash = murmur3(name.as_bytes());
    let exponent = (hash >> 23) & 255;
    let is_ordinary = (1..255).contains(&exponent);
    f32::from_bits(if is_ordinary { hash } else { hash ^ (1 << 23) })
}

/// MurmurHash3_x86_32 with seed 0, by Austin Appleby.
fn murmur3(bytes: &[u8]) -> u32 {
    let scrambled = |block: u32| {
        let rotated = block.wrapping_mul(0xcc9e_2d51).rotate_left(15);
        rotated.wrapping_mul(0x1b87_3593)
    };
    let little_endian =
        |bytes: &[u8]| (bytes.iter().rev()).fold(0, |word: u32, &byte| word << 8 | u32::from(byte));
    let mut chunks = bytes.chunks_exact(4);
    let mut hash = chunks.by_ref().fold(0_u32, |hash, chunk| {
        let mixed = (hash ^ scrambled(little_endian(chunk))).rotate_left(13);
        mixed.wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    hash ^= scrambled(little_endian(chunks.remainder()));
    hash ^= bytes.len() as u32;
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    hash ^ (hash >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_other_programs() {
        // Blender 5.0.1 writes these into the manifests and attribute names of its files.
        for (name, hash) in [
            ("Cube", 0xa8fc_e865),
            ("Light", 0xc77d_43e5),
            ("object", 0x055e_c73d),
            ("World", 0x8940_8cc1),
            ("Material", 0x3913_209d),
            ("default_surface", 0x78d0_5529),
        ] {
            assert_eq!(id_of(name).to_bits(), hash, "{name}");
        }
        for (name, key) in [("CryptoObject", 0x0542_cafa), ("CryptoAsset", 0x0aa2_1542)] {
            let hash = murmur3(format!("ViewLayer.{name}").as_bytes());
            assert_eq!(hash >> 4, key, "{name}");
        }
    }

    #[test]
    fn ids_are_ordinary_floats() {
        let mut changed = 0;
        for i in 0..2000 {
            let name = format!("name {i}");
            let id = id_of(&name);
            assert!(id.is_normal(), "{name}");
            changed += u32::from(id.to_bits() != murmur3(name.as_bytes()));
        }
        // 2 of 256 exponents.
        assert!((4..40).contains(&changed), "{changed}");
    }

    #[test]
    fn pixels_have_ranks() {
        let names = ["wall", "lamp", "cup"].map(str::to_owned);
        let pixels: [RankedIds; 2] = [vec![(2, 0.75), (0, 0.25)], vec![]];
        let matte = Cryptomatte::new("CryptoObject", &names, &pixels);
        let layers: Vec<&str> = matte
            .layers
            .iter()
            .map(|layer| layer.name.as_str())
            .collect();
        assert_eq!(
            layers,
            ["CryptoObject00", "CryptoObject01", "CryptoObject02"]
        );
        let values: Vec<&[f32]> = (matte.layers[0].channels)
            .iter()
            .map(|(_, values)| values.as_slice())
            .collect();
        let [cup, wall] = [id_of("cup"), id_of("wall")];
        assert_eq!(values, [[cup, 0.0], [0.75, 0.0], [wall, 0.0], [0.25, 0.0]]);
        assert_eq!(matte.layers[0].channels[3].0, "CryptoObject00.a");
        let (name, manifest) = &matte.metadata[3];
        assert_eq!(name.len(), "cryptomatte/0123456/manifest".len());
        let hash = |name| format!("{:08x}", id_of(name).to_bits());
        let expected = format!(r#"{{"cup":"{}","wall":"{}"}}"#, hash("cup"), hash("wall"));
        assert_eq!(*manifest, expected);
    }

    #[test]
    fn coverage_never_exceeds_one() {
        let names: Vec<String> = (0..7).map(|i| i.to_string()).collect();
        for parts in 1..8_u32 {
            let pixel: RankedIds = (0..parts)
                .map(|id| (id, 1.000_001 / parts as f32))
                .collect();
            let matte = Cryptomatte::new("CryptoObject", &names, &[pixel]);
            let coverages = matte.layers.iter().flat_map(|layer| {
                let channels = &layer.channels;
                [f64::from(channels[1].1[0]), f64::from(channels[3].1[0])]
            });
            let sum: f64 = coverages.sum();
            let expected = f64::from(parts.min(6)) / f64::from(parts);
            assert!(
                sum <= 1.0 && (sum - expected).abs() < 2e-6,
                "{parts}: {sum}"
            );
        }
    }
}
