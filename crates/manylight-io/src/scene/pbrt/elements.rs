//! What PBRT makes one shape of.

/// The shapes that PBRT makes of a geometry; each of them emits the power of an area light.
#[derive(Clone, Debug)]
pub(super) enum Elements {
    /// One shape.
    Whole,
    /// A shape for each triangle.
    Triangles,
    /// A shape for each run of successive triangles, with the number of triangles of each.
    Runs(Vec<u32>),
    /// A shape for each run of `triangles` successive triangles.
    Equal {
        /// Triangles of a run.
        triangles: usize,
        /// Power of a shape over that of the light.
        power: f32,
    },
}
