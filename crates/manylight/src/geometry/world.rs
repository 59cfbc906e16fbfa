//! All surfaces of a scene: primitives, instances, surface points and sampling by area.

use super::level::{InstanceBounds, Level};
use super::placement::{PlacedInstance, PlacedShape, TriangleTable};
use super::surface_set::SurfaceSet;
use super::{Derivatives, Instance, Primitive, Shape, SurfacePoint, SurfacePoints, SurfaceRef};
use crate::ids::PrimitiveId;
use crate::lanes::{One, Width};
use crate::math::{Aabb, Vec2};
#[cfg(any(test, feature = "testing"))]
use crate::simd::Instructions;
use crate::simd::outlined;
use rayon::prelude::*;
use std::ops::Range;

/// A surface point drawn uniformly by area.
#[derive(Clone, Copy, Debug)]
pub struct AreaSample {
    /// The point.
    pub point: SurfacePoint,
    /// Density of the point by area in the world, in 1/m².
    pub pdf_area: f32,
}

/// Shapes, primitives, instances and the acceleration structures over them. Immutable once built.
#[derive(Debug)]
pub struct Geometry {
    shapes: Vec<Shape>,
    primitives: Vec<Primitive>,
    /// One per primitive.
    pub(super) placements: Vec<PlacedShape>,
    table: TriangleTable,
    pub(super) world: Level,
    pub(super) groups: Vec<Level>,
    pub(super) instances: Vec<PlacedInstance>,
    bounds: Aabb,
}

impl Geometry {
    /// Builds the acceleration structures.
    ///
    /// `primitives` holds first the primitives of the world and then, group by group, those of the
    /// groups: `groups[g]` is the range of group `g`. Degenerate triangles are allowed and never
    /// hit.
    ///
    /// # Panics
    /// If an id or index is out of range.
    pub fn build(
        mut shapes: Vec<Shape>,
        primitives: Vec<Primitive>,
        groups: Vec<Range<usize>>,
        instances: Vec<Instance>,
    ) -> Self {
        let table = TriangleTable::new(&shapes, &primitives);
        shapes.iter_mut().for_each(drop_attributes);
        let placements: Vec<PlacedShape> = primitives
            .par_iter()
            .enumerate()
            .map(|(i, p)| PlacedShape::new(&shapes[p.shape.index()], p, i, &table))
            .collect();
        let world_end = groups
            .iter()
            .map(|g| g.start)
            .min()
            .unwrap_or(primitives.len());
        let groups: Vec<Level> = groups
            .into_iter()
            .map(|range| Level::build(&primitives, &placements, &table, range, &[]))
            .collect();
        let instances: Vec<PlacedInstance> = instances
            .iter()
            .map(|i| PlacedInstance::new(i.group, &i.world_from_group))
            .collect();
        let instance_bounds: Vec<InstanceBounds> = instances
            .iter()
            .map(|i| InstanceBounds::new(i, &groups[i.group()]))
            .collect();
        let world = Level::build(
            &primitives,
            &placements,
            &table,
            0..world_end,
            &instance_bounds,
        );
        let bounds = world.opaque.bounds().union(world.transparent.bounds());
        Geometry {
            shapes,
            primitives,
            placements,
            table,
            world,
            groups,
            instances,
            bounds,
        }
    }

    /// All primitives, by [`PrimitiveId`].
    pub fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// Whether `at` names a surface of this scene: files from elsewhere may name others.
    pub fn has_surface(&self, at: &SurfaceRef) -> bool {
        let Some(primitive) = self.primitives.get(at.primitive.index()) else {
            return false;
        };
        let elements = match &self.shapes[primitive.shape.index()] {
            Shape::Mesh(mesh) => mesh.triangles.len(),
            _ => 1,
        };
        let instance = at.instance as usize;
        let is_placed = at.instance == SurfaceRef::NO_INSTANCE || instance < self.instances.len();
        is_placed && (at.element as usize) < elements
    }

    /// All shapes in object space, by [`ShapeId`](crate::ids::ShapeId); meshes without normals,
    /// tangents and texture coordinates.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Bounding box of the scene, instances included; empty for an empty scene.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Number of stored triangles. Triangles of instanced groups count once.
    pub fn triangle_count(&self) -> usize {
        self.surface_sets().map(SurfaceSet::triangle_count).sum()
    }

    /// Memory of the acceleration structures over triangles, in bytes.
    pub fn acceleration_bytes(&self) -> usize {
        self.surface_sets().map(SurfaceSet::bytes).sum()
    }

    /// Runs all kernels in this instruction set.
    ///
    /// # Panics
    /// If the machine lacks the instruction set.
    #[cfg(any(test, feature = "testing"))]
    pub fn use_instructions(&mut self, instructions: Instructions) {
        let levels = std::iter::once(&mut self.world).chain(&mut self.groups);
        for surfaces in levels.flat_map(|level| [&mut level.opaque, &mut level.transparent]) {
            surfaces.use_instructions(instructions);
        }
    }

