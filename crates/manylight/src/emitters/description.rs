//! Emitters as a scene file describes them.

use crate::color::Rgb;
use crate::ids::{EmitterId, PrimitiveId, TextureId};
use crate::image::Image;
use crate::math::{Mat3, Vec2, Vec3};
use crate::texture::ColorInput;

/// An emitter. All directions and positions are in world space.
#[derive(Clone, Debug)]
pub enum Emitter {
    /// The surface of a primitive, on the side of its shading normal.
    Area {
        /// Emitted radiance in W/(m² sr), the same in all directions.
        radiance: ColorInput,
    },
    /// The same light without a surface: rays pass through the primitives, whatever their material.
    /// PBRT's area lights with `alpha` 0. As of points, walks do not find this light.
    InvisibleArea {
        /// As that of [`Emitter::Area`].
        radiance: ColorInput,
    },
    /// An isotropic point.
    Point {
        /// The point.
        position: Vec3,
        /// Radiant intensity in W/sr.
        intensity: Rgb,
    },
    /// A point with an intensity by direction, as a luminaire's photometry gives it.
    Goniometric {
        /// The point.
        position: Vec3,
        /// Factor of the texture, which gives a radiant intensity in W/sr.
        intensity: Rgb,
        /// Rotation (or reflection) from the world to the frame of the texture.
        emitter_from_world: Mat3,
        /// A map of directions `d` in that frame: `u = atan2(d.y, d.x) / 2π`, `v = acos(d.z) / π`.
        distribution: TextureId,
    },
    /// A point that emits into a cone, with a falloff at the border.
    Spot {
        /// The apex of the cone.
        position: Vec3,
        /// Unit axis.
        direction: Vec3,
        /// Radiant intensity on the axis in W/sr.
        intensity: Rgb,
        /// Half-angle of the cone in radians.
        cutoff: f32,
        /// Half-angle of the part with full intensity in radians, <= `cutoff`.
        beam_width: f32,
        /// Decrease from the beam to the cutoff.
        falloff: SpotFalloff,
        /// Factor of the intensity by direction.
        projector: Option<ProjectorTexture>,
    },
    /// Parallel light through the whole scene.
    Directional {
        /// Unit direction in which the light travels.
        direction: Vec3,
        /// Irradiance in W/m² on a plane perpendicular to `direction`.
        irradiance: Rgb,
    },
    /// An environment with the same radiance from all directions.
    Constant {
        /// W/(m² sr).
        radiance: Rgb,
    },
    /// An environment map.
    Environment(Environment),
}

impl Emitter {
    /// Radiance of an emitter on surfaces, visible or not; `None` for others.
    #[inline]
    pub fn surface_radiance(&self) -> Option<ColorInput> {
        match self {
            Emitter::Area { radiance } | Emitter::InvisibleArea { radiance } => Some(*radiance),
            _ => None,
        }
    }

    /// Whether this is the light of surfaces that no ray meets.
    #[inline]
    pub fn is_invisible(&self) -> bool {
        matches!(self, Emitter::InvisibleArea { .. })
    }
}

/// What emits light: a part of the emitters that names tell apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EmissionSource {
    /// A primitive with an emitter.
    Surface(PrimitiveId),
    /// An emitter without a surface.
    Emitter(EmitterId),
}

/// Decrease of the intensity of a spot from 1 at the border of its beam to 0 at its cutoff.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpotFalloff {
    /// Linear in the angle, as in Mitsuba.
    LinearAngle,
    /// 3t² - 2t³ for a t that is linear in the cosine, as in Blender and PBRT v4.
    SmoothCosine,
    /// t⁴ for a t that is linear in the cosine, as in PBRT v3.
    QuarticCosine,
    /// 1/cos³θ up to the cutoff, whatever the beam: an equal irradiance on planes across the axis,
    /// as of Mitsuba's `projector`.
    FlatIrradiance,
    /// Linear in the angle to the axis of a cone that a linear map deforms. Cutoff and beam of the
    /// spot contain that cone.
    Deformed(DeformedCone),
}

/// The cone of a spot before a linear map deforms it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeformedCone {
    /// From the world to the frame in which the cone is round around z. Scales do not matter.
    pub cone_from_world: Mat3,
    /// Half-angle of the cone there, in radians.
    pub cutoff: f32,
    /// Half-angle of the full intensity there, in radians.
    pub beam_width: f32,
}

/// A texture that a spot projects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectorTexture {
    /// The texture.
    pub texture: TextureId,
    /// Unit directions perpendicular to the axis along which u and v grow.
    pub axes: [Vec3; 2],
    /// Half the extents, along both axes, of the rectangle on the plane at distance 1 that the
    /// texture's unit square fills; no light passes beside it. `None`: the square around the
    /// cross-section of the cone, all of the cone being lit.
    pub window: Option<Vec2>,
}

/// An environment map in latitude-longitude form, as in Mitsuba's `envmap`. For a direction `d` in
/// the emitter's frame (y up) `u = atan2(d.x, -d.z) / 2π` and `v = acos(d.y) / π`. Lookup is
/// bilinear. Column centers lie at half-integers of `u · width`, and columns wrap around. Row 0
/// lies at v = 0 (the pole +y), the last row at v = 1.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Linear RGB radiance.
    pub image: Image,
    /// Factor of the radiance.
    pub scale: f32,
    /// Rotation (or reflection) from the emitter's frame to the world.
    pub world_from_emitter: Mat3,
}
