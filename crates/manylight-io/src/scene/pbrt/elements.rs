//! What PBRT makes one shape of.

/// The shapes that PBRT makes of a geometry; each of them emits the power of an area light.
#[derive(Clone, Debug)]
pub(super) enum Elements {
    /// One shape.
    Whole,
    /// A shape for each triangle.
    Triangles,
    /// Shapes of so many successive triangles each.
    Runs(Vec<u32>),
    /// Runs of as many triangles, whose power is this factor of that of the light.
    Equal {
        /// Triangles of a run.
        triangles: usize,
        /// Factor of the power.
        power: f32,
    },
}
