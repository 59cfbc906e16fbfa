//! The states of the walks of a stream, between two segments.

use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::emitters::Receivers;
use crate::geometry::Ray;
use crate::lanes::{Color, Float, Mask, Vector, Width};
use crate::math::Vec3;
use crate::sampling::Sampler;
use crate::transport::direct::PreviousEvents;
use crate::transport::walk::Previous;

/// The walks of a tile. All vectors have an element per walk. `T` is the payload: what a method
/// attaches to each walk.
#[derive(Clone, Debug)]
pub(crate) struct Walks<T> {
    /// The next segment.
    pub(crate) rays: Vec<Ray>,
    /// Camera paths: factor from radiance that arrives to what the sensor measures. Photons: flux,
    /// in W. By channel.
    pub(crate) throughput: [Vec<f32>; 3],
    /// Product of squared relative indices of refraction along a camera path; see
    /// [`camera_survivals`](crate::transport::roulette::camera_survivals).
    pub(crate) eta_squared: Vec<f32>,
    /// Segments up to the start of the ray.
    pub(crate) segments: Vec<u32>,
    /// The last scattering event.
    pub(crate) previous: Vec<Previous>,
    /// Random numbers.
    pub(crate) samplers: Vec<Sampler>,
    /// What the method attaches.
    pub(crate) payload: Vec<T>,
}

/// One walk.
#[derive(Clone, Debug)]
pub(crate) struct WalkRow<T> {
    pub(crate) ray: Ray,
    pub(crate) throughput: [f32; 3],
    pub(crate) eta_squared: f32,
    pub(crate) segments: u32,
    pub(crate) previous: Previous,
    pub(crate) sampler: Sampler,
    pub(crate) payload: T,
}

impl<T> WalkRow<T> {
    /// A walk at its start, along `ray`.
    #[inline(always)]
    pub(crate) fn start(ray: Ray, throughput: [f32; 3], sampler: Sampler, payload: T) -> Self {
        WalkRow {
            ray,
            throughput,
            eta_squared: 1.0,
            segments: 0,
            previous: Previous::start(ray.o),
            sampler,
            payload,
        }
    }
}

impl<T> Walks<T> {
    /// Multiplies the throughput of walk `i`.
    pub(crate) fn scale_throughput(&mut self, i: u32, factor: Rgb) {
        for (channel, factor) in self.throughput.iter_mut().zip(factor.to_array()) {
            channel[i as usize] *= factor;
        }
    }
}

impl<T: Copy> Walks<T> {
    /// A stream without walks, with space for `count`.
    pub(crate) fn with_capacity(count: usize) -> Self {
        let floats = || Vec::with_capacity(count);
        Walks {
            rays: Vec::with_capacity(count),
            throughput: [floats(), floats(), floats()],
            eta_squared: floats(),
            segments: Vec::with_capacity(count),
            previous: Vec::with_capacity(count),
            samplers: Vec::with_capacity(count),
            payload: Vec::with_capacity(count),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    pub(crate) fn clear(&mut self) {
        self.rays.clear();
        self.throughput.iter_mut().for_each(Vec::clear);
        self.eta_squared.clear();
        self.segments.clear();
        self.previous.clear();
        self.samplers.clear();
        self.payload.clear();
    }

    /// Appends a walk.
    #[inline(always)]
    pub(crate) fn push(&mut self, walk: WalkRow<T>) {
        self.rays.push(walk.ray);
        for (channel, value) in self.throughput.iter_mut().zip(walk.throughput) {
            channel.push(value);
        }
        self.eta_squared.push(walk.eta_squared);
        self.segments.push(walk.segments);
        self.previous.push(walk.previous);
        self.samplers.push(walk.sampler);
        self.payload.push(walk.payload);
    }

    /// Appends walks.
    pub(crate) fn extend(&mut self, walks: impl IntoIterator<Item = WalkRow<T>>) {
        walks.into_iter().for_each(|walk| self.push(walk));
    }

    /// The throughput of the walks `index[i]`.
    #[inline(always)]
    pub(crate) fn throughput<S: Width>(&self, s: S, index: &S::Each<u32>) -> Color<S> {
        let index = index.as_ref();
        let channel = |k: usize| Float::from_fn(s, |i| self.throughput[k][index[i] as usize]);
        Color::new(channel(0), channel(1), channel(2))
    }

    /// The throughput of walk `i`.
    #[inline(always)]
    pub(crate) fn throughput_of(&self, i: u32) -> Rgb {
        let [r, g, b] = &self.throughput;
        Rgb::new(r[i as usize], g[i as usize], b[i as usize])
    }

    /// The last events of the walks `index[i]`.
    #[inline(always)]
    pub(crate) fn previous_events<S: Width>(
        &self,
        s: S,
        index: &S::Each<u32>,
    ) -> PreviousEvents<S> {
        let previous = |i: usize| &self.previous[index.as_ref()[i] as usize];
        let (mut has_normal, mut has_next_event) = (0, 0);
        for i in 0..S::LANES {
            let event = previous(i).event;
            has_normal |= u32::from(previous(i).n.is_some()) << i;
            has_next_event |= u32::from(event != Lobes::NONE && event != Lobes::DELTA) << i;
        }
        PreviousEvents {
            receivers: Receivers {
                p: Vector::from_fn(s, |i| previous(i).p),
                n: Vector::from_fn(s, |i| previous(i).n.unwrap_or(Vec3::ZERO)),
                has_normal: Mask::from_bits(s, has_normal),
            },
            pdf: Float::from_fn(s, |i| previous(i).pdf),
            has_next_event: Mask::from_bits(s, has_next_event),
        }
    }

    /// The class of the last event of walk `i`.
    #[inline(always)]
    pub(crate) fn event(&self, i: u32) -> Lobes {
        self.previous[i as usize].event
    }
}
