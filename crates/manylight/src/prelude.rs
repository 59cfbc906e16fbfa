//! The items that most programs need: `use manylight::prelude::*;`.

pub use crate::film::{Film, Layer};
pub use crate::image::Image;
pub use crate::integrators::{ExtraLayers, ManyLight, Method, MethodKind, PhotonMap};
pub use crate::render::{Budget, Observer, Outcome, RenderJob, Stats, Stop, render, render_film};
pub use crate::scene::{PathLimits, Scene, SceneDesc, SceneError};
