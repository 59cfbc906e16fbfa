//! Sixteen scattering functions whose viewers are fixed, side by side: what the innermost loop of a gather evaluates.
//!
//! Lambert, rough metals, the coated models and the Disney model have code for all lanes at once, made of the same functions that evaluate one;
//! everything else is evaluated lane by lane.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over lanes read like what they become: vector instructions"
)]

use super::bound::Arriving;
use super::conductor::RoughConductor;
use super::fresnel::{self, Metal};
use super::leaf::Leaf;
use super::material::Distribution;
use super::microfacet::Microfacets;
use super::model::Model;
use super::plastic::{COSINES, Plastic, RoughPlastic, interpolate, interpolate_lanes};
use super::principled_front::Fronts;
use super::{Bsdf, Lobes, Receiver};
use crate::color::Rgb;
use crate::lanes::vectors::{dot, scale3};
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3, broadcast, lanes_of};
use crate::math::{Spread, Vec2, Vec3};
use crate::simd::Wide;
use std::f32::consts::FRAC_1_PI;

/// What the lanes of one [`Receivers`] have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `f` is one colour.
    Lambert,
    /// One microfacet lobe with the reflectance of a metal.
    Metal(Distribution),
    /// A diffuse base under a smooth dielectric coat, whose own reflection is no smooth lobe.
    SmoothCoat,
    /// A diffuse base under a rough dielectric coat.
    RoughCoat(Distribution),
    /// The Disney model without transmission.
    Principled,
    /// Whatever it is.
    Any,
}

impl Bsdf<'_> {
    /// Which of the [`Receivers`] this function may be a lane of.
    pub fn form(&self) -> Form {
        let [Some(leaf), None, ..] = &self.leaves else {
            return Form::Any;
        };
        match &leaf.model {
            _ if leaf.tilt.is_some() => Form::Any,
            Model::Diffuse(_) => Form::Lambert,
            Model::Plastic(_) => Form::SmoothCoat,
            Model::RoughConductor(m) => Form::Metal(m.facets.distribution()),
            Model::RoughPlastic(m) => Form::RoughCoat(m.facets.distribution()),
            Model::Principled(m) if !m.transmits() => Form::Principled,
            _ => Form::Any,
        }
    }
}

/// The smooth lobes of up to sixteen scattering functions of one [`Form`], each seen by its own viewer.
#[derive(Clone, Debug)]
pub struct Receivers<'b, 's> {
    form: Form,
    /// World axes of the local frame, the normal on the side that answers.
    frame: [Lanes3; 3],
    /// Direction to the viewer in that frame.
    wo: Lanes3,
    /// Roughness along both axes of the frame, and its inverse.
    roughness: [[Lanes; 2]; 2],
    /// Relative index of refraction of coats, and its inverse.
    eta: Lanes,
    inv_eta: Lanes,
    /// The terms of [`Metal`].
    metal: [Lanes3; 2],
    /// What multiplies `F D G1(wi)` of a microfacet lobe.
    specular: Lanes3,
    /// What multiplies the cosine (and transmittance) of a diffuse lobe.
    base: Lanes3,
    /// Transmittance of rough coats over the cosine.
    transmittance: [&'s [f32; COSINES]; LANES],
    /// The largest of that.
    most_transmitted: Lanes,
    /// Of principled surfaces.
    fronts: Fronts,
    /// For lanes of any form.
    single: [Option<Receiver<'b, 's>>; LANES],
}

impl<'b, 's> Receivers<'b, 's> {
    /// The `lobes` (smooth ones) of functions of the given form with the unit directions to their viewers; at most sixteen. Lanes without
    /// one reflect nothing.
    pub fn new(
        form: Form,
        lobes: Lobes,
        functions: impl Iterator<Item = (&'b Bsdf<'s>, Vec3)>,
    ) -> Self {
        let lobes = lobes.and(Lobes::NON_SPECULAR);
        let mut all = Receivers {
            form,
            frame: [Lanes3::ZERO; 3],
            wo: Lanes3::from_fn(|_| Vec3::Z),
            roughness: [[[1.0; LANES]; 2]; 2],
            eta: [1.0; LANES],
            inv_eta: [1.0; LANES],
            // Finite in lanes without a metal.
            metal: [Lanes3::from_fn(|_| Vec3::ONE); 2],
            specular: Lanes3::ZERO,
            base: Lanes3::ZERO,
            transmittance: [&[1.0; COSINES]; LANES],
            most_transmitted: [1.0; LANES],
            fronts: Fronts::black(),
            single: [None; LANES],
        };
        for (i, (bsdf, wo)) in functions.enumerate() {
            debug_assert!(form == Form::Any || form == bsdf.form());
            match &bsdf.leaves[0] {
                Some(leaf) if form != Form::Any => all.set(i, bsdf, leaf, wo, lobes),
                _ => all.single[i] = Some(bsdf.receiver(wo, lobes)),
            }
        }
        all
    }

