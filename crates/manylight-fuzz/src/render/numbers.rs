//! Numbers from arbitrary bytes: mostly those of usual scenes, now and then extreme ones.

use arbitrary::Unstructured;
use manylight::color::Rgb;
use manylight::math::{Affine3A, Mat3, Vec2, Vec3};

/// Numbers at the borders of what formats and formulas allow.
const EXTREMES: [f32; 20] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    2.0,
    -3.5,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-40,
    1e-20,
    1e-6,
    1e4,
    1e6,
    1e10,
    1e20,
];

/// A source of values. Zeros follow the end of the bytes.
pub(super) struct Numbers<'a> {
    bytes: Unstructured<'a>,
}

impl<'a> Numbers<'a> {
    pub(super) fn new(bytes: Unstructured<'a>) -> Self {
        Numbers { bytes }
    }

    pub(super) fn byte(&mut self) -> u8 {
        self.bytes.arbitrary().unwrap_or(0)
    }

    /// A number below `limit`, which is at most 256.
    pub(super) fn below(&mut self, limit: usize) -> usize {
        usize::from(self.byte()) % limit.max(1)
    }

    /// An index below `count`, or in rare cases one beyond.
    pub(super) fn index(&mut self, count: usize) -> usize {
        if self.rarely(128) {
            count
        } else {
            self.below(count)
        }
    }

    pub(super) fn flag(&mut self) -> bool {
        self.byte() & 1 == 1
    }

    /// `true` once in `n` times.
    pub(super) fn rarely(&mut self, n: u8) -> bool {
        self.byte() % n == n - 1
    }

    pub(super) fn choose<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    /// A number in [low, high], or an extreme one.
    pub(super) fn float(&mut self, low: f32, high: f32) -> f32 {
        match self.byte() {
            0..=231 => low + (high - low) * f32::from(self.byte()) / 255.0,
            232..=249 => self.choose(&EXTREMES),
            _ => f32::from_bits(self.bytes.arbitrary().unwrap_or(0)),
        }
    }

    pub(super) fn unit(&mut self) -> f32 {
        self.float(0.0, 1.0)
    }

    pub(super) fn vec2(&mut self, low: f32, high: f32) -> Vec2 {
        Vec2::new(self.float(low, high), self.float(low, high))
    }

    pub(super) fn vec3(&mut self, low: f32, high: f32) -> Vec3 {
        Vec3::new(
            self.float(low, high),
            self.float(low, high),
            self.float(low, high),
        )
    }

    pub(super) fn color(&mut self, high: f32) -> Rgb {
        if self.flag() {
            Rgb::splat(self.float(0.0, high))
        } else {
            Rgb::from(self.vec3(0.0, high).to_array())
        }
    }

    /// A unit vector, or any other.
    pub(super) fn direction(&mut self) -> Vec3 {
        let v = self.vec3(-1.0, 1.0);
        if self.rarely(16) {
            v
        } else {
            v.try_normalize().unwrap_or(Vec3::Z)
        }
    }

    /// A rotation with a scale, or any matrix.
    pub(super) fn affine(&mut self) -> Affine3A {
        if self.rarely(32) {
            return Affine3A::from_cols(
                self.vec3(-1.0, 1.0).into(),
                self.vec3(-1.0, 1.0).into(),
                self.vec3(-1.0, 1.0).into(),
                self.vec3(-1.0, 1.0).into(),
            );
        }
        let axis = self.vec3(-1.0, 1.0).try_normalize().unwrap_or(Vec3::Y);
        let angle = f32::from(self.byte()) / 40.0;
        let rotation = Affine3A::from_axis_angle(axis, angle);
        let scale = if self.flag() {
            Vec3::splat(self.float(0.1, 2.0))
        } else {
            self.vec3(-2.0, 2.0)
        };
        Affine3A::from_translation(self.vec3(-2.0, 2.0)) * rotation * Affine3A::from_scale(scale)
    }

    pub(super) fn mat3(&mut self) -> Mat3 {
        match self.below(4) {
            0 | 1 => Mat3::IDENTITY,
            2 => Mat3::from(self.affine().matrix3),
            _ => Mat3::from_cols(
                self.vec3(-3.0, 3.0),
                self.vec3(-3.0, 3.0),
                self.vec3(-3.0, 3.0),
            ),
        }
    }
}
