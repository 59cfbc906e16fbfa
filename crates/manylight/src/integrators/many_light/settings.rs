//! The settings of a many-light method: the numbers and axes of [`ManyLight`], what contradicts
//! itself, and the named methods.
//!
//! A named method is a choice on each axis; all combinations exist, but for a few that contradict
//! themselves. In words: docs/many_light.md. The axes [`Kernel`] and [`Strategy`] belong to
//! [`crate::gather`].

use crate::gather::{CutLimits, Kernel, Strategy};
use crate::virtual_lights::{GlossyForm, TableStorage};
use std::fmt;

/// Indirect light from virtual lights: the number of particles and lights, and a choice on each
/// axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManyLight {
    /// Virtual lights that a pass shades with.
    pub light_count: u32,
    /// Emitted photon paths per pass.
    pub photon_paths: u32,
    /// Importon paths per pass.
    pub importon_paths: u32,
    /// How photons are chosen to become lights.
    pub placement: Placement,
    /// The flux of a light.
    pub flux: FluxRule,
    /// Nearest photons that make up the emission of a light, under [`FluxRule::Density`].
    pub neighbors: u32,
    /// The emission of a light.
    pub emission: EmissionKind,
    /// The shape with which a light is evaluated.
    pub kernel: Kernel,
    /// The lights that are evaluated at a point.
    pub strategy: Strategy,
    /// Bound on the singularity of a connection.
    pub clamp: ClampRule,
    /// Compensation of the light that clamping removes.
    pub compensation: Compensation,
    /// The lights of successive passes.
    pub resampling: Resampling,
    /// Edge of the pattern of pixels that are shaded by different subsets of the lights, a power of
    /// two, at most [`MAX_INTERLEAVING`]; 1: all pixels by the same lights. Only under
    /// [`Strategy::All`].
    pub interleaving: u32,
    /// Threshold of Russian roulette before shadow rays, under [`Strategy::All`]: unshadowed light,
    /// relative to the mean over the lights of a pass. 0: no roulette.
    pub roulette: f32,
    /// Emitter samples per direction at the first gather points.
    pub emitter_samples: u32,
    /// Camera paths that a pixel starts with in a pass, among which its lights and directions are
    /// divided: a power of two, at most [`MAX_CAMERA_PATHS`]; one with [`Strategy::Cuts`].
    pub camera_paths: u32,
    /// Passes that share the first set of lights: 1, or those of a frame of a walkthrough.
    pub first_passes: u32,
    /// How `light_count`, `photon_paths`, `roulette`, `emitter_samples` and `camera_paths` are set.
    pub effort: Effort,
}

/// How photons are chosen to become virtual lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// With probability proportional to flux.
    Uniform,
    /// With probability proportional to importance times flux.
    Importance,
    /// As [`Placement::Importance`], followed by relaxation: repulsion between neighboring lights.
    Relaxed,
}

/// The flux of a virtual light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FluxRule {
    /// Flux of the light's photon over the probability of having been kept: the paper's rule, as we
    /// read it.
    Density,
    /// Flux of all photons that are nearer to the light than to any other light of the same
    /// surface.
    Partition,
}

/// The emission of a virtual light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionKind {
    /// The reflection of one photon.
    Single,
    /// The reflection of all photons of a cluster: the diffuse part exactly, the glossy part in
    /// this form.
    Rich(GlossyForm),
}

impl EmissionKind {
    /// Tables of the size of the rich methods.
    pub const TABLE: EmissionKind = EmissionKind::table(TABLE_SIDE, TableStorage::Shared);
    /// As many von Mises-Fisher lobes as in the paper.
    pub const LOBES: EmissionKind = EmissionKind::Rich(GlossyForm::Lobes {
        count: DEFAULT_LOBES,
    });

    /// Tables of `side` texels along an edge.
    const fn table(side: u32, storage: TableStorage) -> Self {
        EmissionKind::Rich(GlossyForm::Table { side, storage })
    }

