//! Periodic value noise for textures.

/// Value noise in [0, 1): hashed values on a lattice, interpolated with a cubic.
///
/// `period` is the number of lattice cells in one unit of `u` and of `v`; the noise repeats with
/// period 1 in both.
pub fn noise(u: f64, v: f64, period: [u32; 2], seed: u32) -> f64 {
    let (x, y) = (u * f64::from(period[0]), v * f64::from(period[1]));
    let (column, row) = (x.floor(), y.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (s, t) = (ease(x - column), ease(y - row));
    let at = |dx: f64, dy: f64| {
        let i = (column + dx).rem_euclid(f64::from(period[0])) as u32;
        let j = (row + dy).rem_euclid(f64::from(period[1])) as u32;
        lattice(i, j, seed)
    };
    let lower = at(0.0, 0.0) + (at(1.0, 0.0) - at(0.0, 0.0)) * s;
    let upper = at(0.0, 1.0) + (at(1.0, 1.0) - at(0.0, 1.0)) * s;
    lower + (upper - lower) * t
}

/// Sum of octaves of [`noise`] in [0, 1). Each octave has twice the frequency and half the
/// amplitude of the one before.
pub fn fractal_noise(u: f64, v: f64, period: [u32; 2], octaves: u32, seed: u32) -> f64 {
    let mut sum = 0.0;
    let mut total = 0.0;
    for octave in 0..octaves {
        let amplitude = 0.5_f64.powi(octave as i32);
        let finer = period.map(|p| p << octave);
        sum += amplitude * noise(u, v, finer, seed + octave);
        total += amplitude;
    }
    sum / total
}

/// The value in [0, 1) of a lattice point. The coordinates are combined with three primes of
/// xxHash; the finalizer is the two-round hash `[15 2c1b3c6d 12 297a2d39 15]` of Wellons, "Hash
/// Function Prospector".
fn lattice(i: u32, j: u32, seed: u32) -> f64 {
    let mut h =
        i.wrapping_mul(0x9E37_79B1) ^ j.wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    f64::from((h ^ (h >> 15)) >> 8) / f64::from(1 << 24)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_periodic() {
        let a = fractal_noise(0.1, 0.999_999, [4, 3], 3, 7);
        let b = fractal_noise(1.1, -0.000_001, [4, 3], 3, 7);
        assert!((a - b).abs() < 1e-9);
        assert!((0.0..1.0).contains(&a));
    }
}
