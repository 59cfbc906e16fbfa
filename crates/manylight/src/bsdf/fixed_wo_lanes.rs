//! Sixteen scattering functions with fixed outgoing directions in lanes, for the innermost loop
//! over lights.
//!
//! The most frequent models separate what depends on `wo` alone: `with_wo` of the model is a
//! function of `wi`. Other models are evaluated lane by lane.

use super::incident_cone::IncidentCone;
use super::leaf::Leaf;
use super::lobes::Classes;
use super::material::Distribution;
use super::model::Model;
use super::models::conductor::RoughConductorToWo;
use super::models::diffuse::DiffuseToWo;
use super::models::plastic::{PlasticToWo, RoughPlasticToWo};
use super::models::principled::PrincipledToWo;
use super::scattering_model::ScatteringModel;
use super::tilt::TiltToWo;
use super::{Bsdf, FixedWo, Lobes};
use crate::color::Rgb;
use crate::lanes::{
    Axes, CacheAligned, Color, Float, LANES, LaneMask, Lanes, Lanes3, Mask, One, Sixteen, Stored,
    Vector, lanes_of,
};
use crate::math::{Spread, Vec3};
use crate::simd::{Isa, Portable, Simd, SimdKernel, outlined};

/// Fewest directions for which the preparation of lanes pays: it costs about as much as four single
/// values. At 3 and 12, the time of 2 passes of `photon-map` at 72x40 differs by less than 1 % in
/// the Glossy Room, as between 3 and 12 in the Kitchen.
const FEWEST_IN_LANES: usize = 6;

/// The model that all lanes of a [`FixedWoLanes`] share. Bump and normal maps may tilt it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneModel {
    /// Lambert's model: `f` is constant without a tilt.
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

impl LaneModel {
    /// The model with which `bsdf` may be a lane of a [`FixedWoLanes`].
    pub fn of(bsdf: &Bsdf) -> Self {
        let Some(leaf) = bsdf.only_leaf() else {
            return LaneModel::Any;
        };
        match &leaf.model {
            Model::Diffuse(_) => LaneModel::Lambert,
            Model::Plastic(_) => LaneModel::Plastic,
            Model::RoughConductor(m) => LaneModel::Conductor(m.facets.distribution()),
            Model::RoughPlastic(m) => LaneModel::RoughPlastic(m.facets.distribution()),
            Model::Principled(m) if !m.transmits().any() => LaneModel::Principled,
            _ => LaneModel::Any,
        }
    }
}

/// The `NON_SPECULAR` lobes of up to sixteen scattering functions of one [`LaneModel`], each with
/// its own fixed `wo`.
#[derive(Clone, Debug)]
pub struct FixedWoLanes<'b, 's>(Functions<'b, 's>);

#[derive(Clone, Debug)]
enum Functions<'b, 's> {
    OfModel(Box<Directed<'s>>),
    /// The functions of [`LaneModel::Any`].
    Any(Vec<FixedWo<'b, 's>>),
}

/// The functions of one model in lanes, and their directions.
#[derive(Clone, Copy, Debug)]
struct Directed<'s> {
    /// World-space axes of the local frames. The normal is on the side of `wo`.
    frame: Axes<Stored>,
    /// `wo` in the local frame.
    wo: Vector<Stored>,
    model: ModelToWo<'s>,
    /// If some lane is tilted. The others have the normal of their frame, and no shadowing.
    tilt: Option<TiltToWo<Stored>>,
}

/// The models with a fixed `wo`.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "one for sixteen gather points, and evaluated in the innermost loop"
)]
enum ModelToWo<'s> {
    Diffuse(CacheAligned<DiffuseToWo<Stored>>),
    Plastic(CacheAligned<PlasticToWo<Stored>>),
    RoughConductor(CacheAligned<RoughConductorToWo<Stored>>),
    RoughPlastic(CacheAligned<RoughPlasticToWo<'s, Stored>>),
    Principled {
        front: CacheAligned<PrincipledToWo<Stored>>,
        /// Whether [`PrincipledToWo::has_extras`] is true in some lane.
        has_extras: bool,
    },
}

