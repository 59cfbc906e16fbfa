use super::*;
use crate::sampling::rng::Pcg;
use crate::simd::{Instructions, Isa};

fn on(instructions: Instructions, mut tree: KdTree<Vec3>) -> KdTree<Vec3> {
    tree.tree.isa = Isa::new(instructions).expect("available");
    tree
}

fn squared(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    d.x * d.x + d.y * d.y + d.z * d.z
}

fn points(count: usize, key: u64) -> Vec<Vec3> {
    let mut rng = Pcg::new(key);
    (0..count)
        .map(|i| {
            let p = Vec3::new(rng.next_f32(), rng.next_f32(), 0.1 * rng.next_f32());
            // Every fifth point stands at one of few places, so that there are many duplicates.
            if i % 5 == 0 {
                (p * 3.0).round() / 3.0
            } else {
                p
            }
        })
        .collect()
}

/// Squared distances and indices, nearest first.
fn brute_force(points: &[Vec3], p: Vec3, k: usize, radius: f32) -> Vec<(f32, u32)> {
    let all = points.iter().enumerate();
    let mut near: Vec<(f32, u32)> = all
        .map(|(i, q)| (squared(*q, p), i as u32))
        .filter(|(d2, _)| *d2 <= radius * radius)
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.truncate(k);
    near
}

#[test]
fn nearest_equals_brute_force_in_every_instruction_set() {
    for count in [0, 1, 7, 16, 17, 64, 65, 256, 257, 1000, 5000] {
        let points = points(count, count as u64);
        for instructions in Instructions::available() {
            let tree = on(instructions, KdTree::build(points.clone()));
            let mut rng = Pcg::new(99);
            for k in [1, 5, 64, 300] {
                let mut found = Neighbors::new(k);
                for radius in [0.05, 0.3, f32::INFINITY, 0.1, f32::INFINITY] {
                    let p = Vec3::new(rng.next_f32(), rng.next_f32(), 0.05) * 1.2;
                    tree.nearest(p, radius, &mut found);
                    let mut near: Vec<_> = found.iter().map(|(i, d2)| (d2, i)).collect();
                    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                    let expected = brute_force(&points, p, k, radius);
                    assert_eq!(
                        near, expected,
                        "{count} points, k = {k}, radius {radius}, {instructions:?}"
                    );
                    let radius_squared = match expected.last() {
                        Some(&(last, _)) if expected.len() == k || radius.is_infinite() => last,
                        None if radius.is_infinite() => 0.0,
                        _ => radius * radius,
                    };
                    assert_eq!(found.radius_squared(), radius_squared);
                }
            }
        }
    }
}

/// A tree that is written in the order of its leaves is the same tree when it is read.
#[test]
fn ordered_items_make_the_tree_that_ordered_them() {
    for count in [0, 1, 16, 17, 300, 5000] {
        let mut all = points(count, 3);
        all.extend([Vec3::splat(0.5); 40]);
        let built = KdTree::build_ordered(all);
        let again = KdTree::of_ordered(built.items().to_vec());
        let parts = |tree: &KdTree<Vec3>| {
            let KdIndex {
                blocks,
                nodes,
                levels,
                ..
            } = &tree.tree;
            format!("{blocks:?} {nodes:?} {levels:?}")
        };
        assert_eq!(parts(&built), parts(&again), "{count} points");
    }
}

/// The bound from the last search is valid for the next, near or far, in the same tree or another,
/// also with more than K points at one distance.
#[test]
fn searches_after_others_equal_brute_force() {
    let mut sets = [points(4000, 1), points(4000, 2)];
    sets[1].extend([Vec3::splat(0.5); 100]);
    let trees = sets.clone().map(KdTree::build);
    let mut rng = Pcg::new(7);
    let mut found = Neighbors::new(40);
    let mut p = Vec3::splat(0.5);
    for step in 0..600 {
        let set = step / 100 % 2;
        trees[set].nearest(p, f32::INFINITY, &mut found);
        let mut indices: Vec<u32> = found.iter().map(|(i, _)| i).collect();
        indices.sort_unstable();
        let mut expected: Vec<u32> = brute_force(&sets[set], p, 40, f32::INFINITY)
            .into_iter()
            .map(|(_, i)| i)
            .collect();
        expected.sort_unstable();
        assert_eq!(indices, expected, "step {step}");
        let size = [0.0, 1e-3, 0.05, 2.0][step % 4];
        p += (Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) - 0.5) * size;
    }
}

#[test]
fn within_and_cheapest_equal_brute_force_in_every_instruction_set() {
    let points = points(3000, 4);
    for instructions in Instructions::available() {
        let tree = on(instructions, KdTree::build(points.clone()));
        let mut rng = Pcg::new(5);
        for _ in 0..100 {
            let p = Vec3::new(rng.next_f32(), rng.next_f32(), 0.1 * rng.next_f32());
            let mut count = 0;
            tree.within(p, 0.1, |_, _| count += 1);
            assert_eq!(count, brute_force(&points, p, usize::MAX, 0.1).len());

            // A metric stretched along z, on every third point only.
            let cost = |i: u32, d2: f32| {
                let z = points[i as usize].z - p.z;
                (i % 3 == 1).then_some(d2 + 24.0 * z * z)
            };
            let expected = (0..points.len() as u32)
                .filter_map(|i| cost(i, squared(points[i as usize], p)).map(|c| (i, c)))
                .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            assert_eq!(tree.cheapest(p, f32::INFINITY, cost), expected);
            let below = expected.map_or(0.0, |e| e.1 * 0.99);
            assert_eq!(tree.cheapest(p, below, cost), None);
        }
    }
}

#[test]
fn ordered_items_are_the_same_in_the_order_of_the_leaves() {
    let points = points(3000, 6);
    let (kept, ordered) = (
        KdTree::build(points.clone()),
        KdTree::build_ordered(points.clone()),
    );
    assert_eq!(kept.items(), points);
    let mut items: Vec<[u32; 3]> = points
        .iter()
        .map(|p| p.to_array().map(f32::to_bits))
        .collect();
    let mut again: Vec<[u32; 3]> = ordered
        .items()
        .iter()
        .map(|p| p.to_array().map(f32::to_bits))
        .collect();
    items.sort_unstable();
    again.sort_unstable();
    assert_eq!(items, again);
    let p = Vec3::splat(0.3);
    ordered.within(p, 0.2, |i, d2| {
        assert_eq!(d2, squared(ordered.items()[i as usize], p))
    });
    let step = |tree: &KdTree<Vec3>| -> f32 {
        tree.items()
            .windows(2)
            .map(|pair| pair[0].distance(pair[1]))
            .sum()
    };
    assert!(step(&ordered) < 0.3 * step(&kept));
}

#[test]
fn the_tree_is_the_same_for_any_thread_count() {
    let points = points(60_000, 8);
    let indices = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| KdTree::build(points.clone()).tree.renumber())
    };
    assert_eq!(indices(1), indices(3));
}

#[test]
fn the_tree_costs_few_bytes_per_point() {
    let tree = KdTree::build(points(10_000, 1));
    let beside = tree.bytes() - 10_000 * size_of::<Vec3>();
    assert!(beside <= 20 * 10_000, "{beside}");
}