    /// The form of the glossy part; `None`: that of one photon.
    pub fn glossy_form(self) -> Option<GlossyForm> {
        match self {
            EmissionKind::Single => None,
            EmissionKind::Rich(form) => Some(form),
        }
    }
}

/// How the bound on the `1 / d²` singularity of a connection is chosen: the [`Clamp`] of a group of
/// passes follows from the areas of its lights.
///
/// [`Clamp`]: crate::gather::Clamp
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClampRule {
    /// No bound.
    None,
    /// By the surface area that each light represents: [`Clamp::Auto`](crate::gather::Clamp::Auto).
    Auto,
    /// `G <= 1 / A`, with `A` the median surface area that the lights of one pass represent, in m².
    Fixed,
    /// `G <= value`, in 1/m².
    Value(f32),
}

/// Compensation of the light that clamping removes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compensation {
    /// None: the image lacks that light.
    None,
    /// Directions sampled at the shading point, continued in proportion to the clamped fraction,
    /// after Kollig and Keller. Photons add what low-roughness lobes reflect from emitters, which
    /// directions would rarely find.
    KolligKeller,
}

/// The virtual lights of successive passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resampling {
    /// New lights in each pass, which represent the same area in all passes.
    New,
    /// New lights in each pass, which represent a smaller area from pass to pass. The mean over
    /// passes converges to the right image.
    Progressive,
}

/// How the effort of a pass is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// As the settings say.
    Fixed,
    /// By a pre-pass: at most as many lights as the settings say.
    Measured,
}

/// Two settings of a many-light method that contradict each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contradiction {
    /// [`Placement::Relaxed`] with [`FluxRule::Density`].
    RelaxedDensity,
    /// [`Kernel::Sphere`] with another strategy than [`Strategy::All`].
    SphereCut,
    /// [`Kernel::Sphere`] with a clamp.
    SphereClamp,
    /// [`Kernel::Sphere`] with a compensation.
    SphereCompensation,
    /// [`Effort::Measured`] with another strategy than [`Strategy::All`].
    MeasuredCut,
    /// [`Strategy::Bidirectional`] without [`Compensation::KolligKeller`].
    UncompensatedPairs,
    /// Interleaved lights with another strategy than [`Strategy::All`].
    InterleavedCut,
    /// Tables in blocks of more than [`TableStorage::MAX_SIDE_OF_BLOCKS`] texels along an edge.
    LargeBlocks,
    /// [`ManyLight::light_count`] is zero.
    NoLights,
    /// [`ManyLight::interleaving`] is larger than [`MAX_INTERLEAVING`], or no power of two.
    Pattern,
    /// [`ManyLight::camera_paths`] that are no power of two, or more than [`MAX_CAMERA_PATHS`].
    CameraPaths,
}

impl Contradiction {
    /// Why the two settings contradict each other.
    pub fn reason(self) -> &'static str {
        match self {
            Contradiction::RelaxedDensity => {
                "the flux by density needs the selection probability of each light, which is unknown after a relaxation"
            }
            Contradiction::SphereCut => "the contribution of a cluster of spheres has no bound",
            Contradiction::SphereClamp => "a sphere has no singularity",
            Contradiction::SphereCompensation => {
                "without clamping there is no clamped fraction to compensate"
            }
            Contradiction::MeasuredCut => "a cut sums as many lights as its error asks for",
            Contradiction::UncompensatedPairs => {
                "camera paths are extended by the clamped fraction"
            }
            Contradiction::InterleavedCut => "a cut is through all lights of a pass",
            Contradiction::LargeBlocks => "the blocks of a table are counted in a byte",
            Contradiction::NoLights => "indirect light is a sum over them",
            Contradiction::Pattern => "pixels and passes share the subsets of the lights evenly",
            Contradiction::CameraPaths => "the camera paths of a pixel share its directions evenly",
        }
    }
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let settings = match self {
            Contradiction::RelaxedDensity => "relaxed placement with flux by density",
            Contradiction::SphereCut => "spheres with cuts",
            Contradiction::SphereClamp => "spheres with a clamp",
            Contradiction::SphereCompensation => "spheres with compensation",
            Contradiction::MeasuredCut => "measured effort with cuts",
            Contradiction::UncompensatedPairs => "bidirectional cuts without compensation",
            Contradiction::InterleavedCut => "interleaved lights with cuts",
            Contradiction::LargeBlocks => "large tables in blocks",
            Contradiction::NoLights => "no virtual lights",
            Contradiction::Pattern => "a pattern whose edge is too large or no power of two",
            Contradiction::CameraPaths => "camera paths that are too many or no power of two",
        };
        write!(f, "{settings}: {}", self.reason())
    }
}

