//! Decoding: channels, transfer functions, damaged files.

use super::super::*;
use super::layered_image;
use crate::testing::mutations;
use std::fs;

fn png(color: ::image::ExtendedColorType, bytes: &[u8], width: u32) -> Vec<u8> {
    use ::image::ImageEncoder;
    let mut file = Vec::new();
    ::image::codecs::png::PngEncoder::new(&mut file)
        .write_image(bytes, width, 1, color)
        .unwrap();
    file
}

fn decoded(bytes: &[u8], transfer: Transfer) -> Result<Image, String> {
    decode(bytes, Path::new("f"), transfer)
        .map_err(|fault| fault.in_file(Path::new("f")).to_string())
}

#[test]
fn radiance_files_are_known_by_either_signature() {
    let rest = b"\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x10\x20\x30\x82";
    let [program, format] = [b"#?RADIANCE".as_slice(), b"#?RGBE"]
        .map(|signature| decoded(&[signature, rest].concat(), Transfer::Auto).unwrap());
    assert_eq!(program, format);
    assert_eq!(format.data, [1.0, 1.0, 1.0, 0.25, 0.5, 0.75]);
}

#[test]
fn integers_are_srgb_and_alpha_is_dropped() {
    use ::image::ExtendedColorType as Color;
    let rgba = decoded(
        &png(Color::Rgba8, &[255, 128, 0, 128, 10, 20, 30, 255], 2),
        Transfer::Auto,
    )
    .unwrap();
    assert_eq!((rgba.width, rgba.height, rgba.channels), (2, 1, 3));
    let expected = [
        1.0,
        0.215_860_5,
        0.0,
        0.003_035_27,
        0.006_995_41,
        0.012_983_03,
    ];
    assert!(
        rgba.data
            .iter()
            .zip(expected)
            .all(|(a, e): (&f32, f32)| (a - e).abs() < 1e-6),
        "{:?}",
        rgba.data
    );
    let gray = decoded(&png(Color::La8, &[51, 7], 1), Transfer::Raw).unwrap();
    assert_eq!(
        gray,
        Image {
            width: 1,
            height: 1,
            channels: 1,
            data: vec![0.2]
        }
    );
    let precise = decoded(&png(Color::L16, &13107_u16.to_ne_bytes(), 1), Transfer::Raw).unwrap();
    assert_eq!(precise.data, [0.2]);
    let squared = decoded(&png(Color::L8, &[51], 1), Transfer::Gamma(2.0)).unwrap();
    assert!((squared.data[0] - 0.04).abs() < 1e-7);
    let srgb16 = decoded(
        &png(Color::L16, &32896_u16.to_ne_bytes(), 1),
        Transfer::Auto,
    )
    .unwrap();
    assert!((srgb16.data[0] - 0.215_860_5).abs() < 1e-6);
}

#[test]
fn the_curve_of_srgb_runs_both_ways() {
    for i in 0..=255 {
        let v = i as f32 / 255.0;
        assert!((transfer::srgb_from_linear(transfer::linear_from_srgb(v)) - v).abs() < 1e-6);
    }
}

#[test]
fn jpeg_is_gray_or_rgb() {
    let encode = |color, bytes: &[u8]| {
        let mut file = Vec::new();
        ::image::codecs::jpeg::JpegEncoder::new_with_quality(&mut file, 100)
            .encode(bytes, 8, 8, color)
            .unwrap();
        decoded(&file, Transfer::Raw).unwrap()
    };
    let gray = encode(::image::ExtendedColorType::L8, &[51; 64]);
    assert_eq!(
        gray,
        Image {
            width: 8,
            height: 8,
            channels: 1,
            data: vec![0.2; 64]
        }
    );
    let color = encode(::image::ExtendedColorType::Rgb8, &[200, 100, 50].repeat(64));
    assert_eq!((color.width, color.height, color.channels), (8, 8, 3));
    assert!(
        color
            .pixel(3, 5)
            .iter()
            .zip([200.0, 100.0, 50.0_f32])
            .all(|(a, e)| (a * 255.0 - e).abs() < 1.5),
        "{:?}",
        color.pixel(3, 5)
    );
}

#[test]
fn tga_is_known_by_its_extension() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tga");
    // Uncompressed RGB, 1 x 1, 24 bits, stored blue first.
    fs::write(
        &path,
        [
            0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0, 0, 51, 255,
        ],
    )
    .unwrap();
    assert_eq!(
        read_image(&path, Transfer::Raw).unwrap().data,
        [1.0, 0.2, 0.0]
    );
}

