//! The hierarchy of nodes: the transforms from each node to the world.

use super::document::Document;
use super::json::Json;
use glam::{DMat4, DQuat, DVec3};

/// A node of the scene to show.
pub(super) struct PlacedNode<'a> {
    /// Index of the node in the file.
    pub(super) index: usize,
    pub(super) json: Json<'a>,
    pub(super) world_from_node: DMat4,
}

impl PlacedNode<'_> {
    /// The light group that the node names, as programs with light groups write it.
    pub(super) fn light_group(&self) -> Option<&str> {
        let names = ["lightgroup", "light_group"];
        let mut groups = names.iter().filter_map(|name| self.json.extra_text(name));
        groups.find(|group| !group.is_empty())
    }
}

/// The nodes of the default scene, parents before children, and the transforms of all nodes of the
/// file.
pub(super) struct Hierarchy<'a> {
    pub(super) nodes: Vec<PlacedNode<'a>>,
    /// By index of the node; that of nodes outside of the scene is the identity.
    pub(super) world: Vec<DMat4>,
    /// By index of the node: the places of its parent and of itself in `nodes`.
    places: Vec<Option<(Option<usize>, usize)>>,
}

impl<'a> Hierarchy<'a> {
    pub(super) fn new(document: &Document<'a>) -> Self {
        let count = document.nodes.len();
        let mut hierarchy = Hierarchy {
            nodes: Vec::new(),
            world: vec![DMat4::IDENTITY; count],
            places: vec![None; count],
        };
        let mut visited = vec![false; count];
        // A stack, not recursion: hierarchies may be deep. Reversed, so that nodes come in the
        // order of the file.
        let mut stack: Vec<(usize, Option<usize>, DMat4, Json<'a>)> = Vec::new();
        let push =
            |stack: &mut Vec<_>, items: Vec<Json<'a>>, above: Option<usize>, parent: DMat4| {
                for item in items.into_iter().rev() {
                    if let Some(node) = item.as_index("nodes", count) {
                        stack.push((node, above, parent, item));
                    }
                }
            };
        push(&mut stack, roots(document), None, DMat4::IDENTITY);
        while let Some((index, above, parent, reference)) = stack.pop() {
            if std::mem::replace(&mut visited[index], true) {
                reference.error(format!(
                    "node {index} is reached twice, but a hierarchy of nodes has neither cycles nor nodes with two parents"
                ));
                break;
            }
            let json = &document.nodes[index];
            let Some(local) = local_transform(json) else {
                continue;
            };
            let world_from_node = parent * local;
            hierarchy.world[index] = world_from_node;
            let place = hierarchy.nodes.len();
            hierarchy.places[index] = Some((above, place));
            push(
                &mut stack,
                json.items("children"),
                Some(place),
                world_from_node,
            );
            hierarchy.nodes.push(PlacedNode {
                index,
                json: json.clone(),
                world_from_node,
            });
        }
        hierarchy
    }

    /// The nodes from a root to a node, with their indices; none if it is not in the scene.
    pub(super) fn chain(&self, node: usize) -> Vec<(usize, &Json<'a>)> {
        let mut chain = Vec::new();
        let mut place = self.places[node].map(|(_, place)| place);
        while let Some(at) = place {
            let PlacedNode { index, json, .. } = &self.nodes[at];
            chain.push((*index, json));
            place = self.places[*index].and_then(|(above, _)| above);
        }
        chain.reverse();
        chain
    }

    /// By index of the node: whether it is one of `wanted`, or above one.
    pub(super) fn above(&self, wanted: impl Fn(&PlacedNode<'a>) -> bool) -> Vec<bool> {
        let mut above = vec![false; self.world.len()];
        // Children come after their parents.
        for node in self.nodes.iter().rev() {
            above[node.index] |= wanted(node);
            if above[node.index]
                && let Some((Some(parent), _)) = self.places[node.index]
            {
                above[self.nodes[parent].index] = true;
            }
        }
        above
    }
}

/// The root nodes of the default scene. A file without scenes shows all nodes that are no children.
fn roots<'a>(document: &Document<'a>) -> Vec<Json<'a>> {
    let root = &document.root;
    let index = match root.has("scene") {
        true => root.index("scene", "scenes", document.scenes.len()),
        false => (!document.scenes.is_empty()).then_some(0),
    };
    match index {
        Some(index) => document.scenes[index].items("nodes"),
        None => {
            if !root.has("scene") {
                root.error("the file has no scene");
            }
            Vec::new()
        }
    }
}

/// The transform from a node to its parent; `None` if it is invalid, which has been reported.
pub(super) fn local_transform(json: &Json<'_>) -> Option<DMat4> {
    if json.has("matrix") {
        let matrix = DMat4::from_cols_array(&json.numbers("matrix")?);
        let last = matrix.row(3).to_array();
        if last != [0.0, 0.0, 0.0, 1.0] {
            json.error_at(
                "matrix",
                format!("found the last row {last:?}, expected 0, 0, 0, 1"),
            );
            return None;
        }
        return Some(matrix);
    }
    let vector = |name: &str, default: [f64; 3]| match json.has(name) {
        true => json.numbers(name).map(DVec3::from),
        false => Some(DVec3::from(default)),
    };
    let translation = vector("translation", [0.0; 3])?;
    let scale = vector("scale", [1.0; 3])?;
    let rotation = match json.has("rotation") {
        true => DQuat::from_array(json.numbers("rotation")?),
        false => DQuat::IDENTITY,
    };
    if rotation.length() < 1e-6 {
        json.error_at("rotation", "the quaternion is zero");
        return None;
    }
    let rotation = rotation.normalize();
    Some(DMat4::from_scale_rotation_translation(
        scale,
        rotation,
        translation,
    ))
}
