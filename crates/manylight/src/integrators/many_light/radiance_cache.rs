//! A cache of the radiance that surfaces reflect. It ends the directions of bias compensation.
//!
//! A direction sampled at `x` that meets a surface at `y` needs the radiance that the non-specular
//! lobes at `y` reflect towards `x`. Photons estimate it. Diffuse lobes reflect the irradiance of
//! the nearest cache point, which is estimated ahead from the photons around that point. Glossy
//! lobes reflect the photons around `y`.
//!
//! The estimates blur light over their kernels. The kernels shrink from pass to pass as those of
//! caustics, so that the mean over passes converges to the right image. Near corners, where `x`
//! lies within the kernel at `y`, the cache is not used.
//!
//! Where `x` is far enough, a path never goes on beyond `y`. Going on with probability 1/8, with
//! the difference to the cache weighted by 8, keeps the expectation of paths without a cache;
//! measured, it has 12 times the variance in the Kitchen and 10 times in the U-Shape, since each
//! path that goes on is noisy.
//!
//! Sources: Jensen, "Global Illumination Using Photon Maps", EGWR 1996; Christensen, "Faster Photon
//! Map Global Illumination", JGT 1999, for irradiance at a subset of the photons. Here the light is
//! weighted by the clamped fraction.

use super::Compensation;
use super::compensation_photons::direction_fraction;
use super::schedule::{GroupContext, PassGroup};
use crate::arrays::{
    Fields, FoundArray, InvalidArray, NamedArray, Record, arrays_of_records, records_of_arrays,
};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::gather::{Assignment, LightIndex, Strategy};
use crate::ids::{LightGroup, LightId};
use crate::integrators::light_groups::RadianceByGroup;
use crate::maps::density::{
    Bandwidth, DensityReceiver, OnSurface, density_estimate, progressive_radius_scale,
};
use crate::maps::{
    ArrivingPhotons, COVERAGE_PROBES_INDIRECT, KdTree, Located, Neighbors, Patch, PhotonReceiver,
    covered_fraction,
};
use crate::math::Vec3;
use crate::particles::Photon;
use crate::sampling::Stream;
use crate::scene::{PathLimits, Scene};
use crate::transport::Vertex;
use crate::virtual_lights::SurfaceLocation;
use crate::virtual_lights::candidates::Candidates;
use crate::virtual_lights::light_groups::NearestLightsOfGroups;
use rayon::prelude::*;

/// Photons in an estimate. Measured against 24, over 8 passes at 160x90: the variance of the
/// compensation falls from 0.0061 to 0.0042 of relMSE in the U-Shape, for 5 % more time.
pub(super) const CACHE_NEIGHBORS: usize = 48;
/// Most photons of the cache per pass of its group: kernels are narrower with more of them. At
/// 16384 and 32768 (2 passes of some 50 000 photons, all of them kept otherwise, at 72x40, 2 seeds;
/// Kitchen, Glossy Room): relMSE +0.6 and -0.8 % (standard error 1 %).
const PHOTONS_PER_PASS: usize = 1 << 17;
/// Photons per cache point, at least: seven eighths of the photons or more are left for the
/// estimates. At 4 and 16 (2 passes of 128 lights at 72x40, 2 seeds; Kitchen): relMSE +0.8 and +4.3
/// %.
const PHOTONS_PER_POINT: usize = 8;
/// Largest probability `p` with which a photon makes a cache point and is none of the estimates:
/// the flux of the photons that remain grows by `1/(1 - p)`, at most 4/3. At 0.125 and 0.5 (2
/// passes of 128 lights at 72x40, 2 seeds; Kitchen): relMSE +3.2 and +3.0 %.
const MAX_POINT_PROBABILITY: f32 = 0.25;
/// Most cache points per pass of its group. Measured against four times as many, over 8 passes at
/// 160x90: no gain in the Kitchen and the U-Shape, for 5 to 13 % more time.
const POINTS_PER_PASS: usize = 1 << 14;
/// Largest distance from `y` to its cache point, in radii of the kernels around. At 1 and 4 (2
/// passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room, U-Shape): relMSE -0.2 and 0 %.
const REACH: f32 = 2.0;
/// Least distance from `y` to the vertex that it lights, in radii of the kernel. Half of it or
/// twice as much change the error of Kitchen and U-Shape by at most 3 %.
const MIN_DISTANCE: f32 = 2.0;
/// Segments by which the camera path to `y` may exceed two, under a limit of path length. Longer
/// ones do without the cache.
const MAX_EXTRA_SEGMENTS: usize = 6;
/// Kernel radius of glossy estimates at most, in radii of the kernel of the cache point: bounds the
/// search. At 1 and 4 (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room, U-Shape):
/// relMSE -0.1 and 0 %.
const MAX_GLOSSY_RADIUS: f32 = 2.0;

