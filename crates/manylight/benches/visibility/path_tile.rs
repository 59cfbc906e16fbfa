//! The rays of a path tracer that advances the paths of a tile together, in the order of the paths.

use super::workload::{SIDE, Workload, spawn};
use manylight::geometry::{Ray, Segment, SurfacePoint};
use manylight::math::{Vec2, Vec3};
use manylight::sampling::{rng::Pcg, warp};

/// Width and height of a tile in pixels. One path per pixel, along the Morton curve.
const TILE: usize = 64;
/// Number of bounces before the rays of [`PathTile::late`].
const LATE: usize = 3;

/// The rays of a tile.
#[derive(Default)]
pub(crate) struct PathTile {
    /// Rays through random points of the pixels.
    pub(crate) camera: Vec<Ray>,
    /// Segments from the hits of `camera` to random points of the emitters.
    pub(crate) shadow: Vec<Segment>,
    /// Cosine-distributed rays from the hits of `camera`.
    pub(crate) bounce: Vec<Ray>,
    /// Cosine-distributed rays after [`LATE`] bounces.
    pub(crate) late: Vec<Ray>,
    /// Segments from the origins of `late` to random points of the emitters.
    pub(crate) late_shadow: Vec<Segment>,
}

/// The tiles of the image of the first sensor.
pub(crate) fn path_tiles(work: &Workload) -> Vec<PathTile> {
    let emitters = EmitterPoints::new(work);
    let tiles = SIDE / TILE;
    (0..tiles * tiles)
        .map(|i| {
            let corner = Vec2::new((i % tiles) as f32, (i / tiles) as f32) * TILE as f32;
            path_tile(work, &emitters, corner, i as u64)
        })
        .collect()
}

fn path_tile(work: &Workload, emitters: &EmitterPoints, corner: Vec2, seed: u64) -> PathTile {
    let mut random = Pcg::new(seed);
    let mut tile = PathTile::default();
    for i in 0..TILE * TILE {
        let position = corner + along_morton_curve(i) + square(&mut random);
        let ray = work.sensor.ray(position, Vec2::splat(0.5));
        tile.camera.push(ray);
        let Some((mut x, mut wo)) = work.hit(&ray) else {
            continue;
        };
        tile.shadow.extend(emitters.segment(&x, wo, &mut random));
        tile.bounce.push(spawn(&x, wo, &mut random));
        let bounces = (0..LATE).try_for_each(|_| {
            (x, wo) = work.hit(&spawn(&x, wo, &mut random))?;
            Some(())
        });
        if bounces.is_some() {
            tile.late_shadow
                .extend(emitters.segment(&x, wo, &mut random));
            tile.late.push(spawn(&x, wo, &mut random));
        }
    }
    tile
}

/// Random points of the area emitters, or of the sky in a scene without them.
struct EmitterPoints {
    /// The triangles, each with the sum of the areas up to it.
    triangles: Vec<([Vec3; 3], f32)>,
    /// Length of the segments to the sky.
    sky: f32,
}

impl EmitterPoints {
    fn new(work: &Workload) -> Self {
        let mut sum = 0.0;
        let triangles = work.emitters.iter().map(|&[a, b, c]| {
            sum += 0.5 * (b - a).cross(c - a).length();
            ([a, b, c], sum)
        });
        EmitterPoints {
            triangles: triangles.collect(),
            sky: work.geometry.bounds().extent().length(),
        }
    }

    /// A segment from `x` to a random point; `None` if it starts below the surface.
    fn segment(&self, x: &SurfacePoint, wo: Vec3, random: &mut Pcg) -> Option<Segment> {
        let Some(&(_, total)) = self.triangles.last() else {
            let ray = spawn(x, wo, random);
            let to = ray.at(self.sky);
            return Some(Segment { from: ray.o, to });
        };
        /// Share of the segment that is traced, so that it ends before the emitter.
        const SHARE: f32 = 0.9999;
        let along = random.next_f32() * total;
        let place = self.triangles.partition_point(|(_, sum)| *sum <= along);
        let ([a, b, c], _) = self.triangles[place.min(self.triangles.len() - 1)];
        let w = warp::triangle(square(random));
        let to = a + (b - a) * w.x + (c - a) * w.y;
        let from = x.offset_towards(to - x.p);
        let is_above = (to - x.p).dot(x.ng) * wo.dot(x.ng) > 0.0;
        is_above.then(|| Segment {
            from,
            to: from.lerp(to, SHARE),
        })
    }
}

fn square(random: &mut Pcg) -> Vec2 {
    Vec2::new(random.next_f32(), random.next_f32())
}

/// The pixel of a tile at index `i` along the Morton curve.
fn along_morton_curve(i: usize) -> Vec2 {
    let even_bits = |i: usize| (0..6).fold(0, |x, bit| x | (i >> (2 * bit) & 1) << bit);
    Vec2::new(even_bits(i) as f32, even_bits(i >> 1) as f32)
}
