//! Pages to look at pictures against a reference, in any browser; nothing comes from elsewhere.
//!
//! The page is made where it is seen: `page.js` finds the groups of pictures as JSON, and their pixels as half floats in base64: in the
//! page itself, or in files beside it that are loaded when they are looked at.

use crate::compare::{Comparison, Frame};
use crate::document::Block;
use crate::failure::Failure;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use half::f16;
use manylight_io::FileError;
use manylight_io::image::write_file;
use serde::Serialize;
use std::path::Path;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Pictures of the same thing.
#[derive(Debug, Serialize)]
pub(crate) struct Group {
    title: String,
    width: usize,
    height: usize,
    figures: Vec<Figure>,
    /// The reference is the last.
    images: Vec<Shown>,
    /// File of the pixels; without one, these are in here.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
}

/// A column of the table of a group.
#[derive(Clone, Copy, Debug, Serialize)]
struct Figure {
    name: &'static str,
    less_is_better: bool,
    #[serde(skip)]
    of: fn(&Comparison) -> Option<f64>,
}

/// One picture.
#[derive(Debug, Serialize)]
struct Shown {
    name: String,
    /// By heading; empty for the reference.
    figures: Vec<Option<f64>>,
    #[serde(flatten)]
    pixels: Option<Pixels>,
}

/// What is seen of a picture, in base64.
#[derive(Debug, Serialize)]
struct Pixels {
    /// Linear RGB as half floats in little endian.
    rgb: String,
    /// HDR-FLIP in bytes; none for the reference.
    flip: Option<String>,
}

const FIGURES: [Figure; 7] = [
    less("relMSE", |c| Some(c.errors.relmse)),
    less("MSE", |c| Some(c.errors.mse)),
    less("SMAPE", |c| Some(c.errors.smape)),
    less("HDR-FLIP", |c| Some(c.flip)),
    more("SSIM", |c| c.ssim),
    more("PSNR", |c| c.errors.psnr),
    less("blocks |z| > 3", |c| Some(c.blocks?.share_beyond_3)),
];

const fn less(name: &'static str, of: fn(&Comparison) -> Option<f64>) -> Figure {
    Figure {
        name,
        less_is_better: true,
        of,
    }
}

const fn more(name: &'static str, of: fn(&Comparison) -> Option<f64>) -> Figure {
    Figure {
        less_is_better: false,
        ..less(name, of)
    }
}

impl Group {
    /// Pictures with what was measured of each, and their reference with its name.
    pub(crate) fn new(
        title: String,
        images: &[Frame],
        comparisons: &[Comparison],
        (reference, reference_name): (&Frame, &str),
    ) -> Self {
        let known = |figure: &Figure| comparisons.iter().any(|c| (figure.of)(c).is_some());
        let figures: Vec<Figure> = FIGURES.into_iter().filter(known).collect();
        let shown = |(frame, comparison): (&Frame, &Comparison)| Shown {
            name: comparison.image.clone(),
            figures: figures
                .iter()
                .map(|figure| (figure.of)(comparison))
                .collect(),
            pixels: Some(Pixels {
                rgb: halves(frame),
                flip: Some(bytes(&comparison.flip_map)),
            }),
        };
        let mut all: Vec<Shown> = images.iter().zip(comparisons).map(shown).collect();
        all.push(Shown {
            name: reference_name.to_owned(),
            figures: Vec::new(),
            pixels: Some(Pixels {
                rgb: halves(reference),
                flip: None,
            }),
        });
        Group {
            title,
            width: reference.width,
            height: reference.height,
            figures,
            images: all,
            file: None,
        }
    }
}

/// A page with everything in it.
pub(crate) fn page(title: &str, groups: &[Group]) -> String {
    html(title, groups, &[])
}

/// Folder of the files of pixels, in that of the page.
const PIXELS: &str = "pixels";

