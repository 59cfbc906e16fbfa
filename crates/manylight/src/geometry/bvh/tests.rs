//! All kernels in all instruction sets against a loop over the triangles in `f64`.

use super::build::{self, WideTree};
use super::item_box::{CornerRows, ItemBox};
use super::packet::{EMPTY_STACK, Packet, RAYS, Targets};
use super::triangle_block::TreeParts;
use super::{TriangleBvh, node};
use crate::geometry::Ray;
use crate::math::{Aabb, Vec2, Vec3};
use crate::sampling::rng::Pcg;
use crate::simd::{Instructions, Simd, SimdKernel};
use glam::DVec3;

struct Random(Pcg);

impl Random {
    fn new(seed: u64) -> Self {
        Random(Pcg::new(seed))
    }
    fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.0.next_f32()
    }
    fn point(&mut self, half: f32) -> Vec3 {
        Vec3::new(
            self.within(-half, half),
            self.within(-half, half),
            self.within(-half, half),
        )
    }
}

/// Random triangles of various sizes in a box of half extent 1.
fn soup(count: usize, size: f32, seed: u64) -> Vec<[Vec3; 3]> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|_| {
            let center = random.point(1.0);
            let size = size * random.within(0.05, 1.0);
            std::array::from_fn(|_| center + random.point(size))
        })
        .collect()
}

/// A bumpy height field over [-1, 1]², without holes.
fn terrain(side: usize) -> Vec<[Vec3; 3]> {
    let at = |i: usize, j: usize| {
        let (x, y) = (
            i as f32 / side as f32 * 2.0 - 1.0,
            j as f32 / side as f32 * 2.0 - 1.0,
        );
        Vec3::new(x, y, 0.1 * (7.0 * x).sin() * (5.0 * y).cos())
    };
    let cells = (0..side * side).map(|c| (c % side, c / side));
    cells
        .flat_map(|(i, j)| {
            [
                [at(i, j), at(i + 1, j), at(i + 1, j + 1)],
                [at(i, j), at(i + 1, j + 1), at(i, j + 1)],
            ]
        })
        .collect()
}

fn over_all(triangles: &[[Vec3; 3]]) -> TriangleBvh {
    let rows = |triangle: &[Vec3; 3]| triangle.map(|p| p.extend(0.0).to_array());
    let rows: Vec<CornerRows> = triangles.iter().map(rows).collect();
    let ids: Vec<u32> = (0..triangles.len() as u32).collect();
    TriangleBvh::new(&ids, |id| &rows[id as usize])
}

fn structures(triangles: &[[Vec3; 3]]) -> Vec<TriangleBvh> {
    Instructions::available()
        .into_iter()
        .map(|instructions| {
            let mut bvh = over_all(triangles);
            bvh.use_instructions(instructions);
            bvh
        })
        .collect()
}

/// Ray parameter, and margin: the least barycentric coordinate, negative outside. `None` for
/// parallel rays.
fn exact(ray: &Ray, [a, b, c]: &[Vec3; 3]) -> Option<(f64, f64)> {
    let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
    let [a, b, c]: [DVec3; 3] = [a.as_dvec3() - o, b.as_dvec3() - o, c.as_dvec3() - o];
    let normal = (b - a).cross(c - a);
    let det = normal.dot(d);
    (det != 0.0).then(|| {
        let margin = [b.cross(c), c.cross(a), a.cross(b)]
            .map(|n| n.dot(d) / det)
            .into_iter()
            .fold(f64::MAX, f64::min);
        (normal.dot(a) / det, margin)
    })
}

/// Smallest ray parameter of hits with more than this margin.
fn brute_force(triangles: &[[Vec3; 3]], ray: &Ray, margin: f64) -> Option<f64> {
    let hits = triangles.iter().filter_map(|t| exact(ray, t));
    hits.filter(|&(t, m)| m > margin && t > 0.0 && t < f64::from(ray.t_max))
        .map(|h| h.0)
        .min_by(f64::total_cmp)
}

