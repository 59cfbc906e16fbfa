//! Photons: flux incident at surfaces, traced from the emitters.

use super::tasks::in_path_order;
use crate::arrays::{Fields, Record};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::{EmissionGuide, EmissionSource, RayDensities};
use crate::geometry::SurfaceRef;
use crate::ids::LightGroup;
use crate::lanes::{Width, lane};
use crate::math::Vec3;
use crate::sampling::{Pass, Stream};
use crate::scene::{LightGroups, PathLimits, Scene};
use crate::simd::set_bits;
use crate::transport::stream::{
    Bits, VertexShader, Vertices, WalkRow, Walks, follow_and_shade, follow_photons, lanes_where,
};
use std::ops::Range;

/// Flux incident at `p` from direction `wi`, already divided by the number of photon paths: for any
/// function `h`
///
/// ```text
/// E[Σ_j Φ_j h(p_j, wi_j)] = ∫∫ L_i(p, w) |n·w| h(p, w) dw dA
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// Position.
    pub p: Vec3,
    /// Geometric normal, turned to the side from which the photon arrives.
    pub n: Vec3,
    /// Unit direction to the previous vertex.
    pub wi: Vec3,
    /// Flux `Φ`, in W.
    pub flux: Rgb,
    /// Flux times [`Bsdf::diffuse_weight`](crate::bsdf::Bsdf::diffuse_weight) at `wi`, in W: the
    /// flux of the diffuse lobes before the exit transmittance.
    pub diffuse_flux: Rgb,
    /// Position of the previous vertex; for infinite lights a point outside of the scene.
    pub prev: Vec3,
    /// The surface and coordinates on it, from which the scattering function is evaluated.
    pub at: SurfaceRef,
    /// Number of segments from the emitter; 1 for direct light.
    pub depth: u16,
    /// Class of the scattering event at `prev`; [`Lobes::NONE`] at an emitter.
    pub event: Lobes,
    /// Class of the last non-specular scattering event; [`Lobes::NONE`] without one since the
    /// emitter.
    pub origin: Lobes,
    /// Light group of the emitter; the first one if groups are not told apart.
    pub group: LightGroup,
    /// Density of photons at the ray from the emitter, in 1/(m² sr); infinite for points, spots,
    /// parallel light and invisible surfaces, which no camera path finds.
    pub ray_density: f32,
}

impl AsRef<Photon> for Photon {
    fn as_ref(&self) -> &Photon {
        self
    }
}

impl Record for Photon {
    const EMPTY: Self = Photon {
        p: Vec3::ZERO,
        n: Vec3::ZERO,
        wi: Vec3::ZERO,
        flux: Rgb::BLACK,
        diffuse_flux: Rgb::BLACK,
        prev: Vec3::ZERO,
        at: SurfaceRef::FIRST,
        depth: 0,
        event: Lobes::NONE,
        origin: Lobes::NONE,
        group: LightGroup(0),
        ray_density: 0.0,
    };

    fn fields(&mut self, f: &mut impl Fields) {
        f.vec3("p", &mut self.p);
        f.vec3("n", &mut self.n);
        f.vec3("wi", &mut self.wi);
        f.rgb("flux", &mut self.flux);
        f.rgb("diffuse_flux", &mut self.diffuse_flux);
        f.vec3("prev", &mut self.prev);
        self.at.fields(f);
        f.word("depth", &mut self.depth);
        f.word("event", &mut self.event.0);
        f.word("origin", &mut self.origin.0);
        f.word("group", &mut self.group.0);
        f.extended("ray_density", &mut self.ray_density);
    }
}

/// Index of the photon at the vertex from which photon `j` was scattered by non-specular lobes, in
/// a list from [`trace_photons`]; `None` if it came from an emitter or a specular event.
pub fn parent(photons: &[Photon], j: usize) -> Option<usize> {
    let child = &photons[j];
    if !child.event.has(Lobes::NON_SPECULAR) {
        return None;
    }
    // Photons in between are of the same path, on transparent surfaces that it passed through.
    (0..j)
        .rev()
        .take_while(|&i| photons[i].depth < child.depth)
        .find(|&i| photons[i].p == child.prev)
}