impl<'b, 's> FixedWoLanes<'b, 's> {
    /// The `NON_SPECULAR` ones of `lobes` of at most sixteen functions of the given model, each
    /// with the unit direction `wo`. Lanes without a function are black.
    pub fn new(
        model: LaneModel,
        lobes: Lobes,
        functions: impl Iterator<Item = (&'b Bsdf<'s>, Vec3)>,
    ) -> Self {
        let lobes = lobes.and(Lobes::NON_SPECULAR);
        if model == LaneModel::Any {
            let single = functions.map(|(bsdf, wo)| FixedWo::new(bsdf, wo, lobes));
            return FixedWoLanes(Functions::Any(single.collect()));
        }
        let mut all: Option<Directed> = None;
        for (i, (bsdf, wo)) in functions.enumerate() {
            debug_assert!(model == LaneModel::of(bsdf));
            if let Some(lit) = LitLeaf::of(bsdf, wo) {
                let all = all.get_or_insert_with(|| Directed::black(&lit));
                all.set_lane(i, &lit, lobes);
            }
        }
        FixedWoLanes(Functions::OfModel(Box::new(
            all.unwrap_or_else(Directed::without_functions),
        )))
    }

    /// The same function and `wo` in all lanes, for any model but [`LaneModel::Any`].
    pub(super) fn alike(lobes: Lobes, bsdf: &Bsdf<'s>, wo: Vec3) -> Self {
        let lobes = lobes.and(Lobes::NON_SPECULAR);
        let all = LitLeaf::of(bsdf, wo).map(|lit| Directed::alike(&lit, lobes, lit.leaf.weight));
        FixedWoLanes(Functions::OfModel(Box::new(
            all.unwrap_or_else(Directed::without_functions),
        )))
    }

    /// [`FixedWo::f_cos_wi`] in each active lane, for unit directions `wi`; other lanes are
    /// unspecified.
    #[inline(always)]
    pub(crate) fn f_cos_wi<S: Sixteen>(&self, wi: Vector<S>, active: Mask<S>) -> Color<S> {
        let s = wi.z.width();
        match &self.0 {
            Functions::Any(single) => {
                let (wi, mut values) = (Lanes3::of_vectors(wi), Lanes3::ZERO);
                for i in lanes_of(active.bits() as LaneMask) {
                    if let Some(function) = single.get(i) {
                        values.set(i, function.f_cos_wi(wi.vec(i)));
                    }
                }
                values.colors(s)
            }
            Functions::OfModel(functions) => match &functions.model {
                ModelToWo::Diffuse(diffuse) if functions.tilt.is_none() => {
                    let n = functions.frame.n.in_vectors(s);
                    diffuse.in_vectors(s).f_cos_wi(n.dot(wi))
                }
                _ => values(functions, wi),
            },
        }
    }

    /// Upper bounds of all channels of [`FixedWoLanes::f_cos_wi`] over the cones with unit axes
    /// `axes` and half-angles `spreads`, in each active lane; other lanes are unspecified.
    #[inline(always)]
    pub(crate) fn bounds<S: Sixteen>(
        &self,
        s: S,
        axes: &Lanes3,
        spreads: &[Spread; LANES],
        active: LaneMask,
    ) -> Lanes {
        match &self.0 {
            Functions::Any(single) => {
                let mut bounds = [0.0; LANES];
                for i in lanes_of(active) {
                    if let Some(function) = single.get(i) {
                        bounds[i] = function.bound(axes.vec(i), spreads[i]);
                    }
                }
                bounds
            }
            Functions::OfModel(functions) => bounds(s, functions, axes, spreads),
        }
    }
}

