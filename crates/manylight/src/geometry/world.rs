//! All surfaces of a scene: nearest hit, visibility, and points by area.

use super::placement::{PlacedInstance, PlacedShape};
use super::surface_set::{Object, SurfaceSet, SurfaceSetBuilder};
use super::{Ray, Segment, Shape, SurfacePoint, SurfaceRef};
use crate::ids::{EmitterId, MaterialId, PrimitiveId, ShapeId};
use crate::math::{Aabb, Affine3A, Vec2, Vec3};
#[cfg(any(test, feature = "testing"))]
use crate::simd::Instructions;
use rayon::prelude::*;
use std::ops::Range;

/// One placed surface: what a ray can hit.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// The shape, in object space.
    pub shape: ShapeId,
    /// Places the shape in the world (or in its group).
    pub world_from_object: Affine3A,
    /// Turn both normals round.
    pub flip_normals: bool,
    /// How it scatters.
    pub material: MaterialId,
    /// What it emits.
    pub emitter: Option<EmitterId>,
    /// Whether light can pass straight through (masks, null, thin glass): such surfaces do not block [`Geometry::occluded`].
    pub transparent: bool,
}

/// A copy of a group of primitives somewhere else.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index of the group.
    pub group: u32,
    /// Places the group in the world.
    pub world_from_group: Affine3A,
}

/// The nearest surface along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance along the ray in units of its direction.
    pub t: f32,
    /// Where.
    pub at: SurfaceRef,
}

/// A point drawn uniformly by area.
#[derive(Clone, Copy, Debug)]
pub struct AreaSample {
    /// The point.
    pub point: SurfacePoint,
    /// 1 / area of the primitive, in 1/m².
    pub pdf_area: f32,
}

/// Shapes, primitives, instances and the acceleration structure over them. Immutable once built.
#[derive(Debug)]
pub struct Geometry {
    shapes: Vec<Shape>,
    primitives: Vec<Primitive>,
    /// One per primitive.
    pub(super) placements: Vec<PlacedShape>,
    pub(super) world: Level,
    pub(super) groups: Vec<Level>,
    pub(super) instances: Vec<PlacedInstance>,
    bounds: Aabb,
}

/// What a ray can meet in one space: the world or a group. Transparent surfaces stand apart, so that visibility among
/// opaque ones never pays for them.
#[derive(Debug)]
pub(super) struct Level {
    opaque: SurfaceSet,
    transparent: SurfaceSet,
}

