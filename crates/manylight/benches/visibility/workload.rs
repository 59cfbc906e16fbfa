//! Ray sets: the triangles of a scene, and rays and segments as a renderer traces them.

use manylight::geometry::{Geometry, Primitive, Ray, Segment, Shape, SurfacePoint};
use manylight::math::{Aabb, UVec2, Vec2, Vec3};
use manylight::sampling::{rng::Pcg, warp};
use manylight::scene::{PrimitiveDesc, SceneDesc};
use manylight::sensors::{Sensor, SensorDesc};
use manylight_io::{LoadOptions, load_scene};
use std::path::Path;

/// Width and height of the image in pixels.
pub(crate) const SIDE: usize = 512;

/// Width and height of a tile in pixels.
const TILE: usize = 8;
/// Number of points of a tile, and of lights of a cluster.
pub(crate) const BLOCK: usize = TILE * TILE;

/// Number of pairs of a tile and a cluster in a set.
const PAIRS: usize = 128;

/// The triangles of a scene, all opaque, and its first camera.
pub(crate) struct Workload {
    pub(crate) geometry: Geometry,
    /// The triangles of `geometry` in world space.
    pub(crate) triangles: Vec<[Vec3; 3]>,
    desc: SceneDesc,
    /// The triangles of area emitters.
    pub(crate) emitters: Vec<[Vec3; 3]>,
    pub(crate) sensor: Sensor,
    /// For each pixel, the surface point seen and the direction towards the camera.
    hits: Vec<Option<(SurfacePoint, Vec3)>>,
}

/// The segments between a tile of points and a cluster of lights.
pub(crate) struct RayBlock {
    /// The points of the tile.
    pub(crate) origins: Vec<Vec3>,
    /// The positions of the lights.
    pub(crate) targets: Vec<Vec3>,
    /// For each point, the lights to test as bits: point and light face each other.
    pub(crate) wanted: Vec<u64>,
}

impl Workload {
    pub(crate) fn load(path: &Path) -> Self {
        let desc = load_scene(path, &LoadOptions::default())
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
            .desc;
        let sensor = square_sensor(&desc.sensors[0]);
        let triangles = world_triangles(&desc, |_| true);
        let emitters = world_triangles(&desc, |p| p.emitter.is_some());
        let (geometry, _) = build(&desc);
        let mut workload = Workload {
            geometry,
            triangles,
            desc,
            emitters,
            sensor,
            hits: Vec::new(),
        };
        workload.hits = workload
            .camera()
            .iter()
            .map(|ray| workload.hit(ray))
            .collect();
        workload
    }

    /// Times of another build in seconds: of the hierarchy, and of the whole geometry, to which the
    /// tables of surface points belong.
    pub(crate) fn build_seconds(&self) -> [f64; 2] {
        let of_hierarchies = self.geometry.time_of_hierarchies();
        [of_hierarchies.as_secs_f64(), build(&self.desc).1]
    }

    /// One ray through the center of every pixel.
    pub(crate) fn camera(&self) -> Vec<Ray> {
        let pixels = (0..SIDE * SIDE).map(|i| Vec2::new((i % SIDE) as f32, (i / SIDE) as f32));
        pixels
            .map(|p| self.sensor.ray(p + 0.5, Vec2::splat(0.5)))
            .collect()
    }

    /// Cosine-distributed rays from the hits of the camera rays.
    pub(crate) fn bounce(&self) -> Vec<Ray> {
        let mut random = Pcg::new(1);
        let hits = self.hits.iter().flatten();
        hits.map(|(x, wo)| spawn(x, *wo, &mut random)).collect()
    }

    /// Segments between the hits of random pixels.
    pub(crate) fn random_segments(&self) -> Vec<Segment> {
        let mut random = Pcg::new(2);
        let hits: Vec<&SurfacePoint> = self.hits.iter().flatten().map(|hit| &hit.0).collect();
        let mut random_hit = || hits[random.next_u32() as usize % hits.len()];
        (0..SIDE * SIDE)
            .map(|_| random_hit().segment_to(random_hit()))
            .collect()
    }

    /// The surface point that the ray meets, and the direction back along the ray.
    pub(crate) fn hit(&self, ray: &Ray) -> Option<(SurfacePoint, Vec3)> {
        let hit = self.geometry.intersect(ray)?;
        Some((self.geometry.surface_point(hit.at), -ray.d))
    }

    /// Positions and normals of `count` lights: the hits of camera paths of three bounces, on the
    /// side that was hit, sorted in clusters of [`BLOCK`].
    pub(crate) fn lights(&self, count: usize) -> Vec<(Vec3, Vec3)> {
        let mut random = Pcg::new(3);
        let mut lights = Vec::with_capacity(count);
        while lights.len() < count {
            let position = Vec2::new(random.next_f32(), random.next_f32()) * SIDE as f32;
            let mut at = self.hit(&self.sensor.ray(position, Vec2::splat(0.5)));
            for _ in 0..3 {
                at = at.and_then(|(x, wo)| self.hit(&spawn(&x, wo, &mut random)));
                if let Some((x, wo)) = &at {
                    lights.push(facing(x, *wo));
                }
            }
        }
        lights.truncate(count);
        sort_in_clusters(&mut lights);
        lights
    }

