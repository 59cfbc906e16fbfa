//! Scene descriptions: plain data, made by loaders and tests.

use crate::bsdf::Material;
use crate::color::Rgb;
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
    /// Groups of placed shapes. They are visible only through instances.
    pub groups: Vec<Vec<PrimitiveDesc>>,
    /// Instances of groups.
    pub instances: Vec<InstanceDesc>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Names of the materials in the file, by the same indices; missing or empty where a material
    /// has none.
    pub material_names: Vec<String>,
    /// Absorbing media inside of surfaces, at most one for each material.
    pub media: Vec<MediumDesc>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// Emitters. The surface of an `Emitter::Area` is the primitives that refer to it.
    pub emitters: Vec<Emitter>,
    /// Names of the light groups of the emitters, by the same indices; missing or empty where an
    /// emitter has none.
    pub emitter_groups: Vec<String>,
    /// Names of the light groups of surfaces, by the indices of `primitives`, instead of those of
    /// their emitters; missing or empty where a surface has none.
    pub primitive_groups: Vec<String>,
    /// Cameras, in file order.
    pub sensors: Vec<SensorDesc>,
    /// Limits on path length.
    pub limits: PathLimits,
}

/// A placed shape.
#[derive(Clone, Debug)]
pub struct PrimitiveDesc {
    /// Name or id in the file, for messages and mattes; may be empty.
    pub name: String,
    /// The shape.
    pub shape: ShapeId,
    /// Object to world (in groups: to the group's frame).
    pub world_from_object: Affine3A,
    /// Reverses geometric and shading normals.
    pub flip_normals: bool,
    /// Material.
    pub material: MaterialId,
    /// Area emitter; `None` if the surface does not emit.
    pub emitter: Option<EmitterId>,
}

/// A medium that absorbs light, and does not scatter it, inside of all closed surfaces of one
/// material: on the side of their backs.
#[derive(Clone, Copy, Debug)]
pub struct MediumDesc {
    /// The material of the surfaces.
    pub material: MaterialId,
    /// Absorption coefficient σ in 1/m, at least 0: the medium transmits `exp(-σ t)`.
    pub absorption: Rgb,
}

/// An instance of a group.
#[derive(Clone, Debug)]
pub struct InstanceDesc {
    /// Name or id in the file; may be empty.
    pub name: String,
    /// Index into `SceneDesc::groups`.
    pub group: usize,
    /// Group to world.
    pub world_from_group: Affine3A,
}

/// Limits on path length in segments, as in Mitsuba: 1 = emitters seen directly, 2 = direct light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathLimits {
    /// Most segments of a path; `None`: no limit.
    pub max_depth: Option<u32>,
    /// Segments of a path from which on Russian roulette is applied.
    pub rr_depth: u32,
    /// Whether emitters are invisible to the camera.
    pub hide_emitters: bool,
}

impl PathLimits {
    /// Whether paths of this length contribute.
    #[inline]
    pub fn allow(&self, segments: u32) -> bool {
        self.max_depth.is_none_or(|max| segments <= max)
    }

    /// Number of segments by which a path of length `segments` may be extended.
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
