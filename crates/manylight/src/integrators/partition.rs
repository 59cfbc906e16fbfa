//! The path partition: the film layer that a path belongs to. In words: docs/path_partition.md.
//!
//! Scattering *events* are classified, not surfaces. Along a camera path, `x` is the first vertex
//! with a non-specular event, and `y` is the vertex after it:
//!
//! | path | layer |
//! |---|---|
//! | ends on an emitter before any `x` | emission |
//! | `y` lies on an emitter and the path ends there | direct |
//! | the event at `y` is non-specular | virtual lights, and compensation of what clamping removes from them |
//! | the event at `y` is specular | caustics |

use crate::bsdf::Lobes;
use crate::film::Layer;

/// The part of a camera path that decides its layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathStage {
    /// All events so far are specular.
    BeforeX,
    /// The event at `x` was non-specular; the next vertex is `y`.
    AfterX,
    /// The event at `y` has decided the layer.
    Decided(Layer),
}

impl PathStage {
    /// The stage after an event of class `event`.
    pub fn after(self, event: Lobes) -> PathStage {
        match self {
            PathStage::BeforeX if event.has(Lobes::NON_SPECULAR) => PathStage::AfterX,
            PathStage::BeforeX => PathStage::BeforeX,
            PathStage::AfterX if event.has(Lobes::NON_SPECULAR) => {
                PathStage::Decided(Layer::VirtualLights)
            }
            PathStage::AfterX => PathStage::Decided(Layer::Caustics),
            decided => decided,
        }
    }

    /// The stage after a non-specular event at a vertex that compensates clamping.
    pub fn after_compensating_event(self) -> PathStage {
        match self.after(Lobes::NON_SPECULAR) {
            PathStage::Decided(Layer::VirtualLights) => PathStage::Decided(Layer::Compensation),
            other => other,
        }
    }

    /// The layer of a path that ends on an emitter here.
    pub fn layer(self) -> Layer {
        match self {
            PathStage::BeforeX => Layer::Emission,
            PathStage::AfterX => Layer::Direct,
            PathStage::Decided(layer) => layer,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table above, written for whole event strings: `events` from the camera to the emitter.
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
                    .fold(PathStage::BeforeX, |stage, &e| stage.after(e));
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
