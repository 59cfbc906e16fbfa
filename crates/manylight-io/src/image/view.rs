//! Views: from linear radiance to the values of an 8 bit picture.

use super::agx::agx;
use super::transfer::srgb_from_linear;

/// A tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// None: values above 1 are clipped.
    #[default]
    Standard,
    /// Khronos PBR Neutral: base colors up to 0.8 keep their hue and saturation, highlights are
    /// compressed.
    Neutral,
    /// AgX as in Blender: low contrast in highlights, which lose saturation.
    Agx,
}

/// How linear values become colors of 8 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DisplayTransform {
    /// Exposure in stops: values are multiplied by 2^`exposure_ev` first.
    pub exposure_ev: f32,
    /// The tone curve.
    pub view: View,
}

impl From<f32> for DisplayTransform {
    /// The standard view with an exposure in stops.
    fn from(exposure_ev: f32) -> Self {
        DisplayTransform {
            exposure_ev,
            view: View::Standard,
        }
    }
}

impl DisplayTransform {
    /// The sRGB values of a linear Rec. 709 color, in [0, 1].
    pub fn srgb(&self, color: [f32; 3]) -> [f32; 3] {
        let exposure = self.exposure_ev.exp2();
        let exposed = color.map(|v| v * exposure);
        let linear = match self.view {
            View::Standard => exposed,
            View::Neutral => neutral(exposed),
            View::Agx => agx(exposed),
        };
        linear.map(|v| srgb_from_linear(v.clamp(0.0, 1.0)))
    }
}

/// The Khronos PBR Neutral tone mapper; linear Rec. 709 in and out. Negative values are set to 0
/// first.
///
/// Source: Khronos Group, "Khronos PBR Neutral Tone Mapper", 2024, section "Formulation".
fn neutral(color: [f32; 3]) -> [f32; 3] {
    /// Reflectance at normal incidence that the offset removes from bright colors.
    const F90: f32 = 0.04;
    /// Start of the compression of highlights.
    const START: f32 = 0.8 - F90;
    /// Rate of the loss of saturation of highlights.
    const DESATURATION: f32 = 0.15;
    // Infinite values would give the quotient of infinities; NaN becomes 0.
    let color = color.map(|v| if v > 0.0 { v.min(1e30) } else { 0.0 });
    let smallest = color[0].min(color[1]).min(color[2]);
    let offset = if smallest < 2.0 * F90 {
        smallest - smallest * smallest / (4.0 * F90)
    } else {
        F90
    };
    let color = color.map(|v| v - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if peak < START {
        return color;
    }
    let rest = 1.0 - START;
    let compressed = 1.0 - rest * rest / (peak + rest - START);
    let saturation = 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    color.map(|v| {
        let scaled = v * (compressed / peak);
        compressed + (scaled - compressed) * saturation
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neutral_is_the_published_formula() {
        // Khronos's GLSL function in double precision.
        let expected = [
            ([0.18, 0.18, 0.18], [0.14, 0.14, 0.14]),
            ([0.05, 0.02, 0.5], [0.0325, 0.0025, 0.4825]),
            ([1.0, 0.2, 0.0], [0.88, 0.1884479, 0.0155599]),
            ([5.0, 3.0, 0.1], [0.987027, 0.7376484, 0.3760495]),
            ([0.9, 0.9, 0.9], [0.8305882, 0.8305882, 0.8305882]),
            ([100.0, 1.0, 1.0], [0.9994208, 0.9369481, 0.9369481]),
            ([0.8, 0.8, 0.8], [0.76, 0.76, 0.76]),
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            ([0.04, 0.04, 0.04], [0.01, 0.01, 0.01]),
        ];
        for (color, expected) in expected {
            for (found, expected) in neutral(color).into_iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-6,
                    "{color:?}: {found}, expected {expected}"
                );
            }
        }
        let continued = neutral([0.8 + 1e-6; 3])[0] - neutral([0.8 - 1e-6; 3])[0];
        assert!(continued.abs() < 1e-5, "the curve jumps by {continued}");
    }

    #[test]
    fn the_standard_view_is_srgb_and_exposure() {
        let color = [-0.5, 0.1, 2.0];
        let found = DisplayTransform::from(1.0).srgb(color);
        assert_eq!(found, [0.0, 0.2, 1.0].map(srgb_from_linear));
        let neutral = DisplayTransform {
            exposure_ev: 0.0,
            view: View::Neutral,
        };
        for v in [f32::NAN, f32::INFINITY, f32::MAX, -1.0] {
            let srgb = neutral.srgb([v, 0.2, 0.0]);
            assert!(
                srgb.iter().all(|s| (0.0..=1.0).contains(s)),
                "{v}: {srgb:?}"
            );
        }
    }
}
