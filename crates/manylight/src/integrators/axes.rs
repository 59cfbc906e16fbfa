//! The axes on which a many-light method is a choice; in words in docs/many_light.md. The others are [`Compensation`], [`Kernel`] and
//! [`Strategy`].
//!
//! [`Kernel`]: crate::gather::Kernel
//! [`Strategy`]: crate::gather::Strategy

use super::light_set::Compensation;
use crate::gather::Clamp;
use crate::virtual_lights::{GlossyForm, VirtualLights};

/// Lights count as so many times larger for the clamp if directions complete it: they bring what near lights send with less noise.
const COMPLETED: f32 = 4.0;

/// Where lights stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// Photons kept with probability proportional to flux.
    Uniform,
    /// Proportional to importance x flux.
    Importance,
    /// As [`Placement::Importance`], and then pushed apart.
    Relaxed,
}

/// How much flux each light carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FluxRule {
    /// Its own photon's over the probability of having been kept: the paper's, as we read it.
    Density,
    /// That of all photons nearer to it than to any other light.
    Partition,
}

/// What each light shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionKind {
    /// The reflection of one photon.
    Single,
    /// The reflection of all its photons: diffuse part exact, glossy part in this form.
    Rich(GlossyForm),
}

/// What is done about the singularity of `1 / d²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClampRule {
    /// Nothing.
    None,
    /// Scale-free, by what each light stands for: [`Clamp::Auto`].
    Auto,
    /// `G <= 1 / A` with one `A` for all lights: the median of what they stand for.
    Fixed,
    /// `G <= value`, in 1/m².
    Value(f32),
}

impl ClampRule {
    /// The clamp for `lights`, one in `parts` of which is summed, when they have become so many times finer.
    pub(super) fn for_lights(
        self,
        lights: &VirtualLights,
        parts: u32,
        finer: f32,
        compensation: Compensation,
    ) -> Clamp {
        match self {
            ClampRule::None => Clamp::None,
            ClampRule::Auto => Clamp::Auto(match compensation {
                Compensation::None => 1.0,
                Compensation::KolligKeller => COMPLETED,
            }),
            ClampRule::Fixed => {
                let area = lights.median_area() * parts as f32;
                Clamp::Value(finer / area.max(f32::MIN_POSITIVE))
            }
            ClampRule::Value(limit) => Clamp::Value(limit * finer),
        }
    }
}

/// Which lights the passes have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resampling {
    /// Each has its own, as fine as the first.
    New,
    /// Each has its own, and they become finer, so that the mean over passes goes to the right picture.
    Progressive,
}
