//! Self-contained HTML pages to inspect images beside their reference.
//!
//! A page holds its data as JSON, and `page.js` builds the display from it in the browser, with
//! functions of `shared.js`. Pixels are half floats in base64, either in the page itself ([`page`])
//! or in files beside it that the browser loads on demand ([`write_pages`]).

use crate::compare::{Comparison, ComparisonImage};
use crate::document::DocumentPart;
use crate::error::LabError;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use half::f16;
use manylight_io::FileError;
use manylight_io::write_file;
use serde::Serialize;
use std::path::Path;

/// Style of pages with images.
pub const STYLE: &str = include_str!("page.css");
/// Functions of pages with images: elements, half floats, sRGB, pan and zoom.
pub const SHARED_SCRIPT: &str = include_str!("shared.js");
const SCRIPT: &str = include_str!("page.js");

/// Images of one scene with their common reference. In the JSON, metrics are called `figures`.
#[derive(Debug, Serialize)]
pub struct ImageGroup {
    title: String,
    /// Width in pixels.
    width: usize,
    /// Height in pixels.
    height: usize,
    #[serde(rename = "figures")]
    metrics: Vec<MetricColumn>,
    /// The images; the reference is the last one.
    images: Vec<ViewerImage>,
    /// Script file with the pixels; `None` if `images` holds them.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
}

/// A column of the table below the images.
#[derive(Clone, Copy, Debug, Serialize)]
struct MetricColumn {
    name: &'static str,
    less_is_better: bool,
    /// The value; `None` if it is not known.
    #[serde(skip)]
    value: fn(&Comparison) -> Option<f64>,
}

/// One image.
#[derive(Debug, Serialize)]
struct ViewerImage {
    name: String,
    /// One value per column; empty for the reference.
    #[serde(rename = "figures")]
    metrics: Vec<Option<f64>>,
    /// Whether it has error bars.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    has_bars: bool,
    #[serde(flatten)]
    pixels: Option<EncodedPixels>,
}

/// The pixels of an image, in base64.
#[derive(Debug, Serialize)]
struct EncodedPixels {
    /// Linear RGB values as little-endian half floats.
    rgb: String,
    /// HDR-FLIP of each pixel as one byte; `None` for the reference.
    flip: Option<String>,
    /// Error bars of the pixels, as `rgb`; `None` if they are not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    bars: Option<String>,
    /// The light groups, from which the page makes the picture with other lights.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    lights: Vec<EncodedLight>,
    /// What the groups add up to, where this is not `rgb`, in the same form.
    #[serde(skip_serializing_if = "Option::is_none")]
    sum: Option<String>,
}

/// A light group.
#[derive(Debug, Serialize)]
struct EncodedLight {
    name: String,
    /// As `rgb` of the image.
    rgb: String,
}

impl EncodedPixels {
    fn new(image: &ComparisonImage, flip: Option<&[f32]>) -> Self {
        let light = |(name, rgb): &(String, Vec<[f32; 3]>)| EncodedLight {
            name: name.clone(),
            rgb: pixel_halves(rgb),
        };
        EncodedPixels {
            rgb: pixel_halves(&image.rgb),
            flip: flip.map(bytes),
            bars: image.bars.as_ref().map(|bars| pixel_halves(&bars.pixels)),
            lights: image.light.groups.iter().map(light).collect(),
            sum: image.light.sum.as_deref().map(pixel_halves),
        }
    }
}

const METRICS: [MetricColumn; 7] = [
    lower_is_better("relMSE", |c| Some(c.errors.relmse)),
    lower_is_better("MSE", |c| Some(c.errors.mse)),
    lower_is_better("SMAPE", |c| Some(c.errors.smape)),
    lower_is_better("HDR-FLIP", |c| Some(c.flip)),
    higher_is_better("SSIM", |c| c.ssim),
    higher_is_better("PSNR", |c| c.errors.psnr),
    lower_is_better("blocks |z| > 3", |c| Some(c.blocks?.share_beyond_3)),
];

const fn lower_is_better(
    name: &'static str,
    value: fn(&Comparison) -> Option<f64>,
) -> MetricColumn {
    MetricColumn {
        name,
        less_is_better: true,
        value,
    }
}