    /// Builds the hierarchies over the primitives of the world once more; returns the time.
    #[cfg(any(test, feature = "testing"))]
    pub fn time_of_hierarchies(&self) -> std::time::Duration {
        let start = std::time::Instant::now();
        let all = 0..self.primitives.len();
        let level = Level::build(&self.primitives, &self.placements, &self.table, all, &[]);
        let time = start.elapsed();
        std::hint::black_box(level);
        time
    }

    fn surface_sets(&self) -> impl Iterator<Item = &SurfaceSet> {
        std::iter::once(&self.world)
            .chain(&self.groups)
            .flat_map(|level| [&level.opaque, &level.transparent])
    }

    /// The surface point that a reference names, in world space.
    #[inline]
    pub fn surface_point(&self, at: SurfaceRef) -> SurfacePoint {
        self.surface_points(One, &[at], Derivatives::OfPosition)
            .into()
    }

    /// The surface point that the reference in each lane names, in world space.
    #[inline(always)]
    pub fn surface_points<S: Width>(
        &self,
        s: S,
        at: &S::Each<SurfaceRef>,
        derivatives: Derivatives,
    ) -> SurfacePoints<S> {
        surface_points(self, s, at, derivatives)
    }

    #[inline(always)]
    fn surface_points_inlined<S: Width>(
        &self,
        s: S,
        at: &S::Each<SurfaceRef>,
        derivatives: Derivatives,
    ) -> SurfacePoints<S> {
        let in_world = |all: u32, at: &SurfaceRef| all & at.instance;
        let is_in_world = at.as_ref().iter().fold(u32::MAX, in_world) == SurfaceRef::NO_INSTANCE;
        // The frames of points in instances follow from their derivatives.
        let derivatives = match is_in_world {
            true => derivatives,
            false => Derivatives::OfPosition,
        };
        let (points, others) = self.table.points(s, at, derivatives);
        if others == 0 && is_in_world {
            return points;
        }
        let points = points.store();
        SurfacePoints::load(s, &s.each(|i| self.completed(points.as_ref()[i])))
    }

    /// The point in world space of a point in the space of its primitive, which is unspecified on
    /// analytic shapes.
    fn completed(&self, point: SurfacePoint) -> SurfacePoint {
        let at = point.at;
        let analytic = self.placements[at.primitive.index()].analytic_point(at);
        let point = analytic.unwrap_or(point);
        match at.instance {
            SurfaceRef::NO_INSTANCE => point,
            instance => self.instances[instance as usize].surface_in_world(&point),
        }
    }

    /// Texture coordinates of a reference: [`SurfacePoint::uv`].
    #[inline]
    pub fn uv(&self, at: SurfaceRef) -> Vec2 {
        self.table
            .uv(&at)
            .unwrap_or_else(|| self.surface_point(at).uv)
    }

    /// Area of a primitive under its transform, in m². Instances are ignored.
    pub fn area(&self, primitive: PrimitiveId) -> f32 {
        self.placements[primitive.index()].area(&self.table)
    }

    /// A point of the primitive, uniform by area. `None` if the area is 0.
    ///
    /// On spheres and cylinders under a transform that is not a similarity the density is not quite
    /// uniform; `pdf_area` is exact.
    pub fn sample_area(&self, primitive: PrimitiveId, u: Vec2) -> Option<AreaSample> {
        let (at, pdf_area) = self.sample_area_ref(primitive, u)?;
        Some(AreaSample {
            point: self.surface_point(at),
            pdf_area,
        })
    }

    /// The point of [`Geometry::sample_area`] by reference, and its density.
    pub(crate) fn sample_area_ref(
        &self,
        primitive: PrimitiveId,
        u: Vec2,
    ) -> Option<(SurfaceRef, f32)> {
        let placement = &self.placements[primitive.index()];
        let (element, coordinates, pdf_area) = placement.sample(&self.table, u)?;
        let at = SurfaceRef {
            primitive,
            element,
            instance: SurfaceRef::NO_INSTANCE,
            coordinates,
        };
        Some((at, pdf_area))
    }
}

outlined! {
    fn surface_points<S: Width>(
        geometry: &Geometry, s: S, at: &S::Each<SurfaceRef>, derivatives: Derivatives,
    ) -> SurfacePoints<S> { s => geometry.surface_points_inlined(s, at, derivatives) }
}

/// Frees the attributes of vertices, which the table of triangles has.
fn drop_attributes(shape: &mut Shape) {
    if let Shape::Mesh(mesh) = shape {
        mesh.normals = Vec::new();
        mesh.tangents = Vec::new();
        mesh.uvs = Vec::new();
    }
}
