//! The generators of all scenes.

mod disco;
mod garage;
mod kitchen;
mod props;
mod u_shape;

use crate::scene::Scene;

/// Level of detail. Level 1 is the scene in the repository; each level above about doubles the
/// number of triangles, or of lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detail(u32);

impl Detail {
    /// The highest level.
    pub const MAX: u32 = 6;

    /// The level, or `None` if it is not from 1 to [`Detail::MAX`].
    pub fn new(level: u32) -> Option<Detail> {
        (1..=Self::MAX).contains(&level).then_some(Detail(level))
    }

    /// The number of segments of a curve that has `base` segments at level 1. It grows by sqrt(2) a
    /// level, so that the number of triangles of a surface doubles.
    pub fn segments(self, base: usize) -> usize {
        let finer = base as f64 * 2.0_f64.sqrt().powi(self.0 as i32 - 1);
        // An even number, so that half a circle has a whole number of segments.
        (finer / 2.0).round() as usize * 2
    }

    /// The number of objects that is `count` at level 1 and doubles with each level.
    pub fn count(self, count: usize) -> usize {
        count << (self.0 - 1)
    }
}

impl Default for Detail {
    fn default() -> Detail {
        Detail(1)
    }
}

/// A generator with its name.
pub struct SceneGenerator {
    /// Name of the scene and of its folder in `scenes/`.
    pub name: &'static str,
    /// Generates the scene.
    pub generate: fn(Detail) -> Scene,
}

/// All generators.
pub const GENERATORS: &[SceneGenerator] = &[
    SceneGenerator {
        name: "u-shape",
        generate: u_shape::scene,
    },
    SceneGenerator {
        name: "kitchen",
        generate: kitchen::scene,
    },
    SceneGenerator {
        name: "garage",
        generate: garage::scene,
    },
    SceneGenerator {
        name: "disco",
        generate: disco::scene,
    },
];

/// The generator of this name.
pub fn generator_named(name: &str) -> Option<&'static SceneGenerator> {
    GENERATORS.iter().find(|generator| generator.name == name)
}
