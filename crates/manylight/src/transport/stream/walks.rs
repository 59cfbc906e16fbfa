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

/// The walks of a tile. `T` is the payload: what a method attaches to each walk. What is in
/// [`WalkState`] lies together, because packets take walks in the order of materials: one array per
/// quantity costs 11 appends per vertex instead of 2.
#[derive(Clone, Debug)]
pub(crate) struct Walks<T> {
    /// The next segment, by walk.
    pub(crate) rays: Vec<Ray>,
    /// The rest, by walk.
    pub(crate) states: Vec<WalkState<T>>,
}

/// One walk without its next segment.
#[derive(Clone, Debug)]
pub(crate) struct WalkState<T> {
    /// Camera paths: factor from radiance that arrives to what the sensor measures. Photons: flux,
    /// in W. By channel.
    pub(crate) throughput: [f32; 3],
    /// Product of squared relative indices of refraction along a camera path; see
    /// [`camera_survivals`](crate::transport::roulette::camera_survivals).
    pub(crate) eta_squared: f32,
    /// Segments up to the start of the ray.
    pub(crate) segments: u32,
    /// The last scattering event.
    pub(crate) previous: Previous,
    /// Random numbers.
    pub(crate) sampler: Sampler,
    /// What the method attaches.
    pub(crate) payload: T,
}

/// One walk.
#[derive(Clone, Debug)]
pub(crate) struct WalkRow<T> {
    pub(crate) ray: Ray,
    pub(crate) state: WalkState<T>,
}

impl<T> WalkRow<T> {
    /// A walk at its start, along `ray`.
    #[inline(always)]
    pub(crate) fn start(ray: Ray, throughput: [f32; 3], sampler: Sampler, payload: T) -> Self {
        let state = WalkState {
            throughput,
            eta_squared: 1.0,
            segments: 0,
            previous: Previous::start(ray.o),
            sampler,
            payload,
        };
        WalkRow { ray, state }
    }

    /// The walk without MIS against next-event estimation at its last event: emission that the
    /// segment meets has weight 1, as after an event of a [`Lobes::DELTA`] lobe
    /// ([`PreviousEvents::has_next_event`]).
    #[inline(always)]
    pub(crate) fn without_next_event(mut self) -> Self {
        self.state.previous.event = Lobes::DELTA;
        self
    }
}

impl<T> Walks<T> {
    /// Walk `i` without its next segment.
    #[inline(always)]
    pub(crate) fn state(&self, i: u32) -> &WalkState<T> {
        &self.states[i as usize]
    }

    /// Multiplies the throughput of walk `i`.
    pub(crate) fn scale_throughput(&mut self, i: u32, factor: Rgb) {
        let throughput = &mut self.states[i as usize].throughput;
        for (channel, factor) in throughput.iter_mut().zip(factor.to_array()) {
            *channel *= factor;
        }
    }
}

impl<T: Copy> Walks<T> {
    /// A stream without walks, with space for `count`.
    pub(crate) fn with_capacity(count: usize) -> Self {
        Walks {
            rays: Vec::with_capacity(count),
            states: Vec::with_capacity(count),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    pub(crate) fn clear(&mut self) {
        self.rays.clear();
        self.states.clear();
    }

    /// Appends a walk.
    #[inline(always)]
    pub(crate) fn push(&mut self, walk: WalkRow<T>) {
        self.rays.push(walk.ray);
        self.states.push(walk.state);
    }

    /// Appends walks.
    pub(crate) fn extend(&mut self, walks: impl IntoIterator<Item = WalkRow<T>>) {
        walks.into_iter().for_each(|walk| self.push(walk));
    }

    /// The throughput of the walks `index[i]`.
    #[inline(always)]
    pub(crate) fn throughput<S: Width>(&self, s: S, index: &S::Each<u32>) -> Color<S> {
        let of_lane = |i: usize| &self.state(index.as_ref()[i]).throughput;
        let channel = |k: usize| Float::from_fn(s, |i| of_lane(i)[k]);
        Color::new(channel(0), channel(1), channel(2))
    }

    /// The throughput of walk `i`.
    #[inline(always)]
    pub(crate) fn throughput_of(&self, i: u32) -> Rgb {
        Rgb::from(self.state(i).throughput)
    }

    /// The last events of the walks `index[i]`.
    #[inline(always)]
    pub(crate) fn previous_events<S: Width>(
        &self,
        s: S,
        index: &S::Each<u32>,
    ) -> PreviousEvents<S> {
        let previous = |i: usize| &self.state(index.as_ref()[i]).previous;
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
        self.state(i).previous.event
    }
}
