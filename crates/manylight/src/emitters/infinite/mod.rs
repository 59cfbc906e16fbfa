//! Infinite lights: parallel light, constant environments, environment maps.

mod bounding_sphere;
mod environment;
mod environment_tiles;
mod guide_tree;
mod guides;
mod light;
mod lights;
mod prepass;

pub(super) use bounding_sphere::BoundingSphere;
#[cfg(test)]
pub(super) use environment::EnvironmentSampler;
pub(super) use guides::InfiniteLightGuides;
pub(super) use lights::{
    ENVIRONMENT, InfiniteEmissionNumbers, InfiniteLightSamples, InfiniteLights,
};
pub(super) use prepass::GuidingPrepass;
