//! Errors of the pictures of the pre-pass, and the weights that follow from them.

use super::pictures::{PrePass, Term, sum_of_terms, trimmed_mean};
use super::{ChoiceErrors, Filter, SHARED_NOISE, weight};
use crate::integrators::mixed::PathWeights;

/// Edge of the blocks in which the light of path samples and of virtual lights is compared.
const LIGHT_BLOCK: usize = 8;
/// Standard errors beyond which the light of a block that only virtual lights find is not noise: of
/// a normal distribution, .1 % of the blocks.
const SIGNIFICANT: f64 = 3.0;
/// Least of that light relative to the light of path samples: smaller amounts do not decide.
const MIN_EXCESS: f64 = 0.1;

impl PrePass {
    /// The weights of path samples by the variances of the terms.
    pub(super) fn weights(&self, filtered: bool) -> PathWeights {
        let [emission, direct, indirect, caustics] = self
            .term_variances(filtered)
            .map(|[path, lights]| weight(path, lights));
        PathWeights {
            emission,
            direct,
            indirect,
            caustics,
        }
    }

    /// The errors of all methods.
    pub(super) fn errors(&self, filter: Option<Filter>) -> ChoiceErrors {
        let [g0, g1, g2, g3] = self.groups.each_ref().map(sum_of_terms);
        let paths = [mean(&g0, &g1), mean(&g2, &g3)];
        let lights = self.lights.each_ref().map(sum_of_terms);
        let mixed = self.mixed(filter.is_some());
        let missed = self.missed();
        let [path, lights, mixed] =
            [&paths, &lights, &mixed].map(|pictures| self.error(pictures, filter));
        let shared = if filter.is_some() { SHARED_NOISE } else { 1.0 };
        ChoiceErrors {
            path,
            lights: lights * shared,
            // It took twice the computation, and a part of its noise is that of virtual lights.
            mixed: 2.0 * mixed * shared.sqrt(),
            missed,
            filtered: filter.is_some(),
        }
    }

    /// The relative variance of two independent pictures by one method, after the filter.
    fn error(&self, pictures: &[Term; 2], filter: Option<Filter>) -> f64 {
        let [a, b] = pictures
            .each_ref()
            .map(|picture| self.filtered(picture, filter));
        let difference: Term = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        0.5 * trimmed_mean(self.squares_of_blocks(&difference, 1))
    }

    /// The weighted means of a pass by virtual lights and two groups of path samples.
    fn mixed(&self, filtered: bool) -> [Term; 2] {
        let weights = self
            .term_variances(filtered)
            .map(|[path, lights]| f64::from(weight(path, lights)));
        [0, 1].map(|k| {
            let mut sum = vec![0.0; 3 * self.scale.len()];
            for (t, w) in weights.into_iter().enumerate() {
                let [a, b] = [2 * k, 2 * k + 1].map(|g| &self.groups[g][t]);
                for (i, sum) in sum.iter_mut().enumerate() {
                    *sum += (1.0 - w) * self.lights[k][t][i] + 0.5 * w * (a[i] + b[i]);
                }
            }
            sum
        })
    }

    fn filtered(&self, picture: &Term, filter: Option<Filter>) -> Term {
        let filtered = filter.and_then(|filter| filter(&self.filter_input(picture)));
        match filtered {
            Some(image) => image.data.iter().map(|&v| f64::from(v)).collect(),
            None => picture.clone(),
        }
    }

    /// The relative squared error by light that path samples miss, as caustics and what comes
    /// through gaps: blocks in which virtual lights bring more by far than the spread of all
    /// pictures explains.
    fn missed(&self) -> f64 {
        let lights = self.lights.each_ref().map(sum_of_terms);
        let groups = self.groups.each_ref().map(sum_of_terms);
        let mut error = 0.0;
        for pixels in self.blocks(LIGHT_BLOCK) {
            let count = pixels.len() as f64;
            let light = |picture: &Term| {
                let of_pixel = |&i: &usize| picture[3 * i..3 * i + 3].iter().sum::<f64>() / 3.0;
                pixels.iter().map(of_pixel).sum::<f64>() / count
            };
            let ([a, b], groups) = (lights.each_ref().map(light), groups.each_ref().map(light));
            let path = groups.iter().sum::<f64>() / groups.len() as f64;
            let spread: f64 = groups.iter().map(|group| (group - path).powi(2)).sum();
            let of_mean = groups.len() * (groups.len() - 1);
            let variance = spread / of_mean as f64 + 0.25 * (a - b).powi(2);
            let excess = 0.5 * (a + b) - path;
            if excess > SIGNIFICANT * variance.sqrt() && excess > MIN_EXCESS * path {
                let scale = pixels.iter().map(|&i| self.scale[i]).sum::<f64>() / count;
                error += count * excess * excess / scale.max(f64::MIN_POSITIVE);
            }
        }
        error / self.scale.len().max(1) as f64
    }
}

fn mean(a: &Term, b: &Term) -> Term {
    a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_variances_relative_to_squared_radiance() {
        let errors = PrePass::constant([0.9, 1.1], [1.2, 0.8, 1.1, 0.9]).errors(None);
        // Halves of 0.2² and 0², over 1 and a hundredth.
        assert!((errors.lights - 0.02 / 1.01).abs() < 1e-6, "{errors:?}");
        assert!(errors.path.abs() < 1e-12, "{errors:?}");
    }

    #[test]
    fn light_that_path_samples_miss_is_found() {
        let missed = |lights, groups| PrePass::constant(lights, groups).errors(None).missed;
        let groups = [1.0, 1.01, 0.99, 1.0];
        // The mean of all pictures is 4/3.
        let expected = 1.01_f64.powi(2) / (1.01 * (8.02_f64 / 6.0).powi(2));
        let found = missed([2.0, 2.02], groups);
        assert!((found - expected).abs() < 1e-3, "{found} for {expected}");
        assert_eq!(missed([1.0, 1.02], groups), 0.0, "noise");
        assert_eq!(
            missed([0.5, 0.51], groups),
            0.0,
            "light that virtual lights miss"
        );
        assert_eq!(
            missed([1.0, 3.0], groups),
            0.0,
            "a pass that differs from the other"
        );
    }
}
