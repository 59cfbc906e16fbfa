//! What loaders write and tests build by hand: plain public data.

use crate::bsdf::Material;
use crate::emitters::Emitter;
use crate::geometry::Shape;
use crate::ids::{EmitterId, MaterialId, ShapeId};
use crate::math::Affine3A;
use crate::sensors::SensorDesc;
use crate::texture::Texture;

/// A scene as a file describes it.
#[derive(Clone, Debug, Default)]
pub struct SceneDesc {
    /// Shapes in object space.
    pub shapes: Vec<Shape>,
    /// Placed shapes.
    pub primitives: Vec<PrimitiveDesc>,
    /// Groups of placed shapes that only instances show.
    pub groups: Vec<Vec<PrimitiveDesc>>,
    /// Copies of groups.
    pub instances: Vec<InstanceDesc>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// Emitters. `Emitter::Area` shines from the primitives that name it.
    pub emitters: Vec<Emitter>,
    /// Cameras, in file order.
    pub sensors: Vec<SensorDesc>,
    /// Path lengths.
    pub limits: PathLimits,
}

/// A placed shape.
#[derive(Clone, Debug)]
pub struct PrimitiveDesc {
    /// Name or id in the file, for messages; may be empty.
    pub name: String,
    /// The shape.
    pub shape: ShapeId,
    /// Object to world (or group).
    pub world_from_object: Affine3A,
    /// Turn both normals round.
    pub flip_normals: bool,
    /// Material.
    pub material: MaterialId,
    /// Area emitter, if it shines.
    pub emitter: Option<EmitterId>,
}

/// A copy of a group.
#[derive(Clone, Debug)]
pub struct InstanceDesc {
    /// Index into `SceneDesc::groups`.
    pub group: usize,
    /// Group to world.
    pub world_from_group: Affine3A,
}

/// How long paths may be, counted as Mitsuba counts: 1 = emitters seen directly, 2 = direct light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathLimits {
    /// `None`: no limit.
    pub max_depth: Option<u32>,
    /// Russian roulette begins at this depth.
    pub rr_depth: u32,
    /// Emitters are not seen directly by the camera.
    pub hide_emitters: bool,
}

impl PathLimits {
    /// Whether a path of so many segments may be counted.
    #[inline]
    pub fn allow(&self, segments: u32) -> bool {
        self.max_depth.is_none_or(|max| segments <= max)
    }

    /// How many segments a path of `segments` may become longer by.
    #[inline]
    pub fn left_after(&self, segments: u32) -> u32 {
        self.max_depth
            .map_or(u32::MAX, |max| max.saturating_sub(segments))
    }
}

impl Default for PathLimits {
    fn default() -> Self {
        PathLimits {
            max_depth: None,
            rr_depth: 5,
            hide_emitters: false,
        }
    }
}
