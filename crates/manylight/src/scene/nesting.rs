//! Bounds for textures in textures and materials in materials: evaluation is recursive, and a
//! texture that occurs twice in another is evaluated twice.

use super::error::{Checked, ensure};

/// Most levels of textures or materials: far above those of artists, and few enough stack frames
/// for recursion.
const MAX_DEPTH: u32 = 100;
/// Most textures or materials that one of them consists of, each counted as often as it occurs.
const MAX_PARTS: u64 = 1000;

/// The size of the tree below a texture or material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Nesting {
    /// Levels, itself included.
    depth: u32,
    /// Textures or materials, itself included, each counted as often as it occurs.
    parts: u64,
}

impl Nesting {
    /// That of a texture or material that contains `inner`.
    ///
    /// # Errors
    /// It is too deep or too large. `what` is its name in the message.
    pub(super) fn of(
        what: &str,
        inner: impl IntoIterator<Item = Nesting>,
    ) -> Result<Self, super::SceneError> {
        let mut nesting = Nesting { depth: 1, parts: 1 };
        for inner in inner {
            nesting.depth = nesting.depth.max(inner.depth.saturating_add(1));
            nesting.parts = nesting.parts.saturating_add(inner.parts);
        }
        nesting.check(what)?;
        Ok(nesting)
    }

    fn check(self, what: &str) -> Checked {
        ensure(self.depth <= MAX_DEPTH, || {
            format!("{what} is nested more than {MAX_DEPTH} deep")
        })?;
        ensure(self.parts <= MAX_PARTS, || {
            format!("{what} consists of more than {MAX_PARTS} nested ones")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_and_size_are_bounded() {
        let mut chain = Nesting::of("texture 0", []).unwrap();
        for _ in 1..MAX_DEPTH {
            chain = Nesting::of("texture 1", [chain]).unwrap();
        }
        let error = Nesting::of("texture 2", [chain]).unwrap_err();
        assert_eq!(error.message, "texture 2 is nested more than 100 deep");
        let mut doubled = Nesting::of("material 0", []).unwrap();
        let error = loop {
            match Nesting::of("material 1", [doubled; 2]) {
                Ok(nesting) => doubled = nesting,
                Err(error) => break error,
            }
        };
        assert_eq!(
            (error.message.as_str(), doubled.depth),
            ("material 1 consists of more than 1000 nested ones", 9)
        );
    }
}