/// Begin of the names of the arrays of cache points.
const POINTS: &str = "cache.points.";
/// Begin of the names of the arrays of their light by group.
const GROUPS: &str = "cache.groups.";
/// Begin of the names of the arrays of photons.
const PHOTONS: &str = "cache.photons.";

/// A photon of the cache.
#[derive(Clone, Copy, Debug)]
struct CachePhoton {
    p: Vec3,
    /// Geometric normal on the side from which the photon arrives, unit.
    n: Vec3,
    /// Unit direction to the previous vertex.
    wi: Vec3,
    /// In W.
    flux: Rgb,
    depth: u16,
    group: LightGroup,
    /// No non-specular event lies between the emitter and here.
    from_emitter: bool,
}

impl CachePhoton {
    /// The photon as one that represents `represented` photons.
    fn new(photon: &Photon, represented: f32) -> Self {
        CachePhoton {
            p: photon.p,
            n: photon.n,
            wi: photon.wi,
            flux: photon.flux * represented,
            depth: photon.depth,
            group: photon.group,
            from_emitter: photon.origin == Lobes::NONE,
        }
    }
}

/// The photons from which a cache is made.
#[derive(Clone, Debug, Default)]
pub(super) struct CacheParticles {
    /// Those of the estimates.
    photons: Vec<CachePhoton>,
    /// Those at which there are cache points. They are drawn independently of the others: a cell
    /// around a photon of the estimate would be too bright.
    points: Vec<Photon>,
}

impl CacheParticles {
    /// Draws photons with probability by their weights. Nothing is drawn without compensation, and
    /// for bidirectional lightcuts, where roulette ends the camera paths.
    pub(super) fn draw(cx: &GroupContext, candidates: &Candidates) -> Self {
        cx.run.stats.time("maps", || Self::drawn(cx, candidates))
    }

    fn drawn(cx: &GroupContext, candidates: &Candidates) -> Self {
        let photons = &candidates.photons;
        let mut particles = CacheParticles::default();
        let is_bidirectional = matches!(cx.method.strategy, Strategy::Bidirectional(_));
        if cx.method.compensation == Compensation::None || is_bidirectional {
            return particles;
        }
        let passes = cx.group.passes.len();
        let points = (photons.len() / PHOTONS_PER_POINT).clamp(1, POINTS_PER_PASS * passes);
        let of_point = candidates.inclusion_probabilities(points);
        let of_photon = candidates.inclusion_probabilities(PHOTONS_PER_PASS * passes);
        let mut rng = cx.run.pass.sampler(Stream::CachePoints, 0);
        for (photon, (of_point, of_photon)) in photons.iter().zip(of_point.iter().zip(of_photon)) {
            let of_point = of_point.min(MAX_POINT_PROBABILITY);
            if rng.next_1d() < of_point {
                particles.points.push(*photon);
            } else if rng.next_1d() < of_photon {
                let represented = 1.0 / ((1.0 - of_point) * of_photon);
                let photon = CachePhoton::new(photon, represented);
                particles.photons.push(photon);
            }
        }
        particles
    }
}

impl Record for CachePhoton {
    const EMPTY: Self = CachePhoton {
        p: Vec3::ZERO,
        n: Vec3::ZERO,
        wi: Vec3::ZERO,
        flux: Rgb::BLACK,
        depth: 0,
        group: LightGroup(0),
        from_emitter: false,
    };

    fn fields(&mut self, f: &mut impl Fields) {
        f.vec3("p", &mut self.p);
        f.vec3("n", &mut self.n);
        f.vec3("wi", &mut self.wi);
        f.rgb("flux", &mut self.flux);
        f.word("depth", &mut self.depth);
        f.word("group", &mut self.group.0);
        f.flag("from_emitter", &mut self.from_emitter);
    }
}

impl Located for CachePhoton {
    #[inline]
    fn position(&self) -> Vec3 {
        self.p
    }
}

impl OnSurface for CachePhoton {
    #[inline]
    fn normal(&self) -> Vec3 {
        self.n
    }
    #[inline]
    fn wi(&self) -> Vec3 {
        self.wi
    }
    #[inline]
    fn depth(&self) -> u32 {
        u32::from(self.depth)
    }
}