/// The only leaf of a function, for a `wo` on a side on which it scatters.
struct LitLeaf<'b, 's> {
    leaf: &'b Leaf<'s, One>,
    /// World-space axes of the frame of the model, with `wo` above the surface.
    frame: Axes<One>,
    /// `wo` in that frame.
    wo: Vector<One>,
    /// If a bump or normal map tilts the frame.
    tilt: Option<TiltToWo<One>>,
}

impl<'b, 's> LitLeaf<'b, 's> {
    /// `None` where `bsdf` scatters nothing to `wo`.
    fn of(bsdf: &'b Bsdf<'s>, wo: Vec3) -> Option<Self> {
        let leaf = bsdf.only_leaf()?;
        let local = bsdf.frame.to_local(wo.into());
        let (outer, on_outer) = leaf.outer.mirror(local.z);
        let mut frame = bsdf.frame;
        frame.n = frame.n * outer;
        let untilted = frame.n;
        if let Some(tilt) = leaf.tilted() {
            let tilted = tilt.frame(tilt.facing(local.scale_z(outer)));
            frame = Axes {
                s: frame.to_world(tilted.s),
                t: frame.to_world(tilted.t),
                n: frame.to_world(tilted.n),
            };
        }
        let (inner, on_inner) = leaf.inner.mirror(frame.n.dot(wo.into()));
        frame.n = frame.n * inner;
        let wo = frame.to_local(wo.into());
        (on_outer & on_inner & wo.z.gt(0.0)).any().then(|| LitLeaf {
            leaf,
            frame,
            wo,
            tilt: leaf.tilted().map(|tilt| TiltToWo {
                normal: untilted * inner,
                alpha2: tilt.alpha2(),
            }),
        })
    }

    /// The classes of the model for the classes `lobes` of the function.
    fn model_lobes(&self, lobes: Lobes) -> Classes<One> {
        self.leaf.model_lobes(lobes.into())
    }
}

impl<'s> Directed<'s> {
    /// The `lobes` of one function times `weight` in all lanes.
    fn alike(lit: &LitLeaf<'_, 's>, lobes: Lobes, weight: Float<One>) -> Self {
        let (s, wo, lobes) = (Portable, lit.wo, lit.model_lobes(lobes));
        let model = match &lit.leaf.model {
            Model::Diffuse(m) => {
                let all = m.with_wo(lobes, weight).in_lanes(s);
                ModelToWo::Diffuse(CacheAligned(all))
            }
            Model::Plastic(m) => {
                let all = m.with_wo(wo, lobes, weight).in_lanes(s);
                ModelToWo::Plastic(CacheAligned(all))
            }
            Model::RoughConductor(m) => {
                let all = m.with_wo(wo, lobes, weight).in_lanes(s);
                ModelToWo::RoughConductor(CacheAligned(all))
            }
            Model::RoughPlastic(m) => {
                let all = m.with_wo(wo, lobes, weight).in_lanes(s);
                ModelToWo::RoughPlastic(CacheAligned(all))
            }
            Model::Principled(m) => {
                let front = m.with_wo(wo, lobes, weight);
                ModelToWo::Principled {
                    has_extras: front.has_extras().any(),
                    front: CacheAligned(front.in_lanes(s)),
                }
            }
            _ => unreachable!("invariant: other models are evaluated lane by lane"),
        };
        Directed {
            frame: lit.frame.in_lanes(s),
            wo: wo.in_lanes(s),
            model,
            tilt: lit.tilt.map(|tilt| tilt.in_lanes(s)),
        }
    }

    /// Functions of the model and in the frame of `lit` that scatter nothing.
    fn black(lit: &LitLeaf<'_, 's>) -> Self {
        Directed::alike(lit, Lobes::NONE, 0.0.into())
    }

