//! Elements as receivers see them, in lanes: sampling and densities.

use super::element::ElementShape;
use super::list::ElementList;
use super::planar;
use super::sampling::ElementSampling;
use super::sphere::SphereCones;
use super::visible_point::VisiblePoints;
use crate::color::Rgb;
use crate::emitters::Emitter;
use crate::geometry::{Derivatives, Geometry, SurfacePoints};
use crate::lanes::{Color, Float, Mask, Pair, Vector, Width, Word, lane};
use crate::math::{Vec2, Vec3};
use crate::simd::{outlined, set_bits};
use crate::texture::{ColorInput, Texture};

/// The lanes with elements of each kind.
struct Kinds<S: Width> {
    planar: Mask<S>,
    spheres: Mask<S>,
    points: Mask<S>,
    surfaces: Mask<S>,
}

/// What sampling reads of a scene.
#[derive(Clone, Copy)]
pub(in crate::emitters) struct EmittingScene<'a> {
    pub(in crate::emitters) emitters: &'a [Emitter],
    pub(in crate::emitters) geometry: &'a Geometry,
    pub(in crate::emitters) textures: &'a [Texture],
}

impl EmittingScene<'_> {
    /// Radiance in W/(m² sr) that the surfaces at the points `x` emit, by the indices of their
    /// emitters; black in lanes outside of `lanes`, and for emitters that `radiance` does not know.
    #[inline(always)]
    pub(in crate::emitters) fn surface_radiance<S: Width>(
        self,
        emitters: Word<S>,
        lanes: Mask<S>,
        x: &SurfacePoints<S>,
        radiance: impl Fn(&Emitter) -> Option<ColorInput>,
    ) -> Color<S> {
        let s = lanes.width();
        let mut all = Color::black(s);
        for (i, lanes) in emitters.groups(lanes) {
            let here = match self.emitters.get(i as usize).and_then(&radiance) {
                None => continue,
                Some(ColorInput::Constant(radiance)) => Color::splat(s, radiance),
                Some(radiance) => {
                    let mut colors = s.each(|_| Rgb::BLACK);
                    for i in set_bits(lanes.bits()) {
                        let x = self.geometry.surface_point(x.at.as_ref()[i]);
                        colors.as_mut()[i] = radiance.eval(&x, self.textures);
                    }
                    Color::from_fn(s, |i| colors.as_ref()[i])
                }
            };
            all = Color::select(lanes, here, all);
        }
        all
    }
}

/// Points of elements, and the lanes in which no walk finds them: points, spots and surfaces that
/// no ray meets.
pub(in crate::emitters) type PointsOfElements<S> = (VisiblePoints<S>, Mask<S>);

impl ElementList {
    outlined! {
        /// Points of elements, by their indices, as seen from `p`, with the uniform numbers `u`.
        pub(in crate::emitters) fn sample<S: Width>(
            list: &ElementList, scene: EmittingScene<'_>, element: Word<S>, lanes: Mask<S>,
            p: Vector<S>, u: Pair<S>,
        ) -> PointsOfElements<S> { lanes.width() => list.sample_inlined(scene, element, lanes, p, u) }
    }

    #[inline(always)]
    fn sample_inlined<S: Width>(
        &self,
        scene: EmittingScene,
        element: Word<S>,
        lanes: Mask<S>,
        p: Vector<S>,
        u: Pair<S>,
    ) -> PointsOfElements<S> {
        let kinds = self.kinds(element, lanes);
        let mut points = VisiblePoints::none(lanes.width());
        if kinds.planar.any() {
            points = planar::sample(&self.sampling, element, kinds.planar, p, u);
        }
        let mut surfaces = kinds.surfaces;
        if kinds.spheres.any() {
            let cones = SphereCones::load(&self.sampling, element, kinds.spheres, p);
            surfaces |= kinds.spheres & !cones.outside;
            points = VisiblePoints::select(cones.outside, cones.sample(u), points);
        }
        if kinds.points.any() {
            let more = self.points(scene, element, kinds.points, p);
            points = VisiblePoints::select(kinds.points, more, points);
        }
        if surfaces.any() {
            let more = self.surfaces(scene, element, surfaces, p, u);
            points = VisiblePoints::select(surfaces, more, points);
        }
        let mut unseen = kinds.points;
        if self.has_invisible {
            let elements = element.store();
            for i in set_bits((lanes & !unseen).bits()) {
                let of = self.element(elements.as_ref()[i] as usize);
                if scene.emitters[of.emitter.index()].is_invisible() {
                    unseen |= Mask::from_bits(lanes.width(), 1 << i);
                }
            }
        }
        (points, unseen)
    }

    #[inline(always)]
    fn kinds<S: Width>(&self, element: Word<S>, lanes: Mask<S>) -> Kinds<S> {
        let none = Mask::splat(lanes.width(), false);
        let mut kinds = Kinds {
            planar: none,
            spheres: none,
            points: none,
            surfaces: none,
        };
        for (i, lanes) in element.groups(lanes) {
            match self.sampling[i as usize] {
                ElementSampling::Planar(_) => kinds.planar |= lanes,
                ElementSampling::Sphere(_) => kinds.spheres |= lanes,
                ElementSampling::Point(_) => kinds.points |= lanes,
                ElementSampling::Surface => kinds.surfaces |= lanes,
            }
        }
        kinds
    }