/// Writes `index.html` with text below the pictures, and their pixels, to a folder that is made if it is not there.
pub(crate) fn write_pages(
    folder: &Path,
    title: &str,
    groups: impl IntoIterator<Item = Result<Group, Failure>>,
    text: &[Block],
) -> Result<(), Failure> {
    let pixels = folder.join(PIXELS);
    std::fs::create_dir_all(&pixels).map_err(|e| FileError::unwritable(&pixels, e))?;
    let mut listed = Vec::new();
    for (k, group) in groups.into_iter().enumerate() {
        let mut group = group?;
        let taken: Vec<_> = (group.images.iter_mut())
            .map(|image| image.pixels.take())
            .collect();
        // The page of a file may load scripts, and nothing else.
        let script = format!("manylight.put({k}, {});\n", serde_json::json!(taken));
        let name = format!("{k}.js");
        write_file(&pixels.join(&name), script.as_bytes())?;
        group.file = Some(format!("{PIXELS}/{name}"));
        listed.push(group);
    }
    let page = html(title, &listed, text);
    write_file(&folder.join("index.html"), page.as_bytes())?;
    Ok(())
}

fn html(title: &str, groups: &[Group], text: &[Block]) -> String {
    let data = serde_json::json!({
        "title": title,
        "version": env!("CARGO_PKG_VERSION"),
        "groups": groups,
        "text": text,
    });
    // So that no text can end the script.
    let data = data.to_string().replace('<', "\\u003c");
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>manylight</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <noscript>This page needs JavaScript.</noscript>\n\
         <script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>\n{SCRIPT}</script>\n</body>\n</html>\n"
    )
}

fn halves(frame: &Frame) -> String {
    let values = frame.rgb.iter().flatten();
    let halves: Vec<u8> = values
        .flat_map(|&v| f16::from_f32(v.clamp(f16::MIN.to_f32(), f16::MAX.to_f32())).to_le_bytes())
        .collect();
    STANDARD.encode(halves)
}

/// Of values in [0, 1].
fn bytes(values: &[f32]) -> String {
    let bytes: Vec<u8> = values.iter().map(|v| (v * 255.0).round() as u8).collect();
    STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{Correlation, compare};

    fn frame(value: f32) -> Frame {
        Frame {
            width: 2,
            height: 1,
            rgb: vec![[value, 0.5, 1e9], [f32::NAN, -1.0, 0.0]],
            variance: None,
            correlation: Correlation::None,
            emission: None,
        }
    }

    #[test]
    fn a_page_has_everything_in_it_and_no_way_out() {
        let (image, reference) = (frame(1.0), frame(2.0));
        let comparison = compare("</script><b>.exr".into(), &image, &reference);
        let group = Group::new(
            "title".into(),
            &[image],
            &[comparison],
            (&reference, "reference.exr"),
        );
        // Nothing is known of noise, and pictures are too small for SSIM.
        let names: Vec<_> = group.figures.iter().map(|f| f.name).collect();
        assert_eq!(names, ["relMSE", "MSE", "SMAPE", "HDR-FLIP", "PSNR"]);
        let page = page("pictures", &[group]);
        assert!(!page.contains("</script><b>"));
        // Nothing comes from elsewhere; this is but a name.
        let page = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!page.contains("http"));
        assert_eq!(page.matches("</script>").count(), 2);
    }

    #[test]
    fn pixels_may_be_beside_the_page() {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("new/page");
        let group = || {
            let (image, reference) = (frame(1.0), frame(2.0));
            let comparison = compare("own".into(), &image, &reference);
            let of = (&reference, "reference");
            Ok(Group::new("title".into(), &[image], &[comparison], of))
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
    fn pixels_are_halves() {
        let decoded = STANDARD.decode(super::halves(&frame(1.0))).unwrap();
        let halves: Vec<f32> = decoded
            .chunks_exact(2)
            .map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32())
            .collect();
        assert_eq!(halves[..3], [1.0, 0.5, 65504.0]);
        assert!(halves[3].is_nan());
        assert_eq!(bytes(&[0.0, 0.5, 1.0]), STANDARD.encode([0, 128, 255]));
    }
}
