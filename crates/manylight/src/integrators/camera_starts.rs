//! The starts of camera paths: camera rays through points of the film and of the lens, in lanes.

use super::camera_round::FirstPart;
use super::context::PassContext;
use super::first_event::SampleShare;
use crate::film::{FilmSampler, TileSamples};
use crate::geometry::Ray;
use crate::lanes::{LaneKernel, Pair, Width};
use crate::math::{UVec2, Vec2};
use crate::sampling::{Sampler, SobolSequences, Stream};
use crate::scene::{PathLimits, Scene};
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
    /// Calls `visit` with the start of each of `paths`, and with what the path has beside its
    /// numbers.
    pub(super) fn each_start<P>(
        &self,
        paths: impl Iterator<Item = (StartNumbers, P)>,
        visit: impl FnMut(CameraStart, P),
    ) {
        Isa::best().run_lanes(EachStart {
            view: self,
            paths,
            visit,
        });
    }
}

/// See [`CameraView::each_start`].
struct EachStart<'a, I, V> {
    view: &'a CameraView<'a>,
    paths: I,
    visit: V,
}

impl<P, I, V> LaneKernel for EachStart<'_, I, V>
where
    I: Iterator<Item = (StartNumbers, P)>,
    V: FnMut(CameraStart, P),
{
    type Output = ();

    #[inline(always)]
    fn run<S: Width>(mut self, s: S) {
        let CameraView {
            scene,
            limits,
            camera,
            positions,
        } = *self.view;
        let mut packet = Vec::with_capacity(S::LANES);
        loop {
            packet.extend(self.paths.by_ref().take(S::LANES));
            let Some(last) = packet.len().checked_sub(1) else {
                break;
            };
            let numbers = s.each(|i| packet[i.min(last)].0);
            let film = Pair::from_fn(s, |i| numbers.as_ref()[i].film);
            let lens = Pair::from_fn(s, |i| numbers.as_ref()[i].lens);
            let pixels = s.each(|i| numbers.as_ref()[i].pixel);
            let samples = positions.samples(&pixels, film);
            let rays = camera.rays(samples.position, lens).store();
            let weight = samples.weight.store();
            for (i, (_, path)) in packet.drain(..).enumerate() {
                let ray = rays.as_ref()[i];
                let (ray, hidden) = visible_part(scene, limits.hide_emitters, ray);
                let start = CameraStart {
                    ray,
                    hidden,
                    filter_weight: weight.as_ref()[i],
                };
                (self.visit)(start, path);
            }
        }
    }
}

/// The sequence of [`SobolSequences`] with the numbers of film and lens. The sequences that follow
/// are free.
pub(super) const CAMERA_SEQUENCE: u32 = 0;

/// Appends to `walks` a camera path for each pixel of a tile, at the camera; `payload` is made of
/// its part in the layers of first surfaces, and of the sequences of its pixel.
pub(super) fn start_paths<T: Copy>(
    (scene, limits): (&Scene, PathLimits),
    run: &PassContext,
    positions: &FilmSampler,
    samples: &TileSamples,
    payload: impl Fn(FirstPart, SobolSequences) -> T,
    walks: &mut Walks<T>,
) {
    let pixels = || samples.tile().pixels().enumerate();
    let number = |pixel: UVec2| positions.index(pixel);
    let sequences = |(_, pixel)| run.pass.sobol_sequences(Stream::Pixel, number(pixel));
    let sequences: Vec<_> = pixels().map(sequences).collect();
    let points = SobolSequences::each_point(&sequences, CAMERA_SEQUENCE);
    let path = |((index, pixel), (point, sequences))| {
        let [x, y, x_lens, y_lens] = point;
        let numbers = StartNumbers {
            pixel,
            film: Vec2::new(x, y),
            lens: Vec2::new(x_lens, y_lens),
        };
        let sampler = run.pass.sampler(Stream::Pixel, number(pixel));
        (numbers, (index as u32, sequences, sampler))
    };
    let paths = pixels().zip(points.into_iter().zip(sequences)).map(path);
    let view = CameraView {
        scene,
        limits,
        camera: run.camera,
        positions,
    };
    view.each_start(paths, |start, (pixel, sequences, sampler)| {
        let first = FirstPart {
            pixel,
            hidden: start.hidden,
            event: SampleShare {
                filter_weight: start.filter_weight,
                share: 1.0,
            },
            surface_share: 1.0,
        };
        walks.push(start.walk(1, sampler, payload(first, sequences)));
    });
}
