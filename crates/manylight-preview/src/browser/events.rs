//! The events that a page receives.
//!
//! While the render goes on, a page receives the one layer that it shows, each time the picture is
//! renewed; a page that weighs the light groups, these too. A page that reads slowly gets the latest
//! picture next. At the end it receives all layers, so that it can show them when the program has
//! ended.
//!
//! | event | data |
//! |---|---|
//! | `picture` | a layer with the state of the render, as in [`PictureEvent`] |
//! | `end` | nothing; the final picture is complete |

use crate::picture::{Picture, Progress, RenderState};
use axum::response::sse::Event;
use futures_util::stream::{Stream, unfold};
use manylight_io::image::{ImageLayer, last_part, light_group};
use manylight_lab::noise::NOISY;
use manylight_lab::viewer::halves;
use serde::Serialize;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;
use tokio::sync::watch::Receiver;

/// The picture that pages show; `None` before the first pass.
pub(super) type Latest = Option<Arc<Picture>>;

/// A layer of a picture.
#[derive(Debug, Serialize)]
struct PictureEvent<'p> {
    width: usize,
    height: usize,
    passes: u32,
    seconds: f64,
    error: Option<f32>,
    state: &'static str,
    /// All layers of the picture.
    layers: Vec<LayerEntry<'p>>,
    /// The layer that follows, as index of `layers`.
    layer: usize,
    /// Its values as half floats in base64, the channels of a pixel together.
    values: String,
}

/// A layer that a page may show.
#[derive(Debug, Serialize)]
struct LayerEntry<'p> {
    name: &'p str,
    /// Last part of the name of each channel.
    channels: Vec<&'p str>,
}

/// What a page shows.
#[derive(Debug)]
pub(super) struct Shown {
    /// Label of the layer; unknown ones mean the first.
    pub(super) layer: String,
    /// Whether the page weighs the light groups.
    pub(super) lights: bool,
}

/// The events for one page.
pub(super) fn events(
    mut latest: Receiver<Latest>,
    shown: Shown,
) -> impl Stream<Item = Result<Event, Infallible>> {
    // The picture that is there counts as new.
    latest.mark_changed();
    let page = Page {
        latest,
        shown,
        phase: Phase::Waiting,
    };
    unfold(page, |mut page| async move {
        let event = page.next().await?;
        Some((Ok(event), page))
    })
}

/// The state of a stream of events.
struct Page {
    latest: Receiver<Latest>,
    shown: Shown,
    phase: Phase,
}

enum Phase {
    /// The next picture is sent when it comes.
    Waiting,
    /// A picture, with its layers that are still to be sent.
    Sending(Arc<Picture>, VecDeque<usize>),
    /// Everything is sent.
    Ended,
}

impl Page {
    /// The next event; `None` after the event `end`, and if the render ended without a final
    /// picture.
    async fn next(&mut self) -> Option<Event> {
        loop {
            match &mut self.phase {
                Phase::Ended => return None,
                Phase::Sending(picture, layers) => {
                    if let Some(layer) = layers.pop_front() {
                        return Some(picture_event(picture, layer));
                    }
                    if picture.progress.state == RenderState::Rendering {
                        self.phase = Phase::Waiting;
                        continue;
                    }
                    self.phase = Phase::Ended;
                    return Some(Event::default().event("end").data(""));
                }
                Phase::Waiting => {}
            }
            self.latest.changed().await.ok()?;
            if let Some(picture) = self.latest.borrow_and_update().clone() {
                let layers = sent_layers(&picture, &self.shown);
                self.phase = Phase::Sending(picture, layers);
            }
        }
    }
}

/// The layers of a picture that a page receives, that which it shows first.
fn sent_layers(picture: &Picture, shown: &Shown) -> VecDeque<usize> {
    let first = index_of(picture, &shown.layer);
    let is_final = picture.progress.state != RenderState::Rendering;
    let is_sent = |&k: &usize| {
        let name = &picture.layers[k].name;
        // Without noise, the image is not what the groups add up to.
        let is_light = k == 0 || light_group(name).is_some() || last_part(name) == NOISY;
        k != first && (is_final || shown.lights && is_light)
    };
    let others = (0..picture.layers.len()).filter(is_sent);
    std::iter::once(first).chain(others).collect()
}

