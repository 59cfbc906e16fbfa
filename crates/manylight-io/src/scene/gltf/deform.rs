//! Morph targets and skins, in the pose of the file.

use super::accessors::{Accessors, Allowed, Component, FLOAT, UNIT};
use super::json::Json;
use super::primitives::{Geometry, morph_differences};
use glam::{DMat4, DVec3};
use manylight::math::Vec3;

/// Joint indices.
const JOINTS: Allowed = Allowed {
    components: &[Component::U8, Component::U16],
    normalized: false,
};

/// Adds the weighted morph targets of a primitive.
pub(super) fn morph<'a>(
    geometry: &mut Geometry,
    json: &Json<'a>,
    weights: &[f32],
    accessors: &Accessors<'a, '_>,
) -> Option<()> {
    for (target, weight) in json.objects("targets").iter().zip(weights) {
        if *weight == 0.0 {
            continue;
        }
        for (name, normals) in [("POSITION", false), ("NORMAL", true)] {
            let Some(at) = target.get(name) else { continue };
            let differences = morph_differences(&at, accessors)?;
            geometry.check_count(&at, differences.len())?;
            let values = match normals {
                true => &mut geometry.normals,
                false => &mut geometry.positions,
            };
            for (value, difference) in values.iter_mut().zip(differences) {
                *value += Vec3::from(difference) * *weight;
            }
        }
    }
    for normal in &mut geometry.normals {
        *normal = normal.normalize_or(Vec3::Z);
    }
    Some(())
}

/// The matrices of the joints of a skin, from the space of the mesh to the world. `world` has the
/// transforms of all nodes.
pub(super) fn joint_matrices<'a>(
    skin: &Json<'a>,
    world: &[DMat4],
    accessors: &Accessors<'a, '_>,
) -> Option<Vec<DMat4>> {
    let nodes: Option<Vec<usize>> = skin
        .items("joints")
        .iter()
        .map(|joint| joint.as_index("nodes", world.len()))
        .collect();
    let nodes = nodes?;
    if nodes.is_empty() {
        skin.error("the array `joints` is missing or empty");
        return None;
    }
    let inverses = match skin.get("inverseBindMatrices") {
        None => vec![DMat4::IDENTITY; nodes.len()],
        Some(at) => {
            let matrices: Vec<[f32; 16]> = accessors.floats(&at, "MAT4", FLOAT)?;
            if matrices.len() < nodes.len() {
                at.error(format!(
                    "the accessor has {} matrices for {} joints",
                    matrices.len(),
                    nodes.len()
                ));
                return None;
            }
            let matrix = |m: &[f32; 16]| DMat4::from_cols_array(&m.map(f64::from));
            matrices.iter().map(matrix).collect()
        }
    };
    let pairs = nodes.into_iter().zip(inverses);
    Some(pairs.map(|(node, inverse)| world[node] * inverse).collect())
}

/// Moves the vertices of a primitive to the world by the joints of its skin.
pub(super) fn skin<'a>(
    geometry: &mut Geometry,
    json: &Json<'a>,
    joints: &[DMat4],
    accessors: &Accessors<'a, '_>,
) -> Option<()> {
    let attributes = json.member("attributes")?;
    let mut sums = vec![(DMat4::ZERO, 0.0_f64); geometry.positions.len()];
    for set in 0.. {
        let (Some(at), Some(weights_at)) = (
            attributes.get(&format!("JOINTS_{set}")),
            attributes.get(&format!("WEIGHTS_{set}")),
        ) else {
            break;
        };
        let indices: Vec<[u32; 4]> = accessors.integers(&at, "VEC4", JOINTS)?;
        let weights: Vec<[f32; 4]> = accessors.floats(&weights_at, "VEC4", UNIT)?;
        geometry.check_count(&at, indices.len())?;
        geometry.check_count(&weights_at, weights.len())?;
        for ((sum, indices), weights) in sums.iter_mut().zip(indices).zip(weights) {
            for (joint, weight) in indices.into_iter().zip(weights) {
                if weight == 0.0 {
                    continue;
                }
                let Some(matrix) = joints.get(joint as usize) else {
                    at.error(format!(
                        "found joint {joint}, but the skin has {}",
                        joints.len()
                    ));
                    return None;
                };
                sum.0 += *matrix * f64::from(weight);
                sum.1 += f64::from(weight);
            }
        }
    }
    geometry.transform_vertices(|vertex| match sums[vertex] {
        (sum, total) if total > 0.0 => sum * total.recip(),
        _ => joints[0],
    });
    Some(())
}

impl Geometry {
    /// Transforms each vertex by its own matrix.
    pub(super) fn transform_vertices(&mut self, matrix: impl Fn(usize) -> DMat4) {
        for i in 0..self.positions.len() {
            let matrix = matrix(i);
            let position = self.positions[i].as_dvec3();
            self.positions[i] = matrix.transform_point3(position).as_vec3();
            if let Some(tangent) = self.tangents.get_mut(i) {
                let along = matrix.transform_vector3(tangent.as_dvec3());
                *tangent = along.normalize_or(DVec3::X).as_vec3();
            }
            if let Some(normal) = self.normals.get_mut(i) {
                // Cofactors map normals also where the inverse does not exist.
                let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|c| c.truncate());
                let [x, y, z] = columns;
                let n = normal.as_dvec3();
                let mapped = y.cross(z) * n.x + z.cross(x) * n.y + x.cross(y) * n.z;
                *normal = mapped.normalize_or(n).as_vec3();
            }
        }
    }
}
