//! The octahedral map between unit directions and the square, and tables of values on it.
//!
//! Source: Engelhardt and Dachsbacher, "Octahedron Environment Maps", VMV 2008.

use super::{Vec2, Vec3};

/// Maps a unit direction to the square [0, 1]². The hemisphere z > 0 maps to the inner diamond.
#[inline(always)]
pub fn square_from_direction(w: Vec3) -> Vec2 {
    let p = w * (w.x.abs() + w.y.abs() + w.z.abs()).recip();
    let q = if p.z >= 0.0 {
        Vec2::new(p.x, p.y)
    } else {
        Vec2::new(
            (1.0 - p.y.abs()).copysign(p.x),
            (1.0 - p.x.abs()).copysign(p.y),
        )
    };
    q * 0.5 + Vec2::splat(0.5)
}

/// Maps the square [0, 1]² to a unit direction: the inverse of [`square_from_direction`].
#[inline]
pub fn direction_from_square(uv: Vec2) -> Vec3 {
    let q = uv * 2.0 - Vec2::ONE;
    let z = 1.0 - q.x.abs() - q.y.abs();
    let (x, y) = if z >= 0.0 {
        (q.x, q.y)
    } else {
        (
            (1.0 - q.y.abs()).copysign(q.x),
            (1.0 - q.x.abs()).copysign(q.y),
        )
    };
    Vec3::new(x, y, z).normalize()
}

/// Index of the texel in column `i`, row `j` of an `n`² table, with `i` and `j` from -1 to `n`.
/// Beyond an edge the other coordinate is mirrored.
#[inline(always)]
pub fn wrapped_texel(i: i32, j: i32, n: i32) -> i32 {
    let beyond = i < 0 || i >= n;
    let (i, j) = if beyond {
        (i.max(0).min(n - 1), n - 1 - j)
    } else {
        (i, j)
    };
    let beyond = j < 0 || j >= n;
    let (i, j) = if beyond {
        (n - 1 - i, j.max(0).min(n - 1))
    } else {
        (i, j)
    };
    j * n + i
}

/// Direction through the center of texel `index` of a `side`² table.
#[inline]
pub fn texel_direction(index: usize, side: usize) -> Vec3 {
    let (row, column) = (index / side, index % side);
    direction_from_square(Vec2::new(column as f32 + 0.5, row as f32 + 0.5) / side as f32)
}

/// Solid angle per unit area of the square at `uv`, in sr.
///
/// With `v` the point of the octahedron |x|+|y|+|z| = 1 above `uv`, dω = dA cosθ / |v|², and one
/// unit of the square is 4 units of the xy-projection; both give 4 / |v|³.
#[inline]
pub fn solid_angle_density(uv: Vec2) -> f32 {
    let q = uv * 2.0 - Vec2::ONE;
    let z = 1.0 - q.x.abs() - q.y.abs();
    let (x, y) = if z >= 0.0 {
        (q.x.abs(), q.y.abs())
    } else {
        (1.0 - q.y.abs(), 1.0 - q.x.abs())
    };
    4.0 * (x * x + y * y + z * z).powf(-1.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> impl Iterator<Item = Vec3> {
        (0..2000).map(|i| {
            let z = 1.0 - 2.0 * (i as f32 + 0.5) / 2000.0;
            let phi = i as f32 * 2.399_963;
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * phi.cos(), r * phi.sin(), z)
        })
    }

    #[test]
    fn the_map_inverts() {
        for w in directions() {
            assert!((direction_from_square(square_from_direction(w)) - w).length() < 1e-5);
        }
    }

    #[test]
    fn solid_angles_sum_to_the_sphere() {
        let n = 512;
        let sum: f64 = (0..n * n)
            .map(|i| {
                let uv = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                f64::from(solid_angle_density(uv)) / (n * n) as f64
            })
            .sum();
        assert!((sum - 4.0 * std::f64::consts::PI).abs() < 1e-3, "{sum}");
    }
}
