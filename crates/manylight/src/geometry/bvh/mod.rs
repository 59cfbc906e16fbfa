//! Eight-wide bounding volume hierarchies over triangles and over other objects.
//!
//! * Construction: [`binary`] divides items ([`item_box`], [`split`], [`join_chunks`]) into a
//!   binary tree, which [`reinsert`] improves. [`collapse`] chooses the wide nodes ([`node`]),
//!   [`build`] writes them.
//! * Single rays: [`traverse`] visits the nodes, [`watertight`] tests triangles
//!   ([`triangle_block`]).
//! * Streams of rays: [`stream`] with [`ray_lanes`] and [`beam`].
//! * Packets of up to 64 rays with a common origin: [`packet`] with [`edge_volumes`].
//! * Tiles of up to 64 x 64 segments: [`tile`] with [`shaft`].
//!
//! All kernels are generic over [`simd`](crate::simd) and run in the best instruction set of the
//! machine.

mod beam;
mod binary;
mod build;
mod collapse;
mod edge_volumes;
mod item_box;
mod join_chunks;
mod node;
mod object_bvh;
mod packet;
mod ray_lanes;
mod reinsert;
mod shaft;
mod split;
mod stack;
mod stream;
#[cfg(test)]
mod tests;
mod tile;
mod traverse;
mod triangle_block;
mod triangle_bvh;
mod watertight;

pub(super) use item_box::CornerRows;
pub(super) use object_bvh::ObjectBvh;
pub(super) use shaft::Shaft;
pub(super) use triangle_block::TriangleHit;
pub(super) use triangle_bvh::TriangleBvh;