    /// Random pairs of a tile and a cluster with at least one segment to test.
    pub(crate) fn blocks(&self, lights: usize) -> Vec<RayBlock> {
        let lights = self.lights(lights);
        let mut random = Pcg::new(4);
        let tiles = SIDE / TILE;
        let mut blocks = Vec::new();
        while blocks.len() < PAIRS {
            let mut below = |n: usize| random.next_u32() as usize % n;
            let corner = (below(tiles) * TILE, below(tiles) * TILE);
            let first = below(lights.len() / BLOCK) * BLOCK;
            let block = self.block(corner, &lights[first..first + BLOCK]);
            if block.wanted.iter().any(|&lights| lights != 0) {
                blocks.push(block);
            }
        }
        blocks
    }

    fn block(&self, corner: (usize, usize), lights: &[(Vec3, Vec3)]) -> RayBlock {
        let pixels = (0..BLOCK).map(|i| {
            let (x, y) = along_z_curve(i);
            (corner.1 + y) * SIDE + corner.0 + x
        });
        let points: Vec<(Vec3, Vec3)> = pixels
            .filter_map(|i| self.hits[i].as_ref())
            .map(|(x, wo)| facing(x, *wo))
            .collect();
        let face_each_other = |(p, n): &(Vec3, Vec3), (q, m): &(Vec3, Vec3)| {
            n.dot(*q - *p) > 0.0 && m.dot(*p - *q) > 0.0
        };
        let wanted = points.iter().map(|point| {
            let lights = lights.iter().rev();
            lights.fold(0, |bits, light| {
                bits << 1 | u64::from(face_each_other(point, light))
            })
        });
        RayBlock {
            wanted: wanted.collect(),
            origins: points.iter().map(|point| point.0).collect(),
            targets: lights.iter().map(|light| light.0).collect(),
        }
    }
}

impl RayBlock {
    pub(crate) fn segments(&self) -> impl Iterator<Item = Segment> {
        let pairs = self.origins.iter().zip(&self.wanted);
        pairs.flat_map(move |(&from, &lights)| {
            let wanted = (0..self.targets.len()).filter(move |i| lights >> i & 1 == 1);
            wanted.map(move |i| Segment {
                from,
                to: self.targets[i],
            })
        })
    }

    pub(crate) fn count(&self) -> usize {
        let counts = self.wanted.iter().map(|lights| lights.count_ones());
        counts.sum::<u32>() as usize
    }
}

/// Builds the geometry of the meshes, and times it in seconds.
fn build(desc: &SceneDesc) -> (Geometry, f64) {
    let primitives = desc.primitives.iter();
    let meshes = primitives.filter(|p| matches!(desc.shapes[p.shape.index()], Shape::Mesh(_)));
    let opaque = meshes.map(|p| Primitive {
        shape: p.shape,
        world_from_object: p.world_from_object,
        flip_normals: false,
        material: p.material,
        emitter: None,
        transparent: false,
        invisible: false,
    });
    let (shapes, primitives) = (desc.shapes.clone(), opaque.collect());
    let start = std::time::Instant::now();
    let geometry = Geometry::build(shapes, primitives, Vec::new(), Vec::new());
    (geometry, start.elapsed().as_secs_f64())
}

fn square_sensor(desc: &SensorDesc) -> Sensor {
    Sensor::new(SensorDesc {
        film: desc.film.with_size(UVec2::splat(SIDE as u32)),
        ..desc.clone()
    })
}

/// The triangles of the wanted primitives in world space.
fn world_triangles(desc: &SceneDesc, wanted: impl Fn(&PrimitiveDesc) -> bool) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for primitive in desc.primitives.iter().filter(|p| wanted(p)) {
        if let Shape::Mesh(mesh) = &desc.shapes[primitive.shape.index()] {
            let corner = |i: u32| {
                let p = mesh.positions[i as usize];
                primitive.world_from_object.transform_point3(p)
            };
            triangles.extend(mesh.triangles.iter().map(|t| t.map(corner)));
        }
    }
    triangles
}

/// A cosine-distributed ray on the side of `wo`.
pub(crate) fn spawn(x: &SurfacePoint, wo: Vec3, random: &mut Pcg) -> Ray {
    let side = 1.0f32.copysign(x.ng.dot(wo));
    let w = warp::cosine_hemisphere(Vec2::new(random.next_f32(), random.next_f32()));
    x.spawn(manylight::math::Frame::from_normal(x.ng * side).to_world(w))
}

/// Position offset from the surface, and normal, both on the side of `wo`.
fn facing(x: &SurfacePoint, wo: Vec3) -> (Vec3, Vec3) {
    (x.offset_towards(wo), x.ng * 1.0f32.copysign(x.ng.dot(wo)))
}

/// Sorts such that aligned runs of [`BLOCK`] lights are compact: recursive median splits along the
/// longest axis.
fn sort_in_clusters(lights: &mut [(Vec3, Vec3)]) {
    if lights.len() < 3 {
        return;
    }
    let extent = Aabb::from_points(lights.iter().map(|light| light.0)).extent();
    let axis = (0..3).fold(0, |best, a| if extent[a] > extent[best] { a } else { best });
    let half = if lights.len() > BLOCK {
        ((lights.len() / BLOCK).div_ceil(2) * BLOCK).min(lights.len() - 1)
    } else {
        lights.len() / 2
    };
    lights.select_nth_unstable_by(half, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    let (low, high) = lights.split_at_mut(half);
    sort_in_clusters(low);
    sort_in_clusters(high);
}

/// The pixel of a tile at index `i` along the Morton curve.
fn along_z_curve(i: usize) -> (usize, usize) {
    let bit = |from: usize, to: usize| (i >> from & 1) << to;
    (
        bit(0, 0) | bit(2, 1) | bit(4, 2),
        bit(1, 0) | bit(3, 1) | bit(5, 2),
    )
}
