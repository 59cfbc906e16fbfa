//! The large functions: choices of elements, points on them, environment maps. They are compiled once for each instruction set, because
//! every caller would otherwise have a copy.

use super::elements::{ElementList, EmittingScene, PointsOfElements};
use super::emitter_tree::{ChosenElements, EmitterTree};
use super::infinite::{EnvironmentSampler, EnvironmentSamples};
use super::receivers::Receivers;
use crate::lanes::{Float, Mask, Pair, Vector, Width, Word};
use crate::simd::Outlined;

struct ChooseElements<'a, S: Width> {
    tree: &'a EmitterTree,
    receivers: &'a Receivers<S>,
    u: Float<S>,
    active: Mask<S>,
}

struct SampleElements<'a, S: Width> {
    list: &'a ElementList,
    scene: EmittingScene<'a>,
    element: Word<S>,
    lanes: Mask<S>,
    p: Vector<S>,
    u: Pair<S>,
}

struct SampleEnvironment<'a, S: Width> {
    sampler: &'a EnvironmentSampler,
    u: Pair<S>,
    lanes: Mask<S>,
}

struct LookUpEnvironment<'a, S: Width> {
    sampler: &'a EnvironmentSampler,
    wi: Vector<S>,
}

impl<S: Width> Outlined for ChooseElements<'_, S> {
    type Output = ChosenElements<S>;

    #[inline(always)]
    fn run(self) -> ChosenElements<S> {
        self.tree
            .sample_inlined(self.receivers, self.u, self.active)
    }
}

impl<S: Width> Outlined for SampleElements<'_, S> {
    type Output = PointsOfElements<S>;

    #[inline(always)]
    fn run(self) -> PointsOfElements<S> {
        self.list
            .sample_inlined(self.scene, self.element, self.lanes, self.p, self.u)
    }
}

impl<S: Width> Outlined for SampleEnvironment<'_, S> {
    type Output = EnvironmentSamples<S>;

    #[inline(always)]
    fn run(self) -> EnvironmentSamples<S> {
        self.sampler.sample_inlined(self.u, self.lanes)
    }
}

impl<S: Width> Outlined for LookUpEnvironment<'_, S> {
    type Output = EnvironmentSamples<S>;

    #[inline(always)]
    fn run(self) -> EnvironmentSamples<S> {
        self.sampler.look_up_inlined(self.wi)
    }
}

impl EmitterTree {
    /// An element for each receiver, and the probability of the choice.
    #[inline(always)]
    pub(super) fn sample<S: Width>(
        &self,
        receivers: &Receivers<S>,
        u: Float<S>,
        active: Mask<S>,
    ) -> ChosenElements<S> {
        u.width().outline(ChooseElements {
            tree: self,
            receivers,
            u,
            active,
        })
    }
}

impl ElementList {
    /// Points of elements, by their indices, as seen from `p`, with the uniform numbers `u`.
    #[inline(always)]
    pub(super) fn sample<S: Width>(
        &self,
        scene: EmittingScene,
        element: Word<S>,
        lanes: Mask<S>,
        p: Vector<S>,
        u: Pair<S>,
    ) -> PointsOfElements<S> {
        lanes.width().outline(SampleElements {
            list: self,
            scene,
            element,
            lanes,
            p,
            u,
        })
    }
}

impl EnvironmentSampler {
    /// Directions in the lanes of `lanes` with density proportional to the interpolated luminance; elsewhere any.
    #[inline(always)]
    pub(super) fn sample<S: Width>(&self, u: Pair<S>, lanes: Mask<S>) -> EnvironmentSamples<S> {
        lanes.width().outline(SampleEnvironment {
            sampler: self,
            u,
            lanes,
        })
    }

    /// Radiance from the unit directions `wi` (pointing away from the scene), and their densities.
    #[inline(always)]
    pub(super) fn look_up<S: Width>(&self, wi: Vector<S>) -> EnvironmentSamples<S> {
        wi.x.width()
            .outline(LookUpEnvironment { sampler: self, wi })
    }
}
