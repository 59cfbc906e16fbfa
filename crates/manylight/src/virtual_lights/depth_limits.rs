//! Path-length limits: the part of a light's flux that arrived over paths short enough for a
//! receiver.

use super::clusters::PhotonClusters;
use crate::arrays::{FoundArray, InvalidArray, NamedArray, read_floats};
use crate::ids::LightId;
use crate::particles::Photon;
use crate::scene::PathLimits;
use rayon::prelude::*;

/// Largest photon depth that is distinguished, in segments. A scene with a longer limit, or none,
/// is treated as unlimited; a larger value costs 4 bytes per light and segment.
const DEPTHS: usize = 16;

/// Name of [`DepthFractions::array`].
const ARRAY: &str = "lights.depth_fractions";

/// For each light the cumulative fractions of its flux by photon depth: depth 1, up to 2, up to 3,
/// ... Empty without a limit.
#[derive(Clone, Debug, Default)]
pub(super) struct DepthFractions {
    fractions: Vec<[f32; DEPTHS]>,
}

impl DepthFractions {
    /// The fractions of all lights, if `limits` restricts paths to at most [`DEPTHS`] segments.
    pub(super) fn new(photons: &[Photon], clusters: &PhotonClusters, limits: PathLimits) -> Self {
        if limits.max_depth.is_none_or(|max| max as usize > DEPTHS) {
            return DepthFractions::default();
        }
        let fractions = (0..clusters.len())
            .into_par_iter()
            .map(|k| fractions_by_depth(photons, clusters.of(k)));
        DepthFractions {
            fractions: fractions.collect(),
        }
    }

    /// As an array with a row for each light, or with none.
    pub(super) fn array(&self) -> NamedArray<'_> {
        let values = || self.fractions.as_flattened().iter().copied();
        NamedArray::floats(ARRAY, [self.fractions.len(), DEPTHS], values)
    }

    /// The inverse of [`DepthFractions::array`], of `lights` lights.
    ///
    /// # Errors
    /// Those of `read`, and fractions of another number of lights.
    pub(super) fn of_array<E: From<InvalidArray>>(
        lights: usize,
        read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
    ) -> Result<Self, E> {
        let fractions = read_floats(ARRAY, DEPTHS, read)?.as_chunks().0.to_vec();
        if !fractions.is_empty() && fractions.len() != lights {
            let message = format!("found {} rows, expected {lights}", fractions.len());
            return Err(InvalidArray::new(ARRAY, message).into());
        }
        Ok(DepthFractions { fractions })
    }

    /// See [`VirtualLights::share_up_to`](super::VirtualLights::share_up_to).
    #[inline]
    pub(super) fn up_to(&self, id: LightId, depth: u32) -> f32 {
        if depth == 0 {
            return 0.0;
        }
        let fractions = self.fractions.get(id.index());
        fractions
            .and_then(|fractions| fractions.get(depth as usize - 1))
            .copied()
            .unwrap_or(1.0)
    }

    /// Bytes of one light in a scene with any limit.
    pub(super) const BYTES_PER_LIGHT: usize = size_of::<[f32; DEPTHS]>();

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.fractions.as_slice())
    }
}

/// Cumulative fractions of the luminance of the flux of a cluster by photon depth.
fn fractions_by_depth(
    photons: &[Photon],
    cluster: impl Iterator<Item = (u32, f32)>,
) -> [f32; DEPTHS] {
    let mut sums = [0.0f64; DEPTHS];
    let mut total = 0.0;
    for (j, weight) in cluster {
        let photon = &photons[j as usize];
        let flux = f64::from(photon.flux.luminance() * weight);
        total += flux;
        for sum in sums.iter_mut().skip(photon.depth.max(1) as usize - 1) {
            *sum += flux;
        }
    }
    sums.map(|sum| {
        if total > 0.0 {
            (sum / total) as f32
        } else {
            0.0
        }
    })
}
