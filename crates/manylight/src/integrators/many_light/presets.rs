//! The many-light methods that have a name.

use super::axes::{ClampRule, Compensation, Effort, EmissionKind, FluxRule, Placement, Resampling};
use super::settings::ManyLight;
use crate::gather::{CutLimits, Kernel, Strategy};
use crate::virtual_lights::{GlossyForm, TableStorage};

/// Virtual lights per pass for lightcuts. Unmeasured: 32 times those of a sum over all lights, since a cut grows slowly with the
/// number of lights.
const CUT_LIGHTS: u32 = 16_384;
/// Emitter samples per direction at the first gather points. Measured against 1 and 4, over 8 passes at 160x90: the variance of direct
/// light falls by 1.5 and 2.1 times in the Kitchen, 1.7 and 2.8 times in the Garage. With 4, passes take 8 to 11 % longer than with 2,
/// and in the CBox, which has one lamp, 20 %.
const EMITTER_SAMPLES: u32 = 2;
/// Camera paths that a pixel starts with in a pass. With one path, edges and textures were most of the noise of a pass.
const CAMERA_PATHS: u32 = 4;
/// Threshold of roulette before shadow rays. Measured at 0, 2 and 4, over 4 passes at 160x90: variance times time is 1, 0.93 and 0.87 in
/// the Kitchen, 1, 0.93 and 0.88 in the Garage, 1, 1.00 and 1.15 in the CBox.
const ROULETTE: f32 = 2.0;
/// Texels along an edge of a table. Measured at 32, 48, 64 and 128, over 8 passes of 512 lights with the same photons at 160x90: the
/// mean of the U-Shape, where light grazes walls, is 0, 0.5, 0.6 and 0.7 % brighter, and variance times time is 1, 1.04 and 1.20 there
/// (32, 48, 64), 1, 1.00 and 1.03 in the Kitchen, 1, 1.01 and 1.05 in the Garage.
const TABLE_SIDE: u32 = 48;
/// The tables of the talk of 2015, and of lightcuts, which keep many of them.
const PAPER_TABLES: EmissionKind = tables(32);
/// Photon paths per virtual light for lightcuts.
const CUT_PHOTON_PATHS_PER_LIGHT: u32 = 64;
/// Most pairs of a product cut. Measured in the Kitchen over 4 passes at 160x90: with 200, 400 and 1000 pairs, the relative variance
/// of virtual lights is 0.018, 0.0046 and 0.0031, and a render takes 35, 57 and 91 s of processor time.
const PRODUCT_CUT: u32 = 400;

/// Emission in tables of `side` texels along an edge.
const fn tables(side: u32) -> EmissionKind {
    EmissionKind::Rich(GlossyForm::Table {
        side,
        storage: TableStorage::Shared,
    })
}

impl ManyLight {
    /// Rich-VPLs: importance placement, partition of flux, tables, discs.
    pub fn rich_vpl() -> Self {
        ManyLight {
            light_count: 512,
            photon_paths: 262_144,
            importon_paths: 32_768,
            placement: Placement::Importance,
            flux: FluxRule::Partition,
            neighbors: 100,
            emission: tables(TABLE_SIDE),
            kernel: Kernel::Disc,
            strategy: Strategy::All,
            clamp: ClampRule::Auto,
            compensation: Compensation::KolligKeller,
            resampling: Resampling::Progressive,
            roulette: ROULETTE,
            emitter_samples: EMITTER_SAMPLES,
            camera_paths: CAMERA_PATHS,
            effort: Effort::Fixed,
        }
    }

    /// [`ManyLight::rich_vpl`] with lights, emitter samples and camera paths by the scene: the default of a render.
    pub fn rich_vpl_by_scene() -> Self {
        ManyLight {
            effort: Effort::Measured,
            ..ManyLight::rich_vpl()
        }
    }

    /// The method of the talk of 2015, as we read it: importance placement, density rule, 32 x 32 tables, points, one clamp
    /// for all lights.
    pub fn rich_vpl_paper() -> Self {
        ManyLight {
            flux: FluxRule::Density,
            kernel: Kernel::Point,
            clamp: ClampRule::Fixed,
            compensation: Compensation::None,
            resampling: Resampling::New,
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

    /// Virtual spherical lights. Source: Hašan, Křivánek, Walter, Bala, "Virtual Spherical Lights for Many-Light Rendering of Glossy
    /// Scenes", SIGGRAPH Asia 2009.
    pub fn vsl() -> Self {
        ManyLight {
            kernel: Kernel::Sphere,
            clamp: ClampRule::None,
            compensation: Compensation::None,
            resampling: Resampling::Progressive,
            ..ManyLight::vpl()
        }
    }

    /// Virtual point lights: photons kept with probability proportional to flux. Source: Keller, "Instant Radiosity",
    /// SIGGRAPH 1997.
    pub fn vpl() -> Self {
        ManyLight {
            placement: Placement::Uniform,
            flux: FluxRule::Density,
            emission: EmissionKind::Single,
            kernel: Kernel::Point,
            resampling: Resampling::New,
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

    /// Lightcuts of virtual point lights. Source: Walter et al., "Lightcuts: A Scalable Approach to Illumination",
    /// SIGGRAPH 2005.
    pub fn lightcuts() -> Self {
        ManyLight {
            strategy: Strategy::Cuts(CutLimits::default()),
            light_count: CUT_LIGHTS,
            photon_paths: CUT_PHOTON_PATHS_PER_LIGHT * CUT_LIGHTS,
            ..ManyLight::vpl()
        }
    }

    /// Lightcuts of Rich-VPLs.
    pub fn rich_lightcuts() -> Self {
        ManyLight {
            strategy: Strategy::Cuts(CutLimits::default()),
            light_count: CUT_LIGHTS,
            photon_paths: CUT_PHOTON_PATHS_PER_LIGHT * CUT_LIGHTS,
            emission: PAPER_TABLES,
            ..ManyLight::rich_vpl()
        }
    }

    /// Bidirectional lightcuts of Rich-VPLs: a cut through the pairs of the gather points of a pixel and the lights of a group of
    /// passes. Source: Walter, Khungurn, Bala, "Bidirectional Lightcuts", SIGGRAPH 2012.
    pub fn bidirectional_lightcuts() -> Self {
        ManyLight {
            strategy: Strategy::Bidirectional(CutLimits {
                max_lights: PRODUCT_CUT,
                ..CutLimits::default()
            }),
            ..ManyLight::rich_vpl()
        }
    }
}
