//! A bound for the geometry of a file: any number of primitives may refer to the same data.

use super::primitives::Geometry;

/// Most bytes of geometry, as a multiple of the data in the file. Compressed data grow by less.
const LARGEST_RATIO: usize = 100;
/// Bytes of geometry that small files may make in any case.
const ALWAYS_ALLOWED: usize = 64 << 20;

/// The geometry of a file so far.
pub(super) struct Growth {
    /// Bytes of data in the file.
    given: usize,
    /// Bytes of vertices and triangles.
    made: usize,
    exceeded: bool,
}

/// The bound is exceeded. The message is given the first time only.
pub(super) struct Exceeded {
    pub(super) message: Option<String>,
}

impl Growth {
    /// For a file with this many bytes of data.
    pub(super) fn new(given: usize) -> Self {
        Growth {
            given,
            made: 0,
            exceeded: false,
        }
    }

    /// Adds a primitive.
    ///
    /// # Errors
    /// The bound is exceeded.
    pub(super) fn add(&mut self, geometry: &Geometry) -> Result<(), Exceeded> {
        self.made = self.made.saturating_add(geometry.bytes());
        let most = self.given.saturating_mul(LARGEST_RATIO).max(ALWAYS_ALLOWED);
        if !self.exceeded && self.made <= most {
            return Ok(());
        }
        let message = format!(
            "the primitives make more than {most} bytes of geometry from {} bytes of data",
            self.given
        );
        let message = (!self.exceeded).then_some(message);
        self.exceeded = true;
        Err(Exceeded { message })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::math::Vec3;

    #[test]
    fn geometry_is_bounded_by_the_data() {
        let geometry = Geometry {
            positions: vec![Vec3::ZERO; 1 << 20],
            ..Geometry::default()
        };
        let mut growth = Growth::new(1 << 20);
        for _ in 0..8 {
            assert!(growth.add(&geometry).is_ok());
        }
        let exceeded = growth.add(&geometry).unwrap_err();
        assert!(
            exceeded
                .message
                .unwrap()
                .ends_with("from 1048576 bytes of data")
        );
        assert!(growth.add(&geometry).unwrap_err().message.is_none());
    }
}
