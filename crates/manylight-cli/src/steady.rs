//! Frames of a walkthrough in image files, averaged in time.

use crate::failure::Failure;
use crate::picture::{
    RGB, derived_image, layers_without_light, metadata_without_noise, picture_layer, picture_name,
    planes,
};
use manylight::image::Image;
use manylight::math::{Mat4, Vec3, Vec4};
use manylight_denoise::WalkFrame;
use manylight_io::image::{LayeredImage, full_name, last_part};
use manylight_io::shown_path;
use std::path::Path;

/// The layer of surface points, in this program and in Blender.
const POSITIONS: [&str; 2] = ["position", "Position"];
/// Name of the metadata with the frames that a picture is made of.
const FRAMES: &str = "steady.frames";

/// The frame in `image`, read from `path`.
///
/// # Errors
/// The image has no picture, no layer of positions, or no camera.
pub(crate) fn walk_frame(path: &Path, image: &LayeredImage) -> Result<WalkFrame, Failure> {
    let lacks = |what: &str| {
        Failure::usage(
            format!("{} has no {what}", shown_path(path)),
            "expected exr files of `manylight render --cameras` or --frames, with --aov position",
        )
    };
    let name = picture_name(image);
    let picture = planes(image, name).ok_or_else(|| lacks("picture"))?;
    let positions = positions(image).ok_or_else(|| lacks("layer of positions"))?;
    let camera = image.camera.ok_or_else(|| lacks("camera"))?;
    let alpha = image.channel(&full_name(name, "A"));
    let surface = |i: usize| {
        let alpha = alpha.map_or(1.0, |alpha| alpha[i]);
        let [x, y, z] = positions.map(|plane| plane[i]);
        let position = Vec3::new(x, y, z) / alpha;
        position.is_finite().then_some(position)
    };
    let radiance = Image {
        width: image.width,
        height: image.height,
        channels: 3,
        data: (0..image.width * image.height)
            .flat_map(|i| picture.map(|plane| plane[i]))
            .collect(),
    };
    let surfaces = (0..image.width * image.height).map(surface).collect();
    let film_from_world = Mat4::from_cols_array(&camera.ndc_from_world);
    let pixels_from_world = pixels_from_film(image) * film_from_world;
    Ok(WalkFrame::new(&radiance, surfaces, pixels_from_world))
}

/// The image with `picture` in the place of its picture. Layers of light and noise are left out.
/// `frames` says in the metadata which frames were averaged.
pub(crate) fn steadied(image: &LayeredImage, picture: &Image, frames: String) -> LayeredImage {
    let plane = |c: usize| picture.data.iter().skip(c).step_by(3).copied().collect();
    let planes = (0..RGB.len()).map(plane).collect();
    let mut layers = vec![picture_layer(image, planes)];
    layers.extend(layers_without_light(image));
    let mut metadata = metadata_without_noise(image);
    metadata.push((FRAMES.to_owned(), frames));
    derived_image(image, layers, metadata)
}

fn positions(image: &LayeredImage) -> Option<[&[f32]; 3]> {
    let mut names = image.layers.iter().map(|layer| layer.name.as_str());
    let layer = names.find(|name| POSITIONS.contains(&last_part(name)))?;
    let [x, y, z] = ["X", "Y", "Z"].map(|channel| image.channel(&full_name(layer, channel)));
    Some([x?, y?, z?])
}

/// From the film, of which (1, 1) is the lower right corner, to pixels of `image`.
fn pixels_from_film(image: &LayeredImage) -> Mat4 {
    let whole = ([image.width, image.height], [0, 0]);
    let ([width, height], [x, y]) =
        (image.window).map_or(whole, |window| (window.full_size, window.offset));
    Mat4::from_cols(
        Vec4::new(width as f32, 0.0, 0.0, 0.0),
        Vec4::new(0.0, height as f32, 0.0, 0.0),
        Vec4::Z,
        Vec4::new(-(x as f32), -(y as f32), 0.0, 1.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight_io::image::{ImageCamera, ImageLayer, ImageWindow};

    /// A picture of two pixels, the second of which has no surface.
    fn image() -> LayeredImage {
        let layer = |name: &str, channels: &[&str], value: f32| ImageLayer {
            name: name.to_owned(),
            channels: (channels.iter())
                .map(|channel| (full_name(name, channel), vec![value, 0.0]))
                .collect(),
        };
        LayeredImage {
            width: 2,
            height: 1,
            layers: vec![
                layer("", &["R", "G", "B", "A"], 0.5),
                layer("error", RGB, 0.1),
                layer("direct", RGB, 0.2),
                layer("position", &["X", "Y", "Z"], 1.5),
            ],
            metadata: [
                ("scene", "a.xml"),
                ("error", "0.1"),
                ("error.at_most", "0.2"),
            ]
            .map(|(name, value)| (name.to_owned(), value.to_owned()))
            .to_vec(),
            camera: Some(ImageCamera {
                camera_from_world: Mat4::IDENTITY.to_cols_array(),
                ndc_from_world: Mat4::IDENTITY.to_cols_array(),
                screen_center: [0.0; 2],
                screen_width: 1.0,
            }),
            ..LayeredImage::default()
        }
    }

    #[test]
    fn a_picture_keeps_what_light_does_not_change() {
        let image = image();
        let picture = Image {
            data: vec![2.0; 6],
            ..Image::new(2, 1, 3)
        };
        let steady = steadied(&image, &picture, "1..3".into());
        let names: Vec<&str> = steady.layers.iter().map(|l| l.name.as_str()).collect();
        assert_eq!(names, ["", "position"]);
        assert_eq!(steady.channel("G").unwrap(), [2.0, 2.0]);
        assert_eq!(steady.channel("A").unwrap(), [0.5, 0.0]);
        assert_eq!(steady.metadata_value(FRAMES), Some("1..3"));
        assert_eq!(steady.metadata_value("scene"), Some("a.xml"));
        assert_eq!(steady.metadata_value("error.at_most"), None);
        assert_eq!(steady.camera, image.camera);
    }

    #[test]
    fn pixels_of_a_crop_are_counted_from_its_corner() {
        let window = Some(ImageWindow {
            full_size: [40, 20],
            offset: [10, 5],
        });
        let crop = LayeredImage { window, ..image() };
        let at = pixels_from_film(&crop) * Vec4::new(0.5, 0.5, 0.0, 1.0);
        assert_eq!([at.x, at.y, at.w], [10.0, 5.0, 1.0]);
    }

    #[test]
    fn pictures_without_positions_or_camera_are_refused() {
        let message = |image: &LayeredImage| {
            let failure = walk_frame(Path::new("a.exr"), image).unwrap_err();
            assert_eq!(failure.exit_code(), 2);
            failure.to_string()
        };
        assert!(walk_frame(Path::new("a.exr"), &image()).is_ok());
        let mut other = image();
        other.layers.truncate(3);
        assert!(message(&other).contains("no layer of positions"));
        let other = LayeredImage {
            camera: None,
            ..image()
        };
        assert!(message(&other).contains("no camera"));
        assert!(message(&LayeredImage::default()).contains("no picture"));
    }
}