/// What a page calls a layer.
fn label(layer: &ImageLayer) -> &str {
    if layer.name.is_empty() {
        "image"
    } else {
        &layer.name
    }
}

fn index_of(picture: &Picture, wanted: &str) -> usize {
    let found = picture
        .layers
        .iter()
        .position(|layer| label(layer) == wanted);
    found.unwrap_or(0)
}

fn picture_event(picture: &Picture, layer: usize) -> Event {
    Event::default()
        .event("picture")
        .data(picture_json(picture, layer))
}

fn picture_json(picture: &Picture, layer: usize) -> String {
    let Progress {
        passes,
        seconds,
        error,
        state,
    } = picture.progress;
    let planes: Vec<&[f32]> = (picture.layers[layer].channels.iter())
        .map(|(_, values)| values.as_slice())
        .collect();
    let pixels = 0..picture.width * picture.height;
    let values = pixels.flat_map(|i| planes.iter().map(move |plane| plane[i]));
    let event = PictureEvent {
        width: picture.width,
        height: picture.height,
        passes,
        seconds,
        error: error.filter(|error| error.is_finite()),
        state: match state {
            RenderState::Rendering => "rendering",
            RenderState::Done => "done",
            RenderState::Interrupted => "interrupted",
        },
        layers: picture.layers.iter().map(entry).collect(),
        layer,
        values: halves(values),
    };
    serde_json::to_string(&event).expect("invariant: the event has text keys alone")
}

fn entry(layer: &ImageLayer) -> LayerEntry<'_> {
    let channels = layer.channels.iter();
    LayerEntry {
        name: label(layer),
        channels: channels.map(|(name, _)| last_part(name)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::testing::picture;
    use serde_json::{Value, json};

    #[test]
    fn an_event_describes_its_layer() {
        let event: Value = serde_json::from_str(&picture_json(&picture(2, 1, 4), 1)).unwrap();
        assert_eq!(
            event,
            json!({
                "width": 2, "height": 1, "passes": 4, "seconds": 1.5, "error": 0.25, "state": "rendering",
                "layers": [
                    {"name": "image", "channels": ["R", "G", "B"]},
                    {"name": "direct", "channels": ["R", "G", "B"]},
                    {"name": "depth", "channels": ["Z"]},
                ],
                "layer": 1,
                "values": halves([3000.5, 4000.5, 5000.5, 3001.5, 4001.5, 5001.5].into_iter()),
            })
        );
    }

    #[test]
    fn pages_receive_what_they_show() {
        let layers = |state, layer: &str, lights| {
            let mut picture = picture(2, 1, 4);
            for name in ["Combined_key", "variance_Combined_key", "noisy"] {
                let mut layer = picture.layers[1].clone();
                layer.name = name.into();
                picture.layers.push(layer);
            }
            picture.progress.state = state;
            let layer = layer.into();
            Vec::from(sent_layers(&picture, &Shown { layer, lights }))
        };
        assert_eq!(layers(RenderState::Rendering, "depth", false), [2]);
        assert_eq!(layers(RenderState::Rendering, "image", true), [0, 3, 5]);
        assert_eq!(layers(RenderState::Rendering, "depth", true), [2, 0, 3, 5]);
        assert_eq!(
            layers(RenderState::Done, "depth", false),
            [2, 0, 1, 3, 4, 5]
        );
    }

    #[test]
    fn unknown_layers_are_the_image() {
        let picture = picture(2, 1, 4);
        let of = |wanted| index_of(&picture, wanted);
        assert_eq!([of("image"), of("depth"), of("x"), of("")], [0, 2, 0, 0]);
    }
}
