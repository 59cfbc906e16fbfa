//! Tilted shading frames.

use crate::math::{Frame, Vec2, Vec3};

/// A normal tilted by a bump or normal map, in the shading frame.
///
/// If the tilted normal faces away from the viewer, it is rotated around the original one by 180 degrees (Schüssler et al.,
/// "Microfacet-based Normal Mapping", 2017). So the tilted frame depends on `wo`. Incident light is attenuated towards the horizon
/// (Conty Estevez et al., "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem", 2019). Both as in Mitsuba 3.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tilt {
    normal: Vec3,
    /// Its projection is the x axis of the tilted frame.
    tangent: Vec3,
}

/// Probability with which a photon walk samples in the frame that faces `wi`, instead of the rotated one. The frame depends on `wo`, which
/// is not known before sampling. Not measured: `wo` mostly sees the frame that faces `wi`.
pub(super) const FACING_FRAME_PROBABILITY: f32 = 0.75;

impl Tilt {
    /// `normal` is a unit vector in the shading frame. `None` if it is the shading normal.
    pub(super) fn new(normal: Vec3, tangent: Vec3) -> Option<Self> {
        (normal.is_finite() && normal.truncate() != Vec2::ZERO).then_some(Tilt { normal, tangent })
    }

    /// The tilted normal.
    pub(super) fn normal(&self) -> Vec3 {
        self.normal
    }

    /// Transforms a normal from the tilted frame to the shading frame.
    pub(super) fn within(&self, normal: Vec3) -> Vec3 {
        self.frame(self.normal).to_world(normal)
    }

    /// The tilted normal, rotated around the original one by 180 degrees.
    pub(super) fn rotated(&self) -> Vec3 {
        Vec3::new(-self.normal.x, -self.normal.y, self.normal.z)
    }

    /// That of the two normals which faces `w`.
    #[inline]
    pub(super) fn facing(&self, w: Vec3) -> Vec3 {
        if w.z * self.normal.dot(w) <= 0.0 {
            self.rotated()
        } else {
            self.normal
        }
    }

    /// The tilted frame with the normal `n`.
    pub(super) fn frame(&self, n: Vec3) -> Frame {
        let s = (self.tangent - n * n.dot(self.tangent))
            .try_normalize()
            .unwrap_or(Vec3::Y);
        Frame {
            s,
            t: n.cross(s),
            n,
        }
    }

    /// Fraction of light from `wi` that the bumps do not shadow.
    #[inline]
    pub(super) fn shadowing(&self, wi: Vec3) -> f32 {
        let tan2 = |w: Vec3| (1.0 - w.z * w.z).max(0.0) / (w.z * w.z).max(f32::MIN_POSITIVE);
        let alpha2 = (0.125 * tan2(self.normal)).min(1.0);
        2.0 / (1.0 + (1.0 + alpha2 * tan2(wi)).sqrt())
    }
}
