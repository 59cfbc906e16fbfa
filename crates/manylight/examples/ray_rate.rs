//! Reports how many rays per second one thread traces through a furnished room of about 30 000 triangles:
//! `cargo run --release --example ray_rate`.
#![allow(
    clippy::print_stdout,
    reason = "reporting is all that this program does"
)]

use manylight::geometry::{Geometry, Mesh, Primitive, Ray, Segment, Shape};
use manylight::ids::{MaterialId, ShapeId};
use manylight::math::{Affine3A, Vec2, Vec3};
use manylight::sampling::{rng::Pcg, warp};
use std::time::Instant;

fn main() {
    let start = Instant::now();
    let room = room();
    let built = start.elapsed();
    let triangles = room.triangle_count();
    let bytes = room.acceleration_bytes() as f64 / triangles as f64;
    println!(
        "{triangles} triangles, {bytes:.1} bytes each, built in {:.1} ms",
        built.as_secs_f64() * 1e3
    );

    let camera = camera_rays(512);
    let nearest = |rays: &[Ray]| {
        rays.iter()
            .filter(|ray| room.intersect(ray).is_some())
            .count()
    };
    report("camera, nearest", &camera, 1, nearest);
    report("camera, nearest with surface point", &camera, 1, |rays| {
        let hits = rays.iter().filter_map(|ray| room.intersect(ray));
        hits.filter(|hit| room.surface_point(hit.at).ng.z > 0.0)
            .count()
    });
    let bounced = bounce(&room, &camera);
    report("bounce, nearest", &bounced, 1, nearest);
    let ends = bounced.iter().zip(bounced.iter().skip(7919));
    let segments: Vec<Segment> = ends.map(|(a, b)| Segment { from: a.o, to: b.o }).collect();
    report("random segments", &segments, 1, |all| {
        all.iter().filter(|s| room.occluded(s)).count()
    });

    for radius in [0.15, 0.5, 2.0] {
        let clusters = clusters(&bounced, radius);
        report(
            &format!("64 targets within {radius} m, single"),
            &clusters,
            64,
            |clusters| {
                let segments = clusters
                    .iter()
                    .flat_map(|(from, to)| to.iter().map(|&to| Segment { from: *from, to }));
                segments.filter(|segment| room.occluded(segment)).count()
            },
        );
        report(
            &format!("64 targets within {radius} m, packet"),
            &clusters,
            64,
            |clusters| {
                clusters
                    .iter()
                    .map(|(from, to)| room.occluded_packet(*from, to).count_ones() as usize)
                    .sum()
            },
        );
    }
}

/// Takes the best of several repeats part by part, so that other work on the machine disturbs little.
fn report<T>(name: &str, work: &[T], rays_each: usize, trace: impl Fn(&[T]) -> usize) {
    const PART: usize = 8192;
    let part = (PART / rays_each).max(1);
    let (mut seconds, mut hits) = (0.0, 0);
    for part in work.chunks(part) {
        let mut best = f64::INFINITY;
        let mut found = 0;
        for _ in 0..7 {
            let start = Instant::now();
            found = trace(part);
            best = best.min(start.elapsed().as_secs_f64());
        }
        seconds += best;
        hits += found;
    }
    let rays = (work.len() * rays_each) as f64;
    println!(
        "{name:36} {:7.2} M/s, {:.3} hit",
        rays / seconds * 1e-6,
        hits as f64 / rays
    );
}