#[test]
fn exr_files_with_unusual_channels() {
    let image_of = |names: &[&str]| {
        let channels = names
            .iter()
            .enumerate()
            .map(|(i, n)| ((*n).to_owned(), vec![i as f32]))
            .collect();
        decoded(
            &exr_file::encode(&LayeredImage::from_channels(1, 1, channels)).unwrap(),
            Transfer::Auto,
        )
    };
    assert_eq!(
        image_of(&["R", "G", "B", "A"]).unwrap().data,
        [0.0, 1.0, 2.0]
    );
    assert_eq!(image_of(&["A", "Y"]).unwrap().data, [1.0]);
    assert_eq!(
        image_of(&["Combined.R", "Combined.G", "Combined.B"])
            .unwrap()
            .data,
        [0.0, 1.0, 2.0]
    );
    // The image of Blender's file, not the first of its layers.
    let names = [
        "AO.R",
        "AO.G",
        "AO.B",
        "Combined.R",
        "Combined.G",
        "Combined.B",
    ];
    let names = names.map(|name| format!("ViewLayer.{name}"));
    let image = image_of(&names.each_ref().map(String::as_str));
    assert_eq!(image.unwrap().data, [3.0, 4.0, 5.0]);
    assert_eq!(image_of(&["height"]).unwrap().data, [0.0]);
    assert_eq!(
        image_of(&["U", "V"]).unwrap_err(),
        "f: expected the channels R, G, B or Y, found U, V"
    );
}

#[test]
fn half_precision_tiles_are_read() {
    use exr::prelude::*;
    let values: Vec<f16> = (0..35).map(|i| f16::from_f32(i as f32 * 0.5)).collect();
    let channels = AnyChannels::sort(
        ["B", "G", "R"]
            .map(|name| AnyChannel::new(name, FlatSamples::F16(values.clone())))
            .into_iter()
            .collect(),
    );
    let encoding = Encoding {
        compression: Compression::PIZ,
        blocks: Blocks::Tiles(Vec2(4, 4)),
        line_order: LineOrder::Increasing,
    };
    let part = exr::image::Layer::new((7, 5), LayerAttributes::default(), encoding, channels);
    let mut file = std::io::Cursor::new(Vec::new());
    exr::image::Image::from_layer(part)
        .write()
        .to_buffered(&mut file)
        .unwrap();
    let image = decoded(file.get_ref(), Transfer::Auto).unwrap();
    assert_eq!(image.pixel(6, 4), [17.0; 3]);
    assert_eq!(image.pixel(0, 1), [3.5; 3]);
}

#[test]
fn broken_images_are_errors() {
    assert_eq!(
        decoded(b"hello", Transfer::Auto).unwrap_err(),
        "f: unknown image format; expected PNG, JPEG, WebP, TGA, BMP, HDR, EXR or PFM"
    );
    assert_eq!(
        decoded(b"PF 2 2 -1.0\nabc", Transfer::Auto).unwrap_err(),
        "f: the file ends at byte 15, before the end of 2 x 2 pixels of 3 values"
    );
    assert_eq!(
        decoded(b"PF 2 x -1.0\nabc", Transfer::Auto).unwrap_err(),
        "f: expected the width or height of a PFM image, found 'x'"
    );
    assert_eq!(
        decoded(b"PF 2 2", Transfer::Auto).unwrap_err(),
        "f: the file ends before the end of the header of a PFM image"
    );
    let whole = png(::image::ExtendedColorType::L8, &[1; 64], 64);
    assert!(
        decoded(&whole[..50], Transfer::Auto)
            .unwrap_err()
            .starts_with("f: the image cannot be decoded: ")
    );
    let exr = exr_file::encode(&layered_image()).unwrap();
    assert!(
        decoded(&exr[..exr.len() - 9], Transfer::Auto)
            .unwrap_err()
            .starts_with("f: the EXR image cannot be decoded: ")
    );
}

#[test]
fn exr_chunks_end_within_the_file() {
    let mut bytes = exr_file::encode(&layered_image()).unwrap();
    // The image has one chunk, which follows its entry in the table of chunks.
    let start = (8..bytes.len())
        .find(|&at| bytes[at - 8..at] == (at as u64).to_le_bytes())
        .unwrap();
    let rest = bytes.len() - start - 8;
    let size = &mut bytes[start + 4..start + 8];
    assert_eq!(*size, (rest as i32).to_le_bytes());
    size.copy_from_slice(&i32::MAX.to_le_bytes());
    assert_eq!(
        decoded(&bytes, Transfer::Auto).unwrap_err(),
        format!(
            "f: the EXR image cannot be decoded: the chunk at byte {start} declares 2147483647 bytes, more than the {rest} that follow"
        )
    );
}

#[test]
fn random_damage_never_panics() {
    let pfm = b"PF\n2 1\n-1.0\n012345678901234567890123".to_vec();
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x10\x20\x30\x82"
        .to_vec();
    let exr = exr_file::encode(&layered_image()).unwrap();
    let seeds = [
        (pfm, 3000),
        (hdr, 1000),
        (exr, 600),
        (png(::image::ExtendedColorType::L8, &[1, 2], 2), 1000),
    ];
    for (seed, count) in seeds {
        assert!(decoded(&seed, Transfer::Auto).is_ok());
        for bytes in mutations(&seed, count) {
            if let Ok(image) = decoded(&bytes, Transfer::Auto) {
                assert_eq!(
                    image.data.len(),
                    image.width * image.height * image.channels
                );
            }
        }
    }
}