    /// Points and spots.
    #[inline(always)]
    fn points<S: Width>(
        &self,
        scene: EmittingScene,
        element: Word<S>,
        lanes: Mask<S>,
        p: Vector<S>,
    ) -> VisiblePoints<S> {
        let s = lanes.width();
        let mut position = Vector::splat(s, Vec3::ZERO);
        let mut intensity = Color::black(s);
        for (i, lanes) in element.groups(lanes) {
            let ElementSampling::Point(of) = &self.sampling[i as usize] else {
                continue;
            };
            position = Vector::select(lanes, Vector::splat(s, of.position), position);
            let here = match of.intensity {
                Some(uniform) => Color::splat(s, uniform),
                None => {
                    let emitter = &scene.emitters[of.emitter.index()];
                    spot_intensity(emitter, scene.textures, lanes, p - position)
                }
            };
            intensity = Color::select(lanes, here, intensity);
        }
        let d = position - p;
        let (wi, valid) = d.try_normalize();
        VisiblePoints {
            wi,
            target: position,
            pdf: d.length_squared(),
            radiance: intensity,
            valid: lanes & valid,
        }
    }

    /// Other surfaces, by area.
    #[inline(always)]
    fn surfaces<S: Width>(
        &self,
        scene: EmittingScene,
        element: Word<S>,
        lanes: Mask<S>,
        p: Vector<S>,
        u: Pair<S>,
    ) -> VisiblePoints<S> {
        let s = lanes.width();
        let (elements, x, y) = (element.store(), u.x.store(), u.y.store());
        let (mut refs, mut emitters) = (s.each(|_| None), s.each(|_| 0));
        let (mut any, mut sampled) = (None, 0);
        for i in set_bits(lanes.bits()) {
            let element = self.element(elements.as_ref()[i] as usize);
            let u = Vec2::new(x.as_ref()[i], y.as_ref()[i]);
            let at = element.sample_ref(scene.geometry, u);
            refs.as_mut()[i] = at;
            emitters.as_mut()[i] = element.emitter.0;
            any = any.or(at);
            sampled |= u32::from(at.is_some()) << i;
        }
        let Some(any) = any else {
            return VisiblePoints::none(s);
        };
        let refs = s.each(|i| refs.as_ref()[i].unwrap_or(any));
        let y = scene
            .geometry
            .surface_points(s, &refs, Derivatives::OfPosition);
        let (wi, is_apart) = (y.p - p).try_normalize();
        let faces = is_apart & y.frame.n.dot(wi).lt(0.0);
        let sampled = Mask::from_bits(s, sampled) & faces;
        let pdf = self.pdf(element, sampled, p, &y);
        let emitters = Word::load(s, &emitters);
        let radiance = scene.surface_radiance(emitters, sampled, &y, Emitter::surface_radiance);
        VisiblePoints {
            wi,
            target: y.offset_towards(-wi),
            pdf,
            radiance,
            valid: sampled & pdf.gt(0.0) & pdf.is_finite() & !radiance.is_black(),
        }
    }

    /// Density per solid angle of sampling the points `y` of elements with [`ElementList::sample`]
    /// from `p`.
    #[inline(always)]
    pub(in crate::emitters) fn pdf<S: Width>(
        &self,
        element: Word<S>,
        lanes: Mask<S>,
        p: Vector<S>,
        y: &SurfacePoints<S>,
    ) -> Float<S> {
        let s = lanes.width();
        let mut pdf_area = Float::splat(s, 0.0);
        let mut spheres = Mask::splat(s, false);
        for (i, lanes) in element.groups(lanes) {
            let of = self.element(i as usize);
            let density = match of.shape {
                ElementShape::Stretched { uv_density } => {
                    let (u, v) = (y.uv.x.store(), y.uv.y.store());
                    let uv = |i: usize| Vec2::new(u.as_ref()[i], v.as_ref()[i]);
                    let density = Float::from_fn(s, |i| uv_density(uv(i)));
                    density / y.dp_du.cross(y.dp_dv).length()
                }
                _ => Float::splat(s, 1.0 / of.area),
            };
            pdf_area = lanes.select(density, pdf_area);
            if let ElementSampling::Sphere(_) = self.sampling[i as usize] {
                spheres |= lanes;
            }
        }
        let d = y.p - p;
        let d2 = d.length_squared();
        let along = y.ng.dot(d);
        let cos = along.abs() / d2.sqrt();
        let mut pdf = cos.gt(0.0).select(d2 * pdf_area / cos, 0.0);
        if spheres.any() {
            let cones = SphereCones::load(&self.sampling, element, spheres, p);
            let by_cap = along.lt(0.0).select(cones.pdf(), 0.0);
            pdf = cones.outside.select(by_cap, pdf);
        }
        pdf
    }
}

/// Intensities of one spot towards the points at `d` from it, in W/sr.
#[inline(always)]
fn spot_intensity<S: Width>(
    spot: &Emitter,
    textures: &[Texture],
    lanes: Mask<S>,
    d: Vector<S>,
) -> Color<S> {
    let (w, valid) = d.try_normalize();
    let (w, s) = (w.store(), lanes.width());
    let mut intensities = s.each(|_| Rgb::BLACK);
    for i in set_bits((lanes & valid).bits()) {
        let w = lane(&w, i).into();
        intensities.as_mut()[i] = spot.point_intensity(textures, w);
    }
    Color::from_fn(s, |i| intensities.as_ref()[i])
}