    /// One function with one viewer in all lanes; of a form that has code for all lanes.
    pub(super) fn alike(form: Form, lobes: Lobes, bsdf: &'b Bsdf<'s>, wo: Vec3) -> Self {
        debug_assert!(form != Form::Any);
        let mut all = Receivers::new(form, lobes, std::iter::once((bsdf, wo)));
        all.frame.iter_mut().for_each(Lanes3::broadcast);
        all.wo.broadcast();
        all.roughness.iter_mut().flatten().for_each(broadcast);
        broadcast(&mut all.eta);
        broadcast(&mut all.inv_eta);
        all.metal.iter_mut().for_each(Lanes3::broadcast);
        all.specular.broadcast();
        all.base.broadcast();
        broadcast(&mut all.transmittance);
        all.fronts.broadcast();
        all
    }

    fn set(&mut self, i: usize, bsdf: &Bsdf<'s>, leaf: &Leaf<'s>, wo: Vec3, lobes: Lobes) {
        let mut wo = bsdf.frame.to_local(wo);
        let Some(side) = leaf.side(wo.z) else {
            return;
        };
        wo.z *= side;
        if wo.z <= 0.0 {
            return;
        }
        let axes = [bsdf.frame.s, bsdf.frame.t, bsdf.frame.n * side];
        for (lanes, axis) in self.frame.iter_mut().zip(axes) {
            lanes.set(i, axis);
        }
        self.wo.set(i, wo);
        let has_diffuse = lobes.has(Lobes::DIFFUSE);
        match &leaf.model {
            Model::Diffuse(m) if has_diffuse => {
                self.base.set(i, m.reflectance * (leaf.weight * FRAC_1_PI));
            }
            Model::Plastic(m) if has_diffuse => self.set_smooth_coat(i, m, leaf.weight, wo),
            Model::RoughConductor(m) if lobes.has(m.lobes()) => {
                self.set_metal(i, m, leaf.weight, wo);
            }
            Model::RoughPlastic(m) => self.set_rough_coat(i, m, leaf.weight, wo, lobes),
            Model::Principled(m) => {
                let seen = self.set_facets(i, m.facets(), wo);
                self.specular.set(i, Rgb::splat(seen));
                self.fronts.set(i, &m.front(lobes), leaf.weight);
            }
            _ => {}
        }
    }

    fn set_smooth_coat(&mut self, i: usize, m: &Plastic, weight: f32, wo: Vec3) {
        self.set_eta(i, m.eta);
        let exit = fresnel::coat_transmittance(wo.z, m.eta);
        self.base.set(i, m.base * (exit * weight * FRAC_1_PI));
    }

    fn set_metal(&mut self, i: usize, m: &RoughConductor, weight: f32, wo: Vec3) {
        let terms = m.metal.terms();
        self.metal[0].set(i, terms[0]);
        self.metal[1].set(i, terms[1]);
        let seen = self.set_facets(i, &m.facets, wo);
        self.specular.set(i, m.tint * (seen * weight));
    }

    fn set_rough_coat(
        &mut self,
        i: usize,
        m: &RoughPlastic<'s>,
        weight: f32,
        wo: Vec3,
        lobes: Lobes,
    ) {
        self.set_eta(i, m.eta);
        self.transmittance[i] = m.transmittance;
        self.most_transmitted[i] = m.most_transmitted();
        if lobes.has(Lobes::DIFFUSE) {
            let exit = interpolate(m.transmittance, wo.z);
            self.base.set(i, m.base * (exit * weight * FRAC_1_PI));
        }
        if lobes.has(m.coat_class()) {
            let seen = self.set_facets(i, &m.facets, wo);
            self.specular.set(i, m.tint * (seen * weight));
        }
    }

    fn set_eta(&mut self, i: usize, eta: f32) {
        self.eta[i] = eta;
        self.inv_eta[i] = eta.recip();
    }

    /// Returns [`Microfacets::seen`].
    fn set_facets(&mut self, i: usize, facets: &Microfacets, wo: Vec3) -> f32 {
        for (pair, values) in self.roughness.iter_mut().zip(facets.roughness()) {
            pair[0][i] = values.x;
            pair[1][i] = values.y;
        }
        facets.seen(wo)
    }