    /// No function in any lane.
    fn without_functions() -> Self {
        let zero = Vector::<One>::from(Vec3::ZERO).in_lanes(Portable);
        let black = super::models::diffuse::Diffuse {
            reflectance: Color::from(Rgb::BLACK),
        };
        Directed {
            frame: Axes {
                s: zero,
                t: zero,
                n: zero,
            },
            wo: zero,
            model: ModelToWo::Diffuse(CacheAligned(
                (black.with_wo(Lobes::NONE.into(), 0.0.into())).in_lanes(Portable),
            )),
            tilt: None,
        }
    }

    /// Sets lane `i` to the `lobes` of a function of the same model.
    fn set_lane(&mut self, i: usize, lit: &LitLeaf<'_, 's>, lobes: Lobes) {
        let (wo, lobes, weight) = (lit.wo, lit.model_lobes(lobes), lit.leaf.weight);
        self.set_tilt(i, lit);
        self.frame.set_lane(i, lit.frame);
        self.wo.set_lane(i, wo);
        match (&mut self.model, &lit.leaf.model) {
            (ModelToWo::Diffuse(all), Model::Diffuse(m)) => {
                all.set_lane(i, m.with_wo(lobes, weight));
            }
            (ModelToWo::Plastic(all), Model::Plastic(m)) => {
                all.set_lane(i, m.with_wo(wo, lobes, weight));
            }
            (ModelToWo::RoughConductor(all), Model::RoughConductor(m)) => {
                all.set_lane(i, m.with_wo(wo, lobes, weight));
            }
            (ModelToWo::RoughPlastic(all), Model::RoughPlastic(m)) => {
                all.set_lane(i, m.with_wo(wo, lobes, weight));
            }
            (ModelToWo::Principled { front, has_extras }, Model::Principled(m)) => {
                let single = m.with_wo(wo, lobes, weight);
                *has_extras |= single.has_extras().any();
                front.set_lane(i, single);
            }
            _ => unreachable!("invariant: all lanes have one model"),
        }
    }

    /// Sets the tilt of lane `i`, before its frame is set.
    fn set_tilt(&mut self, i: usize, lit: &LitLeaf) {
        let flat = |normal| TiltToWo {
            normal,
            alpha2: 0.0.into(),
        };
        if lit.tilt.is_some() && self.tilt.is_none() {
            let mut all = flat(lit.frame.n).in_lanes(Portable);
            all.normal = self.frame.n;
            self.tilt = Some(all);
        }
        if let Some(all) = &mut self.tilt {
            all.set_lane(i, lit.tilt.unwrap_or(flat(lit.frame.n)));
        }
    }
}

outlined! {
    fn values<S: Sixteen>(
        functions: &Directed<'_>, wi: Vector<S>,
    ) -> Color<S> { wi.z.width() => functions.f_cos_wi(wi) }

    fn bounds<S: Sixteen>(
        _s: S, functions: &Directed<'_>, axes: &Lanes3, spreads: &[Spread; LANES],
    ) -> Lanes { _s => functions.bounds(axes, spreads) }
}

