//! Options of the many-light methods.

use crate::names::{
    COMPENSATIONS, EMISSIONS, EmissionName, FLUX_RULES, KERNELS, PLACEMENTS, RESAMPLINGS,
    STRATEGIES, StrategyName, TABLE_STORAGES, one_of,
};
use crate::values::{self, LightCount};
use clap::Args;
use manylight::integrators::many_light::{
    ClampRule, Compensation, FluxRule, GlossyForm, Kernel, Placement, Resampling, TableStorage,
};
use std::num::NonZeroU32;

/// Options of the many-light methods. Each overrides one setting of the preset.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Virtual lights")]
pub(crate) struct LightArgs {
    /// Virtual lights per pass. This is a lower bound: photons without a suitable light nearby get additional lights. auto: the number
    /// of the preset or a half, a quarter or an eighth of it, and as many photons, emitter samples and camera paths as suit the scene, by
    /// a short pre-pass. Default: the preset's.
    #[arg(short = 'n', long, value_name = "N|auto", value_parser = values::light_count)]
    pub(crate) lights: Option<LightCount>,

    /// Emitted photon paths per pass. Default: the preset's, and at least 64 per virtual light.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = values::count)]
    pub(crate) photons: Option<NonZeroU32>,

    /// Selection of light positions among the photons: uniform (probability proportional to flux), importance (flux times importance),
    /// relaxed (as importance, then moved apart).
    #[arg(long, value_name = "RULE", value_parser = one_of(PLACEMENTS))]
    pub(crate) placement: Option<Placement>,

    /// Flux of a light: density (flux of its photon over the selection probability), partition (sum over the photons in its Voronoi cell).
    #[arg(long, value_name = "RULE", value_parser = one_of(FLUX_RULES))]
    pub(crate) flux: Option<FluxRule>,

    /// Emission of a light: single (reflection of one photon), table (octahedral table of radiant intensity from many photons), vmf
    /// (mixture of von Mises-Fisher lobes from many photons).
    #[arg(long, value_name = "KIND", value_parser = one_of(EMISSIONS))]
    pub(crate) emission: Option<EmissionName>,

    /// Texels along an edge of an emission table: an even number from 8 to 128.
    #[arg(long, value_name = "N", value_parser = values::table_size)]
    pub(crate) table_size: Option<u32>,

    /// Storage of a texel: float (12 bytes), shared (4 bytes with a shared exponent).
    #[arg(long, value_name = "KIND", value_parser = one_of(TABLE_STORAGES))]
    pub(crate) table_storage: Option<TableStorage>,

    /// Von Mises-Fisher lobes per light, from 1 to 8.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(GlossyForm::MAX_LOBES)))]
    pub(crate) lobes: Option<u32>,

    /// Evaluation of a light: point (virtual point light), sphere (virtual spherical light), disc (points over the extent of its photons).
    #[arg(long, value_name = "KIND", value_parser = one_of(KERNELS))]
    pub(crate) kernel: Option<Kernel>,

    /// Summation over the lights: all (every light of the pass), lightcuts (clusters of a light tree), bidirectional (clusters of pairs of
    /// gather points and lights: all vertices of the camera paths of a pixel share a cut).
    #[arg(long, value_name = "KIND", value_parser = one_of(STRATEGIES))]
    pub(crate) strategy: Option<StrategyName>,

    /// Lightcuts: largest error bound of a cluster, as a fraction of the radiance that all lights contribute.
    #[arg(long, value_name = "FRACTION", value_parser = values::fraction)]
    pub(crate) max_error: Option<f32>,

    /// Lightcuts: largest number of clusters in a cut; it takes precedence over --max-error.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = values::count)]
    pub(crate) max_cut: Option<NonZeroU32>,

    /// Bound of the geometry term: none, auto (from the area that each light represents), fixed (from the median of these areas), or a value
    /// in 1/m².
    #[arg(long, value_name = "none|auto|fixed|VALUE", value_parser = values::clamp)]
    pub(crate) clamp: Option<ClampRule>,

    /// Compensation of the bias of clamping: none, kollig-keller (the clamped residual is estimated by extending camera paths).
    #[arg(long, value_name = "RULE", value_parser = one_of(COMPENSATIONS))]
    pub(crate) compensation: Option<Compensation>,

    /// Photons in the emission estimate of a light with --flux density.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = values::count)]
    pub(crate) neighbors: Option<NonZeroU32>,

    /// Lights of successive passes: new (resampled for each pass), progressive (resampled with increasing density, so that the bias of the
    /// mean image vanishes).
    #[arg(long, value_name = "KIND", value_parser = one_of(RESAMPLINGS))]
    pub(crate) resampling: Option<Resampling>,
}