    /// [`Receiver::f_cos_wi`] in each active lane, for unit directions `wi`; other lanes hold anything.
    #[inline(always)]
    pub(crate) fn f_cos_wi<W: Wide>(&self, w: W, wi: &Lanes3, active: LaneMask) -> Lanes3 {
        match self.form {
            Form::Lambert => self.lambert(w, wi),
            Form::Metal(Distribution::Ggx) => self.metal(wi, Distribution::Ggx),
            Form::Metal(Distribution::Beckmann) => self.metal(wi, Distribution::Beckmann),
            Form::SmoothCoat => self.smooth_coat(w, wi),
            Form::RoughCoat(Distribution::Ggx) => self.rough_coat(w, wi, Distribution::Ggx),
            Form::RoughCoat(Distribution::Beckmann) => {
                self.rough_coat(w, wi, Distribution::Beckmann)
            }
            Form::Principled if self.fronts.has_extras => self.principled::<true>(wi),
            Form::Principled => self.principled::<false>(wi),
            Form::Any => {
                let mut out = Lanes3::ZERO;
                for i in lanes_of(active) {
                    if let Some(receiver) = &self.single[i] {
                        out.set(i, receiver.f_cos_wi(wi.vec(i)));
                    }
                }
                out
            }
        }
    }

    /// Upper bounds of every channel of [`Receivers::f_cos_wi`] for light from the cones with unit axes `axes`, in each active lane; other
    /// lanes hold anything.
    #[inline(always)]
    pub(crate) fn bounds(
        &self,
        axes: &Lanes3,
        spreads: &[Spread; LANES],
        active: LaneMask,
    ) -> Lanes {
        let mut out = [0.0; LANES];
        match self.form {
            Form::Lambert => {
                for i in 0..LANES {
                    let [_, cos] = self.arriving(i, axes, spreads).cosines();
                    out[i] = self.base.rgb(i).max_channel() * cos.max(0.0);
                }
            }
            Form::SmoothCoat => {
                for i in 0..LANES {
                    let [_, cos] = self.arriving(i, axes, spreads).cosines();
                    let cos = cos.max(0.0);
                    let enters = 1.0 - fresnel::coat_reflectance(cos, self.eta[i], self.inv_eta[i]);
                    out[i] = self.base.rgb(i).max_channel() * (enters * cos);
                }
            }
            Form::Metal(distribution) => {
                for i in 0..LANES {
                    let terms = [self.metal[0].rgb(i), self.metal[1].rgb(i)];
                    let arriving = self.arriving(i, axes, spreads);
                    let lobe = self.facet_bound(i, &arriving, distribution);
                    let f = Metal::from_terms(terms).bound(lobe.cosines);
                    out[i] = (self.specular.rgb(i) * f).max_channel() * lobe.density;
                }
            }
            Form::RoughCoat(distribution) => {
                for i in 0..LANES {
                    let arriving = self.arriving(i, axes, spreads);
                    let [_, cos] = arriving.cosines();
                    let base = self.base.rgb(i).max_channel() * self.most_transmitted[i];
                    let lobe = self.facet_bound(i, &arriving, distribution);
                    let f =
                        fresnel::coat_reflectance(lobe.cosines[0], self.eta[i], self.inv_eta[i]);
                    let coat = self.specular.rgb(i).max_channel() * (f * lobe.density);
                    out[i] = base * cos.max(0.0) + coat;
                }
            }
            Form::Principled => {
                for i in 0..LANES {
                    let arriving = self.arriving(i, axes, spreads);
                    let facets = self.facets(i, Distribution::Ggx);
                    let (wo, seen) = (self.wo.vec(i), self.specular.0[0][i]);
                    out[i] = self.fronts.lane(i).bound(&facets, &arriving, wo, seen);
                }
            }
            Form::Any => {
                for i in lanes_of(active) {
                    if let Some(receiver) = &self.single[i] {
                        out[i] = receiver.bound(axes.vec(i), spreads[i]);
                    }
                }
            }
        }
        out
    }

    #[inline(always)]
    fn arriving(&self, i: usize, axes: &Lanes3, spreads: &[Spread; LANES]) -> Arriving {
        Arriving {
            axis: self.to_local(i, axes.vec(i)),
            spread: spreads[i],
            projected: None,
        }
    }

    /// Bounds of the microfacets of lane `i` that reflect light from a cone to the viewer.
    #[inline(always)]
    fn facet_bound(&self, i: usize, arriving: &Arriving, distribution: Distribution) -> FacetBound {
        let halves = arriving.halves(self.wo.vec(i));
        let [_, cos] = arriving.cosines();
        let facets = self.facets(i, distribution);
        FacetBound {
            density: facets.visible_bound(halves.highest, cos),
            cosines: halves.cosines,
        }
    }

