//! How the choice of `--method auto` is written, and what it changes in a render.

use crate::args::PartArgs;
use crate::preset;
use manylight::integrators::{Choice, ChoiceErrors, MethodKind, Mixed, PathWeights};
use manylight::render::Budget;
use serde_json::{Map, Value, json};
use std::num::NonZeroU32;

/// The budget and the block of a render with a choice. Path tracing takes as many samples as have
/// the computation of the passes by virtual lights that were asked for, in as many blocks.
pub(crate) fn budget_and_block(
    budget: Budget,
    block: NonZeroU32,
    choice: Option<&Choice>,
) -> (Budget, NonZeroU32) {
    let Some(samples) = choice
        .filter(|choice| is_path(choice))
        .map(|c| c.path_samples)
    else {
        return (budget, block);
    };
    let passes = budget.passes.map(|n| n.saturating_mul(samples.get()));
    (Budget { passes, ..budget }, block.saturating_mul(samples))
}

/// Whether path tracing alone was chosen.
pub(crate) fn is_path(choice: &Choice) -> bool {
    choice.kind == MethodKind::Path
}

/// The method that repeats a render with this choice.
pub(crate) fn repeating_method(choice: &Choice) -> &'static str {
    match choice.kind {
        MethodKind::Mixed(_) => preset::DEFAULT,
        _ => word(&choice.kind),
    }
}

/// The blocks of a command that repeats a render.
pub(crate) fn parts(parts: &PartArgs, choice: Option<&Choice>) -> PartArgs {
    let (_, block) = budget_and_block(Budget::default(), parts.block, choice);
    PartArgs {
        block,
        ..parts.clone()
    }
}

/// The word of a choice.
fn word(kind: &MethodKind) -> &'static str {
    match kind {
        MethodKind::Path => "path",
        MethodKind::Mixed(_) => "both",
        _ => "rich-vpl",
    }
}

/// What decides about the bits of an image, as JSON.
pub(crate) fn deciding(choice: &Choice) -> Map<String, Value> {
    let mut map = Map::new();
    map.insert("choice".into(), word(&choice.kind).into());
    if choice.kind == MethodKind::Path || matches!(choice.kind, MethodKind::Mixed(_)) {
        map.insert("path_samples".into(), choice.path_samples.get().into());
    }
    if let MethodKind::Mixed(Mixed { weights, .. }) = &choice.kind {
        let PathWeights {
            emission,
            direct,
            indirect,
            caustics,
        } = weights;
        let weights = json!({
            "emission": emission,
            "direct": direct,
            "virtual_lights": indirect,
            "caustics": caustics,
        });
        map.insert("path_weights".into(), weights);
    }
    map
}

/// The figures of a choice, as JSON.
pub(crate) fn figures(choice: &Choice) -> Value {
    let ChoiceErrors {
        path,
        lights,
        mixed,
        missed,
        filtered,
    } = choice.errors;
    let rounded = |error: f64| format!("{error:.3e}").parse::<f64>().unwrap_or(error);
    json!({
        "path": rounded(path),
        "rich-vpl": rounded(lights),
        "both": rounded(mixed),
        "missed_by_path": rounded(missed),
        "denoised": filtered,
        "path_samples": choice.path_samples,
    })
}

/// The choice in one line.
pub(crate) fn line(choice: &Choice) -> String {
    let chosen = match &choice.kind {
        MethodKind::Path => "path tracing".to_owned(),
        MethodKind::Mixed(mixed) => format!(
            "the mean of rich-vpl and path tracing, {} samples a pass",
            mixed.path_samples
        ),
        _ => "rich-vpl".to_owned(),
    };
    let ChoiceErrors {
        path,
        lights,
        mixed,
        missed,
        filtered,
    } = choice.errors;
    let state = if filtered { "denoised" } else { "as rendered" };
    let missed = match missed > 0.0 {
        true => format!(" and light that it misses {missed:.2e}"),
        false => String::new(),
    };
    format!(
        "auto: {chosen} (errors at equal computation, {state}: path {path:.2e}{missed}, rich-vpl {lights:.2e}, both {mixed:.2e})"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::integrators::ManyLight;

    fn choice(kind: MethodKind) -> Choice {
        Choice {
            kind,
            path_samples: NonZeroU32::new(40).unwrap(),
            errors: ChoiceErrors {
                path: 0.5,
                lights: 0.25,
                mixed: 1.0 / 3.0,
                missed: 0.0,
                filtered: true,
            },
        }
    }

    fn mixed() -> MethodKind {
        MethodKind::Mixed(Mixed {
            lights: ManyLight::rich_vpl(),
            path_samples: NonZeroU32::new(40).unwrap(),
            weights: PathWeights {
                emission: 0.5,
                direct: 0.25,
                indirect: 0.75,
                caustics: 1.0,
            },
        })
    }

    #[test]
    fn path_tracing_has_the_computation_of_the_passes_that_were_asked_for() {
        let block = NonZeroU32::new(16).unwrap();
        let path = choice(MethodKind::Path);
        let (budget, path_block) = budget_and_block(Budget::passes(19), block, Some(&path));
        assert_eq!((budget.passes, path_block.get()), (Some(760), 640));
        for kind in [MethodKind::ManyLight(ManyLight::rich_vpl()), mixed()] {
            let other = budget_and_block(Budget::passes(19), block, Some(&choice(kind)));
            assert_eq!(other, (Budget::passes(19), block));
        }
    }

    #[test]
    fn parts_of_different_choices_differ() {
        let lights = MethodKind::ManyLight(ManyLight::rich_vpl());
        let [path, lights, both] =
            [MethodKind::Path, lights, mixed()].map(|k| deciding(&choice(k)));
        assert_eq!(path["choice"], "path");
        assert_eq!(path["path_samples"], 40);
        assert_eq!(lights["choice"], "rich-vpl");
        assert_eq!(both["path_weights"]["virtual_lights"], 0.75);
        assert!(path != lights && lights != both && path != both);
    }

    #[test]
    fn figures_have_four_digits() {
        let figures = figures(&choice(mixed()));
        assert_eq!(figures["both"], 0.3333);
        assert_eq!(figures["denoised"], true);
        let line = line(&choice(mixed()));
        assert!(
            line.contains("the mean of rich-vpl and path tracing, 40 samples a pass"),
            "{line}"
        );
    }
}