impl std::error::Error for Contradiction {}

/// Most camera paths that a pixel starts with in a pass: each has at least one of its directions.
pub const MAX_CAMERA_PATHS: u32 = 16;

/// Largest edge of a pattern of pixels that are shaded by different subsets of the lights.
pub const MAX_INTERLEAVING: u32 = 4;

/// Whether pixels and passes can share the subsets of a pattern with edge `edge`.
fn is_pattern_edge(edge: u32) -> bool {
    edge.is_power_of_two() && edge <= MAX_INTERLEAVING
}

/// Whether `count` camera paths can share the directions of a pixel.
pub(super) fn are_camera_paths(count: u32) -> bool {
    count.is_power_of_two() && count <= MAX_CAMERA_PATHS
}

impl ManyLight {
    /// Refuses settings that contradict each other.
    ///
    /// # Errors
    /// The first contradiction.
    pub fn check(&self) -> Result<(), Contradiction> {
        let is_sphere = self.kernel.is_sphere();
        let is_cut = self.strategy != Strategy::All;
        let is_bidirectional = matches!(self.strategy, Strategy::Bidirectional(_));
        let contradictions = [
            (
                self.placement == Placement::Relaxed && self.flux == FluxRule::Density,
                Contradiction::RelaxedDensity,
            ),
            (is_sphere && is_cut, Contradiction::SphereCut),
            (
                is_sphere && self.clamp != ClampRule::None,
                Contradiction::SphereClamp,
            ),
            (
                is_sphere && self.compensation != Compensation::None,
                Contradiction::SphereCompensation,
            ),
            (
                self.effort == Effort::Measured && is_cut,
                Contradiction::MeasuredCut,
            ),
            (
                is_bidirectional && self.compensation == Compensation::None,
                Contradiction::UncompensatedPairs,
            ),
            (
                is_cut && self.interleaving > 1,
                Contradiction::InterleavedCut,
            ),
            (self.has_large_blocks(), Contradiction::LargeBlocks),
            (self.light_count == 0, Contradiction::NoLights),
            (!is_pattern_edge(self.interleaving), Contradiction::Pattern),
            (
                !are_camera_paths(self.camera_paths),
                Contradiction::CameraPaths,
            ),
        ];
        match contradictions.into_iter().find(|(found, _)| *found) {
            None => Ok(()),
            Some((_, contradiction)) => Err(contradiction),
        }
    }

    fn has_large_blocks(&self) -> bool {
        matches!(self.emission, EmissionKind::Rich(GlossyForm::Table { side, storage: TableStorage::Blocks })
            if side > TableStorage::MAX_SIDE_OF_BLOCKS)
    }

    /// Camera paths that a pixel starts with in a pass. Pixels with a cut for each gather point
    /// start with one path: four cuts were no better at equal time (relMSE of one against four:
    /// Kitchen 0.044 after 45 s, 0.048 after 42 s).
    pub(super) fn started_paths(&self) -> u32 {
        match self.strategy {
            Strategy::All | Strategy::Bidirectional(_) => self.camera_paths,
            Strategy::Cuts(_) => 1,
        }
    }
}

