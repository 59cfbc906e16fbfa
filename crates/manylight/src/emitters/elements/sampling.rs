//! The data by which elements are sampled from receivers.

use super::planar::PlanarElement;
use super::sphere::SphereElement;
use crate::color::Rgb;
use crate::emitters::Emitter;
use crate::ids::EmitterId;
use crate::math::Vec3;

/// The data for sampling an element from a receiver.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) enum ElementSampling {
    /// A planar element with constant radiance.
    Planar(PlanarElement),
    /// A sphere with constant radiance, sampled by its visible cap.
    Sphere(SphereElement),
    /// A point or a spot.
    Point(PointElement),
    /// Any other surface, by [`EmitterElement`](super::element::EmitterElement).
    Surface,
}

/// A point or a spot.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointElement {
    pub(super) position: Vec3,
    pub(super) emitter: EmitterId,
    /// In W/sr; `None` if it depends on the direction.
    pub(super) intensity: Option<Rgb>,
}

impl PointElement {
    pub(super) fn new(id: EmitterId, emitter: &Emitter, position: Vec3) -> Self {
        PointElement {
            position,
            emitter: id,
            intensity: match emitter {
                Emitter::Point { intensity, .. } => Some(*intensity),
                _ => None,
            },
        }
    }
}
