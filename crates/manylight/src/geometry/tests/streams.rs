//! Streams of rays and segments against single ones, bit by bit.

use super::structures::mixed;
use super::*;
use crate::simd::Instructions;

/// A room of 12 triangles, a ball in it, and a second copy of the room: each hit with a wall is two
/// hits at equal distance.
fn doubled_room() -> Geometry {
    let room = Affine3A::from_scale(Vec3::splat(4.0));
    let primitives = vec![
        placed(0, room),
        placed(1, Affine3A::IDENTITY),
        placed(0, room),
    ];
    Geometry::build(
        vec![Shape::Mesh(Mesh::cube()), ball()],
        primitives,
        vec![],
        vec![],
    )
}

/// A dense mesh and sparse slivers, with a transparent soup between.
fn crowded() -> Geometry {
    let mut random = Random(Pcg::new(8));
    let shapes = vec![
        Shape::Mesh(soup(&mut random, 3000)),
        Shape::Mesh(soup(&mut random, 40)),
    ];
    let primitives = vec![
        placed(0, Affine3A::IDENTITY),
        placed(1, enlarged()),
        Primitive {
            transparent: true,
            ..placed(1, Affine3A::from_scale(Vec3::splat(1.4)))
        },
        placed(0, Affine3A::from_translation(Vec3::new(3.0, 0.0, 0.0))),
    ];
    Geometry::build(shapes, primitives, vec![], vec![])
}

/// Numbers of rays around the widths of packets, and a number of several thousand.
const COUNTS: [usize; 8] = [0, 1, 7, 15, 16, 17, 100, 5000];

/// Rays of all kinds: fans of neighbors from one origin, random ones, and ones along the axes.
fn rays(random: &mut Random, count: usize) -> Vec<Ray> {
    let mut eye = random.point(3.0);
    let mut towards = random.point(1.0) - eye;
    let ray = |i: usize| {
        if i.is_multiple_of(64) {
            eye = random.point(3.0);
            towards = random.point(1.0) - eye;
        }
        let (o, d) = match i / 64 % 4 {
            0 => (eye, towards + random.point(0.05)),
            1 => (eye + random.point(0.1), towards + random.point(0.3)),
            2 => (random.point(3.0), random.point(1.0)),
            _ => {
                let mut d = Vec3::ZERO;
                d[i % 3] = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
                (random.point(1.5).round(), d)
            }
        };
        Ray {
            o,
            d: d.normalize(),
            t_max: if i.is_multiple_of(5) {
                4.0 * random.number()
            } else {
                f32::INFINITY
            },
        }
    };
    (0..count).map(ray).collect()
}

fn bits(hit: &Option<Hit>) -> Option<([u32; 3], [u32; 3])> {
    hit.map(|hit| {
        let SurfaceRef {
            primitive,
            element,
            instance,
            coordinates,
        } = hit.at;
        (
            [primitive.0, element, instance],
            [hit.t, coordinates.x, coordinates.y].map(f32::to_bits),
        )
    })
}

#[test]
fn streams_equal_single_rays_and_segments() {
    for mut geometry in [mixed(), doubled_room(), crowded()] {
        for instructions in Instructions::available() {
            geometry.use_instructions(instructions);
            compare_streams_with_singles(&geometry, instructions);
        }
    }
}

fn compare_streams_with_singles(geometry: &Geometry, instructions: Instructions) {
    let mut random = Random(Pcg::new(9));
    // What an earlier call left in the lists must not matter.
    let (mut hits, mut occluded) = (vec![None; 3], vec![true; 3]);
    let mut found = [0; 2];
    for count in COUNTS {
        let rays = rays(&mut random, count);
        geometry.intersect_stream(&rays, &mut hits);
        assert_eq!(hits.len(), count);
        for (ray, hit) in rays.iter().zip(&hits) {
            let single = geometry.intersect(ray);
            assert_eq!(bits(hit), bits(&single), "{instructions:?}: {ray:?}");
            found[usize::from(hit.is_some())] += 1;
        }
        let segments: Vec<Segment> = rays
            .iter()
            .map(|ray| Segment {
                from: ray.o,
                to: ray.at(ray.t_max.min(2.0)),
            })
            .collect();
        geometry.occluded_stream(&segments, &mut occluded);
        assert_eq!(occluded.len(), count);
        for (segment, &blocked) in segments.iter().zip(&occluded) {
            let single = geometry.occluded(segment);
            assert_eq!(blocked, single, "{instructions:?}: {segment:?}");
        }
    }
    assert!(found.iter().all(|&count| count > 500), "{found:?}");
}
