//! Round trips, pinned values, damaged files.

use super::*;
use crate::file_error::FileErrorKind;
use crate::fuzz::mutations;
use std::fs;

/// Values that no 8 bit format can hold, different in every pixel and channel.
fn picture() -> Picture {
    let plane = |c: usize| {
        (0..6)
            .map(|i| (i * 3 + c) as f32 * 0.37 - 0.2)
            .collect::<Vec<f32>>()
    };
    let channel = |name: &str, c: usize| (name.to_owned(), plane(c));
    let layers = vec![
        Layer {
            name: String::new(),
            channels: vec![channel("R", 0), channel("G", 1), channel("B", 2)],
        },
        Layer {
            name: "variance".into(),
            channels: vec![channel("variance.R", 3), channel("variance.G", 4)],
        },
        Layer {
            name: "depth".into(),
            channels: vec![(
                "depth.Z".into(),
                vec![1e30, 0.0, -1.0, 1.0 / 3.0, 1e-30, f32::INFINITY],
            )],
        },
    ];
    let metadata = [
        ("software", "manylight"),
        ("scene", "Küche λ.xml"),
        ("comments", "none"),
        ("empty", ""),
    ];
    Picture {
        width: 3,
        height: 2,
        layers,
        metadata: metadata.map(|(n, v)| (n.to_owned(), v.to_owned())).to_vec(),
    }
}

fn beauty_picture(width: usize, height: usize, value: impl Fn(usize, usize) -> f32) -> Picture {
    let plane = |c: usize| (0..width * height).map(|i| value(i, c)).collect();
    Picture::from_channels(
        width,
        height,
        vec![
            ("R".into(), plane(0)),
            ("G".into(), plane(1)),
            ("B".into(), plane(2)),
        ],
    )
}

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
fn exr_keeps_every_channel_and_all_metadata() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let picture = picture();
    write_image(&path, &picture, 3.0).unwrap();
    let read = read_picture(&path).unwrap();
    assert_eq!((read.width, read.height), (3, 2));
    for (name, values) in picture.layers.iter().flat_map(|l| &l.channels) {
        assert_eq!(read.channel(name), Some(values.as_slice()), "{name}");
    }
    assert_eq!(
        read.layers.iter().map(|l| l.channels.len()).sum::<usize>(),
        6
    );
    assert_eq!(
        read.layers
            .iter()
            .find(|l| l.name == "variance")
            .unwrap()
            .channels
            .len(),
        2
    );
    for (name, value) in &picture.metadata {
        assert_eq!(read.metadata_value(name), Some(value.as_str()), "{name}");
    }
    let image = read_image(&path, Transfer::Auto).unwrap();
    assert_eq!(
        image.pixel(2, 1),
        [15.0, 16.0, 17.0].map(|v| v * 0.37 - 0.2)
    );
}

#[test]
fn pfm_keeps_every_value() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pfm");
    write_image(&path, &picture(), 3.0).unwrap();
    let image = read_image(&path, Transfer::Auto).unwrap();
    assert_eq!((image.width, image.height, image.channels), (3, 2, 3));
    assert_eq!(image.pixel(1, 0), [3.0, 4.0, 5.0].map(|v| v * 0.37 - 0.2));
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

#[test]
fn radiance_files_keep_values_to_their_precision() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdr");
    let value = |i: usize, c: usize| {
        (1.0 + i as f32) * 3_f32.powi(c as i32 - 1) * if i == 3 { 1000.0 } else { 1.0 }
    };
    write_image(&path, &beauty_picture(9, 2, value), 3.0).unwrap();
    let image = read_image(&path, Transfer::Auto).unwrap();
    for i in 0..18 {
        let pixel = image.pixel(i % 9, i / 9);
        let largest = value(i, 2);
        assert!(
            (0..3).all(|c| (pixel[c] - value(i, c)).abs() <= largest / 128.0),
            "{i}: {pixel:?}"
        );
    }
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
fn display_formats_apply_exposure_and_the_srgb_curve() {
    let folder = tempfile::tempdir().unwrap();
    let values = [0.0, 0.001, 0.25, f32::NAN, 7.0, -1.0];
    let picture = beauty_picture(6, 1, |i, _| values[i] * 0.5);
    for (name, tolerance) in [("a.png", 0), ("a.jpg", 12)] {
        let path = folder.path().join(name);
        write_image(&path, &picture, 1.0).unwrap();
        let bytes = ::image::open(&path).unwrap().into_rgb8();
        // 0.25 is 0.537 on the sRGB curve, 0.001 is on its straight part.
        for (pixel, expected) in bytes.pixels().zip([0, 3, 137, 0, 255, 0_u8]) {
            assert!(
                pixel.0.iter().all(|v| v.abs_diff(expected) <= tolerance),
                "{name}: {pixel:?} is not {expected}"
            );
        }
    }
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
            &exr_file::encode(&Picture::from_channels(1, 1, channels)).unwrap(),
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
        "f: not an image of a known format: expected PNG, JPEG, TGA, BMP, HDR, EXR or PFM"
    );
    assert_eq!(
        decoded(b"PF 2 2 -1.0\nabc", Transfer::Auto).unwrap_err(),
        "f: the file ends at byte 15, too early for 2 x 2 pixels of 3 values"
    );
    assert_eq!(
        decoded(b"PF 2 x -1.0\nabc", Transfer::Auto).unwrap_err(),
        "f: 'x' is not a size of a PFM image"
    );
    assert_eq!(
        decoded(b"PF 2 2", Transfer::Auto).unwrap_err(),
        "f: the file ends within the header of a PFM image"
    );
    let whole = png(::image::ExtendedColorType::L8, &[1; 64], 64);
    assert!(
        decoded(&whole[..50], Transfer::Auto)
            .unwrap_err()
            .starts_with("f: the image cannot be decoded: ")
    );
    let exr = exr_file::encode(&picture()).unwrap();
    assert!(
        decoded(&exr[..exr.len() - 9], Transfer::Auto)
            .unwrap_err()
            .starts_with("f: the EXR image cannot be decoded: ")
    );
}