/// For [`trace_photons`]: the smallest number of segments by which a many-light method extends a
/// photon on a surface with the lobes `surface`, after an event of the given class; `None` on
/// surfaces without non-specular lobes. A virtual light at depth m makes paths of at least m + 2
/// segments, a photon of m + 1: caustic photons, and those that glossy lobes reflect, which
/// compensate clamping.
pub fn usable_by_virtual_lights(surface: Lobes, event: Lobes) -> Option<u32> {
    let is_estimate = event.has(Lobes::SPECULAR) || event.has(Lobes::GLOSSY);
    let segments = if is_estimate { 1 } else { 2 };
    surface.has(Lobes::NON_SPECULAR).then_some(segments)
}

/// Traces `path_count` photon paths and stores a photon at every vertex where it is useful:
/// `segments_added` returns, for the lobes of a surface and the class of the previous event, the
/// smallest number of segments that a camera path adds, or `None` for a useless photon.
///
/// `guide` concentrates photons on what the camera sees; it changes no expected value. Photons of
/// which every extended path would exceed `limits` are left out. The list is in path order, the
/// same for any number of threads.
pub fn trace_photons(
    scene: &Scene,
    guide: &EmissionGuide,
    limits: PathLimits,
    path_count: u32,
    pass: Pass,
    segments_added: impl Fn(Lobes, Lobes) -> Option<u32> + Sync,
) -> Vec<Photon> {
    let scene = (scene, None);
    trace_photons_of_groups(scene, guide, limits, path_count, pass, segments_added)
}

/// [`trace_photons`] that tell the light groups apart, if they are given.
pub fn trace_photons_of_groups(
    (scene, groups): (&Scene, Option<&LightGroups>),
    guide: &EmissionGuide,
    limits: PathLimits,
    path_count: u32,
    pass: Pass,
    segments_added: impl Fn(Lobes, Lobes) -> Option<u32> + Sync,
) -> Vec<Photon> {
    let tracer = PathTracer {
        scene,
        groups,
        guide,
        densities: RayDensities::new(guide, &scene.emitters, path_count),
        limits,
        path_fraction: 1.0 / path_count as f32,
        segments_added,
    };
    in_path_order(path_count, |paths| tracer.trace(pass, paths))
}

/// The arguments of [`trace_photons`] that all paths share.
struct PathTracer<'a, F> {
    scene: &'a Scene,
    groups: Option<&'a LightGroups>,
    guide: &'a EmissionGuide,
    densities: RayDensities,
    limits: PathLimits,
    /// One over the number of paths.
    path_fraction: f32,
    segments_added: F,
}

/// What a photon path carries.
#[derive(Clone, Copy, Debug)]
struct PhotonPath {
    index: u32,
    /// See [`Photon::origin`].
    origin: Lobes,
    /// See [`Photon::ray_density`].
    ray_density: f32,
    group: LightGroup,
}

impl<F: Fn(Lobes, Lobes) -> Option<u32>> PathTracer<'_, F> {
    /// Traces paths, and returns their photons with the index of their path.
    fn trace(&self, pass: Pass, paths: Range<u32>) -> Vec<(u32, Photon)> {
        let mut photons = StoredPhotons {
            tracer: self,
            stored: Vec::new(),
        };
        follow_and_shade(self.scene, self.start(pass, paths), &mut photons);
        photons.stored
    }

    /// The paths at their emitters.
    fn start(&self, pass: Pass, paths: Range<u32>) -> Walks<PhotonPath> {
        let scene = self.scene;
        let mut walks = Walks::with_capacity(paths.len());
        for index in paths {
            let mut sampler = pass.sampler(Stream::Photon, u64::from(index));
            let start = self.guide.sample(
                &scene.emitters,
                &scene.geometry,
                &scene.textures,
                sampler.next_emission(),
            );
            if let Some(start) = start {
                let origin = Lobes::NONE;
                let flux = (start.flux * self.path_fraction).to_array();
                let surfaces = (&scene.geometry, &scene.textures[..]);
                let densities = &self.densities;
                let ray_density = densities.of_sample(&scene.emitters, surfaces, &start);
                let path = PhotonPath {
                    index,
                    origin,
                    ray_density,
                    group: self.group_of(start.source),
                };
                walks.push(WalkRow::start(start.ray, flux, sampler, path));
            }
        }
        walks
    }
}

