//! The many-light methods that have a name.

use super::axes::{ClampRule, EmissionKind, FluxRule, Placement, Resampling};
use super::light_set::Compensation;
use super::many_light::ManyLight;
use crate::gather::{CutLimits, Kernel, ShareOf, Strategy};
use crate::virtual_lights::{GlossyForm, TableStorage};

/// Lights per pass where a cut makes them cheap.
const MANY: u32 = 16_384;

impl ManyLight {
    /// Rich-VPLs: importance placement, partition, 32 x 32 tables, discs.
    pub fn rich_vpl() -> Self {
        ManyLight {
            light_count: 512,
            photon_paths: 262_144,
            importon_paths: 32_768,
            placement: Placement::Importance,
            flux: FluxRule::Partition,
            neighbors: 100,
            emission: EmissionKind::Rich(GlossyForm::Table {
                side: 32,
                storage: TableStorage::Shared,
            }),
            kernel: Kernel::Disc,
            strategy: Strategy::All,
            clamp: ClampRule::Auto,
            compensation: Compensation::KolligKeller,
            resampling: Resampling::Progressive,
        }
    }

    /// The method of the talk, as we read it: importance placement, the density rule, 32 x 32 tables, points, one clamp for all.
    pub fn rich_vpl_paper() -> Self {
        ManyLight {
            flux: FluxRule::Density,
            kernel: Kernel::Point,
            clamp: ClampRule::Fixed,
            compensation: Compensation::None,
            resampling: Resampling::New,
            ..ManyLight::rich_vpl()
        }
    }

    /// Rich-VSLs: Rich-VPLs as spheres.
    pub fn rich_vsl() -> Self {
        ManyLight {
            kernel: Kernel::Sphere,
            clamp: ClampRule::None,
            compensation: Compensation::None,
            ..ManyLight::rich_vpl()
        }
    }

    /// Virtual spherical lights. Source: Hašan, Křivánek, Walter, Bala, "Virtual Spherical Lights for Many-Light Rendering of Glossy
    /// Scenes", 2009.
    pub fn vsl() -> Self {
        ManyLight {
            kernel: Kernel::Sphere,
            clamp: ClampRule::None,
            compensation: Compensation::None,
            resampling: Resampling::Progressive,
            ..ManyLight::vpl()
        }
    }

    /// Classic VPLs: photons thinned at random.
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

    /// VPLs placed by importance.
    pub fn vpl_importance() -> Self {
        ManyLight {
            placement: Placement::Importance,
            ..ManyLight::vpl()
        }
    }

    /// Lightcuts of classic lights. Source: Walter et al., "Lightcuts: A Scalable Approach to Illumination", SIGGRAPH 2005.
    pub fn lightcuts() -> Self {
        ManyLight {
            strategy: Strategy::Cuts(CutLimits::default()),
            light_count: MANY,
            photon_paths: 64 * MANY,
            ..ManyLight::vpl()
        }
    }

    /// Lightcuts of Rich-VPLs from the ends of eye paths, as many as the clamp asks for.
    pub fn bidirectional_lightcuts() -> Self {
        ManyLight {
            strategy: Strategy::Cuts(CutLimits {
                share_of: ShareOf::Pixel,
                ..CutLimits::default()
            }),
            ..ManyLight::rich_lightcuts()
        }
    }

    /// Lightcuts of Rich-VPLs.
    pub fn rich_lightcuts() -> Self {
        ManyLight {
            strategy: Strategy::Cuts(CutLimits::default()),
            light_count: MANY,
            photon_paths: 64 * MANY,
            ..ManyLight::rich_vpl()
        }
    }
}
