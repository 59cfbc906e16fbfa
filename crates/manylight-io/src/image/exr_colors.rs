//! Colors of EXR files as linear Rec. 709.
//!
//! Primaries and the white point of a file are converted with the adaptation of Bradford, so that
//! gray stays gray, as color tools do. Luminance/chroma (`Y`, `RY`, `BY`) and CIE tristimulus
//! values (`X`, `Y`, `Z`) become `R`, `G`, `B`.
//!
//! Sources: "Technical Introduction to OpenEXR" (luminance/chroma images, chromaticities);
//! Lindbloom, "Chromatic Adaptation"; the identifiers of the Color Interop Forum.

use crate::file_error::Fault;
use exr::image::{AnyChannels, FlatSamples, Layer as Part};
use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::meta::header::ImageAttributes;
use exr::prelude::Vec2;
use glam::{DMat3, DVec3};

/// What to do with the color space of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Colors {
    /// Convert to linear Rec. 709.
    Converted,
    /// Leave the values as they are stored: they are no colors.
    Stored,
}

/// The attribute with an identifier of the Color Interop Forum for the color space, which OpenEXR
/// standardizes beside the chromaticities.
pub(super) const COLOR_INTEROP_ID: &str = "colorInteropID";

/// Primaries and white point of Rec. 709.
pub(super) const REC_709: Chromaticities =
    primaries([[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]]);

/// Color spaces by their identifiers in the attribute `colorInteropID`.
const IDENTIFIED: [(&str, Chromaticities); 5] = [
    (
        "lin_ap0_scene",
        primaries([
            [0.7347, 0.2653],
            [0.0, 1.0],
            [0.0001, -0.077],
            [0.32168, 0.33767],
        ]),
    ),
    (
        "lin_ap1_scene",
        primaries([
            [0.713, 0.293],
            [0.165, 0.83],
            [0.128, 0.044],
            [0.32168, 0.33767],
        ]),
    ),
    (
        "lin_p3d65_scene",
        primaries([[0.68, 0.32], [0.265, 0.69], [0.15, 0.06], [0.3127, 0.329]]),
    ),
    (
        "lin_rec2020_scene",
        primaries([
            [0.708, 0.292],
            [0.17, 0.797],
            [0.131, 0.046],
            [0.3127, 0.329],
        ]),
    ),
    (
        "lin_adobergb_scene",
        primaries([[0.64, 0.33], [0.21, 0.71], [0.15, 0.06], [0.3127, 0.329]]),
    ),
];

/// Red, green, blue and white.
const fn primaries([red, green, blue, white]: [[f32; 2]; 4]) -> Chromaticities {
    Chromaticities {
        red: Vec2(red[0], red[1]),
        green: Vec2(green[0], green[1]),
        blue: Vec2(blue[0], blue[1]),
        white: Vec2(white[0], white[1]),
    }
}

/// The channels of a file by their names, all of one size.
pub(super) type Planes = Vec<(String, Vec<f32>)>;

/// The color space of a file.
pub(super) struct ColorSpace {
    /// From its colors to linear Rec. 709; `None` if they are.
    to_rec_709: Option<DMat3>,
    /// Luminances of red, green and blue, of sum 1.
    luminances: DVec3,
}

impl ColorSpace {
    /// The color space of a file with these attributes, of which `part` is the first part.
    ///
    /// # Errors
    /// The chromaticities are not those of a color space.
    pub(super) fn of(
        attributes: &ImageAttributes,
        part: &Part<AnyChannels<FlatSamples>>,
    ) -> Result<Self, Fault> {
        let found = attributes.chromaticities.or_else(|| {
            let mut other = part.attributes.other.iter();
            let (_, value) = other.find(|(name, _)| text(name) == COLOR_INTEROP_ID)?;
            let AttributeValue::Text(id) = value else {
                return None;
            };
            let id = text(id);
            let mut known = IDENTIFIED.iter();
            known.find(|(name, _)| *name == id).map(|(_, space)| *space)
        });
        let found = found.unwrap_or(REC_709);
        let xyz = xyz_of(&found).ok_or_else(|| {
            Fault::new(format!(
                "the chromaticities of the EXR file are not those of a color space: red {}, green {}, blue {}, white {}",
                shown(found.red), shown(found.green), shown(found.blue), shown(found.white),
            ))
        })?;
        let adapted = adaptation(white_of(&found), white_of(&REC_709)) * xyz;
        let to_rec_709 = from_xyz() * adapted;
        Ok(ColorSpace {
            to_rec_709: (!is_rec_709(&found)).then_some(to_rec_709),
            luminances: xyz.transpose().y_axis,
        })
    }

    /// Converts the image in `planes`: channels without a layer.
    pub(super) fn convert(&self, planes: &mut Planes, colors: Colors) {
        let index = |planes: &Planes, name: &str| planes.iter().position(|(n, _)| n == name);
        let three = |planes: &Planes, names: [&str; 3]| -> Option<[usize; 3]> {
            let [a, b, c] = names.map(|name| index(planes, name));
            Some([a?, b?, c?])
        };
        if let Some(rgb) = three(planes, ["R", "G", "B"]) {
            return self.convert_planes(planes, rgb, colors);
        }
        if let Some(at) = three(planes, ["RY", "Y", "BY"]) {
            for_each_pixel(planes, at, |chroma| self.rgb_of_chroma(chroma));
            rename(planes, at);
            return self.convert_planes(planes, at, colors);
        }
        if let Some(at) = three(planes, ["X", "Y", "Z"]) {
            if colors == Colors::Converted {
                for_each_pixel(planes, at, |xyz| from_xyz() * xyz);
            }
            rename(planes, at);
        }
    }

