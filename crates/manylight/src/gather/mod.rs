//! Sums virtual lights at shading points. [`Kernel`] says how one light is evaluated; which are is every one, or a few for all.

mod clamp;
mod cluster;

pub use clamp::Clamp;

use crate::bsdf::{Bsdf, Lobes, Receiver};
use crate::color::Rgb;
use crate::geometry::{Segment, SurfacePoint};
use crate::ids::LightId;
use crate::math::Vec3;
use crate::scene::Scene;
use crate::virtual_lights::moments::POINTS;
use crate::virtual_lights::{LightField, Spot, VirtualLight};
use clamp::Way;
use cluster::Cluster;
use std::f32::consts::PI;

/// How one light is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// As a point.
    Point,
    /// As a disc with the second moment of its photons, by sixteen to one of its points.
    Disc,
}

/// A light is all its points nearer than the first number of its radii, four of them nearer than the second, and one beyond;
/// which ones is random. Both are stretched by a random factor, so that no ring shows where the number changes.
const SIXTEEN_POINTS_WITHIN: f32 = 1.5;
const FOUR_POINTS_WITHIN: f32 = 4.0;
const REACH_SPREAD: f32 = 0.25;

/// A disc is at least this share of the surface per light.
const SMALLEST_DISC: f32 = 0.25;

/// Connections tested for visibility together.
const PACKET: usize = 64;

/// Where lights are summed: a surface point, seen along `-wo`.
#[derive(Clone, Copy, Debug)]
pub struct ShadingPoint<'s> {
    /// The point.
    pub x: SurfacePoint,
    /// Unit direction to the viewer.
    pub wo: Vec3,
    /// Scattering function; its smooth lobes count here.
    pub bsdf: Bsdf<'s>,
    /// Largest photon depth that fits the path limits here; `None` without limit.
    pub max_photon_depth: Option<u32>,
    /// Uniform in [0, 1): decides between numbers of points.
    pub u: f32,
    /// Which lights are summed here.
    pub lights: Selection,
    /// Only light that arrives on the side of this normal counts, if given.
    pub lit_from: Option<Vec3>,
}

/// Which lights are summed at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// Every one.
    All,
    /// One in [`FEW`] along the space-filling curve, beginning with this one; each stands for that many.
    Few(u8),
}

/// Lights are selected one in this many.
pub const FEW: u8 = 8;
/// The first light of a cluster and every [`FEW`]th after it.
const FEW_MASK: u64 = 0x0101_0101_0101_0101;

impl Selection {
    /// The lights of a cluster as bits, and for how many each stands.
    #[inline]
    fn of_cluster(self) -> (u64, f32) {
        match self {
            Selection::All => (u64::MAX, 1.0),
            Selection::Few(first) => (FEW_MASK << (first % FEW), f32::from(FEW)),
        }
    }
}

impl ShadingPoint<'_> {
    /// A number below `count`, each as likely.
    #[inline]
    fn choose(&self, count: usize) -> usize {
        // Other digits of `u` than those that decide about the number of points.
        ((self.u * 64.0).fract() * count as f32) as usize
    }
}

/// Lights made ready to be summed.
#[derive(Debug)]
pub struct Lights<'s> {
    /// The lights themselves.
    pub field: LightField<'s>,
    clusters: Vec<Cluster>,
}

impl<'s> Lights<'s> {
    /// Cuts `field` into clusters.
    pub fn new(field: LightField<'s>) -> Self {
        let clusters = Cluster::all(&field);
        Lights { field, clusters }
    }
}

/// How lights are summed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gather {
    /// How one is evaluated.
    pub kernel: Kernel,
    /// What is done about the singularity.
    pub clamp: Clamp,
}

/// A sum of lights, with what it cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gathered {
    /// Radiance towards the viewer.
    pub radiance: Rgb,
    /// Radiance that the clamp took away, before visibility; luminance.
    pub clamped: f32,
    /// Luminance before clamp and visibility.
    pub unclamped: f32,
    /// Connections evaluated.
    pub connections: u64,
    /// Visibility tests.
    pub shadow_rays: u64,
}

