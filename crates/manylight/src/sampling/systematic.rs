//! Systematic sampling: a subset of nearly fixed size of weighted items, from one random offset.

/// Inclusion probabilities `a_i = min(1, w_i / τ)`. The threshold τ is chosen such that they sum to
/// `target`, or to the number of items with positive weight, if that is smaller. Positive weights
/// below `floor_share` times the mean weight are raised to this floor first, so that no positive
/// item has a vanishing probability. Items of weight 0 have probability 0.
pub fn inclusion_probabilities(weights: &[f32], target: usize, floor_share: f32) -> Vec<f32> {
    let positive = weights.iter().filter(|&&w| w > 0.0).count();
    if positive <= target {
        return weights
            .iter()
            .map(|&w| if w > 0.0 { 1.0 } else { 0.0 })
            .collect();
    }
    let mean = weights.iter().map(|&w| f64::from(w)).sum::<f64>() / positive as f64;
    let floor = mean * f64::from(floor_share);
    let raised = |w: f32| {
        if w > 0.0 {
            f64::from(w).max(floor)
        } else {
            0.0
        }
    };
    // Items with w >= τ have probability 1; the others share the rest of the target. No step
    // enlarges τ, so that the number of such items grows until it is stable.
    let mut tau = weights.iter().map(|&w| raised(w)).sum::<f64>() / target as f64;
    loop {
        let (mut certain, mut rest) = (0, 0.0);
        for w in weights.iter().map(|&w| raised(w)) {
            if w >= tau { certain += 1 } else { rest += w }
        }
        let next = if certain < target {
            rest / (target - certain) as f64
        } else {
            tau
        };
        if next >= tau || next <= 0.0 {
            break;
        }
        tau = next;
    }
    weights
        .iter()
        .map(|&w| (raised(w) / tau).min(1.0) as f32)
        .collect()
}

/// Indices of the selected items, ascending. Item `i` is selected with probability
/// `probabilities[i]`; the number of selected items differs from the sum of the probabilities by
/// less than one. `u` in [0, 1) is the random offset. Neighbors in the list are rarely selected
/// together: items sorted along a space-filling curve give a stratified subset.
///
/// Source: Madow, "On the Theory of Systematic Sampling, II", 1949. Prefix sums in `f64`.
pub fn systematic(probabilities: &[f32], u: f32) -> Vec<usize> {
    let mut selected = Vec::new();
    let mut sum = 0.0f64;
    let mut next = f64::from(u);
    for (i, &p) in probabilities.iter().enumerate() {
        sum += f64::from(p);
        if sum > next {
            selected.push(i);
            next += 1.0;
        }
    }
    selected
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_sum_to_the_target_and_respect_one() {
        let weights: Vec<f32> = (0..1000)
            .map(|i| {
                if i % 7 == 0 {
                    0.0
                } else {
                    (i as f32 * 0.37).sin().abs().powi(4)
                }
            })
            .collect();
        let a = inclusion_probabilities(&weights, 100, 1e-3);
        let sum: f64 = a.iter().map(|&p| f64::from(p)).sum();
        assert!((sum - 100.0).abs() < 1e-2, "{sum}");
        assert!(
            a.iter()
                .zip(&weights)
                .all(|(&p, &w)| (0.0..=1.0).contains(&p) && (p > 0.0) == (w > 0.0))
        );
    }

    #[test]
    fn items_are_selected_with_their_probabilities() {
        let a = [0.3f32, 0.9, 0.05, 0.75];
        let trials = 10_000;
        let mut counts = [0; 4];
        for t in 0..trials {
            for i in systematic(&a, (t as f32 + 0.5) / trials as f32) {
                counts[i] += 1;
            }
        }
        for (count, p) in counts.iter().zip(a) {
            assert!((*count as f32 / trials as f32 - p).abs() < 1e-3);
        }
    }
}