impl Level {
    pub(super) fn surfaces(&self, class: Class) -> &SurfaceSet {
        match class {
            Class::Opaque => &self.opaque,
            Class::Transparent => &self.transparent,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    Opaque,
    Transparent,
}

impl Geometry {
    /// Builds the acceleration structures. `primitives` holds the world's own first and then, group by group, those of
    /// the groups: `groups[g]` is the range of group `g`. Ids must be in range; degenerate triangles are allowed and never hit.
    pub fn build(
        shapes: Vec<Shape>,
        primitives: Vec<Primitive>,
        groups: Vec<Range<usize>>,
        instances: Vec<Instance>,
    ) -> Self {
        let placements: Vec<PlacedShape> = primitives
            .par_iter()
            .map(|p| PlacedShape::new(&shapes[p.shape.index()], &p.world_from_object))
            .collect();
        let level = |range: Range<usize>, instances: &[(usize, Aabb, Aabb)]| {
            let surfaces = |class: Class| {
                let members = range
                    .clone()
                    .filter(|&i| primitives[i].transparent == (class == Class::Transparent));
                let mut builder = SurfaceSetBuilder::default();
                for i in members {
                    builder.add_primitive(PrimitiveId::from(i), &placements[i]);
                }
                for &(index, opaque, transparent) in instances {
                    builder.add_instance(
                        index,
                        if class == Class::Opaque {
                            opaque
                        } else {
                            transparent
                        },
                    );
                }
                builder.build()
            };
            Level {
                opaque: surfaces(Class::Opaque),
                transparent: surfaces(Class::Transparent),
            }
        };
        let world_end = groups
            .iter()
            .map(|g| g.start)
            .min()
            .unwrap_or(primitives.len());
        let groups: Vec<Level> = groups.into_iter().map(|range| level(range, &[])).collect();
        let instances: Vec<PlacedInstance> = instances
            .iter()
            .map(|i| PlacedInstance::new(i.group, &i.world_from_group))
            .collect();
        let instance_bounds: Vec<(usize, Aabb, Aabb)> = instances
            .iter()
            .map(|i| (i, &groups[i.group()]))
            .map(|(i, group)| {
                (
                    i.bounds(group.opaque.bounds()),
                    i.bounds(group.transparent.bounds()),
                )
            })
            .enumerate()
            .map(|(index, (opaque, transparent))| (index, opaque, transparent))
            .collect();
        let world = level(0..world_end, &instance_bounds);
        let bounds = world.opaque.bounds().union(world.transparent.bounds());
        Geometry {
            shapes,
            primitives,
            placements,
            world,
            groups,
            instances,
            bounds,
        }
    }

    /// The placed surfaces; index by [`PrimitiveId`].
    pub fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// The shapes in object space; index by [`ShapeId`].
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Box around everything, instances included; empty for an empty scene.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Number of triangles stored (instances not multiplied).
    pub fn triangle_count(&self) -> usize {
        self.surface_sets().map(SurfaceSet::triangle_count).sum()
    }

    /// Memory of the acceleration structures over triangles, in bytes.
    pub fn acceleration_bytes(&self) -> usize {
        self.surface_sets().map(SurfaceSet::bytes).sum()
    }

    /// Restricts the kernels to these instructions.
    ///
    /// # Panics
    /// If the machine lacks them.
    #[cfg(any(test, feature = "testing"))]
    pub fn use_instructions(&mut self, instructions: Instructions) {
        let levels = std::iter::once(&mut self.world).chain(&mut self.groups);
        for surfaces in levels.flat_map(|level| [&mut level.opaque, &mut level.transparent]) {
            surfaces.use_instructions(instructions);
        }
    }

    fn surface_sets(&self) -> impl Iterator<Item = &SurfaceSet> {
        std::iter::once(&self.world)
            .chain(&self.groups)
            .flat_map(|level| [&level.opaque, &level.transparent])
    }

    /// The nearest surface with `0 < t < ray.t_max`, opaque or transparent.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let opaque = self.nearest(Class::Opaque, ray);
        if !self.has_transparent() {
            return opaque;
        }
        let rest = Ray {
            t_max: opaque.map_or(ray.t_max, |hit| hit.t),
            ..*ray
        };
        self.nearest(Class::Transparent, &rest).or(opaque)
    }

    /// Whether an opaque surface lies on the segment.
    pub fn occluded(&self, segment: &Segment) -> bool {
        let surfaces = &self.world.opaque;
        surfaces.any_triangle(segment)
            || (surfaces.has_objects() && self.any_object(surfaces, segment))
    }

    /// Visibility from one point to up to 64 others at once: bit `i` is set when an opaque surface lies between `from` and `to[i]`.
    /// Bits beyond `to.len()` are 0. Equal to single [`Geometry::occluded`] calls, only faster.
    pub fn occluded_packet(&self, from: Vec3, to: &[Vec3]) -> u64 {
        let surfaces = &self.world.opaque;
        let mut blocked = surfaces.any_triangle_packet(from, to);
        if surfaces.has_objects() {
            for (i, &to) in to.iter().enumerate() {
                if blocked >> i & 1 == 0 && self.any_object(surfaces, &Segment { from, to }) {
                    blocked |= 1 << i;
                }
            }
        }
        blocked
    }

    /// Whether any surface lets light straight through; if not, [`Geometry::occluded`] is the whole story.
    pub fn has_transparent(&self) -> bool {
        !self.world.transparent.is_empty()
    }

    /// Calls `visit` for the hits of the segment with transparent surfaces, in no order, until it returns true.
    pub fn visit_transparent(&self, segment: &Segment, mut visit: impl FnMut(Hit) -> bool) {
        self.visit_in_set(&self.world.transparent, segment, &mut visit);
    }

    /// Whether `visit` ended it.
    fn visit_in_set(
        &self,
        surfaces: &SurfaceSet,
        segment: &Segment,
        visit: &mut dyn FnMut(Hit) -> bool,
    ) -> bool {
        if surfaces.visit_triangles(segment, &mut *visit) {
            return true;
        }
        if !surfaces.has_objects() {
            return false;
        }
        let mut ended = false;
        let whole = segment.ray();
        surfaces.visit_objects(&whole, whole.t_max, |object, t_max| {
            ended = match object {
                Object::Analytic(primitive) => self.visit_analytic(primitive, segment, visit),
                Object::Instance(index) => {
                    let instance = &self.instances[index];
                    let group = &self.groups[instance.group()].transparent;
                    let segment = instance.segment_in_group(segment);
                    self.visit_in_set(group, &segment, &mut |mut hit| {
                        hit.at.instance = index as u32;
                        visit(hit)
                    })
                }
            };
            if ended { 0.0 } else { t_max }
        });
        ended
    }

    fn visit_analytic(
        &self,
        primitive: PrimitiveId,
        segment: &Segment,
        visit: &mut dyn FnMut(Hit) -> bool,
    ) -> bool {
        /// A line meets a quadric twice at most.
        const MOST: usize = 2;
        let (mut rest, mut start) = (*segment, 0.0);
        for _ in 0..MOST {
            let placement = &self.placements[primitive.index()];
            let Some(mut hit) = placement.intersect_analytic(primitive, &rest.ray()) else {
                return false;
            };
            hit.t = start + (1.0 - start) * hit.t;
            if visit(hit) {
                return true;
            }
            let x = self.surface_point(hit.at);
            rest.from = x.offset_towards(rest.to - rest.from);
            start = hit.t;
        }
        false
    }

    fn nearest(&self, class: Class, ray: &Ray) -> Option<Hit> {
        let surfaces = self.world.surfaces(class);
        let mut best = surfaces.nearest_triangle(ray);
        if !surfaces.has_objects() {
            return best;
        }
        let mut rest = Ray {
            t_max: best.map_or(ray.t_max, |hit| hit.t),
            ..*ray
        };
        surfaces.visit_objects(ray, rest.t_max, |object, t_max| {
            rest.t_max = t_max;
            let hit = match object {
                Object::Analytic(primitive) => {
                    self.placements[primitive.index()].intersect_analytic(primitive, &rest)
                }
                Object::Instance(index) => self.nearest_in_instance(class, index, &rest),
            };
            best = hit.or(best);
            hit.map_or(t_max, |hit| hit.t)
        });
        best
    }

    fn nearest_in_instance(&self, class: Class, index: usize, ray: &Ray) -> Option<Hit> {
        let instance = &self.instances[index];
        let surfaces = self.groups[instance.group()].surfaces(class);
        let mut rest = instance.ray_in_group(ray);
        let mut best = surfaces.nearest_triangle(&rest);
        rest.t_max = best.map_or(ray.t_max, |hit| hit.t);
        let start = rest;
        surfaces.visit_objects(&start, start.t_max, |object, t_max| {
            rest.t_max = t_max;
            let hit = match object {
                Object::Analytic(primitive) => {
                    self.placements[primitive.index()].intersect_analytic(primitive, &rest)
                }
                Object::Instance(_) => None,
            };
            best = hit.or(best);
            hit.map_or(t_max, |hit| hit.t)
        });
        best.map(|hit| Hit {
            at: SurfaceRef {
                instance: index as u32,
                ..hit.at
            },
            ..hit
        })
    }

    fn any_object(&self, surfaces: &SurfaceSet, segment: &Segment) -> bool {
        surfaces.any_object(segment, |object| match object {
            Object::Analytic(primitive) => self.placements[primitive.index()].blocks(segment),
            Object::Instance(index) => {
                let instance = &self.instances[index];
                let group = &self.groups[instance.group()].opaque;
                let segment = instance.segment_in_group(segment);
                group.any_triangle(&segment) || self.any_object(group, &segment)
            }
        })
    }

    /// Asks for the memory that [`Geometry::surface_point`] will read first.
    #[inline]
    pub fn prefetch(&self, at: SurfaceRef) {
        let (shape, placement) = self.placed(at.primitive);
        placement.prefetch(shape, at.element);
    }

    /// The same for what it reads next.
    #[inline]
    pub fn prefetch_vertices(&self, at: SurfaceRef) {
        let (shape, placement) = self.placed(at.primitive);
        placement.prefetch_vertices(shape, at.element);
    }

    #[inline]
    fn placed(&self, primitive: PrimitiveId) -> (&Shape, &PlacedShape) {
        let shape = self.primitives[primitive.index()].shape;
        (
            &self.shapes[shape.index()],
            &self.placements[primitive.index()],
        )
    }

    /// The full description of a hit or stored reference. Needs no ray.
    #[inline]
    pub fn surface_point(&self, at: SurfaceRef) -> SurfacePoint {
        let primitive = &self.primitives[at.primitive.index()];
        let shape = &self.shapes[primitive.shape.index()];
        let placement = &self.placements[at.primitive.index()];
        let mut surface = placement.surface(shape, at.element, at.coordinates);
        if primitive.flip_normals {
            surface = surface.flipped();
        }
        if at.instance != SurfaceRef::NO_INSTANCE {
            surface = self.instances[at.instance as usize].surface_in_world(&surface);
        }
        SurfacePoint {
            p: surface.p,
            ng: surface.ng,
            frame: surface.frame,
            uv: surface.uv,
            dp_du: surface.dp_du,
            dp_dv: surface.dp_dv,
            at,
            offset: surface.offset,
        }
    }

    /// [`SurfacePoint::uv`] of a reference.
    #[inline]
    pub fn uv(&self, at: SurfaceRef) -> Vec2 {
        let (shape, placement) = self.placed(at.primitive);
        placement.uv(shape, at.element, at.coordinates)
    }

    /// Area of a primitive in the world, instances ignored, in m².
    pub fn area(&self, primitive: PrimitiveId) -> f32 {
        self.placements[primitive.index()].area()
    }

    /// A point of the primitive, uniform by area. `None` if its area is 0.
    ///
    /// Under a transform that is no similarity the points of a sphere or cylinder are only nearly uniform; `pdf_area` is
    /// always the density with which they are drawn.
    pub fn sample_area(&self, primitive: PrimitiveId, u: Vec2) -> Option<AreaSample> {
        let (element, coordinates, pdf_area) = self.placements[primitive.index()].sample(u)?;
        let at = SurfaceRef {
            primitive,
            element,
            instance: SurfaceRef::NO_INSTANCE,
            coordinates,
        };
        Some(AreaSample {
            point: self.surface_point(at),
            pdf_area,
        })
    }
}