impl Gather {
    /// For each point of a tile the radiance from all lights: `L = Σ_k f |w·n| I_k(-w) V / d²` over the points that each light
    /// is made of. Cluster by cluster, so that the tables of its lights stay in the cache for the whole tile.
    pub fn sum(&self, scene: &Scene, lights: &Lights, points: &[ShadingPoint]) -> Vec<Gathered> {
        let mut sums = vec![Gathered::default(); points.len()];
        let receivers: Vec<Receiver> = points
            .iter()
            .map(|at| at.bsdf.receiver(at.wo, Lobes::SMOOTH))
            .collect();
        for cluster in &lights.clusters {
            for ((at, receiver), sum) in points.iter().zip(&receivers).zip(&mut sums) {
                self.add_cluster(scene, lights, cluster, at, receiver, sum);
            }
        }
        sums
    }

    fn add_cluster(
        &self,
        scene: &Scene,
        lights: &Lights,
        cluster: &Cluster,
        at: &ShadingPoint,
        receiver: &Receiver,
        sum: &mut Gathered,
    ) {
        let field = &lights.field;
        let (selected, stands_for) = at.lights.of_cluster();
        let mut facing = cluster.facing(at.x.p, at.bsdf.receiving_normal(at.wo)) & selected;
        sum.connections += u64::from((cluster.used() & selected).count_ones());
        // Shadow rays of one packet share their origin, which lies off the surface on the side that they leave by.
        let (mut front, mut back) = (Packet::new(at, at.x.ng), Packet::new(at, -at.x.ng));
        while facing != 0 {
            let k = cluster.first + facing.trailing_zeros() as usize;
            facing &= facing - 1;
            let (id, light) = (LightId(k as u32), &field.lights()[k]);
            let share = at
                .max_photon_depth
                .map_or(1.0, |m| field.share_up_to(id, m));
            if share <= 0.0 {
                continue;
            }
            let connector = Connector {
                gather: self,
                field,
                at,
                receiver,
                light,
                id,
            };
            let mut connect = |p: Vec3, area: f32, weight: f32| {
                if let Some(c) = connector.connect(p, area, weight * share * stands_for) {
                    sum.clamped += c.clamped;
                    sum.unclamped += c.value.luminance() + c.clamped;
                    let packet = if c.in_front { &mut front } else { &mut back };
                    packet.push(scene, c.target, c.value, sum);
                }
            };
            let (count, area) = self.parts(at, light);
            let weight = (count as f32).recip();
            match count {
                POINTS => light
                    .points
                    .into_iter()
                    .for_each(|p| connect(p, area, weight)),
                4 => (0..4).for_each(|i| connect(light.points[4 * i + at.choose(4)], area, weight)),
                _ if self.kernel == Kernel::Point => connect(light.p, area, weight),
                _ => connect(light.points[at.choose(POINTS)], area, weight),
            }
        }
        front.flush(scene, sum);
        back.flush(scene, sum);
    }

    /// Of how many points `light` is made as seen from `at`, and the area that each stands for, in m².
    #[inline]
    fn parts(&self, at: &ShadingPoint, light: &VirtualLight) -> (usize, f32) {
        let disc = PI * light.radius * light.radius;
        if self.kernel == Kernel::Point {
            return (1, light.area);
        }
        // A share dominated by one strong photon has hardly a radius, yet stands for as much surface as its neighbors: a point.
        let is_disc = disc > SMALLEST_DISC * light.area;
        let reach = light.radius * (1.0 + REACH_SPREAD * at.u);
        let d2 = at.x.p.distance_squared(light.p);
        let within = |radii: f32| d2 < (radii * reach).powi(2);
        if is_disc && within(SIXTEEN_POINTS_WITHIN) {
            (POINTS, disc / POINTS as f32)
        } else if is_disc && within(FOUR_POINTS_WITHIN) {
            (4, disc / 4.0)
        } else {
            (1, disc.max(light.area))
        }
    }