impl Directed<'_> {
    /// See [`FixedWoLanes::f_cos_wi`].
    #[inline(always)]
    fn f_cos_wi<S: Sixteen>(&self, wi: Vector<S>) -> Color<S> {
        let s = wi.z.width();
        let towards = wi;
        let (wi, wo) = (self.frame.in_vectors(s).to_local(wi), self.wo.in_vectors(s));
        let value = match &self.model {
            ModelToWo::Diffuse(m) => m.in_vectors(s).f_cos_wi(wi.z),
            ModelToWo::Plastic(m) => m.in_vectors(s).f_cos_wi(wi.z),
            ModelToWo::RoughConductor(m) => m.in_vectors(s).f_cos_wi(wi, wo),
            ModelToWo::RoughPlastic(m) => m.in_vectors(s).f_cos_wi(wi, wo),
            ModelToWo::Principled { front, has_extras } => {
                let front = front.in_vectors(s);
                if *has_extras {
                    front.f_cos_wi::<true>(wi, wo)
                } else {
                    front.f_cos_wi::<false>(wi, wo)
                }
            }
        };
        match &self.tilt {
            None => value,
            Some(tilt) => tilt.in_vectors(s).attenuated(value, towards),
        }
    }

    /// See [`FixedWoLanes::bounds`]. Loops over lanes, one for each model, which become vector
    /// instructions.
    #[inline(always)]
    fn bounds(&self, axes: &Lanes3, spreads: &[Spread; LANES]) -> Lanes {
        let mut bounds = [0.0; LANES];
        match &self.model {
            ModelToWo::Diffuse(m) => {
                for (i, bound) in bounds.iter_mut().enumerate() {
                    *bound = m.lane(i).bound(&self.incident(i, axes, spreads));
                }
            }
            ModelToWo::Plastic(m) => {
                for (i, bound) in bounds.iter_mut().enumerate() {
                    *bound = m.lane(i).bound(&self.incident(i, axes, spreads));
                }
            }
            ModelToWo::RoughConductor(m) => {
                for (i, bound) in bounds.iter_mut().enumerate() {
                    *bound = (m.lane(i)).bound(&self.incident(i, axes, spreads), self.wo(i));
                }
            }
            ModelToWo::RoughPlastic(m) => {
                for (i, bound) in bounds.iter_mut().enumerate() {
                    *bound = (m.lane(i)).bound(&self.incident(i, axes, spreads), self.wo(i));
                }
            }
            ModelToWo::Principled { front, .. } => {
                for (i, bound) in bounds.iter_mut().enumerate() {
                    *bound = (front.lane(i)).bound(&self.incident(i, axes, spreads), self.wo(i));
                }
            }
        }
        bounds
    }

    /// The cone of lane `i` in the local frame.
    #[inline(always)]
    fn incident(&self, i: usize, axes: &Lanes3, spreads: &[Spread; LANES]) -> IncidentCone {
        let Axes { s, t, n } = &self.frame;
        let axis = axes.vec(i);
        let along = |v: &Vector<Stored>| Vec3::from(v.lane(i)).dot(axis);
        IncidentCone {
            axis: Vec3::new(along(s), along(t), along(n)),
            spread: spreads[i],
            projected: None,
        }
    }

    #[inline(always)]
    fn wo(&self, i: usize) -> Vec3 {
        self.wo.lane(i).into()
    }
}

impl FixedWoLanes<'_, '_> {
    /// Replaces the contents of `out` by [`Bsdf::f_cos_wi`] for each of the unit directions `wi`,
    /// for the `NON_SPECULAR` ones of `lobes`.
    pub fn f_cos_each_wi(bsdf: &Bsdf, wi: &[Vec3], wo: Vec3, lobes: Lobes, out: &mut Vec<Rgb>) {
        out.clear();
        if LaneModel::of(bsdf) == LaneModel::Any || wi.len() < FEWEST_IN_LANES {
            let function = FixedWo::new(bsdf, wo, lobes.and(Lobes::NON_SPECULAR));
            out.extend(wi.iter().map(|&wi| function.f_cos_wi(wi)));
            return;
        }
        let functions = FixedWoLanes::alike(lobes, bsdf, wo);
        Isa::best().run(EachInLanes(&functions, wi, out));
    }
}

struct EachInLanes<'a>(&'a FixedWoLanes<'a, 'a>, &'a [Vec3], &'a mut Vec<Rgb>);

impl SimdKernel for EachInLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) {
        let EachInLanes(functions, directions, out) = self;
        let s = isa.wide();
        for chunk in directions.chunks(LANES) {
            let wi = Lanes3::from_fn(|i| chunk[i.min(chunk.len() - 1)]);
            let values = functions.f_cos_wi(wi.vectors(s), Mask::splat(s, true));
            let values = Lanes3::of_colors(values);
            out.extend((0..chunk.len()).map(|i| values.rgb(i)));
        }
    }
}