fn check_nearest(bvh: &TriangleBvh, triangles: &[[Vec3; 3]], ray: &Ray, tolerance: f64) {
    let hit = bvh.nearest(ray);
    // Hits despite rounding, and hits that rounding may produce.
    let certain = brute_force(triangles, ray, 1e-4);
    let possible = brute_force(triangles, ray, -1e-4);
    match hit {
        None => assert!(
            certain.is_none(),
            "{:?}: {ray:?} misses the hit at {certain:?}",
            bvh.isa
        ),
        Some(hit) => {
            let t = f64::from(hit.t);
            let slack = tolerance * (1.0 + t);
            assert!(
                possible.is_some_and(|p| p <= t + slack),
                "{:?}: {ray:?} reports {hit:?} in front of {possible:?}",
                bvh.isa
            );
            assert!(
                certain.is_none_or(|c| t <= c + slack),
                "{:?}: {ray:?} misses the hit at {certain:?} before {t}",
                bvh.isa
            );
            let [a, b, c] = triangles[hit.id as usize];
            let w = hit.coordinates;
            let p = a * (1.0 - w.x - w.y) + b * w.x + c * w.y;
            let scale =
                a.abs().max(ray.o.abs()).max_element() + (b - a).length().max((c - a).length());
            assert!(
                (p - ray.at(hit.t)).length() <= 1e-3 * scale,
                "{:?}: {p} is not on {ray:?}",
                bvh.isa
            );
            assert!(w.min_element() >= 0.0 && w.x + w.y <= 1.0 + 1e-5);
        }
    }
}

fn random_rays(count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|i| {
            let o = random.point(1.5);
            let d =
                (random.point(1.0) - if i.is_multiple_of(2) { o } else { Vec3::ZERO }).normalize();
            let t_max = if i.is_multiple_of(3) {
                random.within(0.1, 2.0)
            } else {
                f32::INFINITY
            };
            Ray {
                t_max,
                ..Ray::new(o, d)
            }
        })
        .collect()
}

/// Each triangle three times: hits do not depend on the tree, which mixes the copies.
#[test]
fn of_coincident_triangles_the_first_is_hit() {
    let once = soup(300, 0.4, 21);
    let all = [&once[..], &once, &once].concat();
    for bvh in structures(&all) {
        let hits = random_rays(3000, 22)
            .iter()
            .filter_map(|ray| bvh.nearest(ray))
            .map(|hit| assert!((hit.id as usize) < once.len(), "{:?}: {hit:?}", bvh.isa))
            .count();
        assert!(hits > 1000, "{hits}");
    }
}

#[test]
fn nearest_hits_equal_the_loop() {
    for (count, size) in [(1, 1.0), (7, 0.7), (9, 0.7), (64, 0.5), (700, 0.2)] {
        let triangles = soup(count, size, count as u64);
        for bvh in structures(&triangles) {
            for ray in random_rays(1500, 11) {
                check_nearest(&bvh, &triangles, &ray, 1e-5);
            }
        }
    }
}

#[test]
fn axis_parallel_rays_equal_the_loop() {
    let triangles = soup(300, 0.3, 5);
    let mut random = Random::new(6);
    let axes = [
        Vec3::X,
        Vec3::NEG_X,
        Vec3::Y,
        Vec3::NEG_Y,
        Vec3::Z,
        Vec3::NEG_Z,
        Vec3::new(-0.0, 0.6, -0.8),
    ];
    for bvh in structures(&triangles) {
        for i in 0..3000usize {
            let mut o = random.point(1.2);
            if i.is_multiple_of(4) {
                // Start exactly on the plane of a box.
                o.x = triangles[i % triangles.len()][0].x;
            }
            check_nearest(&bvh, &triangles, &Ray::new(o, axes[i % axes.len()]), 1e-5);
        }
    }
}

#[test]
fn hits_do_not_depend_on_scale() {
    let triangles = soup(200, 0.3, 8);
    for exponent in [-30, -12, 12, 30] {
        let scale = 2f32.powi(exponent);
        let scaled: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(|p| p * scale)).collect();
        for (bvh, reference) in structures(&scaled).iter().zip(structures(&triangles)) {
            for ray in random_rays(400, 9) {
                let far = Ray {
                    o: ray.o * scale,
                    d: ray.d,
                    t_max: ray.t_max * scale,
                };
                let (hit, expected) = (bvh.nearest(&far), reference.nearest(&ray));
                assert_eq!(hit.map(|h| h.id), expected.map(|h| h.id));
                assert_eq!(hit.map(|h| h.t), expected.map(|h| h.t * scale));
            }
        }
    }
}