#[test]
fn big_endian_pfm_rows_run_from_bottom_to_top() {
    let big_endian = b"Pf 1 2 1.0\n\x3F\x80\0\0\x40\0\0\0";
    assert_eq!(
        decoded(big_endian, Transfer::Auto).unwrap(),
        Image {
            width: 1,
            height: 2,
            channels: 1,
            data: vec![2.0, 1.0]
        }
    );
}

/// An EXR file with these channels of 2 x 2 pixels, and chromaticities.
fn exr_with(channels: &[(&str, &[f32])], chromaticities: Option<[[f32; 2]; 4]>) -> Vec<u8> {
    use exr::image::write::WritableImage;
    use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
    use exr::meta::attribute::Chromaticities;
    use exr::meta::header::{ImageAttributes, LayerAttributes};
    use exr::prelude::{IntegerBounds, Vec2};
    let channels = channels
        .iter()
        .map(|(name, values)| AnyChannel::new(*name, FlatSamples::F32(values.to_vec())));
    let size = Vec2(2, 2);
    let layer = Layer::new(
        size,
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(channels.collect()),
    );
    let mut attributes = ImageAttributes::new(IntegerBounds::from_dimensions(size));
    attributes.chromaticities = chromaticities.map(|c| {
        let [red, green, blue, white] = c.map(|[x, y]| Vec2(x, y));
        Chromaticities {
            red,
            green,
            blue,
            white,
        }
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = exr::image::Image::empty(attributes).with_layer(layer);
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

const ACESCG: [[f32; 2]; 4] = [
    [0.713, 0.293],
    [0.165, 0.83],
    [0.128, 0.044],
    [0.321_68, 0.337_67],
];

fn first_pixel(bytes: &[u8], transfer: Transfer) -> Vec<f32> {
    decoded(bytes, transfer).unwrap().data[..3].to_vec()
}

#[test]
fn exr_colors_become_linear_rec_709() {
    let close = |found: &[f32], expected: [f32; 3]| {
        let pairs = found.iter().zip(expected);
        pairs.into_iter().all(|(a, b)| (a - b).abs() < 2e-3)
    };
    let rgb = |value: [f32; 3], space| {
        let [r, g, b] = value.map(|v| [v; 4]);
        exr_with(&[("B", &b), ("G", &g), ("R", &r)], space)
    };
    let gray = rgb([0.5; 3], Some(ACESCG));
    assert!(close(&first_pixel(&gray, Transfer::Auto), [0.5; 3]));
    // The first column of the ACES project's matrix.
    let red = rgb([1.0, 0.0, 0.0], Some(ACESCG));
    let found = first_pixel(&red, Transfer::Auto);
    assert!(close(&found, [1.705, -0.130, -0.024]), "{found:?}");
    assert_eq!(first_pixel(&red, Transfer::Raw), [1.0, 0.0, 0.0]);
    let flat = rgb([0.5; 3], Some([[0.3, 0.3]; 4]));
    let error = decoded(&flat, Transfer::Auto).unwrap_err();
    assert!(error.contains("chromaticities of the EXR file"), "{error}");

    // R = 1.5 Y, B = 0.5 Y, and G from the luminance.
    let (y, ry, by) = (0.4, 0.5, -0.5);
    let g = (y - 0.2126 * 0.6 - 0.0722 * 0.2) / 0.7152;
    let (ry, by) = ([ry; 4], [by; 4]);
    let file = exr_with(&[("BY", &by), ("RY", &ry), ("Y", &[y; 4])], None);
    let found = first_pixel(&file, Transfer::Auto);
    assert!(close(&found, [0.6, g, 0.2]), "{found:?}");
    // The white of Rec. 709 in CIE coordinates.
    let (x, z) = (0.95046, 1.08906);
    let file = exr_with(&[("X", &[x; 4]), ("Y", &[1.0; 4]), ("Z", &[z; 4])], None);
    assert!(close(&first_pixel(&file, Transfer::Auto), [1.0; 3]));
}

#[test]
fn newer_compressions_of_exr_are_named() {
    let mut bytes = exr_with(&[("Y", &[1.0; 4])], None);
    let name = b"compression\0compression\0\x01\0\0\0";
    let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len();
    for newer in [10, 11, 12, 13] {
        bytes[at] = newer;
        let error = decoded(&bytes, Transfer::Auto).unwrap_err();
        assert!(error.contains("OpenEXR 3.4"), "{newer}: {error}");
    }
}