    /// Cosines to the normals, or 0.
    #[inline(always)]
    fn cosines<W: Wide>(&self, w: W, wi: &Lanes3) -> W::F {
        let cos = dot(w, self.frame[2].load(w), wi.load(w));
        w.max(cos, w.splat(0.0))
    }

    #[inline(always)]
    fn lambert<W: Wide>(&self, w: W, wi: &Lanes3) -> Lanes3 {
        let cos = self.cosines(w, wi);
        Lanes3::store(w, scale3(w, self.base.load(w), cos))
    }

    #[inline(always)]
    fn smooth_coat<W: Wide>(&self, w: W, wi: &Lanes3) -> Lanes3 {
        let cos = self.cosines(w, wi);
        let mut enters = w.store(cos);
        for i in 0..LANES {
            enters[i] = 1.0 - fresnel::coat_reflectance(enters[i], self.eta[i], self.inv_eta[i]);
        }
        let share = w.mul(w.load(&enters), cos);
        Lanes3::store(w, scale3(w, self.base.load(w), share))
    }

    #[inline(always)]
    fn metal(&self, wi: &Lanes3, distribution: Distribution) -> Lanes3 {
        let mut out = Lanes3::ZERO;
        for i in 0..LANES {
            let lobe = self.facet_lobe(i, self.to_local(i, wi.vec(i)), distribution);
            let terms = [self.metal[0].rgb(i), self.metal[1].rgb(i)];
            let f = Metal::from_terms(terms).reflectance(lobe.cos);
            out.set(i, self.specular.rgb(i) * f * lobe.density);
        }
        out
    }

    #[inline(always)]
    fn rough_coat<W: Wide>(&self, w: W, wi: &Lanes3, distribution: Distribution) -> Lanes3 {
        let cos = self.cosines(w, wi);
        // Rounding may leave a cosine above 1.
        let enters = interpolate_lanes(&self.transmittance, &w.store(w.min(cos, w.splat(1.0))));
        let base = scale3(w, self.base.load(w), w.mul(w.load(&enters), cos));
        let mut out = Lanes3::store(w, base);
        for i in 0..LANES {
            let lobe = self.facet_lobe(i, self.to_local(i, wi.vec(i)), distribution);
            let f = fresnel::coat_reflectance(lobe.cos, self.eta[i], self.inv_eta[i]);
            let coat = self.specular.rgb(i) * (f * lobe.density);
            out.set(i, out.rgb(i) + coat);
        }
        out
    }

    #[inline(always)]
    fn principled<const EXTRAS: bool>(&self, wi: &Lanes3) -> Lanes3 {
        let mut out = Lanes3::ZERO;
        for i in 0..LANES {
            let wi = self.to_local(i, wi.vec(i));
            let facets = self.facets(i, Distribution::Ggx);
            let value = self.fronts.lane(i).eval::<EXTRAS>(
                &facets,
                wi,
                self.wo.vec(i),
                self.specular.0[0][i],
            );
            out.set(i, if wi.z > 0.0 { value } else { Rgb::BLACK });
        }
        out
    }

    #[inline(always)]
    fn to_local(&self, i: usize, w: Vec3) -> Vec3 {
        let [s, t, n] = &self.frame;
        Vec3::new(s.vec(i).dot(w), t.vec(i).dot(w), n.vec(i).dot(w))
    }

    #[inline(always)]
    fn facets(&self, i: usize, distribution: Distribution) -> Microfacets {
        let pair = |k: usize| Vec2::new(self.roughness[k][0][i], self.roughness[k][1][i]);
        Microfacets::from_roughness(distribution, [pair(0), pair(1)])
    }

    /// The microfacets of lane `i` that reflect light from the local direction `wi` to the viewer.
    #[inline(always)]
    fn facet_lobe(&self, i: usize, wi: Vec3, distribution: Distribution) -> FacetLobe {
        let wo = self.wo.vec(i);
        let half = wi + wo;
        let density = self.facets(i, distribution).visible_density(wi, half);
        // Without light from above there may be no half vector.
        let lit = wi.z > 0.0;
        FacetLobe {
            density: if lit { density } else { 0.0 },
            // |wi + wo| = 2 wo·m for unit vectors.
            cos: if lit {
                0.5 * half.length_squared().sqrt()
            } else {
                1.0
            },
        }
    }
}

/// The most that [`FacetLobe::density`] may be, and the range of the cosine.
struct FacetBound {
    density: f32,
    cosines: [f32; 2],
}

/// `D G1(wi)` of the facets with the half vector's normal, and the cosine to it.
struct FacetLobe {
    density: f32,
    cos: f32,
}