/// Virtual lights per pass. With 1024 and 2048 instead, relMSE after Open Image Denoise is 1.14 and
/// 1.29 times as large at equal time (six scenes, 20 s; docs/measurements/many_light.md). A pre-pass
/// takes fewer where they suffice.
const LIGHTS: u32 = 512;
/// Photon paths per pass: 512 per light. With half and twice as many (2 passes of 128 lights and
/// 65 536 paths at 72x40, 4 seeds; Kitchen, Glossy Room, U-Shape): relMSE +12 and +1 % (standard
/// error 4 %).
const PHOTON_PATHS: u32 = 262_144;
/// Importon paths per pass. With half and twice as many (likewise): relMSE -0.3 and +2.5 %
/// (standard error 4 %).
const IMPORTON_PATHS: u32 = 32_768;
/// Nearest photons of a light under [`FluxRule::Density`]. With half and twice as many (likewise):
/// relMSE -1.3 and +2.6 % (standard error 6 %).
const NEIGHBORS: u32 = 100;
/// Virtual lights per pass for lightcuts: 32 times those of a sum over all lights, since a cut
/// grows slowly with the number of lights. In the Glossy Room a thousand times as many lights take
/// seven to eight times as long per point (docs/measurements/performance.md); at this rate, 32
/// times as many take less than three times as long. The time to make lights, and their memory,
/// grow in proportion.
const CUT_LIGHTS: u32 = 16_384;
/// Emitter samples per direction at the first gather points. With 2 and 4 instead of 1 (8 passes at
/// 160x90), the variance of direct light falls by 1.5 and 2.1 times in the Kitchen, by 1.7 and 2.8
/// times in the Garage. With 4, passes take 8 to 11 % longer than with 2, and in the CBox,
/// which has one lamp, 20 %.
const EMITTER_SAMPLES: u32 = 2;
/// Camera paths that a pixel starts with in a pass. With one path, edges and textures were most of
/// the noise of a pass.
const CAMERA_PATHS: u32 = 4;
/// Threshold of roulette before shadow rays. Measured at 0, 2 and 4, over 4 passes at 160x90:
/// variance times time is 1, 0.93 and 0.87 in the Kitchen, 1, 0.93 and 0.88 in the Garage, 1, 1.00
/// and 1.15 in the CBox.
const ROULETTE: f32 = 2.0;
/// Edge of the pattern of interleaved lights, in pixels. Measured at 1, 2 and 4 over 4 passes at
/// 256x144: relMSE after Open Image Denoise is 0.0069, 0.0061 and 0.0059 in a living room with
/// windows, 0.0096, 0.0019 and 0.0019 in a stairwell, 0.0061, 0.0041 and 0.0039 in a room lit
/// through a door; processor time relative to 1 is 1.04, 1.16 and 1.09 with 2, and 1.3, 1.8 and 1.3
/// with 4.
const INTERLEAVING: u32 = 2;
/// Texels along an edge of a table. Measured at 32, 48, 64 and 128, over 8 passes of 512 lights
/// with the same photons at 160x90: the mean of the U-Shape, where light grazes walls, is 0, 0.5,
/// 0.6 and 0.7 % brighter, and variance times time is 1, 1.04 and 1.20 there (32, 48, 64), 1, 1.00
/// and 1.03 in the Kitchen, 1, 1.01 and 1.05 in the Garage.
const TABLE_SIDE: u32 = 48;
/// Von Mises-Fisher lobes of a light, as in the paper (Simon, Hanika, Dachsbacher 2015).
const DEFAULT_LOBES: u32 = 5;
/// The tables of the talk of 2015.
const PAPER_TABLES: EmissionKind = EmissionKind::table(32, TableStorage::Shared);
/// The tables of lightcuts, which keep many of them: in blocks. Measured against shared exponents,
/// one pass of 16 384 lights at 96x54: a light takes 596 instead of 2020 bytes in the Kitchen, and
/// 606 instead of 2552 in the living-room; the sum takes 0.99 to 1.05 of the time.
const CUT_TABLES: EmissionKind = EmissionKind::table(32, TableStorage::Blocks);
/// Least photon paths per virtual light, for presets with many lights and for numbers of lights on
/// request. With this many, the noise of the photon fluxes is expected to be below the noise of the
/// light positions; no measurement is recorded. More paths take longer.
pub const PHOTON_PATHS_PER_LIGHT: u32 = 64;
/// Most pairs of a product cut. Measured in the Kitchen over 4 passes at 160x90: with 200, 400 and
/// 1000 pairs, the relative variance of virtual lights is 0.018, 0.0046 and 0.0031, and a render
/// takes 35, 57 and 91 s of processor time.
const PRODUCT_CUT: u32 = 400;

