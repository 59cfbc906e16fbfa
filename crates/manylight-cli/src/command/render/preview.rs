//! `--preview`: the picture while it grows, in a viewer. It changes neither the image nor the exit
//! code.

use crate::args::RenderArgs;
use crate::output::{Console, print_message};
use crate::picture::{NamedFilm, RGB, channels, named};
use crate::request::RenderRequest;
use crate::session::Session;
use manylight::film::{ErrorBars, Film, Layer};
use manylight::integrators::{Stage, StageMemory};
use manylight::render::{Budget, Observer, Outcome, RenderJob, Stats, Stop};
use manylight_denoise::DenoisedImage;
use manylight_io::image::{ImageLayer, full_name};
use manylight_lab::noise::NOISY;
use manylight_preview::{Picture, Preview, Progress, RenderInfo, RenderState};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Name of the stage with the time of making pictures for the viewer.
const STAGE: &str = "preview";

/// The preview of a render, if one is asked for.
pub(super) struct RenderPreview {
    preview: Option<Preview>,
    /// Names of the light groups.
    groups: Vec<String>,
    /// Time between the begin of the render and its last pass.
    elapsed: Duration,
}

impl RenderPreview {
    /// Starts the preview that `args` ask for. Its address is printed even with `--quiet`: nobody
    /// could open the page otherwise.
    pub(super) fn start(args: &RenderArgs, session: &Session, console: &Console) -> Self {
        let (console, quiet) = (console.clone(), args.display.quiet);
        let warn = Arc::new(move |warning: String| {
            if !quiet {
                console.print(format_args!("warning: {warning}"));
            }
        });
        let target = args.preview.as_ref();
        let preview =
            target.and_then(|target| Preview::start(target, info(&session.request), warn));
        if let Some(address) = preview.as_ref().and_then(Preview::address) {
            print_message(format_args!("preview: {address}"));
        }
        RenderPreview {
            preview,
            groups: session.scene.light_groups.names().to_vec(),
            elapsed: Duration::ZERO,
        }
    }

    /// Memory of the pictures of a render, if there is a preview: one that waits, and one that is
    /// being sent.
    pub(super) fn memory(&self, job: &RenderJob) -> Option<StageMemory> {
        self.preview.as_ref()?;
        let size = job.scene.sensor.desc().film.crop_size;
        let layers = job.method.layers();
        let count: usize = layers.iter().map(|&layer| channels(layer).len()).sum();
        let picture = u64::from(size.x) * u64::from(size.y) * (count * size_of::<f32>()) as u64;
        Some(StageMemory {
            stage: Stage::Preview,
            bytes: 2 * picture,
        })
    }

    /// An observer that shows pictures and calls `observer`.
    pub(super) fn beside<'a>(
        &'a mut self,
        observer: &'a mut (dyn Observer + Send),
    ) -> impl Observer {
        Beside {
            preview: self,
            observer,
        }
    }

    /// Shows the final picture, denoised if it is.
    pub(super) fn finish(
        &mut self,
        outcome: &Outcome,
        denoised: Option<&DenoisedImage>,
        stats: &Stats,
    ) {
        let state = match outcome.stop {
            Stop::Budget => RenderState::Done,
            Stop::Cancelled => RenderState::Interrupted,
        };
        let elapsed = self.elapsed;
        let film = NamedFilm {
            film: &outcome.film,
            denoised,
            groups: &self.groups,
        };
        if let Some(preview) = &mut self.preview {
            preview.finish(|| snapshot(film, elapsed, state, stats));
        }
    }

    /// Waits a few seconds at most until the viewer has received the final picture.
    pub(super) fn close(self) {
        if let Some(preview) = self.preview {
            preview.close();
        }
    }
}

struct Beside<'a> {
    preview: &'a mut RenderPreview,
    observer: &'a mut (dyn Observer + Send),
}

impl Observer for Beside<'_> {
    fn begins(&mut self, budget: &Budget) {
        self.observer.begins(budget);
    }

    fn pass_done(&mut self, film: &Film, stats: &Stats, elapsed: Duration) -> ControlFlow<()> {
        self.preview.elapsed = elapsed;
        let named = NamedFilm {
            film,
            denoised: None,
            groups: &self.preview.groups,
        };
        if let Some(preview) = &mut self.preview.preview {
            preview.update(|| snapshot(named, elapsed, RenderState::Rendering, stats));
        }
        self.observer.pass_done(film, stats, elapsed)
    }
}

