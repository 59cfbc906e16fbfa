//! The starts of camera paths: camera rays through points of the film and of the lens, in lanes.

use super::camera_round::FirstPart;
use super::context::PassContext;
use super::first_event::SampleShare;
use crate::film::{FilmSampler, TileSamples};
use crate::geometry::Ray;
use crate::lanes::{LaneKernel, Pair, Width};
use crate::math::{UVec2, Vec2};
use crate::sampling::{Sampler, SobolSequences, Stream};
use crate::scene::{LimitedScene, PathLimits, Scene};
use crate::sensors::Sensor;
use crate::simd::Isa;
use crate::transport::stream::{WalkRow, Walks};
use crate::transport::walk::visible_part;

/// Where a camera path starts.
#[derive(Clone, Copy, Debug)]
pub(super) struct StartNumbers {
    pub(super) pixel: UVec2,
    /// Point of the pixel's reconstruction filter, in [0, 1)².
    pub(super) film: Vec2,
    /// Point of the lens, in [0, 1)².
    pub(super) lens: Vec2,
}

/// The start of a camera path.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraStart {
    /// The part of the ray that the camera sees.
    ray: Ray,
    /// See [`FirstPart::hidden`].
    pub(super) hidden: f32,
    /// Weight by the reconstruction filter.
    pub(super) filter_weight: f32,
}

impl CameraStart {
    /// The walk of one of `count` paths.
    pub(super) fn walk<T>(&self, count: u32, sampler: Sampler, payload: T) -> WalkRow<T> {
        let throughput = [self.filter_weight / count as f32; 3];
        WalkRow::start(self.ray, throughput, sampler, payload)
    }
}

/// What decides where camera paths start.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraView<'a> {
    pub(super) scene: &'a Scene,
    pub(super) limits: PathLimits,
    pub(super) camera: &'a Sensor,
    pub(super) positions: &'a FilmSampler,
}

impl CameraView<'_> {
    /// Calls `visit` with the index and the start of each camera path.
    pub(super) fn each_start(
        &self,
        mut numbers: impl Iterator<Item = StartNumbers>,
        mut visit: impl FnMut(usize, CameraStart),
    ) {
        Isa::best().run_lanes(EachStart {
            view: self,
            numbers: &mut numbers,
            visit: &mut visit,
        });
    }
}

/// See [`CameraView::each_start`]. Compiled once for all callers.
struct EachStart<'a> {
    view: &'a CameraView<'a>,
    numbers: &'a mut dyn Iterator<Item = StartNumbers>,
    visit: &'a mut dyn FnMut(usize, CameraStart),
}

impl LaneKernel for EachStart<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Width>(self, s: S) {
        let CameraView {
            scene,
            limits,
            camera,
            positions,
        } = *self.view;
        let mut packet = Vec::with_capacity(S::LANES);
        let mut first = 0;
        loop {
            packet.clear();
            packet.extend(self.numbers.take(S::LANES));
            let Some(last) = packet.len().checked_sub(1) else {
                break;
            };
            let numbers = s.each(|i| packet[i.min(last)]);
            let film = Pair::from_fn(s, |i| numbers.as_ref()[i].film);
            let lens = Pair::from_fn(s, |i| numbers.as_ref()[i].lens);
            let pixels = s.each(|i| numbers.as_ref()[i].pixel);
            let samples = positions.samples(&pixels, film);
            let rays = camera.rays(samples.position, lens).store();
            let weight = samples.weight.store();
            for i in 0..=last {
                let ray = rays.as_ref()[i];
                let (ray, hidden) = visible_part(scene, limits.hide_emitters, ray);
                let start = CameraStart {
                    ray,
                    hidden,
                    filter_weight: weight.as_ref()[i],
                };
                (self.visit)(first + i, start);
            }
            first += packet.len();
        }
    }
}

/// The sequence of [`SobolSequences`] with the numbers of film and lens. The sequences that follow
/// are free.
pub(super) const CAMERA_SEQUENCE: u32 = 0;

/// Appends to `walks` a camera path for each pixel of a tile, at the camera; `payload` is made of
/// its part in the layers of first surfaces, and of the sequences of its pixel.
pub(super) fn start_paths<T: Copy>(
    LimitedScene { scene, limits }: LimitedScene,
    run: &PassContext,
    positions: &FilmSampler,
    samples: &TileSamples,
    payload: impl Fn(FirstPart, SobolSequences) -> T,
    walks: &mut Walks<T>,
) {
    let pixels: Vec<UVec2> = samples.tile().pixels().collect();
    let number = |&pixel: &UVec2| positions.index(pixel);
    let sequences = |pixel| run.pass.sobol_sequences(Stream::Pixel, number(pixel));
    let sequences: Vec<_> = pixels.iter().map(sequences).collect();
    let points = SobolSequences::each_point(&sequences, CAMERA_SEQUENCE);
    let numbers = pixels.iter().zip(&points);
    let numbers = numbers.map(|(&pixel, &[x, y, x_lens, y_lens])| StartNumbers {
        pixel,
        film: Vec2::new(x, y),
        lens: Vec2::new(x_lens, y_lens),
    });
    let view = CameraView {
        scene,
        limits,
        camera: run.camera,
        positions,
    };
    view.each_start(numbers, |i, start| {
        let first = FirstPart {
            pixel: i as u32,
            hidden: start.hidden,
            event: SampleShare {
                filter_weight: start.filter_weight,
                share: 1.0,
            },
            surface_share: 1.0,
        };
        let sampler = run.pass.sampler(Stream::Pixel, number(&pixels[i]));
        walks.push(start.walk(1, sampler, payload(first, sequences[i])));
    });
}
