//! Elements of the emitters with a position: primitives, triangles of larger meshes, points and
//! spots.
//!
//! An element is the unit among which [`super::emitter_tree`] chooses, and which is sampled as a
//! whole.

mod element;
mod from_receivers;
mod list;
mod of_primitive;
mod planar;
mod power;
mod sampling;
mod sphere;
mod visible_point;

pub(super) use element::{ElementBounds, EmitterElement};
pub(super) use from_receivers::EmittingScene;
pub(super) use list::ElementList;
#[cfg(test)]
pub(super) use power::point_power;