#[test]
fn flat_axis_aligned_scenes_far_from_the_origin_are_hit() {
    let offset = Vec3::new(1000.0, -3000.0, 500.0);
    let triangles: Vec<[Vec3; 3]> = (0..200)
        .flat_map(|i| {
            let corner = offset + Vec3::new((i % 20) as f32, (i / 20) as f32, 0.0);
            let (x, y) = (corner + Vec3::X, corner + Vec3::Y);
            [[corner, x, x + Vec3::Y], [corner, x + Vec3::Y, y]]
        })
        .collect();
    let mut random = Random::new(3);
    for bvh in structures(&triangles) {
        for _ in 0..2000 {
            let target =
                offset + Vec3::new(random.within(0.01, 19.99), random.within(0.01, 9.99), 0.0);
            let from = target + Vec3::new(0.0, 0.0, random.within(0.1, 100.0));
            assert!(bvh.nearest(&Ray::new(from, Vec3::NEG_Z)).is_some());
            assert!(bvh.any(from, target - Vec3::Z));
            assert!(!bvh.any(from, target + 0.001 * Vec3::Z));
        }
    }
}

#[test]
fn no_ray_slips_through_a_closed_surface() {
    let triangles = terrain(24);
    let mut random = Random::new(21);
    for bvh in structures(&triangles) {
        for i in 0..6000 {
            let o = random.point(0.9).with_z(random.within(3.0, 9.0));
            // Steep rays from above, away from silhouettes: through corners, through points of
            // edges, through centers.
            let [a, b, c] = triangles[(i * 37) % triangles.len()];
            let target = match i % 3 {
                0 => a,
                1 => a.lerp(b, random.within(0.0, 1.0)),
                _ => (a + b + c) / 3.0,
            };
            let inside = target.x.abs().max(target.y.abs()) < 0.99;
            if !inside {
                continue;
            }
            let below = o + (target - o) * 2.0;
            assert!(
                bvh.nearest(&Ray::new(o, (target - o).normalize()))
                    .is_some(),
                "{o} {target}"
            );
            assert!(bvh.any(o, below), "{o} {target}");
            assert_eq!(any_packet(&bvh, o, &[below; 5]), 0b11111);
        }
    }
}

#[test]
fn segments_equal_the_loop() {
    for (count, size) in [(1, 1.0), (9, 0.7), (300, 0.2)] {
        let triangles = soup(count, size, 40 + count as u64);
        let mut random = Random::new(41);
        for bvh in structures(&triangles) {
            for _ in 0..2000 {
                let (from, to) = (random.point(1.3), random.point(1.3));
                let ray = Ray {
                    o: from,
                    d: to - from,
                    t_max: 1.0,
                };
                let blocked = bvh.any(from, to);
                assert!(
                    blocked || brute_force(&triangles, &ray, 1e-4).is_none(),
                    "{from} {to}"
                );
                let longer = Ray {
                    t_max: 1.0 + 1e-5,
                    ..ray
                };
                assert!(
                    !blocked || brute_force(&triangles, &longer, -1e-4).is_some(),
                    "{from} {to}"
                );
            }
        }
    }
}

/// [`TriangleBvh::any`] for up to 64 targets: bit `i` is the answer for `to[i]`.
struct AnyPacket<'a> {
    bvh: &'a TriangleBvh,
    from: Vec3,
    to: &'a [Vec3],
}

impl SimdKernel for AnyPacket<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> u64 {
        let rays = u64::MAX >> (RAYS - self.to.len());
        let targets = Targets::new(self.to);
        let mut packet = Packet::new(s, self.bvh.parts(), self.from, &targets, rays);
        let mut stack = EMPTY_STACK;
        packet.trace(s, &mut stack, 0, rays);
        rays & !packet.open
    }
}

fn any_packet(bvh: &TriangleBvh, from: Vec3, to: &[Vec3]) -> u64 {
    bvh.isa.run(AnyPacket { bvh, from, to })
}

#[test]
fn packets_equal_single_segments() {
    let triangles = soup(600, 0.25, 50);
    let mut random = Random::new(51);
    for bvh in structures(&triangles) {
        for i in 0..400 {
            let from = random.point(1.3);
            let (center, spread) = (random.point(1.3), [0.01, 0.2, 2.0][i % 3]);
            let mut to: Vec<Vec3> = (0..1 + i % 64)
                .map(|_| center + random.point(spread))
                .collect();
            if i.is_multiple_of(5) {
                to[0] = from;
                to.iter_mut().step_by(3).for_each(|p| p.x = from.x);
            }
            let blocked = any_packet(&bvh, from, &to);
            for (j, &p) in to.iter().enumerate() {
                check_equal_or_grazing(&bvh, &triangles, from, p, blocked >> j & 1 == 1);
            }
            assert!(to.len() == 64 || blocked >> to.len() == 0);
        }
    }
}

