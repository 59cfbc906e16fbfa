//! Round trips, and errors of writing.

use super::super::*;
use super::{beauty_image, layered_image};
use crate::file_error::FileErrorKind;
use std::fs;

#[test]
fn exr_keeps_every_channel_and_all_metadata() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let image = layered_image();
    write_image(&path, &image, 3.0).unwrap();
    let read = read_layered_image(&path).unwrap();
    assert_eq!((read.width, read.height), (3, 2));
    for (name, values) in image.layers.iter().flat_map(|l| &l.channels) {
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
    for (name, value) in &image.metadata {
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
    write_image(&path, &layered_image(), 3.0).unwrap();
    let image = read_image(&path, Transfer::Auto).unwrap();
    assert_eq!((image.width, image.height, image.channels), (3, 2, 3));
    assert_eq!(image.pixel(1, 0), [3.0, 4.0, 5.0].map(|v| v * 0.37 - 0.2));
}

#[test]
fn radiance_files_keep_values_to_their_precision() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdr");
    let value = |i: usize, c: usize| {
        (1.0 + i as f32) * 3_f32.powi(c as i32 - 1) * if i == 3 { 1000.0 } else { 1.0 }
    };
    write_image(&path, &beauty_image(9, 2, value), 3.0).unwrap();
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
fn display_formats_apply_exposure_and_the_srgb_curve() {
    let folder = tempfile::tempdir().unwrap();
    let values = [0.0, 0.001, 0.25, f32::NAN, 7.0, -1.0];
    let image = beauty_image(6, 1, |i, _| values[i] * 0.5);
    for (name, tolerance) in [("a.png", 0), ("a.jpg", 12)] {
        let path = folder.path().join(name);
        write_image(&path, &image, 1.0).unwrap();
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
fn errors_name_the_target_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("no/a.png");
    let expected = format!(
        "{}: cannot be written: the folder does not exist",
        path.display()
    );
    assert_eq!(check_writable(&path).unwrap_err().to_string(), expected);
    let image = beauty_image(1, 1, |_, _| 1.0);
    assert_eq!(
        write_image(&path, &image, 0.0).unwrap_err().to_string(),
        expected
    );
}

#[test]
fn invalid_images_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let message = |name: &str, image: &LayeredImage| {
        write_image(&folder.path().join(name), image, 0.0)
            .unwrap_err()
            .message
    };
    assert_eq!(
        message("a.exr", &LayeredImage::default()),
        "the image has no pixels; expected at least one"
    );
    assert_eq!(
        message(
            "a.exr",
            &LayeredImage {
                width: 1,
                height: 1,
                ..LayeredImage::default()
            }
        ),
        "the image has no channels; expected at least one"
    );
    let twice =
        LayeredImage::from_channels(1, 1, vec![("R".into(), vec![0.0]), ("R".into(), vec![0.0])]);
    assert_eq!(
        message("a.exr", &twice),
        "two channels have the name R; expected distinct names"
    );
    let short = LayeredImage::from_channels(2, 1, vec![("R".into(), vec![0.0])]);
    assert_eq!(
        message("a.exr", &short),
        "the channel R has 1 values, expected 2, the number of pixels"
    );
    let depth = LayeredImage::from_channels(1, 1, vec![("depth.Z".into(), vec![0.0])]);
    assert_eq!(
        message("a.png", &depth),
        "the image has no channels R, G, B or Y, which this format requires; use .exr for other channels"
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn check_writable_finds_errors_without_writing() {
    let folder = tempfile::tempdir().unwrap();
    check_writable(&folder.path().join("new.exr")).unwrap();
    let unknown = check_writable(&folder.path().join("a.bmp")).unwrap_err();
    assert!(matches!(unknown.kind, FileErrorKind::UnknownFormat));
    assert_eq!(
        unknown.message,
        "found the extension '.bmp', expected .exr, .png, .jpg, .hdr or .pfm"
    );
    assert_eq!(
        check_writable(Path::new("image")).unwrap_err().message,
        "found no extension, expected .exr, .png, .jpg, .hdr or .pfm"
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
    write_image(&path, &layered_image(), 0.0).unwrap();
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
    write_image(&link, &layered_image(), 0.0).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert!(fs::metadata(&file).unwrap().len() > 0);
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&file), mode(&plain));
}

#[test]
fn exr_keeps_the_place_of_a_crop_and_the_camera() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let window = ImageWindow {
        full_size: [30, 20],
        offset: [7, 18],
    };
    let matrix = |first: f32| std::array::from_fn(|i| first + i as f32);
    let image = LayeredImage {
        window: Some(window),
        camera: Some(ImageCamera {
            camera_from_world: matrix(1.0),
            ndc_from_world: matrix(100.0),
            screen_center: [0.25, -0.5],
            screen_width: 1.5,
        }),
        ..layered_image()
    };
    write_image(&path, &image, 0.0).unwrap();
    let read = read_layered_image(&path).unwrap();
    assert_eq!((read.width, read.height, read.window), (3, 2, Some(window)));
    assert_eq!(read.camera, image.camera);
    let file = fs::File::open(&path).unwrap();
    let meta =
        exr::meta::MetaData::read_from_buffered(std::io::BufReader::new(file), true).unwrap();
    let header = &meta.headers[0];
    let attributes = &header.own_attributes;
    assert_eq!(attributes.world_to_camera, Some(matrix(1.0)));
    assert_eq!(attributes.world_to_normalized_device, Some(matrix(100.0)));
    assert_eq!(attributes.screen_window_width, 1.5);
    let display = header.shared_attributes.display_window;
    assert_eq!(
        (display.position.0, display.size.0, display.size.1),
        (0, 30, 20)
    );
}

#[test]
fn png_is_tagged_and_says_where_it_comes_from() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    write_image(&path, &layered_image(), 0.0).unwrap();
    let file = std::io::BufReader::new(fs::File::open(&path).unwrap());
    let reader = png::Decoder::new(file).read_info().unwrap();
    let info = reader.info();
    assert_eq!(info.srgb, Some(png::SrgbRenderingIntent::Perceptual));
    let text = |keyword: &str| {
        let chunk = info.utf8_text.iter().find(|chunk| chunk.keyword == keyword);
        chunk.map(|chunk| chunk.get_text().unwrap())
    };
    assert_eq!(text("Software").as_deref(), Some("manylight"));
    assert_eq!(text("scene").as_deref(), Some("Küche λ.xml"));
    assert_eq!(text("command"), None);
}

#[test]
fn gray_pictures_have_views() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let image = LayeredImage::from_channels(2, 1, vec![("Y".into(), vec![0.18, 2.0])]);
    let agx = DisplayTransform {
        exposure_ev: 0.0,
        view: View::Agx,
    };
    write_image(&path, &image, agx).unwrap();
    let read = read_image(&path, Transfer::Raw).unwrap();
    assert_eq!(read.channels, 1);
    for (found, expected) in read.data.iter().zip([0.4613, 0.8518]) {
        assert!((found - expected).abs() < 0.003, "{found}");
    }
}
