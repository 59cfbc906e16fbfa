//! Sixteen scattering functions with fixed outgoing directions in SIMD lanes, for the innermost loop over lights.
//!
//! The most frequent models have code for all lanes at once, made of the functions that evaluate a single one. Other models are
//! evaluated lane by lane.

mod bounds;
mod each;
mod values;

use super::leaf::Leaf;
use super::material::Distribution;
use super::model::Model;
use super::models::coat::{COSINES, interpolate};
use super::models::conductor::RoughConductor;
use super::models::fresnel;
use super::models::microfacet::Microfacets;
use super::models::plastic::{Plastic, RoughPlastic};
use super::models::principled::PrincipledFrontLanes;
use super::scattering_model::ScatteringModel;
use super::{Bsdf, FixedWo, Lobes};
use crate::color::Rgb;
use crate::lanes::{Float, LANES, Lanes, Lanes3, One, broadcast};
use crate::math::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// The model that all lanes of a [`FixedWoLanes`] share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneModel {
    /// Lambert's model: `f` is constant.
    Lambert,
    /// A rough conductor.
    Conductor(Distribution),
    /// The base of smooth plastic. The reflection at the coat is a delta lobe.
    Plastic,
    /// Rough plastic.
    RoughPlastic(Distribution),
    /// The principled model without transmission.
    Principled,
    /// Any mixture of functions, evaluated lane by lane.
    Any,
}

impl Bsdf<'_> {
    /// The model with which this function may be a lane of a [`FixedWoLanes`].
    pub fn lane_model(&self) -> LaneModel {
        let Some(leaf) = self.only_leaf() else {
            return LaneModel::Any;
        };
        match &leaf.model {
            _ if leaf.tilted().is_some() => LaneModel::Any,
            Model::Diffuse(_) => LaneModel::Lambert,
            Model::Plastic(_) => LaneModel::Plastic,
            Model::RoughConductor(m) => LaneModel::Conductor(m.facets.distribution()),
            Model::RoughPlastic(m) => LaneModel::RoughPlastic(m.facets.distribution()),
            Model::Principled(m) if !m.transmits().any() => LaneModel::Principled,
            _ => LaneModel::Any,
        }
    }
}

/// The `NON_SPECULAR` lobes of up to sixteen scattering functions of one [`LaneModel`], each with its own fixed `wo`.
#[derive(Clone, Debug)]
pub struct FixedWoLanes<'b, 's> {
    model: LaneModel,
    /// World-space axes of the local frame. The normal is on the side of `wo`.
    frame: [Lanes3; 3],
    /// `wo` in the local frame.
    wo: Lanes3,
    /// Roughness alpha along both axes, and its inverse.
    roughness: [[Lanes; 2]; 2],
    /// Relative index of refraction of coats.
    eta: Lanes,
    /// Its inverse.
    inv_eta: Lanes,
    /// The terms of [`fresnel::ConductorFresnel`].
    conductor: [Lanes3; 2],
    /// Factor of `F D G1(wi)` of a microfacet lobe.
    specular: Lanes3,
    /// Factor of the cosine (and transmittance) of a diffuse lobe.
    base: Lanes3,
    /// Tables of the transmittance of rough coats over the cosine.
    transmittance: [&'s [f32; COSINES]; LANES],
    /// Largest entry of each table.
    max_transmittance: Lanes,
    /// Principled models.
    principled: PrincipledFrontLanes,
    /// The functions of [`LaneModel::Any`].
    single: [Option<FixedWo<'b, 's>>; LANES],
}

impl<'b, 's> FixedWoLanes<'b, 's> {
    /// The `NON_SPECULAR` ones of `lobes` of at most sixteen functions of the given model, each with the unit direction `wo`. Lanes
    /// without a function are black.
    pub fn new(
        model: LaneModel,
        lobes: Lobes,
        functions: impl Iterator<Item = (&'b Bsdf<'s>, Vec3)>,
    ) -> Self {
        let lobes = lobes.and(Lobes::NON_SPECULAR);
        let mut all = FixedWoLanes {
            model,
            frame: [Lanes3::ZERO; 3],
            wo: Lanes3::from_fn(|_| Vec3::Z),
            roughness: [[[1.0; LANES]; 2]; 2],
            eta: [1.0; LANES],
            inv_eta: [1.0; LANES],
            // Finite values also in lanes without a conductor.
            conductor: [Lanes3::from_fn(|_| Vec3::ONE); 2],
            specular: Lanes3::ZERO,
            base: Lanes3::ZERO,
            transmittance: [&[1.0; COSINES]; LANES],
            max_transmittance: [1.0; LANES],
            principled: PrincipledFrontLanes::black(),
            single: [None; LANES],
        };
        for (i, (bsdf, wo)) in functions.enumerate() {
            debug_assert!(model == LaneModel::Any || model == bsdf.lane_model());
            match &bsdf.leaves[0] {
                Some(leaf) if model != LaneModel::Any => all.set(i, bsdf, leaf, wo, lobes),
                _ => all.single[i] = Some(bsdf.with_wo(wo, lobes)),
            }
        }
        all
    }