#[test]
fn random_damage_never_panics() {
    let pfm = b"PF\n2 1\n-1.0\n012345678901234567890123".to_vec();
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x10\x20\x30\x82"
        .to_vec();
    let exr = exr_file::encode(&picture()).unwrap();
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
fn unwritable_files_are_called_by_their_own_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("no/a.png");
    let expected = format!(
        "{}: cannot be written: the folder does not exist",
        path.display()
    );
    assert_eq!(check_writable(&path).unwrap_err().to_string(), expected);
    let picture = beauty_picture(1, 1, |_, _| 1.0);
    assert_eq!(
        write_image(&path, &picture, 0.0).unwrap_err().to_string(),
        expected
    );
}

#[test]
fn pictures_that_cannot_be_written_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let message = |name: &str, picture: &Picture| {
        write_image(&folder.path().join(name), picture, 0.0)
            .unwrap_err()
            .message
    };
    assert_eq!(
        message("a.exr", &Picture::default()),
        "an image without pixels cannot be written"
    );
    assert_eq!(
        message(
            "a.exr",
            &Picture {
                width: 1,
                height: 1,
                ..Picture::default()
            }
        ),
        "an image without channels cannot be written"
    );
    let twice =
        Picture::from_channels(1, 1, vec![("R".into(), vec![0.0]), ("R".into(), vec![0.0])]);
    assert_eq!(message("a.exr", &twice), "there are two channels R");
    let short = Picture::from_channels(2, 1, vec![("R".into(), vec![0.0])]);
    assert_eq!(
        message("a.exr", &short),
        "the channel R has 1 values, the image 2 pixels"
    );
    let depth = Picture::from_channels(1, 1, vec![("depth.Z".into(), vec![0.0])]);
    assert_eq!(
        message("a.png", &depth),
        "this format needs the channels R, G, B or Y"
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn writability_is_known_beforehand() {
    let folder = tempfile::tempdir().unwrap();
    check_writable(&folder.path().join("new.exr")).unwrap();
    let unknown = check_writable(&folder.path().join("a.bmp")).unwrap_err();
    assert!(matches!(unknown.kind, FileErrorKind::UnknownFormat));
    assert_eq!(
        unknown.message,
        "found the extension '.bmp'; images are written as .exr, .png, .jpg, .hdr or .pfm"
    );
    assert_eq!(
        check_writable(Path::new("image")).unwrap_err().message,
        "found no extension; images are written as .exr, .png, .jpg, .hdr or .pfm"
    );
    let missing = check_writable(&folder.path().join("no/such/folder/a.exr")).unwrap_err();
    assert!(matches!(missing.kind, FileErrorKind::Unwritable(_)));
    fs::create_dir(folder.path().join("folder.exr")).unwrap();
    assert!(check_writable(&folder.path().join("folder.exr")).is_err());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn writing_replaces_the_file_and_leaves_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    fs::write(&path, "old").unwrap();
    write_image(&path, &picture(), 0.0).unwrap();
    assert_eq!(read_image(&path, Transfer::Auto).unwrap().width, 3);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[cfg(unix)]
#[test]
fn new_files_have_ordinary_permissions_and_links_survive() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let (file, link, plain) = (
        folder.path().join("a.pfm"),
        folder.path().join("link.pfm"),
        folder.path().join("plain"),
    );
    fs::write(&plain, "").unwrap();
    fs::write(&file, "").unwrap();
    symlink(&file, &link).unwrap();
    write_image(&link, &picture(), 0.0).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert!(fs::metadata(&file).unwrap().len() > 0);
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&file), mode(&plain));
}
