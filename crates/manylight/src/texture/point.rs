//! Places at which textures are evaluated, and values per vertex of a mesh.

use crate::geometry::{SurfacePoint, SurfacePoints, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::lanes::{One, Pair, Vector, Width};
use crate::math::{Vec2, Vec3};

/// The place on a surface at which a texture is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexturePoint {
    /// Texture coordinates of the mesh.
    pub uv: Vec2,
    /// Position in world space, for patterns in space.
    pub p: Vec3,
    /// Triangle of the mesh; 0 for other shapes.
    pub element: u32,
    /// Barycentric coordinates of the second and third corner.
    pub coordinates: Vec2,
}

/// A place that is known by its texture coordinates alone. Patterns in space get the origin.
impl From<Vec2> for TexturePoint {
    #[inline]
    fn from(uv: Vec2) -> Self {
        TexturePoint {
            uv,
            ..TexturePoint::default()
        }
    }
}

impl TexturePoint {
    /// The place of a reference with the texture coordinates `uv` and the position `p`.
    #[inline]
    pub fn new(uv: Vec2, p: Vec3, at: SurfaceRef) -> Self {
        TexturePoint {
            uv,
            p,
            element: at.element,
            coordinates: at.coordinates,
        }
    }
}

impl From<&SurfacePoint> for TexturePoint {
    #[inline]
    fn from(x: &SurfacePoint) -> Self {
        TexturePoint::new(x.uv, x.p, x.at)
    }
}

/// The places in all lanes at which a texture is evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TexturePoints<'a, S: Width> {
    /// Texture coordinates of the mesh.
    pub(super) uv: Pair<S>,
    /// Positions in world space.
    pub(super) p: Vector<S>,
    /// Triangles of the mesh, and the coordinates on them.
    pub(super) at: &'a S::Each<SurfaceRef>,
}

impl<'a, S: Width> From<&'a SurfacePoints<S>> for TexturePoints<'a, S> {
    #[inline(always)]
    fn from(x: &'a SurfacePoints<S>) -> Self {
        TexturePoints {
            uv: x.uv,
            p: x.p,
            at: &x.at,
        }
    }
}

impl TexturePoint {
    /// The reference to the place, of which textures use the triangle and the coordinates.
    #[inline]
    pub(super) fn reference(&self) -> [SurfaceRef; 1] {
        [SurfaceRef {
            primitive: PrimitiveId(0),
            element: self.element,
            instance: SurfaceRef::NO_INSTANCE,
            coordinates: self.coordinates,
        }]
    }

    /// The place in the only lane, with its reference.
    #[inline]
    pub(super) fn in_lane<'a>(&self, at: &'a [SurfaceRef; 1]) -> TexturePoints<'a, One> {
        TexturePoints {
            uv: self.uv.into(),
            p: self.p.into(),
            at,
        }
    }
}

/// Values at the vertices of one mesh, interpolated linearly over its triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexValues<T> {
    /// Indices of the values at the corners of each triangle of the mesh; all smaller than
    /// `values.len()`.
    pub triangles: Vec<[u32; 3]>,
    /// The values.
    pub values: Vec<T>,
}

impl<T> VertexValues<T>
where
    T: Copy + Default + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    /// The value at a point; the default value on other meshes, which have more triangles.
    #[inline]
    pub(super) fn at(&self, point: &SurfaceRef) -> T {
        let Some(corners) = self.triangles.get(point.element as usize) else {
            return T::default();
        };
        let [a, b, c] = corners.map(|i| self.values[i as usize]);
        let at = point.coordinates;
        a * (1.0 - at.x - at.y) + b * at.x + c * at.y
    }

    /// Whether all indices are smaller than the number of values.
    pub(crate) fn is_valid(&self) -> bool {
        let count = self.values.len();
        let corners = self.triangles.iter().flatten();
        corners.into_iter().all(|&i| (i as usize) < count)
    }
}
