//! Typed indices into the arrays of a [`Scene`](crate::scene::Scene).

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
                $name(u32::try_from(index).expect("arrays of a scene have fewer than 2^32 elements"))
            }
        }
    )*};
}

/// Index of a light group: a set of emitters with one layer of the film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(transparent)]
pub struct LightGroup(pub u8);

impl LightGroup {
    /// Most light groups of a picture.
    pub const MAX: usize = 64;

    /// The index as a `usize`, for slices.
    #[inline]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

ids! {
    /// Index of a shape in object space.
    ShapeId,
    /// Index of a primitive: a shape with transform, material and emitter.
    PrimitiveId,
    /// Index of a material.
    MaterialId,
    /// Index of a texture.
    TextureId,
    /// Index of an emitter of the scene file.
    EmitterId,
    /// Index of a virtual light.
    LightId,
}
