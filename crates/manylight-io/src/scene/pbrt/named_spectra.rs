//! Spectra that PBRT v4 knows by name.

use crate::spectra::metal;
use manylight::color::Rgb;

/// A named spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NamedSpectrum {
    /// A color: a coefficient of a metal, or an illuminant of luminance 1.
    Color(Rgb),
    /// The index of refraction of a glass at 587.6 nm (the Fraunhofer line d).
    Glass(f32),
}

/// Metals of which the crate has eta and k.
const METALS: [&str; 6] = ["Ag", "Al", "Au", "Cu", "MgO", "TiO2"];

/// Brass (CuZn): eta and k at the primaries of Rec. 709. Source: Querry 1985, by way of
/// refractiveindex.info.
const BRASS: [[f32; 3]; 2] = [[0.444, 0.527, 1.094], [3.695, 2.765, 1.829]];

/// Glasses and their index of refraction n_d; F5, F10 and F11 are PBRT's names of SF5, SF10 and
/// SF11. Source: the data sheets of Schott.
const GLASSES: [(&str, f32); 7] = [
    ("glass-BK7", 1.516_8),
    ("glass-BAF10", 1.670_0),
    ("glass-FK51A", 1.486_6),
    ("glass-LASF9", 1.850_3),
    ("glass-F5", 1.672_7),
    ("glass-F10", 1.728_3),
    ("glass-F11", 1.784_7),
];

/// Illuminants with their CIE 1931 chromaticities (x, y). Source: CIE 015; fluorescent lamps: its
/// table of F1 to F12.
const ILLUMINANTS: [(&str, [f32; 2]); 16] = [
    ("stdillum-A", [0.447_57, 0.407_45]),
    ("stdillum-D50", [0.345_67, 0.358_50]),
    ("stdillum-D65", [0.312_71, 0.329_02]),
    ("stdillum-F1", [0.313_10, 0.337_27]),
    ("stdillum-F2", [0.372_08, 0.375_29]),
    ("stdillum-F3", [0.409_10, 0.394_30]),
    ("stdillum-F4", [0.440_18, 0.403_29]),
    ("stdillum-F5", [0.313_79, 0.345_31]),
    ("stdillum-F6", [0.377_90, 0.388_35]),
    ("stdillum-F7", [0.312_92, 0.329_33]),
    ("stdillum-F8", [0.345_88, 0.358_75]),
    ("stdillum-F9", [0.374_17, 0.372_81]),
    ("stdillum-F10", [0.346_09, 0.359_86]),
    ("stdillum-F11", [0.380_52, 0.377_13]),
    ("stdillum-F12", [0.436_95, 0.404_41]),
    ("illum-acesD60", [0.321_68, 0.337_67]),
];

/// The spectrum with this name.
pub(super) fn named_spectrum(name: &str) -> Option<NamedSpectrum> {
    if let Some((metal_name, part)) = name.strip_prefix("metal-").and_then(|n| n.rsplit_once('-')) {
        let (eta, k) = match metal_name {
            "CuZn" => (BRASS[0].into(), BRASS[1].into()),
            known if METALS.contains(&known) => metal(known)?,
            _ => return None,
        };
        return match part {
            "eta" => Some(NamedSpectrum::Color(eta)),
            "k" => Some(NamedSpectrum::Color(k)),
            _ => None,
        };
    }
    if let Some((_, eta)) = GLASSES.iter().find(|(glass, _)| *glass == name) {
        return Some(NamedSpectrum::Glass(*eta));
    }
    let found = ILLUMINANTS
        .iter()
        .find(|(illuminant, _)| *illuminant == name);
    found.map(|(_, xy)| NamedSpectrum::Color(of_chromaticity(*xy)))
}

/// All names.
pub(super) fn spectrum_names() -> Vec<String> {
    let metals = METALS.iter().chain(&["CuZn"]);
    let metals = metals.flat_map(|metal| ["eta", "k"].map(|part| format!("metal-{metal}-{part}")));
    let glasses = GLASSES.iter().map(|(name, _)| (*name).to_owned());
    let illuminants = ILLUMINANTS.iter().map(|(name, _)| (*name).to_owned());
    metals.chain(glasses).chain(illuminants).collect()
}

/// The color of luminance 1 with a chromaticity.
fn of_chromaticity([x, y]: [f32; 2]) -> Rgb {
    let [x, y] = [x, y].map(f64::from);
    crate::spectra::rec709_from_xyz([x / y, 1.0, (1.0 - x - y) / y])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_a_spectrum() {
        let wrong: Vec<String> = spectrum_names()
            .into_iter()
            .filter(|name| named_spectrum(name).is_none())
            .collect();
        assert!(wrong.is_empty(), "{wrong:?}");
        assert_eq!(named_spectrum("metal-Xx-eta"), None);
    }

    #[test]
    fn daylight_is_white() {
        let Some(NamedSpectrum::Color(color)) = named_spectrum("stdillum-D65") else {
            panic!("D65 is a color");
        };
        let off = color.map(|v| (v - 1.0).abs()).max_channel();
        assert!(off < 5e-3, "{color:?}");
    }
}
