//! Reconstruction filters, by importance sampling: a sample is drawn around the centre of one pixel and counts for that pixel alone.

/// A reconstruction filter as files name it. Radii and deviations in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// Constant over the pixel's square.
    Box,
    /// Falls linearly to 0 at `radius`.
    Tent {
        /// Radius.
        radius: f32,
    },
    /// Gaussian, cut at 4 deviations and lowered to reach 0 there, as Mitsuba does.
    Gaussian {
        /// Standard deviation.
        stddev: f32,
    },
    /// Mitchell-Netravali, radius 2.
    Mitchell {
        /// B.
        b: f32,
        /// C.
        c: f32,
    },
    /// Catmull-Rom, radius 2.
    CatmullRom,
    /// Windowed sinc.
    Lanczos {
        /// Number of lobes: the radius.
        lobes: f32,
    },
}

impl Filter {
    /// Offset from the pixel's centre in pixels, and the weight of a sample there.
    pub fn sample(&self, _u: crate::math::Vec2) -> (crate::math::Vec2, f32) {
        todo!()
    }
}