/// Light around a cache point: of all emitters, or of those of one light group.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CachedLight {
    /// `Σ_j k_j Φ_j a(wi_j) / a(n)` with the diffuse albedo `a` before the exit transmittance, in
    /// W/m²: the irradiance, where `a` does not depend on direction.
    irradiance: Rgb,
    /// The light to which a photon at this point is assigned.
    light: Option<LightId>,
    /// Fraction of the irradiance that arrives by photons of at most `max_depth - 3 - i` segments;
    /// until it is complete, luminance instead of the fraction.
    within_limits: [f32; MAX_EXTRA_SEGMENTS],
}

impl CachedLight {
    const BLACK: CachedLight = CachedLight {
        irradiance: Rgb::BLACK,
        light: None,
        within_limits: [0.0; MAX_EXTRA_SEGMENTS],
    };

    /// As fields of a record.
    fn fields(&mut self, f: &mut impl Fields) {
        f.rgb("irradiance", &mut self.irradiance);
        f.light("light", &mut self.light);
        f.floats("within_limits", &mut self.within_limits);
    }
}

/// Light of a group at a cache point.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroupLight {
    pub(super) group: LightGroup,
    pub(super) light: CachedLight,
}

impl Record for GroupLight {
    const EMPTY: Self = GroupLight {
        group: LightGroup(0),
        light: CachedLight::BLACK,
    };

    fn fields(&mut self, f: &mut impl Fields) {
        f.word("group", &mut self.group.0);
        self.light.fields(f);
    }
}

/// Diffusely reflected light around a photon.
#[derive(Clone, Copy, Debug)]
pub(super) struct CachePoint {
    patch: Patch,
    /// Of all light groups. With several of them it has no light.
    all: CachedLight,
    /// Index of the light of the first light group that has some here, and number of these groups.
    groups: [u32; 2],
    /// Radius of the kernel, in m.
    radius: f32,
}

impl Record for CachePoint {
    const EMPTY: Self = CachePoint {
        patch: Patch::EMPTY,
        all: CachedLight::BLACK,
        groups: [0; 2],
        radius: 0.0,
    };

    fn fields(&mut self, f: &mut impl Fields) {
        self.patch.fields(f);
        self.all.fields(f);
        f.words("groups", &mut self.groups);
        f.extended("radius", &mut self.radius);
    }
}

impl Located for CachePoint {
    #[inline]
    fn position(&self) -> Vec3 {
        self.patch.p
    }
}

impl CachedLight {
    /// Adds a photon that arrives with this irradiance; `allows(i)` tells whether a path is within
    /// the limits that has `3 + i` segments more than the photon.
    fn add(&mut self, arriving: Rgb, allows: impl Fn(u32) -> bool) {
        self.irradiance += arriving;
        for (i, sum) in self.within_limits.iter_mut().enumerate() {
            if allows(i as u32) {
                *sum += arriving.luminance();
            }
        }
    }

    /// The light from the sums over photons, in a kernel of which the fraction `covered` is
    /// surface.
    fn complete(mut self, covered: f32, light: Option<LightId>) -> Self {
        let all = self.irradiance.luminance().max(f32::MIN_POSITIVE);
        self.within_limits = self.within_limits.map(|sum| sum / all);
        self.irradiance /= covered;
        CachedLight { light, ..self }
    }

    /// The light that represents light from `point`.
    pub(super) fn assignment(&self, point: &CachePoint, lights: &LightIndex) -> Assignment {
        lights.assignment(self.light, point.patch.p)
    }

    /// Radiance that diffuse lobes with the scattering function `f`, in 1/sr, reflect along a
    /// camera path of `segments` segments, in W/(m² sr).
    pub(super) fn reflected(&self, f: Rgb, segments: u32) -> Rgb {
        let fraction = match segments.saturating_sub(2) as usize {
            0 => 1.0,
            extra => self.within_limits[(extra - 1).min(MAX_EXTRA_SEGMENTS - 1)],
        };
        self.irradiance * f * fraction
    }
}

impl CachePoint {
    /// Light of all groups.
    pub(super) fn all(&self) -> &CachedLight {
        &self.all
    }

    /// Whether the kernel is small beside the distance from `y` to `x`, in m.
    pub(super) fn serves(&self, distance: f32) -> bool {
        distance > MIN_DISTANCE * self.radius
    }
}

/// A cache of the radiance that surfaces reflect.
#[derive(Debug)]
pub(in crate::integrators) struct RadianceCache {
    points: KdTree<CachePoint>,
    /// Light of the groups that have some, by cache point.
    groups: Vec<GroupLight>,
    photons: KdTree<CachePhoton>,
    /// As [`Bandwidth::share`].
    radius_scale: f32,
    limits: PathLimits,
}

