//! The ends of the segments of a round: emitted radiance, the layers of first surfaces, straight-through transmission, and what each part of
//! a path does at a vertex where it scatters.

use super::compensation_photons::direction_fraction;
use super::gather_points::TileGather;
use super::paths::{EMISSION_PATHS, PathPart, PathState, Prefix};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::Layer;
use crate::geometry::SurfacePoint;
use crate::ids::MaterialId;
use crate::integrators::first_event::{FirstEvent, SampleShare, add_first_event};
use crate::integrators::first_surface::{FirstSurface, add_first_surfaces};
use crate::lanes::{Color, Float, Mask, Width, lane};
use crate::math::Vec3;
use crate::scene::Scene;
use crate::simd::set_bits;
use crate::transport::Vertex;
use crate::transport::direct_lanes::emitted_with_mis_lanes;
use crate::transport::stream::{
    Arrivals, Bits, Generators, PacketShader, Vertices, Walks, lanes_where, see_environment, used,
};

/// The camera paths of a round, at the ends of their segments.
pub(super) struct Arriving<'a, 's, 'o, 't> {
    pub(super) walks: &'a Walks<PathState>,
    pub(super) arrivals: &'a Arrivals,
    pub(super) next: &'a mut Walks<PathState>,
    pub(super) tile: &'a mut TileGather<'s, 'o, 't>,
}

/// The vertices of a packet, with the paths that arrive there.
pub(super) struct Arrived<'s, S: Width> {
    pub(super) v: Vertices<'s, S>,
    /// After the segment.
    pub(super) paths: S::Each<PathState>,
    pub(super) throughput: Color<S>,
    pub(super) eta_squared: Float<S>,
    pub(super) generators: Generators<S>,
    pub(super) material: MaterialId,
}

impl<'s, S: Width> Arrived<'s, S> {
    /// The vertex of lane `i`, with the surface points and directions of all lanes.
    #[inline(always)]
    pub(super) fn vertex(
        &self,
        scene: &'s Scene,
        x: &S::Each<SurfacePoint>,
        w_prev: &[S::Each<f32>; 3],
        i: usize,
    ) -> Vertex<'s> {
        let x = x.as_ref()[i];
        Vertex {
            bsdf: scene.materials.bsdf(self.material, &x, &scene.textures),
            x,
            w_prev: Vec3::from(lane(w_prev, i)),
            distance: self.v.hits.as_ref()[i].t,
            segments: self.v.segments.as_ref()[i],
        }
    }
}

impl PacketShader for Arriving<'_, '_, '_, '_> {
    #[inline(always)]
    fn shade<S: Width>(&mut self, s: S, material: MaterialId, packet: &[u32]) {
        let (walks, scene) = (self.walks, self.tile.prepared.scene);
        let limits = self.tile.prepared.limits;
        let active = used(packet.len());
        let primitives = scene.geometry.primitives();
        let emits = lanes_where(active, |i| {
            let hit = self.arrivals.hits[packet[i] as usize];
            hit.is_some_and(|hit| primitives[hit.at.primitive.index()].emitter.is_some())
                && walks.kept[packet[i] as usize].chain().is_none()
        });
        let firsts = lanes_where(active, |i| self.is_first(packet[i]));
        let ends = lanes_where(active, |i| {
            !limits.allow(walks.segments[packet[i] as usize] + 2)
        });
        if emits | firsts | (active & !ends) == 0 {
            return;
        }
        let v = Vertices::new(s, scene, walks, self.arrivals, material, packet);
        if emits != 0 {
            self.add_emission(&v, emits);
        }
        let mut at = Arrived {
            paths: s.each(|i| v.kept(walks, i).after_segment(v.hits.as_ref()[i].t)),
            throughput: walks.throughput(s, &v.index),
            eta_squared: v.eta_squared(s, walks),
            generators: v.generators(s, walks),
            v,
            material,
        };
        self.describe_first_surfaces(&mut at, active & firsts);
        for i in set_bits(firsts & ends) {
            self.add_event(&at, i, at.v.opacity(i));
        }
        let scatters = self.pass_through(s, &mut at, active & !ends);
        if scatters == 0 {
            return;
        }
        for i in set_bits(firsts & scatters) {
            self.add_event(&at, i, 1.0);
        }
        self.end_prefixes(s, &mut at, scatters);
        self.end_chains(&mut at, scatters);
        self.follow_specular(s, &mut at, scatters);
        self.end_directions(&mut at, scatters);
    }
}

impl Arriving<'_, '_, '_, '_> {
    /// Whether path `i` gathers, and has met nothing yet.
    #[inline(always)]
    fn is_first(&self, i: u32) -> bool {
        self.walks.event(i) == Lobes::NONE && self.walks.kept[i as usize].number().is_some()
    }

