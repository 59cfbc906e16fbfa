//! What a scene says about its emitters.

use super::Environment;
use crate::color::Rgb;
use crate::ids::TextureId;
use crate::math::Vec3;
use crate::texture::ColorInput;

/// A source of light. All directions and positions in world space.
#[derive(Clone, Debug)]
pub enum Emitter {
    /// A primitive that shines from the side of its shading normal.
    Area {
        /// W/(m² sr).
        radiance: ColorInput,
    },
    /// An isotropic point.
    Point {
        /// Where.
        position: Vec3,
        /// W/sr.
        intensity: Rgb,
    },
    /// A cone with a smooth rim.
    Spot {
        /// Where.
        position: Vec3,
        /// Unit axis.
        direction: Vec3,
        /// W/sr on the axis.
        intensity: Rgb,
        /// Half-angle of the rim in radians.
        cutoff: f32,
        /// Half-angle of the constant part in radians, <= `cutoff`.
        beam_width: f32,
        /// What colors the light.
        slide: Option<ProjectorTexture>,
    },
    /// Parallel light through the whole scene.
    Directional {
        /// Unit direction in which the light travels.
        direction: Vec3,
        /// W/m² on a plane across it.
        irradiance: Rgb,
    },
    /// The same radiance from every direction.
    Constant {
        /// W/(m² sr).
        radiance: Rgb,
    },
    /// A picture of the surroundings.
    Environment(Environment),
}

/// A picture that a spot throws: its square is the one around the cone's cross-section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectorTexture {
    /// The picture.
    pub texture: TextureId,
    /// Unit directions across the axis along which u and v grow.
    pub axes: [Vec3; 2],
}