impl RadianceCache {
    /// The cache of a group.
    pub(super) fn new(
        cx: &GroupContext,
        particles: CacheParticles,
        nearest: &NearestLightsOfGroups,
    ) -> Self {
        (cx.run.stats).time("maps", || Self::of_particles(cx, particles, nearest))
    }

    fn of_particles(
        cx: &GroupContext,
        particles: CacheParticles,
        nearest: &NearestLightsOfGroups,
    ) -> Self {
        let mut cache = RadianceCache {
            points: KdTree::build(Vec::new()),
            groups: Vec::new(),
            photons: KdTree::build(Vec::new()),
            radius_scale: progressive_radius_scale(cx.group.passes.end),
            limits: cx.limits,
        };
        let CacheParticles { photons, points } = particles;
        cache.photons = KdTree::build_ordered(photons);
        let points = points.par_iter().map_init(
            || Neighbors::new(CACHE_NEIGHBORS),
            |found, photon| cache.point_at(cx, photon, nearest, found),
        );
        let points: Vec<(CachePoint, Vec<GroupLight>)> = points.collect();
        let mut all = Vec::with_capacity(points.len());
        for (point, groups) in points {
            let place = [cache.groups.len() as u32, groups.len() as u32];
            cache.groups.extend(groups);
            all.push(CachePoint {
                groups: place,
                ..point
            });
        }
        cache.points = KdTree::build_ordered(all);
        cache
    }

    /// The cache point at a photon, and its light by group, if groups are told apart.
    fn point_at(
        &self,
        cx: &GroupContext,
        photon: &Photon,
        nearest: &NearestLightsOfGroups,
        found: &mut Neighbors,
    ) -> (CachePoint, Vec<GroupLight>) {
        let scene = cx.scene;
        let location = SurfaceLocation::of_photon(photon, scene);
        let light = |group| nearest.light(group, scene, &location);
        let bsdf = scene.bsdf(&scene.surface_point(photon.at));
        let facing = bsdf.diffuse_weight(photon.n);
        let relative = |a: f32, facing: f32| if facing > 0.0 { a / facing } else { 1.0 };
        let (mut all, limits) = (CachedLight::default(), self.limits);
        let mut groups = vec![CachedLight::default(); cx.run.light_groups];
        let receiver = DensityReceiver {
            p: photon.p,
            n: photon.n,
        };
        let bandwidth = self.bandwidth(f32::INFINITY);
        let photons = &self.photons;
        let radius = density_estimate(photons, receiver, bandwidth, found, |other, kernel| {
            let a = bsdf.diffuse_weight(other.wi).zip(facing, relative);
            let arriving = other.flux * a * kernel;
            let allows = |i: u32| limits.allow(u32::from(other.depth) + 3 + i);
            all.add(arriving, allows);
            if let Some(of_group) = groups.get_mut(other.group.index()) {
                of_group.add(arriving, allows);
            }
        });
        let (geometry, probes) = (&scene.geometry, COVERAGE_PROBES_INDIRECT);
        let covered = covered_fraction(geometry, receiver, radius, probes, photon.wi);
        let told_apart = !groups.is_empty();
        let point = CachePoint {
            patch: Patch::new(photon.p, photon.n, location.material, 1.0),
            all: all.complete(
                covered,
                (!told_apart).then(|| light(photon.group)).flatten(),
            ),
            groups: [0; 2],
            radius,
        };
        let groups = groups.into_iter().enumerate();
        let lit = groups.filter(|(_, of_group)| !of_group.irradiance.is_black());
        let lit = lit.map(|(group, of_group)| {
            let group = LightGroup(group as u8);
            GroupLight {
                group,
                light: of_group.complete(covered, light(group)),
            }
        });
        (point, lit.collect())
    }

    /// Light of each group that has some at `point`.
    pub(super) fn groups_at(&self, point: &CachePoint) -> &[GroupLight] {
        let [first, count] = point.groups.map(|index| index as usize);
        &self.groups[first..first + count]
    }

    /// The nearest cache point of the surface at `y`; `None` if none is near, or if photons do not
    /// tell which fraction of their light is within the path limits, for camera paths of `segments`
    /// segments to `y`.
    pub(super) fn point(&self, y: &SurfaceLocation, segments: u32) -> Option<&CachePoint> {
        let extra = segments.saturating_sub(2) as usize;
        if self.limits.max_depth.is_some() && extra > MAX_EXTRA_SEGMENTS {
            return None;
        }
        let points = self.points.items();
        let cost = |k: u32| {
            points[k as usize]
                .patch
                .distance_squared(y.p, y.n, y.material)
        };
        let reach = |any: u32, d2: f32| {
            let radius = points[any as usize].radius;
            REACH * REACH * d2.max(radius * radius)
        };
        let (k, d2) = self.points.cheapest_around(y.p, reach, cost)?;
        let point = &points[k as usize];
        (d2 <= point.radius * point.radius).then_some(point)
    }