impl ManyLight {
    /// Rich-VPLs: importance placement, partition of flux, tables, discs.
    pub fn rich_vpl() -> Self {
        ManyLight {
            light_count: LIGHTS,
            photon_paths: PHOTON_PATHS,
            importon_paths: IMPORTON_PATHS,
            placement: Placement::Importance,
            flux: FluxRule::Partition,
            neighbors: NEIGHBORS,
            emission: EmissionKind::TABLE,
            kernel: Kernel::Disc,
            strategy: Strategy::All,
            clamp: ClampRule::Auto,
            compensation: Compensation::KolligKeller,
            resampling: Resampling::Progressive,
            interleaving: INTERLEAVING,
            roulette: ROULETTE,
            emitter_samples: EMITTER_SAMPLES,
            camera_paths: CAMERA_PATHS,
            first_passes: 1,
            effort: Effort::Fixed,
        }
    }

    /// [`ManyLight::rich_vpl`] with lights, emitter samples and camera paths by the scene: the
    /// default of a render.
    pub fn rich_vpl_by_scene() -> Self {
        ManyLight {
            effort: Effort::Measured,
            ..ManyLight::rich_vpl()
        }
    }

    /// The method of the talk of 2015, as we read it: importance placement, density rule, 32 x 32
    /// tables, points, one clamp for all lights.
    pub fn rich_vpl_paper() -> Self {
        ManyLight {
            flux: FluxRule::Density,
            kernel: Kernel::Point,
            clamp: ClampRule::Fixed,
            compensation: Compensation::None,
            resampling: Resampling::New,
            interleaving: 1,
            emission: PAPER_TABLES,
            ..ManyLight::rich_vpl()
        }
    }

    /// Rich-VPLs as virtual spherical lights.
    pub fn rich_vsl() -> Self {
        ManyLight {
            kernel: Kernel::Sphere,
            clamp: ClampRule::None,
            compensation: Compensation::None,
            ..ManyLight::rich_vpl()
        }
    }

    /// Virtual spherical lights. Source: Hašan, Křivánek, Walter, Bala, "Virtual Spherical Lights
    /// for Many-Light Rendering of Glossy Scenes", SIGGRAPH Asia 2009.
    pub fn vsl() -> Self {
        ManyLight {
            kernel: Kernel::Sphere,
            clamp: ClampRule::None,
            compensation: Compensation::None,
            resampling: Resampling::Progressive,
            ..ManyLight::vpl()
        }
    }

    /// Virtual point lights: photons kept with probability proportional to flux. Source: Keller,
    /// "Instant Radiosity", SIGGRAPH 1997.
    pub fn vpl() -> Self {
        ManyLight {
            placement: Placement::Uniform,
            flux: FluxRule::Density,
            emission: EmissionKind::Single,
            kernel: Kernel::Point,
            resampling: Resampling::New,
            interleaving: 1,
            ..ManyLight::rich_vpl()
        }
    }

    /// Virtual point lights placed by importance.
    pub fn vpl_importance() -> Self {
        ManyLight {
            placement: Placement::Importance,
            ..ManyLight::vpl()
        }
    }

    /// Lightcuts of virtual point lights. Source: Walter et al., "Lightcuts: A Scalable Approach to
    /// Illumination", SIGGRAPH 2005.
    pub fn lightcuts() -> Self {
        ManyLight {
            strategy: Strategy::Cuts(CutLimits::default()),
            light_count: CUT_LIGHTS,
            photon_paths: PHOTON_PATHS_PER_LIGHT * CUT_LIGHTS,
            ..ManyLight::vpl()
        }
    }