const fn higher_is_better(
    name: &'static str,
    value: fn(&Comparison) -> Option<f64>,
) -> MetricColumn {
    MetricColumn {
        less_is_better: false,
        ..lower_is_better(name, value)
    }
}

impl ImageGroup {
    /// A group of images with their comparisons, in the same order, and the reference with its
    /// name.
    pub fn new(
        title: String,
        images: &[ComparisonImage],
        comparisons: &[Comparison],
        (reference, reference_name): (&ComparisonImage, &str),
    ) -> Self {
        let known = |metric: &MetricColumn| comparisons.iter().any(|c| (metric.value)(c).is_some());
        let metrics: Vec<MetricColumn> = METRICS.into_iter().filter(known).collect();
        let shown = |(image, comparison): (&ComparisonImage, &Comparison)| ViewerImage {
            name: comparison.image.clone(),
            metrics: metrics
                .iter()
                .map(|metric| (metric.value)(comparison))
                .collect(),
            has_bars: image.bars.is_some(),
            pixels: Some(EncodedPixels::new(image, Some(&comparison.flip_map))),
        };
        let mut all: Vec<ViewerImage> = images.iter().zip(comparisons).map(shown).collect();
        all.push(ViewerImage {
            name: reference_name.to_owned(),
            metrics: Vec::new(),
            has_bars: false,
            pixels: Some(EncodedPixels::new(reference, None)),
        });
        ImageGroup {
            title,
            width: reference.width,
            height: reference.height,
            metrics,
            images: all,
            file: None,
        }
    }
}

/// One HTML page that contains everything.
pub fn page(title: &str, groups: &[ImageGroup]) -> String {
    html(title, groups, &[])
}

/// Name of the folder with pixels, beside the page.
const PIXEL_FOLDER: &str = "pixels";

/// Writes `index.html`, with `text` below the images, and one script file of pixels per group to
/// `folder`, which is created if needed. Only one group is in memory at a time.
///
/// # Errors
/// The first error of `groups`, or a file that cannot be written.
pub fn write_pages(
    folder: &Path,
    title: &str,
    groups: impl IntoIterator<Item = Result<ImageGroup, LabError>>,
    text: &[DocumentPart],
) -> Result<(), LabError> {
    let pixels = folder.join(PIXEL_FOLDER);
    std::fs::create_dir_all(&pixels).map_err(|e| FileError::unwritable(&pixels, e))?;
    let mut listed = Vec::new();
    for (k, group) in groups.into_iter().enumerate() {
        let mut group = group?;
        let taken: Vec<_> = (group.images.iter_mut())
            .map(|image| image.pixels.take())
            .collect();
        // A page opened from a file may load scripts, but no other data.
        let script = format!("manylight.put({k}, {});\n", serde_json::json!(taken));
        let name = format!("{k}.js");
        write_file(&pixels.join(&name), script.as_bytes())?;
        group.file = Some(format!("{PIXEL_FOLDER}/{name}"));
        listed.push(group);
    }
    let page = html(title, &listed, text);
    write_file(&folder.join("index.html"), page.as_bytes())?;
    Ok(())
}

fn html(title: &str, groups: &[ImageGroup], text: &[DocumentPart]) -> String {
    let data = serde_json::json!({
        "title": title,
        "version": env!("CARGO_PKG_VERSION"),
        "groups": groups,
        "text": text,
    });
    // Escaped, so that no text can end the script element.
    let data = data.to_string().replace('<', "\\u003c");
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>manylight</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <noscript>This page needs JavaScript.</noscript>\n\
         <script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>\n{SHARED_SCRIPT}</script>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n"
    )
}

fn pixel_halves(rgb: &[[f32; 3]]) -> String {
    halves(rgb.as_flattened().iter().copied())
}

/// Values as little-endian half floats, clamped to their range, in base64.
pub fn halves(values: impl Iterator<Item = f32>) -> String {
    let range = [f16::MIN.to_f32(), f16::MAX.to_f32()];
    let halves: Vec<u8> = values
        .flat_map(|v| f16::from_f32(v.clamp(range[0], range[1])).to_le_bytes())
        .collect();
    STANDARD.encode(halves)
}