/// If `blocked` differs from the result for a single segment, the segment must graze an edge or end
/// on a triangle.
fn check_equal_or_grazing(
    bvh: &TriangleBvh,
    triangles: &[[Vec3; 3]],
    from: Vec3,
    to: Vec3,
    blocked: bool,
) {
    if bvh.any(from, to) == blocked {
        return;
    }
    let segment = |t_max: f32| Ray {
        o: from,
        d: to - from,
        t_max,
    };
    let certain = brute_force(triangles, &segment(1.0 - 1e-5), 1e-4);
    let possible = brute_force(triangles, &segment(1.0 + 1e-5), -1e-4);
    assert!(
        certain.is_none() && possible.is_some(),
        "{:?}: {from} to {to} is not {blocked}",
        bvh.isa
    );
}

#[test]
fn tiles_equal_single_segments() {
    let terrain = terrain(40);
    let wall = [
        Vec3::new(-9.0, -9.0, 0.2),
        Vec3::new(9.0, -9.0, 0.2),
        Vec3::new(0.0, 9.0, 0.2),
    ];
    for triangles in [
        soup(600, 0.25, 60),
        soup(6000, 0.04, 61),
        terrain,
        vec![wall],
    ] {
        let mut random = Random::new(62);
        for bvh in structures(&triangles) {
            for i in 0..24 {
                // Groups of all sizes: compact, wide, and overlapping.
                let (a, b) = (random.point(1.3), random.point(1.3));
                let spread = [0.003, 0.05, 0.3, 2.0];
                let mut group = |middle: Vec3, spread: f32, count: usize| -> Vec<Vec3> {
                    (0..count).map(|_| middle + random.point(spread)).collect()
                };
                let points = group(a, spread[i % 4], 1 + 37 * i % 64);
                let mut lights = group(b, spread[i / 4 % 4], 1 + 53 * i % 64);
                if i % 7 == 0 {
                    lights[0] = points[0];
                    lights.iter_mut().for_each(|p| p.z = points[0].z);
                }
                let all = u64::MAX >> (64 - lights.len());
                let sparse = random.0.next_u32();
                let wanted: Vec<u64> = (0..points.len() as u32)
                    .map(|k| {
                        if i % 3 == 0 {
                            all
                        } else {
                            all & u64::from(sparse).rotate_left(7 * k)
                        }
                    })
                    .collect();
                let open = bvh.open_in_tile(&points, &lights, &wanted);
                for (k, &from) in points.iter().enumerate() {
                    assert_eq!(open[k] & !wanted[k], 0);
                    for (j, &to) in lights.iter().enumerate() {
                        if wanted[k] >> j & 1 == 1 {
                            check_equal_or_grazing(
                                &bvh,
                                &triangles,
                                from,
                                to,
                                open[k] >> j & 1 == 0,
                            );
                        }
                    }
                }
                assert!(open[points.len()..].iter().all(|&lights| lights == 0));
            }
        }
    }
}

#[test]
fn degenerate_triangles_are_never_hit() {
    let p = Vec3::new(0.1, 0.2, 0.3);
    let mut triangles = vec![
        [p; 3],
        [Vec3::ZERO, Vec3::X, Vec3::X * 2.0],
        [Vec3::splat(f32::NAN), Vec3::X, Vec3::Y],
        [Vec3::splat(f32::INFINITY), Vec3::X, Vec3::Y],
    ];
    for bvh in structures(&triangles) {
        assert!(bvh.is_empty());
        assert!(
            bvh.nearest(&Ray::new(Vec3::Z, Vec3::NEG_Z)).is_none()
                && !bvh.any(Vec3::Z, Vec3::NEG_Z)
        );
    }
    triangles.push([Vec3::NEG_X, Vec3::X, Vec3::Y]);
    for bvh in structures(&triangles) {
        let hit = bvh
            .nearest(&Ray::new(Vec3::new(0.0, 0.25, 1.0), Vec3::NEG_Z))
            .unwrap();
        assert_eq!((hit.id, hit.t), (4, 1.0));
        assert!((hit.coordinates - Vec2::new(0.375, 0.25)).length() < 1e-6);
        // A ray in the plane of the triangle has no hit.
        assert!(
            bvh.nearest(&Ray::new(Vec3::new(-5.0, 0.25, 0.0), Vec3::X))
                .is_none()
        );
    }
}

