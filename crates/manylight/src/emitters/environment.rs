//! Light from far away, given by an image.

use crate::image::Image;
use crate::math::Mat3;

/// An image in latitude-longitude form. As in Mitsuba's `envmap`: with `d` the direction in the emitter's own frame (y up),
/// `u = atan2(d.x, -d.z) / 2π`, `v = acos(d.y) / π`, row 0 on top at the pole +y. Lookup is bilinear, wrapping in u.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Linear RGB radiance.
    pub image: Image,
    /// Times this.
    pub scale: f32,
    /// Rotation from the emitter's frame to the world.
    pub world_from_emitter: Mat3,
}
