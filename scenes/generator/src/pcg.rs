//! A random number generator with the same sequence on every platform.

/// PCG-XSH-RR with 64 bits of state and 32 bits of output. Source: O'Neill, "PCG: A Family of
/// Simple Fast Space-Efficient Statistically Good Algorithms for Random Number Generation", 2014.
#[derive(Clone, Debug)]
pub struct Pcg32 {
    state: u64,
}

impl Pcg32 {
    /// Multiplier of the linear congruential step, from the reference implementation.
    const MULTIPLIER: u64 = 6_364_136_223_846_793_005;
    /// Increment of the linear congruential step: one stream for all generators.
    const INCREMENT: u64 = 1_442_695_040_888_963_407;

    /// A generator. Different seeds start at different positions of the same sequence.
    pub fn new(seed: u64) -> Pcg32 {
        let mut pcg = Pcg32 {
            state: seed.wrapping_add(Self::INCREMENT),
        };
        pcg.bits();
        pcg
    }

    /// 32 random bits.
    pub fn bits(&mut self) -> u32 {
        let old = self.state;
        self.state = old
            .wrapping_mul(Self::MULTIPLIER)
            .wrapping_add(Self::INCREMENT);
        let mixed = (((old >> 18) ^ old) >> 27) as u32;
        mixed.rotate_right((old >> 59) as u32)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        f64::from(self.bits()) / 4_294_967_296.0
    }

    /// Uniform in [`low`, `high`).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in [`-spread`, `spread`).
    pub fn jitter(&mut self, spread: f64) -> f64 {
        self.range(-spread, spread)
    }

    /// Uniform in 0..`count`.
    pub fn index(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_have_the_range_and_mean_of_a_uniform_distribution() {
        let mut pcg = Pcg32::new(1);
        let draws: Vec<f64> = (0..10_000).map(|_| pcg.range(2.0, 4.0)).collect();
        assert!(draws.iter().all(|x| (2.0..4.0).contains(x)));
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        assert!((mean - 3.0).abs() < 0.03);
    }

    #[test]
    fn seeds_differ() {
        assert_ne!(Pcg32::new(1).bits(), Pcg32::new(2).bits());
    }
}