    /// Share of the light from `y` that the sum at `at` lacks, because the clamp takes it away from the light that photons at
    /// `y` belong to: one less what [`Gather::sum`] keeps of a connection to a part of `owner` at `y`. Without an owner, photons
    /// there are lights by themselves.
    pub fn missing(
        &self,
        lights: &Lights,
        at: &ShadingPoint,
        y: &Spot,
        owner: Option<LightId>,
    ) -> f32 {
        let to_y = y.p - at.x.p;
        let d2 = to_y.length_squared();
        if self.clamp == Clamp::None || d2 == 0.0 {
            return 0.0;
        }
        let w = to_y * d2.sqrt().recip();
        let (n_y, area) = match owner {
            Some(id) => {
                let light = &lights.field.lights()[id.index()];
                (light.n, self.parts(at, light).1)
            }
            None => (y.n, lights.field.area_around(y.p)),
        };
        let way = Way {
            w,
            d2,
            f_cos: at.bsdf.f_cos_wi(w, at.wo, Lobes::SMOOTH),
            n_x: at.x.ng,
            n_y,
            area,
        };
        1.0 - self.clamp.kept(&way)
    }
}

/// One light as seen from one shading point.
struct Connector<'a, 's> {
    gather: &'a Gather,
    field: &'a LightField<'s>,
    at: &'a ShadingPoint<'s>,
    receiver: &'a Receiver<'a, 's>,
    light: &'a VirtualLight<'s>,
    id: LightId,
}

/// A connection that carries light, but for visibility.
struct Connection {
    target: Vec3,
    value: Rgb,
    clamped: f32,
    in_front: bool,
}

impl Connector<'_, '_> {
    /// The connection to the part of the light at `p`, of the given area, carrying `weight` of its intensity.
    #[inline]
    fn connect(&self, p: Vec3, area: f32, weight: f32) -> Option<Connection> {
        let to_light = p - self.at.x.p;
        let d2 = to_light.length_squared();
        if d2 == 0.0 {
            return None;
        }
        let w = to_light * d2.sqrt().recip();
        if self.at.lit_from.is_some_and(|n| w.dot(n) <= 0.0) {
            return None;
        }
        let intensity = self.field.intensity(self.id, -w);
        if intensity.is_black() {
            return None;
        }
        let f_cos = self.receiver.f_cos_wi(w);
        if f_cos.is_black() {
            return None;
        }
        let kept = self.gather.clamp.kept(&Way {
            w,
            d2,
            f_cos,
            n_x: self.at.x.ng,
            n_y: self.light.n,
            area,
        });
        let full = f_cos * intensity * (weight / d2);
        let offset = self.light.offset.copysign(-w.dot(self.light.n));
        Some(Connection {
            target: p + self.light.n * offset,
            value: full * kept,
            clamped: full.luminance() * (1.0 - kept),
            in_front: w.dot(self.at.x.ng) >= 0.0,
        })
    }
}

/// Connections that wait for their visibility test.
struct Packet {
    origin: Vec3,
    targets: [Vec3; PACKET],
    values: [Rgb; PACKET],
    len: usize,
}

impl Packet {
    fn new(at: &ShadingPoint, side: Vec3) -> Self {
        let origin = at.x.offset_towards(side);
        Packet {
            origin,
            targets: [Vec3::ZERO; PACKET],
            values: [Rgb::BLACK; PACKET],
            len: 0,
        }
    }

    #[inline]
    fn push(&mut self, scene: &Scene, target: Vec3, value: Rgb, sum: &mut Gathered) {
        self.targets[self.len] = target;
        self.values[self.len] = value;
        self.len += 1;
        if self.len == PACKET {
            self.flush(scene, sum);
        }
    }

    /// Tests the waiting connections and adds those that arrive.
    fn flush(&mut self, scene: &Scene, sum: &mut Gathered) {
        if self.len == 0 {
            return;
        }
        let occluded = scene
            .geometry
            .occluded_packet(self.origin, &self.targets[..self.len]);
        for i in (0..self.len).filter(|i| occluded >> i & 1 == 0) {
            let mut value = self.values[i];
            if scene.geometry.has_transparent() {
                value *= scene
                    .cross_transparent(&Segment {
                        from: self.origin,
                        to: self.targets[i],
                    })
                    .0;
            }
            sum.radiance += value;
        }
        sum.shadow_rays += self.len as u64;
        self.len = 0;
    }
}