    /// The same function and `wo` in all lanes, for any model but [`LaneModel::Any`].
    pub(super) fn alike(model: LaneModel, lobes: Lobes, bsdf: &'b Bsdf<'s>, wo: Vec3) -> Self {
        debug_assert!(model != LaneModel::Any);
        let mut all = FixedWoLanes::new(model, lobes, std::iter::once((bsdf, wo)));
        all.frame.iter_mut().for_each(Lanes3::broadcast);
        all.wo.broadcast();
        all.roughness.iter_mut().flatten().for_each(broadcast);
        broadcast(&mut all.eta);
        broadcast(&mut all.inv_eta);
        all.conductor.iter_mut().for_each(Lanes3::broadcast);
        all.specular.broadcast();
        all.base.broadcast();
        broadcast(&mut all.transmittance);
        all.principled.broadcast();
        all
    }

    /// Sets lane `i`.
    fn set(&mut self, i: usize, bsdf: &Bsdf<'s>, leaf: &Leaf<'s, One>, wo: Vec3, lobes: Lobes) {
        let local = bsdf.frame.to_local(wo.into());
        let (side, valid) = leaf.side(local.z);
        let wo = Vec3::from(local.scale_z(side));
        if valid.none() || wo.z <= 0.0 {
            return;
        }
        let axes = [bsdf.frame.s, bsdf.frame.t, bsdf.frame.n * side];
        for (lanes, axis) in self.frame.iter_mut().zip(axes) {
            lanes.set(i, Vec3::from(axis));
        }
        self.wo.set(i, wo);
        let weight = leaf.weight.get();
        let has_diffuse = lobes.has(Lobes::DIFFUSE);
        match &leaf.model {
            Model::Diffuse(m) if has_diffuse => {
                self.base
                    .set(i, Rgb::from(m.reflectance) * (weight * FRAC_1_PI));
            }
            Model::Plastic(m) if has_diffuse => self.set_plastic(i, m, weight, wo),
            Model::RoughConductor(m) if lobes.has(m.lobes().get()) => {
                self.set_conductor(i, m, weight, wo);
            }
            Model::RoughPlastic(m) => self.set_rough_plastic(i, m, weight, wo, lobes),
            Model::Principled(m) => {
                let seen = self.set_facets(i, m.facets(), wo);
                self.specular.set(i, Rgb::splat(seen));
                self.principled.set(i, &m.front(lobes.into()), weight);
            }
            _ => {}
        }
    }

    fn set_plastic(&mut self, i: usize, m: &Plastic<One>, weight: f32, wo: Vec3) {
        self.set_eta(i, m.eta);
        let exit = fresnel::coat_transmittance::<One>(wo.z.into(), m.eta).get();
        self.base
            .set(i, Rgb::from(m.base()) * (exit * weight * FRAC_1_PI));
    }

    fn set_conductor(&mut self, i: usize, m: &RoughConductor<One>, weight: f32, wo: Vec3) {
        let terms = m.fresnel.terms();
        self.conductor[0].set(i, terms[0]);
        self.conductor[1].set(i, terms[1]);
        let seen = self.set_facets(i, &m.facets, wo);
        self.specular.set(i, Rgb::from(m.tint) * (seen * weight));
    }

    fn set_rough_plastic(
        &mut self,
        i: usize,
        m: &RoughPlastic<'s, One>,
        weight: f32,
        wo: Vec3,
        lobes: Lobes,
    ) {
        self.set_eta(i, m.eta);
        self.transmittance[i] = m.transmittance;
        self.max_transmittance[i] = m.max_transmittance();
        if lobes.has(Lobes::DIFFUSE) {
            let exit = interpolate::<One>(m.transmittance, wo.z.into()).get();
            self.base
                .set(i, Rgb::from(m.base()) * (exit * weight * FRAC_1_PI));
        }
        if lobes.has(m.facets.class().get()) {
            let seen = self.set_facets(i, &m.facets, wo);
            self.specular.set(i, Rgb::from(m.tint()) * (seen * weight));
        }
    }

    fn set_eta(&mut self, i: usize, eta: f32) {
        self.eta[i] = eta;
        self.inv_eta[i] = eta.recip();
    }

    /// Sets the roughness of lane `i`. Returns [`Microfacets::seen`].
    fn set_facets(&mut self, i: usize, facets: &Microfacets<One>, wo: Vec3) -> f32 {
        for (pair, values) in self.roughness.iter_mut().zip(facets.roughness()) {
            pair[0][i] = values.x;
            pair[1][i] = values.y;
        }
        facets.seen(wo.into()).get()
    }

    /// A world-space direction in the local frame of lane `i`.
    #[inline(always)]
    fn to_local(&self, i: usize, w: Vec3) -> Vec3 {
        let [s, t, n] = &self.frame;
        Vec3::new(s.vec(i).dot(w), t.vec(i).dot(w), n.vec(i).dot(w))
    }

    /// Reflectance of the smooth coat of lane `i` from outside.
    #[inline(always)]
    fn coat_reflectance(&self, i: usize, cos: f32) -> f32 {
        let [cos, eta, inv_eta] = [cos, self.eta[i], self.inv_eta[i]].map(Float::<One>::from);
        fresnel::coat_reflectance(cos, eta, inv_eta).get()
    }

    /// The microfacets of lane `i`.
    #[inline(always)]
    fn facets(&self, i: usize, distribution: Distribution) -> Microfacets<One> {
        let pair = |k: usize| Vec2::new(self.roughness[k][0][i], self.roughness[k][1][i]);
        Microfacets::from_roughness(distribution, pair(0).into(), pair(1).into())
    }
}