/// What the viewer is told in the beginning. The name is that of the first output: the same for
/// repeated renders.
fn info(request: &RenderRequest) -> RenderInfo {
    let name = request
        .outputs
        .first()
        .map(|path| path.display().to_string());
    RenderInfo {
        name: name.unwrap_or_default(),
        title: format!("{}, {}", request.scene.display(), request.paths.method.name),
        passes: request.budget.passes,
        seconds: request.budget.time.map(|time| time.as_secs_f64()),
        error: request.budget.relative_error,
    }
}

fn snapshot(named: NamedFilm, elapsed: Duration, state: RenderState, stats: &Stats) -> Picture {
    let (start, film) = (Instant::now(), named.film);
    let (layers, bars) = rayon::join(|| layers(&named), || ErrorBars::of_film(film));
    let size = film.image_size();
    let picture = Picture {
        width: size.x as usize,
        height: size.y as usize,
        layers,
        progress: Progress {
            passes: film.passes(),
            seconds: elapsed.as_secs_f64(),
            error: bars.map(|bars| bars.stated.at_most),
            state,
        },
    };
    stats.add_time(STAGE, start.elapsed());
    picture
}

/// The layers of the image file, without variances and mattes.
fn layers(named_film: &NamedFilm) -> Vec<ImageLayer> {
    let NamedFilm { film, denoised, .. } = *named_film;
    let entries: Vec<(usize, Layer, &[&str])> = (film.layers().iter().enumerate())
        .filter(|(_, layer)| **layer != Layer::Alpha)
        .map(|(l, &layer)| (l, layer, channels(layer)))
        .collect();
    let places = entries.iter();
    let places = places.flat_map(|&(l, _, names)| (0..names.len()).map(move |c| (l, c)));
    let mut planes = film.planes(&places.collect::<Vec<_>>()).into_iter();
    let layer_of = |(_, layer, names): (usize, Layer, &[&str])| {
        let name = match (layer, denoised) {
            (Layer::Beauty, Some(_)) => NOISY.to_owned(),
            _ => named_film.name_of(layer),
        };
        let names = names.iter().map(|channel| full_name(&name, channel));
        let channels = names.zip(&mut planes).collect();
        ImageLayer { name, channels }
    };
    let layers = entries.into_iter().map(layer_of);
    let denoised = denoised.map(|denoised| named("", RGB, &denoised.image));
    let mut layers: Vec<ImageLayer> = denoised.into_iter().chain(layers).collect();
    if let (Some(alpha), Some(first)) = (film.alpha(), layers.first_mut()) {
        first.channels.push(("A".into(), alpha.data));
    }
    layers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::names::AovNames;
    use crate::picture;
    use manylight::color::Rgb;
    use manylight::film::{FilmDesc, Filter};
    use manylight::image::Image;
    use manylight::math::UVec2;
    use std::sync::atomic::{AtomicBool, AtomicU64};

    /// Channels of the preview are those of the image file, with the same values.
    #[test]
    fn layers_are_those_of_the_file() {
        let size = UVec2::new(19, 11);
        let desc = FilmDesc {
            size,
            crop_offset: UVec2::ZERO,
            crop_size: size,
            filter: Filter::Box,
        };
        let recorded = [Layer::Beauty, Layer::Direct, Layer::Depth, Layer::Alpha];
        let mut film = Film::new(desc, &recorded);
        for pass in 1..4 {
            film.add_pass(&AtomicBool::new(false), &AtomicU64::new(0), |samples| {
                for (i, pixel) in samples.tile().pixels().enumerate() {
                    let place = (100 * pixel.y + pixel.x) as f32;
                    samples.add(i, Layer::Direct, Rgb::new(place, pass as f32, 0.1));
                    samples.add(i, Layer::Depth, Rgb::splat(place / pass as f32));
                    samples.add(i, Layer::Alpha, Rgb::new(0.5, 0.5, 1.0));
                }
            });
        }
        let denoised = DenoisedImage {
            image: Image::new(19, 11, 3),
            bars: None,
            groups: Vec::new(),
        };
        for denoised in [None, Some(&denoised)] {
            let named_film = NamedFilm {
                film: &film,
                denoised,
                groups: &[],
            };
            let mut expected = picture::film_layers(&named_film, None, AovNames::Manylight);
            expected.retain(|layer| !layer.name.contains("variance"));
            assert_eq!(layers(&named_film), expected);
        }
    }
}
