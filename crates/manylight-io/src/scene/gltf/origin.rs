//! The program that made a scene: it decides what numbers mean for which the specification leaves a
//! choice, or that a program writes in another way.

use super::json::Json;
use std::f64::consts::PI;

/// Luminous efficacy in lm/W by which the units of light are converted: that of green light, which
/// Blender's exporter uses for all colors.
pub(super) const LUMENS_PER_WATT: f32 = 683.0;

/// Programs that rewrite files of others, and put their name in the place of the other one.
const REWRITERS: [&str; 2] = ["glTF-Transform", "gltfpack"];

/// The program that made a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// Blender's exporter.
    Blender,
    /// A program that names itself.
    Other,
    /// Unknown: a rewriter has put its name in the place of the other one.
    Replaced,
}

impl Origin {
    /// By the name in the file, or else by the intensities of its lights.
    pub(super) fn of(root: &Json<'_>, lights: &[Json<'_>]) -> Self {
        let asset = root.member("asset");
        let generator = asset.and_then(|asset| asset.string("generator"));
        let generator = generator.unwrap_or_default();
        if generator.contains("Blender") {
            return Origin::Blender;
        }
        if !REWRITERS.iter().any(|name| generator.contains(name)) {
            return Origin::Other;
        }
        let intensities: Vec<(f64, f64)> = lights.iter().filter_map(intensity_and_watts).collect();
        let all_round = |of: fn(&(f64, f64)) -> f64| intensities.iter().all(|v| is_round(of(v)));
        let is_blender = !intensities.is_empty() && all_round(|v| v.1) && !all_round(|v| v.0);
        if is_blender {
            Origin::Blender
        } else {
            Origin::Replaced
        }
    }
}

/// The intensity of a light, and the watts for which Blender's exporter writes it.
fn intensity_and_watts(light: &Json<'_>) -> Option<(f64, f64)> {
    let intensity = light.number("intensity")?;
    let watts = match light.string("type")? {
        "directional" => intensity / f64::from(LUMENS_PER_WATT),
        _ => intensity * 4.0 * PI / f64::from(LUMENS_PER_WATT),
    };
    Some((intensity, watts))
}

/// Whether a number has at most three digits, as people give the power of lamps. One number in a
/// thousand that nobody chose has this property.
fn is_round(v: f64) -> bool {
    /// Rounding of single precision, relative.
    const ROUNDING: f64 = 1e-6;
    if v <= 0.0 {
        return v == 0.0;
    }
    let unit = 10f64.powf(v.log10().floor() - 2.0);
    let digits = v / unit;
    (digits - digits.round()).abs() <= ROUNDING * digits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chosen_numbers_are_round() {
        for v in [0.0, 1.0, 10.0, 1000.0, 12.5, 0.1f32.into(), 54.3] {
            assert!(is_round(v), "{v}");
        }
        for v in [54.351_41, 1234.0, 0.333_333, 2_174.056_522] {
            assert!(!is_round(v), "{v}");
        }
    }
}