impl<F> PathTracer<'_, F> {
    fn group_of(&self, source: EmissionSource) -> LightGroup {
        (self.groups).map_or_else(LightGroup::default, |groups| groups.of(source))
    }
}

/// The photons of the paths of a task.
struct StoredPhotons<'a, F> {
    tracer: &'a PathTracer<'a, F>,
    /// With the index of their path.
    stored: Vec<(u32, Photon)>,
}

impl<F: Fn(Lobes, Lobes) -> Option<u32>> VertexShader<PhotonPath> for StoredPhotons<'_, F> {
    #[inline(always)]
    fn shade<S: Width>(
        &mut self,
        v: &Vertices<S>,
        walks: &Walks<PhotonPath>,
        lanes: Bits,
        next: &mut Walks<PhotonPath>,
    ) {
        self.store(v, walks, lanes);
        let generators = v.generators(v.w_prev.x.width(), walks);
        let path = |i: usize| path_at(walks, v.index.as_ref()[i]);
        let round = (walks, self.tracer.limits);
        follow_photons(v, round, lanes, generators, path, next);
    }
}

impl<F: Fn(Lobes, Lobes) -> Option<u32>> StoredPhotons<'_, F> {
    /// Stores the photons at the vertices where they are useful.
    #[inline(always)]
    fn store<S: Width>(&mut self, v: &Vertices<S>, walks: &Walks<PhotonPath>, lanes: Bits) {
        let tracer = self.tracer;
        let surfaces = v.bsdf.lobes_each();
        let useful = lanes_where(lanes, |i| {
            let event = walks.event(v.index.as_ref()[i]);
            let added = (tracer.segments_added)(surfaces.as_ref()[i], event);
            added.is_some_and(|added| tracer.limits.allow(v.segments.as_ref()[i] + added))
        });
        if useful == 0 {
            return;
        }
        let flux = walks.throughput(v.w_prev.x.width(), &v.index);
        let diffuse_flux = (flux * v.bsdf.diffuse_weights(v.w_prev)).store();
        let n = v.x.normals_towards(v.w_prev).store();
        let (p, wi, flux) = (v.x.p.store(), v.w_prev.store(), flux.store());
        for i in set_bits(useful) {
            let walk = v.index.as_ref()[i];
            let (previous, path) = (&walks.state(walk).previous, path_at(walks, walk));
            let photon = Photon {
                p: Vec3::from(lane(&p, i)),
                n: Vec3::from(lane(&n, i)),
                wi: Vec3::from(lane(&wi, i)),
                flux: Rgb::from(lane(&flux, i)),
                diffuse_flux: Rgb::from(lane(&diffuse_flux, i)),
                prev: previous.p,
                at: v.x.at.as_ref()[i],
                depth: v.segments.as_ref()[i].min(u32::from(u16::MAX)) as u16,
                event: previous.event,
                origin: path.origin,
                group: path.group,
                ray_density: path.ray_density,
            };
            self.stored.push((path.index, photon));
        }
    }
}

/// The path of a walk, with the class of its last event.
#[inline(always)]
fn path_at(walks: &Walks<PhotonPath>, walk: u32) -> PhotonPath {
    let (event, path) = (walks.event(walk), walks.state(walk).payload);
    let origin = match event.has(Lobes::SPECULAR) {
        true => path.origin,
        false => event,
    };
    PhotonPath { origin, ..path }
}