/// A box of 8 m x 6 m x 3 m with boxes and balls on the floor.
fn room() -> Geometry {
    let shapes = vec![Shape::Mesh(Mesh::cube()), Shape::Mesh(ball(36))];
    let place = |shape: u32, center: Vec3, half: Vec3| Primitive {
        shape: ShapeId(shape),
        world_from_object: Affine3A::from_translation(center) * Affine3A::from_scale(half),
        flip_normals: false,
        material: MaterialId(0),
        emitter: None,
        transparent: false,
    };
    let mut random = Pcg::new(1);
    let mut within = |low: f32, high: f32| low + (high - low) * random.next_f32();
    let mut primitives = vec![place(0, Vec3::new(0.0, 0.0, 1.5), Vec3::new(4.0, 3.0, 1.5))];
    for _ in 0..120 {
        let half = Vec3::new(within(0.05, 0.3), within(0.05, 0.3), within(0.05, 0.6));
        primitives.push(place(
            0,
            Vec3::new(within(-3.5, 3.5), within(-2.5, 2.5), half.z),
            half,
        ));
    }
    for _ in 0..11 {
        let radius = within(0.1, 0.5);
        primitives.push(place(
            1,
            Vec3::new(within(-3.0, 3.0), within(-2.0, 2.0), within(0.3, 2.0)),
            Vec3::splat(radius),
        ));
    }
    Geometry::build(shapes, primitives, Vec::new(), Vec::new())
}

fn ball(side: u32) -> Mesh {
    let point = |i: u32, j: u32| {
        let (phi, theta) = (
            std::f32::consts::TAU * i as f32 / side as f32,
            std::f32::consts::PI * j as f32 / side as f32,
        );
        Vec3::new(
            theta.sin() * phi.cos(),
            theta.sin() * phi.sin(),
            theta.cos(),
        )
    };
    let positions = (0..=side)
        .flat_map(|j| (0..side).map(move |i| point(i, j)))
        .collect();
    let index = |i: u32, j: u32| j * side + i % side;
    let cells = (0..side).flat_map(|j| (0..side).map(move |i| (i, j)));
    let triangles = cells
        .flat_map(|(i, j)| {
            [
                [index(i, j), index(i, j + 1), index(i + 1, j)],
                [index(i + 1, j), index(i, j + 1), index(i + 1, j + 1)],
            ]
        })
        .collect();
    Mesh {
        positions,
        triangles,
        ..Mesh::default()
    }
}

fn camera_rays(side: usize) -> Vec<Ray> {
    let eye = Vec3::new(-3.8, -2.8, 2.0);
    let forward = Vec3::new(1.0, 0.75, -0.25).normalize();
    let right = forward.cross(Vec3::Z).normalize();
    let up = right.cross(forward);
    let pixels = (0..side * side).map(|i| (i % side, i / side));
    let offset = |x: usize| 2.0 * (x as f32 + 0.5) / side as f32 - 1.0;
    pixels
        .map(|(x, y)| {
            Ray::new(
                eye,
                (forward + 0.8 * (right * offset(x) - up * offset(y))).normalize(),
            )
        })
        .collect()
}

/// Cosine-distributed rays from where the paths of `rays` stand after three bounces, in random order.
fn bounce(room: &Geometry, rays: &[Ray]) -> Vec<Ray> {
    let mut random = Pcg::new(2);
    let mut spawn = |room: &Geometry, ray: &Ray| {
        let x = room.surface_point(room.intersect(ray)?.at);
        let side = x.frame.n.dot(-ray.d).signum();
        let w = warp::cosine_hemisphere(Vec2::new(random.next_f32(), random.next_f32()));
        Some(x.spawn(x.frame.to_world(w * side)))
    };
    let mut rays = rays.to_vec();
    for _ in 0..3 {
        rays = rays.iter().filter_map(|ray| spawn(room, ray)).collect();
    }
    let count = rays.len();
    (0..count).map(|i| rays[i * 7919 % count]).collect()
}

/// Origins, and for each of them 64 points on the surfaces within a cube of edge `size`.
fn clusters(points: &[Ray], size: f32) -> Vec<(Vec3, Vec<Vec3>)> {
    let mut sorted: Vec<Vec3> = points.iter().map(|ray| ray.o).collect();
    let cell = |p: Vec3| (p / size).floor().as_ivec3().to_array();
    sorted.sort_by_key(|&p| cell(p));
    let groups = sorted
        .chunk_by(|&a, &b| cell(a) == cell(b))
        .filter(|group| group.len() >= 64);
    let targets = groups.map(|group| group[..64].to_vec());
    targets
        .enumerate()
        .map(|(i, to)| (points[i * 31 % points.len()].o, to))
        .collect()
}