#[test]
fn piles_of_coincident_triangles_keep_the_depth_bounded() {
    let one = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let nested = (0..3000).map(|i| one.map(|p| p * (1.0 + i as f32 * 1e-3)));
    let triangles: Vec<[Vec3; 3]> = std::iter::repeat_n(one, 3000).chain(nested).collect();
    for bvh in structures(&triangles) {
        let ray = Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z);
        assert!(
            bvh.nearest(&ray)
                .is_some_and(|hit| (hit.t - 1.0).abs() < 1e-6)
        );
        assert!(!bvh.any(Vec3::new(5.0, 5.0, 1.0), Vec3::new(5.0, 5.0, -1.0)));
        let far = Ray::new(Vec3::new(1.5, 1.5, 1.0), Vec3::NEG_Z);
        assert!(bvh.nearest(&far).is_some());
    }
}

#[test]
fn rays_that_are_not_finite_end() {
    let triangles = soup(300, 0.1, 5);
    let numbers = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 0.0];
    let points = || {
        let all = numbers.into_iter().map(Vec3::splat);
        all.chain([
            Vec3::new(f32::NAN, 0.5, 0.5),
            Vec3::new(0.5, 0.5, f32::INFINITY),
        ])
    };
    for bvh in structures(&triangles) {
        for (a, b) in points().flat_map(|a| points().map(move |b| (a, b))) {
            let _ = (bvh.nearest(&Ray::new(a, b)), bvh.any(a, b));
        }
    }
}

#[test]
fn nested_boxes_keep_the_depth_bounded() {
    let nested = |i: u32| Aabb {
        min: Vec3::ZERO,
        max: Vec3::splat(1.5f32.powi(i as i32 - 60)),
    };
    let boxes = (0..120).map(|i| ItemBox::new(nested(i), i)).collect();
    let tree = WideTree::new(boxes, 1);
    let mut seen: Vec<u32> = tree.items.clone();
    seen.sort_unstable();
    assert!(seen.into_iter().eq(0..120));
    assert!(depth(&tree, 0) <= build::MAX_DEPTH);
}

fn depth(tree: &WideTree, node: usize) -> usize {
    let children = tree.nodes[node]
        .children
        .iter()
        .filter(|&&word| word != 0 && word & node::LEAF == 0);
    1 + children
        .map(|&word| depth(tree, word as usize))
        .max()
        .unwrap_or(0)
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    // Long enough for divisions in chunks.
    let triangles = soup(80_000, 0.02, 9);
    let build = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let bvh = pool.unwrap().install(|| over_all(&triangles));
        let TreeParts { nodes, blocks } = bvh.parts();
        let nodes = nodes.iter().map(|n| (n.bounds, n.children, n.order));
        let blocks = blocks.iter().map(|b| (b.corners, b.ids));
        (nodes.collect::<Vec<_>>(), blocks.collect::<Vec<_>>())
    };
    let one = build(1);
    assert!([2, 3, 8].into_iter().all(|threads| build(threads) == one));
}

#[test]
fn every_triangle_is_in_one_leaf() {
    let triangles = soup(20_000, 0.05, 10);
    let bvh = over_all(&triangles);
    let blocks = bvh.parts().blocks;
    // Unused lanes are degenerate, and repeat index 0.
    let used = blocks.iter().flat_map(|block| {
        let is_used =
            |&lane: &usize| (0..3).any(|a| block.corners[0][a][lane] != block.corners[1][a][lane]);
        (0..8).filter(is_used).map(|lane| block.ids[lane])
    });
    let mut used: Vec<u32> = used.collect();
    used.sort_unstable();
    assert!(used.into_iter().eq(0..20_000));
}

#[test]
fn memory_per_triangle_stays_small() {
    let triangles = terrain(100);
    let bvh = over_all(&triangles);
    let bytes = bvh.bytes() as f64 / triangles.len() as f64;
    assert!(bytes < 90.0, "{bytes}");
}