    /// Radiance that the non-specular lobes at `y` reflect along the camera path, in W/(m² sr), by
    /// the photons around `y`, with the cache point of `y`. Directions account for light of
    /// emitters up to `direction_limit`. `by_group` becomes the radiance of each light group.
    pub(super) fn glossy_radiance(
        &self,
        scene: &Scene,
        (y, point): (&Vertex, &CachePoint),
        direction_limit: f32,
        (found, by_group): (&mut Neighbors, &mut RadianceByGroup),
    ) -> Rgb {
        by_group.clear();
        let at = PhotonReceiver {
            x: &y.x,
            bsdf: &y.bsdf,
            wo: y.w_prev,
            segments: y.segments,
            limits: self.limits,
        };
        let n = y.x.normal_towards(y.w_prev);
        let bandwidth = self.bandwidth(MAX_GLOSSY_RADIUS * point.radius / self.radius_scale);
        let arriving = ArrivingPhotons::around(&self.photons, at, n, bandwidth, found);
        let mut sum = Rgb::BLACK;
        arriving.each(Lobes::NON_SPECULAR, |photon, f_cos, kernel| {
            let fraction = match photon.from_emitter {
                true => direction_fraction(direction_limit, f_cos),
                false => 1.0,
            };
            let value = photon.flux * f_cos * (fraction * kernel);
            sum += value;
            by_group.add(photon.group, value);
        });
        if sum.is_black() {
            return sum;
        }
        let covered = arriving.covered(&scene.geometry, COVERAGE_PROBES_INDIRECT);
        by_group.scale(1.0 / covered);
        sum / covered
    }

    fn bandwidth(&self, largest: f32) -> Bandwidth {
        Bandwidth {
            largest,
            radius_scale: self.radius_scale,
        }
    }

    /// Bytes of the cache of a group of `passes` passes with this number of photons, of
    /// `light_groups` light groups (0: not told apart), at most.
    pub(in crate::integrators) fn bytes_for(
        photons: f64,
        passes: usize,
        light_groups: usize,
    ) -> f64 {
        let bytes =
            |per_pass: usize, size: usize| photons.min((per_pass * passes) as f64) * size as f64;
        let point = size_of::<CachePoint>() + light_groups * size_of::<GroupLight>();
        bytes(PHOTONS_PER_PASS, size_of::<CachePhoton>()) + bytes(POINTS_PER_PASS, point)
    }
}

/// The cache as arrays.
pub(super) fn arrays_of_cache(cache: &RadianceCache) -> Vec<NamedArray<'_>> {
    let mut arrays = arrays_of_records(POINTS, cache.points.items());
    arrays.extend(arrays_of_records(GROUPS, &cache.groups[..]));
    arrays.extend(arrays_of_records(PHOTONS, cache.photons.items()));
    arrays
}

/// The inverse of [`arrays_of_cache`], of a group of passes with `light_groups` light groups and
/// `lights` lights.
///
/// # Errors
/// Those of `read`, and a cache that names other lights.
pub(super) fn cache_of_arrays<E: From<InvalidArray>>(
    group: &PassGroup,
    limits: PathLimits,
    (light_groups, lights): (usize, usize),
    read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
) -> Result<RadianceCache, E> {
    let points: Vec<CachePoint> = records_of_arrays(POINTS, read)?;
    let groups: Vec<GroupLight> = records_of_arrays(GROUPS, read)?;
    let photons: Vec<CachePhoton> = records_of_arrays(PHOTONS, read)?;
    let is_group = |group: LightGroup| group.index() < light_groups.max(1);
    let has_light = |light: &CachedLight| light.light.is_none_or(|light| light.index() < lights);
    let are_listed = |point: &CachePoint| {
        let [first, count] = point.groups.map(u64::from);
        first + count <= groups.len() as u64
    };
    let are_sound = points
        .iter()
        .all(|point| has_light(&point.all) && are_listed(point))
        && groups
            .iter()
            .all(|of_group| is_group(of_group.group) && has_light(&of_group.light))
        && photons.iter().all(|photon| is_group(photon.group));
    if !are_sound {
        let message = "a row names a light or a light group that is not there";
        return Err(InvalidArray::new(POINTS, message).into());
    }
    Ok(RadianceCache {
        points: KdTree::of_ordered(points),
        groups,
        photons: KdTree::of_ordered(photons),
        radius_scale: progressive_radius_scale(group.passes.end),
        limits,
    })
}
