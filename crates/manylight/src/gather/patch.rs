//! The piece of surface that a light stands for, seen from near by.

use crate::math::Vec3;
use crate::virtual_lights::VirtualLight;

/// Off the tangent plane by more than this share of its size, a patch is not flat, and only its four stored points are known
/// to lie on the surface.
const FLAT: f32 = 0.05;

/// The uniform parallelogram with the moments of a light's four points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    center: Vec3,
    half_edges: [Vec3; 2],
    /// Whether its points are known to lie on the surface.
    pub(super) is_flat: bool,
}

impl Patch {
    pub(super) fn new(light: &VirtualLight) -> Self {
        let [a, b, c, d] = light.points;
        let center = (a + b + c + d) * 0.25;
        // A uniform parallelogram has a third of its squared half edges as variance; the points stand one deviation out.
        let half_edges = [(a + b - c - d) * 0.25 * 3.0f32.sqrt(), (a - b + c - d) * 0.25 * 3.0f32.sqrt()];
        let height = light.points.iter().map(|p| (*p - center).dot(light.n).abs()).fold(0.0, f32::max);
        let is_regular = ((a - b) - (c - d)).length() <= FLAT * light.radius;
        Patch { center, half_edges, is_flat: is_regular && height <= FLAT * light.radius }
    }

    /// The centers of a 4 x 4 grid of parts.
    #[inline]
    pub(super) fn points(&self) -> impl Iterator<Item = Vec3> {
        (0..16).map(move |i| {
            let (u, v) = ((i % 4) as f32 * 0.5 - 0.75, (i / 4) as f32 * 0.5 - 0.75);
            self.center + self.half_edges[0] * u + self.half_edges[1] * v
        })
    }
}
