//! The virtual lights with what the sums over them need.

use super::points::LightCylinder;
use crate::ids::LightId;
use crate::light_tree::LightTree;
use crate::virtual_lights::{SurfaceLocation, VirtualLights};

/// The virtual lights with what the sums over them need.
#[derive(Debug)]
pub struct LightIndex<'s> {
    /// The lights.
    pub set: VirtualLights<'s>,
    /// Bounds of the points of each light.
    pub(super) cylinders: Vec<LightCylinder>,
    /// For cuts.
    pub(super) tree: Option<LightTree>,
    /// Number of light groups; 0 if they are not told apart.
    pub(super) groups: usize,
}

/// The representation of light from some surface location.
#[derive(Clone, Copy, Debug)]
pub enum Assignment {
    /// By this light.
    Light(LightId),
    /// By no light: photons there become lights of one photon.
    Unassigned {
        /// Surface area that each of them represents, in m².
        area: f32,
    },
}

impl<'s> LightIndex<'s> {
    /// Prepares lights for sums over all of them.
    pub fn new(set: VirtualLights<'s>) -> Self {
        let cylinders = set.lights().iter().map(LightCylinder::of).collect();
        LightIndex {
            set,
            cylinders,
            tree: None,
            groups: 0,
        }
    }

    /// The same lights, of which `groups` light groups are told apart; 0 for none. Without a tree
    /// yet.
    pub fn of_groups(self, groups: usize) -> Self {
        LightIndex { groups, ..self }
    }

    /// Adds a tree over all lights, for cuts. Its clusters do not mix the groups.
    pub fn with_tree(self) -> Self {
        let tree = LightTree::of_groups(&self.set, self.groups);
        LightIndex {
            tree: Some(tree),
            ..self
        }
    }

    /// Adds a tree that bounds single lights as well, for product cuts.
    pub fn with_tree_of_bounded_lights(self) -> Self {
        let mut index = self.with_tree();
        if let Some(tree) = &mut index.tree {
            tree.bound_lights(&index.set);
        }
        index
    }

    /// The representation of light from `y`, where photons are assigned to `light`.
    pub fn assignment(&self, light: Option<LightId>, y: &SurfaceLocation) -> Assignment {
        match light {
            Some(id) => Assignment::Light(id),
            None => Assignment::Unassigned {
                area: self.set.unassigned_area(y.p),
            },
        }
    }
}
