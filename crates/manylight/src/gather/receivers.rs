//! Both ends of a connection: points, and a light.

use super::Subset;
use super::light_points::LightPoint;
use super::points::Batch;
use super::sphere_samples::LightLobe;
use crate::ids::LightId;
use crate::lanes::{Color, Float, LANES, Mask, Sixteen, Vector, Width};
use crate::math::Vec3;
use crate::virtual_lights::{VirtualLight, VirtualLights};

/// The point `x` of a connection in each lane.
pub(super) trait Receivers<S: Width> {
    /// The vectors from the points to `p`, in m.
    fn towards(&self, p: Vec3) -> Vector<S>;
    /// Geometric normals.
    fn normals(&self) -> Vector<S>;
    /// The lights that are summed at all points.
    fn lights(&self) -> Subset;
    /// `f cosθ` of the non-specular lobes for unit directions, in 1/sr; inactive lanes hold any
    /// value.
    fn f_cos_wi(&self, wi: Vector<S>, active: Mask<S>) -> Color<S>;
    /// Where light from the unit directions `wi` counts; see
    /// [`ShadingPoint::lit_from`](super::ShadingPoint::lit_from).
    fn count_light_from(&self, wi: Vector<S>) -> Mask<S>;
    /// The fraction of the flux of light `id` that fits the path limits.
    fn shares(&self, lights: &VirtualLights, id: LightId) -> Float<S>;
}

/// The light of a connection.
pub(super) struct ConnectedLight<'f, 's, E> {
    pub(super) lights: &'f VirtualLights<'s>,
    pub(super) id: LightId,
    pub(super) light: &'f VirtualLight<'s>,
    pub(super) emission: E,
    /// Radius as a sphere, in m.
    pub(super) radius: f32,
    /// The glossy lobe of a light of one photon, for sampling directions to a sphere.
    pub(super) lobe: Option<LightLobe>,
}

/// Where points and a part of a light see each other.
#[derive(Clone, Copy)]
pub(super) struct Direction<S: Width> {
    /// Unit directions to the light.
    pub(super) wi: Vector<S>,
    /// Inverse of the squared distances, in 1/m².
    pub(super) inv_d2: Float<S>,
    pub(super) active: Mask<S>,
}

impl<S: Width> Direction<S> {
    /// The directions of the active points to `part`.
    #[inline(always)]
    pub(super) fn towards(x: &impl Receivers<S>, part: &LightPoint, active: Mask<S>) -> Self {
        let to = x.towards(part.p);
        let d2 = to.length_squared();
        let inv_d = d2.sqrt().recip();
        let wi = to * inv_d;
        Direction {
            wi,
            inv_d2: inv_d * inv_d,
            active: active & x.count_light_from(wi) & d2.gt(0.0),
        }
    }

    /// No active lane.
    #[inline(always)]
    pub(super) fn none(s: S) -> Self {
        Direction {
            wi: Vector::splat(s, Vec3::ZERO),
            inv_d2: Float::splat(s, 0.0),
            active: Mask::splat(s, false),
        }
    }
}

/// The points of a batch as receivers of connections.
pub(super) struct BatchReceivers<'a, 'b, 's, S: Width> {
    pub(super) s: S,
    pub(super) batch: &'a Batch<'b, 's>,
}

impl<S: Sixteen> Receivers<S> for BatchReceivers<'_, '_, '_, S> {
    #[inline(always)]
    fn towards(&self, p: Vec3) -> Vector<S> {
        self.batch.towards(self.s, p)
    }

    #[inline(always)]
    fn normals(&self) -> Vector<S> {
        self.batch.ng.vectors(self.s)
    }

    #[inline(always)]
    fn lights(&self) -> Subset {
        self.batch.lights
    }

    #[inline(always)]
    fn f_cos_wi(&self, wi: Vector<S>, active: Mask<S>) -> Color<S> {
        self.batch.bsdfs.f_cos_wi(wi, active)
    }

    #[inline(always)]
    fn count_light_from(&self, wi: Vector<S>) -> Mask<S> {
        let Batch {
            limited, lit_from, ..
        } = self.batch;
        if *limited == 0 {
            return Mask::splat(self.s, true);
        }
        let limited = Mask::of_lanes(self.s, *limited);
        lit_from.vectors(self.s).dot(wi).gt(0.0) | !limited
    }

    #[inline(always)]
    fn shares(&self, lights: &VirtualLights, id: LightId) -> Float<S> {
        let mut shares = [1.0; LANES];
        if let Some(depths) = &self.batch.depths {
            for (share, depth) in shares.iter_mut().zip(depths) {
                *share = depth.map_or(1.0, |depth| lights.share_up_to(id, depth));
            }
        }
        Float::load(self.s, &shares)
    }
}
