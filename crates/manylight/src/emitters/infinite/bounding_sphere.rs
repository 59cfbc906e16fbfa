//! The sphere through which all light of infinite lights enters the scene.

use crate::math::{Aabb, Vec3};
use std::f32::consts::PI;

/// A sphere around all geometry.
#[derive(Clone, Copy, Debug)]
pub(in crate::emitters) struct BoundingSphere {
    pub(in crate::emitters) center: Vec3,
    /// Positive also for empty scenes and single points, so that the power of infinite lights is
    /// defined.
    pub(in crate::emitters) radius: f32,
}

/// Radius over half the diagonal of the bounding box: a margin against rounding.
const RADIUS_MARGIN: f32 = 1.001;

/// Smallest radius over the distance of the center from the origin. Below it, single precision
/// cannot tell neighboring ray origins apart.
const MIN_RADIUS_PER_DISTANCE: f32 = 1e-4;

/// Smallest radius of all, for a point at the origin.
const MIN_RADIUS: f32 = 1e-6;

impl BoundingSphere {
    pub(in crate::emitters) fn new(bounds: Aabb) -> Self {
        if bounds.is_empty() {
            return BoundingSphere {
                center: Vec3::ZERO,
                radius: 1.0,
            };
        }
        let center = bounds.center();
        let smallest = (center.length() * MIN_RADIUS_PER_DISTANCE).max(MIN_RADIUS);
        BoundingSphere {
            center,
            radius: (bounds.diagonal() * 0.5 * RADIUS_MARGIN).max(smallest),
        }
    }

    /// Area of a great disc in m².
    pub(super) fn cross_section(&self) -> f32 {
        PI * self.radius * self.radius
    }
}