/// Values in [0, 1] as one byte each, in base64.
fn bytes(values: &[f32]) -> String {
    let bytes: Vec<u8> = values.iter().map(|v| (v * 255.0).round() as u8).collect();
    STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{ErrorBars, LightGroups, compare};

    fn frame(value: f32) -> ComparisonImage {
        let rgb = vec![[value, 0.5, 1e9], [f32::NAN, -1.0, 0.0]];
        ComparisonImage::from_rgb(2, 1, rgb)
    }

    #[test]
    fn a_page_is_self_contained() {
        let (image, reference) = (frame(1.0), frame(2.0));
        let comparison = compare("</script><b>.exr", &image, &reference);
        let group = ImageGroup::new(
            "title".into(),
            &[image],
            &[comparison],
            (&reference, "reference.exr"),
        );
        // The noise is unknown, and the images are too small for SSIM.
        let names: Vec<_> = group.metrics.iter().map(|f| f.name).collect();
        assert_eq!(names, ["relMSE", "MSE", "SMAPE", "HDR-FLIP", "PSNR"]);
        let page = page("pictures", &[group]);
        assert!(!page.contains("</script><b>"));
        // The page loads nothing from the network; the namespace of SVG is only a name.
        let page = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!page.contains("http"));
        assert_eq!(page.matches("</script>").count(), 3);
    }

    #[test]
    fn pixels_may_be_beside_the_page() {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("new/page");
        let group = || {
            let (image, reference) = (frame(1.0), frame(2.0));
            let comparison = compare("own", &image, &reference);
            let of = (&reference, "reference");
            Ok(ImageGroup::new("title".into(), &[image], &[comparison], of))
        };
        write_pages(&page, "pictures", [group(), group()], &[]).unwrap();
        let html = std::fs::read_to_string(page.join("index.html")).unwrap();
        assert!(html.contains("pixels/1.js") && !html.contains("\"rgb\""));
        let script = std::fs::read_to_string(page.join("pixels/1.js")).unwrap();
        assert!(
            script.starts_with("manylight.put(1, [{\"rgb\":"),
            "{script}"
        );
    }

    #[test]
    fn images_with_light_groups_have_their_pixels() {
        let mut image = frame(1.0);
        let pixels = |image: &ComparisonImage| serde_json::json!(EncodedPixels::new(image, None));
        assert_eq!(pixels(&image).get("lights"), None);
        let groups = vec![("key".to_owned(), vec![[0.5; 3]; 2])];
        let sum = Some(vec![[0.75; 3]; 2]);
        image.light = LightGroups { groups, sum };
        let half = halves([0.5; 6].into_iter());
        let lights = serde_json::json!([{"name": "key", "rgb": half}]);
        assert_eq!(pixels(&image)["lights"], lights);
        assert_eq!(pixels(&image)["sum"], halves([0.75; 6].into_iter()));
    }

    #[test]
    fn images_with_error_bars_have_those_of_pixels() {
        let mut image = frame(1.0);
        let bars = |value| vec![[value; 3]; 2];
        image.bars = Some(ErrorBars {
            pixels: bars(0.25),
            blocks: bars(0.5),
        });
        let pixels = serde_json::json!(EncodedPixels::new(&image, None));
        assert_eq!(pixels["bars"], halves([0.25; 6].into_iter()));
        let reference = frame(2.0);
        let comparison = compare("own", &image, &reference);
        let of = (&reference, "reference");
        let group = ImageGroup::new("title".into(), &[image], &[comparison], of);
        let group = serde_json::json!(group);
        assert_eq!(group["images"][0]["has_bars"], true);
        assert_eq!(group["images"][1].get("has_bars"), None);
    }

    #[test]
    fn pixels_are_halves() {
        let decoded = STANDARD.decode(pixel_halves(&frame(1.0).rgb)).unwrap();
        let halves: Vec<f32> = decoded
            .chunks_exact(2)
            .map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32())
            .collect();
        assert_eq!(halves[..3], [1.0, 0.5, 65504.0]);
        assert!(halves[3].is_nan());
        assert_eq!(bytes(&[0.0, 0.5, 1.0]), STANDARD.encode([0, 128, 255]));
    }
}