    /// Adds the environment to the paths that leave the scene.
    pub(super) fn add_escapes(&mut self) {
        let (walks, arrivals) = (self.walks, self.arrivals);
        let TileGather {
            prepared,
            out,
            vertices,
            ..
        } = &mut *self.tile;
        let guide = |i: u32| {
            let direction = walks.kept[i as usize].direction()?;
            vertices[direction.from as usize].environment.as_ref()
        };
        let limits = |from: u32| vertices[from as usize].role.direction_limit();
        let (scene, path_limits) = (prepared.scene, prepared.limits);
        let escaped = &arrivals.escaped;
        see_environment(scene, path_limits, walks, escaped, guide, |i, radiance| {
            let path = walks.kept[i as usize];
            if !radiance.is_black() {
                let radiance = walks.throughput_of(i) * radiance;
                let (layer, radiance) = emitted_part(&path, radiance, limits);
                out.add(path.pixel as usize, layer, radiance);
            }
        });
        for &i in escaped {
            if self.is_first(i) {
                let event = FirstEvent::escape(scene, path_limits);
                self.add_first_event(&walks.kept[i as usize], event);
            }
        }
    }

    /// Adds the radiance that the surfaces emit towards the paths.
    #[inline(always)]
    fn add_emission<S: Width>(&mut self, v: &Vertices<S>, emits: Bits) {
        let walks = self.walks;
        let previous = walks.previous_events(v.w_prev.x.width(), &v.index);
        let emits = v.mask(emits);
        let scene = self.tile.prepared.scene;
        let radiance = emitted_with_mis_lanes(scene, &previous, &v.x, v.w_prev, emits);
        let lit = (emits & !radiance.is_black()).bits();
        let radiance = radiance.store();
        for i in set_bits(lit) {
            let path = v.kept(walks, i);
            let throughput = walks.throughput_of(v.index.as_ref()[i]);
            let radiance = throughput * Rgb::from(lane(&radiance, i));
            let limits = |from: u32| self.tile.vertices[from as usize].role.direction_limit();
            let (layer, radiance) = emitted_part(&path, radiance, limits);
            self.tile.out.add(path.pixel as usize, layer, radiance);
        }
    }

    /// Adds the layers that describe the first surfaces of camera paths.
    #[inline(always)]
    fn describe_first_surfaces<S: Width>(&mut self, at: &mut Arrived<S>, firsts: Bits) {
        let lanes = lanes_where(firsts, |i| at.v.segments.as_ref()[i] == 1);
        if lanes == 0 {
            return;
        }
        let numbers = at.generators.next_bsdf();
        let samples = at.v.bsdf.sample_each_wi(at.v.w_prev, numbers, Lobes::ALL);
        let first = |i: usize| {
            let path = &at.paths.as_ref()[i];
            FirstSurface {
                pixel: path.pixel as usize,
                depth: path.prefix().map_or(0.0, |prefix| prefix.length),
                share: share(path),
            }
        };
        add_first_surfaces(&at.v, &samples, lanes, first, self.tile.out);
    }

    /// Adds the vertex in lane `i` as the first event of its path.
    #[inline(always)]
    fn add_event<S: Width>(&mut self, at: &Arrived<S>, i: usize, opacity: f32) {
        let event = FirstEvent::surface(&at.v, i, opacity);
        self.add_first_event(&at.paths.as_ref()[i], event);
    }

    fn add_first_event(&mut self, path: &PathState, event: FirstEvent) {
        if let Some(&Prefix { filter_weight, .. }) = path.prefix() {
            let sample = SampleShare {
                filter_weight,
                share: share(path),
            };
            let scene = self.tile.prepared.scene;
            add_first_event(scene, event, sample, path.pixel as usize, self.tile.out);
        }
    }

    /// Appends the paths that continue straight through. Returns the lanes in which they scatter.
    #[inline(always)]
    fn pass_through<S: Width>(&mut self, s: S, at: &mut Arrived<S>, goes_on: Bits) -> Bits {
        let u = at.generators.next_within(Mask::from_bits(s, goes_on));
        let Some((passes, factor)) = at.v.passes(u, goes_on) else {
            return goes_on;
        };
        at.throughput = at.throughput * factor;
        let kept = (passes, |i: usize| at.paths.as_ref()[i]);
        (at.v).pass_through(self.walks, self.next, at.throughput, &at.generators, kept);
        goes_on & !passes
    }
}

/// The layer of radiance that is emitted towards a path, and the part of it that the path accounts for. `limit` is the direction limit at a
/// gather point.
#[inline(always)]
fn emitted_part(path: &PathState, radiance: Rgb, limit: impl Fn(u32) -> f32) -> (Layer, Rgb) {
    match &path.part {
        PathPart::Prefix(_) => (Layer::Emission, radiance / EMISSION_PATHS as f32),
        PathPart::Direction(direction) => {
            let fraction = direction_fraction(limit(direction.from), direction.f_cos);
            (path.stage.layer(), radiance * fraction)
        }
        // Photons account for it: emitters may be small.
        PathPart::Chain(_) => (path.stage.layer(), Rgb::BLACK),
    }
}

/// Inverse of the number of camera paths of the pixel that gather.
#[inline(always)]
fn share(path: &PathState) -> f32 {
    path.number()
        .map_or(0.0, |number| 1.0 / number.count as f32)
}
