//! The path partition: which layer a path belongs to; in words in docs/path_partition.md.
//!
//! Classify scattering *events*, not surfaces. Walk the eye path through specular events; `x` is the first vertex where a
//! smooth lobe scatters, `y` the vertex after it:
//!
//! | path | layer |
//! |---|---|
//! | ends on an emitter before any `x` | emission |
//! | `y` lies on an emitter and the path ends there | direct |
//! | the event at `y` is smooth | virtual lights |
//! | the event at `y` is specular | caustics |

use crate::bsdf::Lobes;
use crate::film::Layer;

/// How far along the partition an eye path is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Specular events only so far.
    BeforeX,
    /// The event at `x` was smooth; the next vertex is `y`.
    AfterX,
    /// The event at `y` decided the layer.
    Decided(Layer),
}

impl Stage {
    /// The stage after an event of class `event`.
    pub fn after(self, event: Lobes) -> Stage {
        match self {
            Stage::BeforeX if event.has(Lobes::NON_SPECULAR) => Stage::AfterX,
            Stage::BeforeX => Stage::BeforeX,
            Stage::AfterX if event.has(Lobes::NON_SPECULAR) => Stage::Decided(Layer::VirtualLights),
            Stage::AfterX => Stage::Decided(Layer::Caustics),
            decided => decided,
        }
    }

    /// The layer of a path that ends on an emitter now.
    pub fn layer(self) -> Layer {
        match self {
            Stage::BeforeX => Layer::Emission,
            Stage::AfterX => Layer::Direct,
            Stage::Decided(layer) => layer,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table above, written for whole event strings: `events` from the eye to the emitter.
    fn layer_by_definition(events: &[Lobes]) -> Layer {
        match events.iter().position(|e| e.has(Lobes::NON_SPECULAR)) {
            None => Layer::Emission,
            Some(x) => match events.get(x + 1) {
                None => Layer::Direct,
                Some(y) if y.has(Lobes::NON_SPECULAR) => Layer::VirtualLights,
                Some(_) => Layer::Caustics,
            },
        }
    }

    #[test]
    fn every_event_string_has_one_layer() {
        let classes = [
            Lobes::DIFFUSE,
            Lobes::GLOSSY,
            Lobes::NEAR_DELTA,
            Lobes::DELTA,
        ];
        let mut strings: Vec<Vec<Lobes>> = vec![vec![]];
        let mut seen = 0;
        for _ in 0..6 {
            for events in &strings {
                let stage = events
                    .iter()
                    .fold(Stage::BeforeX, |stage, &e| stage.after(e));
                assert_eq!(stage.layer(), layer_by_definition(events), "{events:?}");
                seen += 1;
            }
            strings = strings
                .iter()
                .flat_map(|s| classes.map(|c| [s.as_slice(), &[c]].concat()))
                .collect();
        }
        assert_eq!(seen, 1 + 4 + 16 + 64 + 256 + 1024);
    }
}