    /// Lightcuts of Rich-VPLs.
    pub fn rich_lightcuts() -> Self {
        ManyLight {
            strategy: Strategy::Cuts(CutLimits::default()),
            light_count: CUT_LIGHTS,
            photon_paths: PHOTON_PATHS_PER_LIGHT * CUT_LIGHTS,
            interleaving: 1,
            emission: CUT_TABLES,
            ..ManyLight::rich_vpl()
        }
    }

    /// Bidirectional lightcuts of Rich-VPLs: a cut through the pairs of the gather points of a
    /// pixel and the lights of a group of passes. Source: Walter, Khungurn, Bala, "Bidirectional
    /// Lightcuts", SIGGRAPH 2012.
    pub fn bidirectional_lightcuts() -> Self {
        ManyLight {
            strategy: Strategy::Bidirectional(CutLimits {
                max_lights: PRODUCT_CUT,
                ..CutLimits::default()
            }),
            interleaving: 1,
            ..ManyLight::rich_vpl()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contradictions_are_found_and_presets_have_none() {
        let rich = ManyLight::rich_vpl();
        for preset in [
            rich,
            ManyLight::rich_vpl_by_scene(),
            ManyLight::rich_vpl_paper(),
            ManyLight::rich_vsl(),
            ManyLight::vsl(),
            ManyLight::vpl(),
            ManyLight::vpl_importance(),
            ManyLight::lightcuts(),
            ManyLight::rich_lightcuts(),
            ManyLight::bidirectional_lightcuts(),
        ] {
            assert_eq!(preset.check(), Ok(()), "{preset:?}");
        }
        let sphere = ManyLight::rich_vsl();
        let cuts = Strategy::Cuts(CutLimits::default());
        let with = |change: fn(&mut ManyLight), mut settings: ManyLight| {
            change(&mut settings);
            settings.check()
        };
        let relaxed = ManyLight {
            placement: Placement::Relaxed,
            ..rich
        };
        let cut = ManyLight {
            strategy: cuts,
            ..sphere
        };
        assert_eq!(cut.check(), Err(Contradiction::SphereCut));
        assert_eq!(relaxed.check(), Ok(()));
        for (found, expected) in [
            (
                with(|m| m.flux = FluxRule::Density, relaxed),
                Contradiction::RelaxedDensity,
            ),
            (
                with(|m| m.clamp = ClampRule::Auto, sphere),
                Contradiction::SphereClamp,
            ),
            (
                with(|m| m.compensation = Compensation::KolligKeller, sphere),
                Contradiction::SphereCompensation,
            ),
            (
                with(|m| m.effort = Effort::Measured, ManyLight::lightcuts()),
                Contradiction::MeasuredCut,
            ),
            (
                with(
                    |m| m.compensation = Compensation::None,
                    ManyLight::bidirectional_lightcuts(),
                ),
                Contradiction::UncompensatedPairs,
            ),
            (
                with(|m| m.interleaving = 2, ManyLight::lightcuts()),
                Contradiction::InterleavedCut,
            ),
            (with(|m| m.light_count = 0, rich), Contradiction::NoLights),
            (with(|m| m.interleaving = 0, rich), Contradiction::Pattern),
            (with(|m| m.interleaving = 3, rich), Contradiction::Pattern),
            (with(|m| m.interleaving = 8, rich), Contradiction::Pattern),
            (
                with(|m| m.camera_paths = 3, rich),
                Contradiction::CameraPaths,
            ),
            (
                with(|m| m.camera_paths = 32, rich),
                Contradiction::CameraPaths,
            ),
            (
                with(
                    |m| m.emission = EmissionKind::table(62, TableStorage::Blocks),
                    rich,
                ),
                Contradiction::LargeBlocks,
            ),
        ] {
            assert_eq!(found, Err(expected));
        }
    }
}
