//! The scenes.

mod disco;
mod garage;
mod kitchen;
mod props;
mod u_shape;

use crate::scene::Scene;

/// How fine a scene is: 1 is the one that the repository holds; each step up doubles what it can.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detail(u32);

impl Detail {
    /// The finest.
    pub const MAX: u32 = 6;

    /// The detail of this number, from 1 to [`Detail::MAX`].
    pub fn new(level: u32) -> Option<Detail> {
        (1..=Self::MAX).contains(&level).then_some(Detail(level))
    }

    /// `pieces` of a curve at detail 1, finer with each level. Two directions of a surface grow together, so triangles
    /// double.
    pub fn pieces(self, pieces: usize) -> usize {
        let finer = pieces as f64 * 2.0_f64.sqrt().powi(self.0 as i32 - 1);
        // Even, so that halves of circles are whole pieces.
        (finer / 2.0).round() as usize * 2
    }

    /// `count` of things at detail 1, doubled with each level.
    pub fn count(self, count: usize) -> usize {
        count << (self.0 - 1)
    }
}

impl Default for Detail {
    fn default() -> Detail {
        Detail(1)
    }
}

/// A scene that can be generated.
pub struct Generator {
    /// Name, that of its folder.
    pub name: &'static str,
    /// Makes the scene.
    pub generate: fn(Detail) -> Scene,
}

/// All scenes.
pub const ALL: &[Generator] = &[
    Generator {
        name: "u-shape",
        generate: u_shape::scene,
    },
    Generator {
        name: "kitchen",
        generate: kitchen::scene,
    },
    Generator {
        name: "garage",
        generate: garage::scene,
    },
    Generator {
        name: "disco",
        generate: disco::scene,
    },
];

/// The scene of this name.
pub fn named(name: &str) -> Option<&'static Generator> {
    ALL.iter().find(|generator| generator.name == name)
}
