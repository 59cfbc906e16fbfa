//! The hierarchy of nodes: the transforms from each node to the world.

use super::document::Document;
use super::json::Json;
use glam::{DMat4, DQuat, DVec3};

/// A node of the scene to show.
pub(super) struct PlacedNode<'a> {
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
}

impl<'a> Hierarchy<'a> {
    pub(super) fn new(document: &Document<'a>) -> Self {
        let count = document.nodes.len();
        let mut hierarchy = Hierarchy {
            nodes: Vec::new(),
            world: vec![DMat4::IDENTITY; count],
        };
        let mut visited = vec![false; count];
        // A stack, not recursion: hierarchies may be deep. Reversed, so that nodes come in the
        // order of the file.
        let mut stack: Vec<(usize, DMat4, Json<'a>)> = Vec::new();
        let push = |stack: &mut Vec<_>, items: Vec<Json<'a>>, parent: DMat4| {
            for item in items.into_iter().rev() {
                if let Some(node) = item.as_index("nodes", count) {
                    stack.push((node, parent, item));
                }
            }
        };
        push(&mut stack, roots(document), DMat4::IDENTITY);
        while let Some((index, parent, reference)) = stack.pop() {
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
            push(&mut stack, json.items("children"), world_from_node);
            hierarchy.nodes.push(PlacedNode {
                json: json.clone(),
                world_from_node,
            });
        }
        hierarchy
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
fn local_transform(json: &Json<'_>) -> Option<DMat4> {
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
