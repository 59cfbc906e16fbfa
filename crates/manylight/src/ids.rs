//! Typed indices into the arrays of a [`Scene`](crate::scene::Scene), so that two of them are never confused.

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(transparent)]
        pub struct $name(pub u32);

        impl $name {
            /// The index as a `usize`, for slices.
            #[inline]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl From<usize> for $name {
            fn from(index: usize) -> Self {
                $name(u32::try_from(index).expect("an array of the scene has fewer than 2^32 elements"))
            }
        }
    )*};
}

ids! {
    /// A shape in object space.
    ShapeId,
    /// A placed shape: what a ray can hit.
    PrimitiveId,
    /// A material.
    MaterialId,
    /// A texture.
    TextureId,
    /// An emitter of the scene file.
    EmitterId,
    /// A virtual light.
    LightId,
}
