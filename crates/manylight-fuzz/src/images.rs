//! Images.

use crate::folder::with_file;
use crate::messages::check_file_error;
use manylight::image::Image;
use manylight_io::image::{Transfer, read_alpha, read_image, read_layered_image};

/// Reads an image file called `name` in every way.
pub(crate) fn check(input: &[u8], name: &str) {
    with_file(input, name, |path| {
        match read_image(path, Transfer::Auto) {
            Ok(image) => {
                check_image(&image);
                assert!(
                    matches!(image.channels, 1 | 3),
                    "{} channels",
                    image.channels
                );
            }
            Err(error) => check_file_error(&error),
        }
        match read_alpha(path) {
            Ok(image) => {
                check_image(&image);
                assert_eq!(image.channels, 1);
            }
            Err(error) => check_file_error(&error),
        }
        match read_layered_image(path) {
            Ok(image) => {
                let channels = image.layers.iter().flat_map(|layer| &layer.channels);
                for (name, values) in channels {
                    assert_eq!(values.len(), image.width * image.height, "channel {name}");
                }
            }
            Err(error) => check_file_error(&error),
        }
    });
}

fn check_image(image: &Image) {
    let samples = image.width * image.height * image.channels;
    assert_eq!(image.data.len(), samples);
    assert!(samples > 0, "an image without pixels");
}
