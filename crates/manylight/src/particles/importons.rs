//! Importons: importance that arrives at surfaces from the points that will sum virtual lights.

use crate::math::Vec3;

/// Importance that arrives at `p` from the shading point that would sum lights standing here.
#[derive(Clone, Copy, Debug)]
pub struct Importon {
    /// Position.
    pub p: Vec3,
    /// Geometric normal, turned to the side from which the importon arrives.
    pub n: Vec3,
    /// Unit direction to the shading point.
    pub wo: Vec3,
    /// Importance, already divided by the number of importon paths.
    pub importance: f32,
}