    /// Converts the three planes with these indices.
    fn convert_planes(&self, planes: &mut Planes, rgb: [usize; 3], colors: Colors) {
        if let (Some(matrix), Colors::Converted) = (self.to_rec_709, colors) {
            for_each_pixel(planes, rgb, |color| matrix * color);
        }
    }

    /// Converts the colors of an image of three channels.
    pub(super) fn convert_pixels(&self, data: &mut [f32]) {
        let Some(matrix) = self.to_rec_709 else {
            return;
        };
        for pixel in data.as_chunks_mut::<3>().0 {
            let color = matrix * DVec3::from(pixel.map(f64::from));
            *pixel = color.to_array().map(|v| v as f32);
        }
    }

    /// The color with `RY = (R - Y) / Y`, `Y`, `BY = (B - Y) / Y`.
    fn rgb_of_chroma(&self, chroma: DVec3) -> DVec3 {
        let (ry, y, by) = (chroma.x, chroma.y, chroma.z);
        let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
        let weights = self.luminances;
        let g = (y - r * weights.x - b * weights.z) / weights.y;
        // Chroma of few pixels and of half precision may lead to negative colors.
        DVec3::new(r, g, b).max(DVec3::ZERO)
    }
}

/// Replaces the values of three planes.
fn for_each_pixel(planes: &mut Planes, at: [usize; 3], map: impl Fn(DVec3) -> DVec3) {
    for i in 0..planes[at[0]].1.len() {
        let value = DVec3::from(at.map(|plane| f64::from(planes[plane].1[i])));
        for (plane, v) in at.into_iter().zip(map(value).to_array()) {
            planes[plane].1[i] = v as f32;
        }
    }
}

/// Names three planes `R`, `G`, `B`.
fn rename(planes: &mut Planes, at: [usize; 3]) {
    for (plane, name) in at.into_iter().zip(["R", "G", "B"]) {
        name.clone_into(&mut planes[plane].0);
    }
}

fn is_rec_709(found: &Chromaticities) -> bool {
    /// Largest difference of a coordinate: writers round, and some give D65 as (0.3127, 0.3291).
    const ROUNDING: f32 = 1e-3;
    let coordinates = |c: &Chromaticities| [c.red, c.green, c.blue, c.white];
    let pairs = coordinates(found).into_iter().zip(coordinates(&REC_709));
    pairs
        .into_iter()
        .all(|(a, b)| (a.x() - b.x()).abs() < ROUNDING && (a.y() - b.y()).abs() < ROUNDING)
}

/// XYZ of the white, of luminance 1.
fn white_of(space: &Chromaticities) -> DVec3 {
    tristimulus(space.white)
}

/// XYZ of the chromaticity, of luminance 1.
fn tristimulus(xy: Vec2<f32>) -> DVec3 {
    let (x, y) = (f64::from(xy.x()), f64::from(xy.y()));
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// The matrix from RGB to XYZ; `None` if there is none.
fn xyz_of(space: &Chromaticities) -> Option<DMat3> {
    let direction = |xy: Vec2<f32>| {
        let (x, y) = (f64::from(xy.x()), f64::from(xy.y()));
        DVec3::new(x, y, 1.0 - x - y)
    };
    let axes = DMat3::from_cols(
        direction(space.red),
        direction(space.green),
        direction(space.blue),
    );
    let white = white_of(space);
    if !white.is_finite() || axes.determinant().abs() < 1e-6 {
        return None;
    }
    let amounts = axes.inverse() * white;
    let matrix = axes * DMat3::from_diagonal(amounts);
    let luminances = matrix.transpose().y_axis;
    (matrix.determinant().abs() > 1e-6 && luminances.y > 1e-3).then_some(matrix)
}

/// From XYZ to linear Rec. 709.
fn from_xyz() -> DMat3 {
    xyz_of(&REC_709).unwrap_or_default().inverse()
}

/// The change of XYZ with which what is white under `from` becomes white under `to`.
fn adaptation(from: DVec3, to: DVec3) -> DMat3 {
    /// Bradford's cone responses, in rows.
    const ROWS: [f64; 9] = [
        0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296,
    ];
    let cones = DMat3::from_cols_array(&ROWS).transpose();
    let gains = (cones * to) / (cones * from);
    cones.inverse() * DMat3::from_diagonal(gains) * cones
}

/// The text of an attribute.
pub(super) fn text(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

fn shown(xy: Vec2<f32>) -> String {
    format!("({}, {})", xy.x(), xy.y())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gray_stays_gray_in_every_space() {
        for (name, space) in IDENTIFIED {
            let xyz = xyz_of(&space).unwrap();
            let matrix = from_xyz() * adaptation(white_of(&space), white_of(&REC_709)) * xyz;
            let white = matrix * DVec3::ONE;
            assert!(white.abs_diff_eq(DVec3::ONE, 1e-6), "{name}: {white}");
        }
        // The matrix from ACEScg to linear Rec. 709 of the ACES project, which adapts by CAT02 or
        // Bradford alike to two digits.
        let (_, acescg) = IDENTIFIED[1];
        let matrix = from_xyz()
            * adaptation(white_of(&acescg), white_of(&REC_709))
            * xyz_of(&acescg).unwrap();
        let red = matrix.x_axis;
        assert!(
            red.abs_diff_eq(DVec3::new(1.705, -0.130, -0.024), 2e-3),
            "{red}"
        );
    }
}
