//! The surfaces of one space: the world, or a group of instanced primitives.

use super::Primitive;
use super::placement::{PlacedInstance, PlacedShape, TriangleTable};
use super::surface_set::{SurfaceSet, SurfaceSetBuilder};
use crate::ids::PrimitiveId;
use crate::math::Aabb;
use std::ops::Range;

/// How a surface affects visibility.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SurfaceClass {
    /// Blocks every segment.
    Opaque,
    /// May let light pass straight through: [`Primitive::transparent`].
    Transparent,
}

/// All surfaces of one space, with one hierarchy per class: visibility among opaque surfaces never
/// visits transparent ones.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) opaque: SurfaceSet,
    pub(super) transparent: SurfaceSet,
}

/// World-space bounds of the surfaces in an instance, by class.
pub(super) struct InstanceBounds {
    opaque: Aabb,
    transparent: Aabb,
}

impl InstanceBounds {
    pub(super) fn new(instance: &PlacedInstance, group: &Level) -> Self {
        InstanceBounds {
            opaque: instance.bounds(group.opaque.bounds()),
            transparent: instance.bounds(group.transparent.bounds()),
        }
    }
}

impl Level {
    /// Builds the hierarchies over the primitives in `range` and over all `instances`. `placements`
    /// has one element per primitive.
    pub(super) fn build(
        primitives: &[Primitive],
        placements: &[PlacedShape],
        table: &TriangleTable,
        range: Range<usize>,
        instances: &[InstanceBounds],
    ) -> Self {
        let build = |class: SurfaceClass| {
            let mut builder = SurfaceSetBuilder::default();
            for i in range.clone() {
                let Primitive {
                    transparent,
                    invisible,
                    ..
                } = primitives[i];
                if !invisible && transparent == (class == SurfaceClass::Transparent) {
                    builder.add_primitive(PrimitiveId::from(i), &placements[i]);
                }
            }
            for (index, bounds) in instances.iter().enumerate() {
                builder.add_instance(
                    index,
                    match class {
                        SurfaceClass::Opaque => bounds.opaque,
                        SurfaceClass::Transparent => bounds.transparent,
                    },
                );
            }
            builder.build(table)
        };
        Level {
            opaque: build(SurfaceClass::Opaque),
            transparent: build(SurfaceClass::Transparent),
        }
    }

    pub(super) fn surfaces(&self, class: SurfaceClass) -> &SurfaceSet {
        match class {
            SurfaceClass::Opaque => &self.opaque,
            SurfaceClass::Transparent => &self.transparent,
        }
    }
}
