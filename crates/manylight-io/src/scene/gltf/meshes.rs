//! Meshes at nodes: shapes, primitives, and groups with instances.

use super::super::description::add;
use super::super::growth::{Bound, Growth};
use super::super::names::set_name;
use super::accessors::{Accessors, QUANTIZED};
use super::deform::{joint_matrices, morph, skin};
use super::emission;
use super::json::Json;
use super::materials::{Materials, material_of};
use super::nodes::{Hierarchy, PlacedNode};
use super::primitives::Geometry;
use super::tangents::{add_tangents, bitangents};
use super::textures::{Textures, VertexInputs, vertex_needs};
use glam::{DMat3, DMat4, DQuat, DVec3};
use manylight::emitters::Emitter;
use manylight::geometry::{Mesh, Shape};
use manylight::ids::{EmitterId, MaterialId, ShapeId};
use manylight::math::{Aabb, Affine3A};
use manylight::scene::{InstanceDesc, PrimitiveDesc, SceneDesc};
use manylight::texture::ColorInput;
use std::collections::HashMap;

/// Number of triangles from which on the copies of a mesh share its memory as instances. Fewer are
/// faster as separate triangles, which lie in one acceleration structure.
const INSTANCED_TRIANGLES: usize = 20_000;
/// Bytes of geometry from the bytes of the buffers.
const BOUND: Bound = Bound {
    ratio: 100,
    always_allowed: 64 << 20,
};

/// A mesh in one of its forms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct MeshKey {
    mesh: usize,
    /// Whether transforms mirror it, so that its corners are in reverse order.
    mirrored: bool,
    /// The path of the node that deforms it.
    deformed_by: Option<usize>,
    /// Bits of the scale of its volumes; those of 1 without volumes.
    scale: u32,
}

/// A primitive as a shape with its material.
#[derive(Clone, Copy, Debug)]
struct Part {
    shape: ShapeId,
    material: MaterialId,
    emitter: Option<EmitterId>,
    triangles: usize,
}

/// The meshes of a scene, made at their first use.
pub(super) struct Meshes<'a, 'b> {
    accessors: Accessors<'a, 'b>,
    variant: Option<usize>,
    materials: Materials,
    parts: HashMap<MeshKey, Vec<Part>>,
    groups: HashMap<MeshKey, usize>,
    uses: HashMap<MeshKey, usize>,
    emitters: HashMap<[u32; 4], EmitterId>,
    growth: Growth,
}

/// The skin or the weights by which a node deforms its mesh.
struct Deformation {
    weights: Vec<f32>,
    joints: Option<Vec<DMat4>>,
}

impl<'a, 'b> Meshes<'a, 'b> {
    pub(super) fn new(accessors: Accessors<'a, 'b>, variant: Option<usize>) -> Self {
        Meshes {
            growth: Growth::new(accessors.buffers.total_bytes(), BOUND),
            accessors,
            variant,
            materials: Materials::default(),
            parts: HashMap::new(),
            groups: HashMap::new(),
            uses: HashMap::new(),
            emitters: HashMap::new(),
        }
    }

    pub(super) fn accessors(&self) -> &Accessors<'a, 'b> {
        &self.accessors
    }

    /// Stores the materials in `desc`, and returns the textures.
    pub(super) fn into_parts(self, desc: &mut SceneDesc) -> Textures {
        desc.media = self.materials.media();
        desc.materials = self.materials.list;
        desc.material_names = self.materials.names;
        self.materials.textures
    }

    /// Counts how often each mesh is placed.
    pub(super) fn count_uses(&mut self, hierarchy: &Hierarchy<'a>) {
        for (index, node) in hierarchy.nodes.iter().enumerate() {
            let Some(mesh) = self.mesh_of(&node.json) else {
                continue;
            };
            for transform in self.transforms(node).unwrap_or_default() {
                let key = self.key(mesh, index, node, &transform);
                *self.uses.entry(key).or_default() += 1;
            }
        }
    }

    /// Adds the mesh of a node.
    pub(super) fn add_node(
        &mut self,
        index: usize,
        hierarchy: &Hierarchy<'a>,
        desc: &mut SceneDesc,
    ) {
        let node = &hierarchy.nodes[index];
        let Some(mesh) = self.mesh_of(&node.json) else {
            return;
        };
        let Some(transforms) = self.transforms(node) else {
            return;
        };
        for transform in transforms {
            let key = self.key(mesh, index, node, &transform);
            if !self.parts.contains_key(&key) {
                let parts = self.build(&key, node, hierarchy, desc);
                self.parts.insert(key, parts);
            }
            self.place(key, (index, node), transform, desc);
        }
    }

    fn mesh_of(&self, node: &Json<'a>) -> Option<usize> {
        node.index("mesh", "meshes", self.accessors.document.meshes.len())
    }

    fn key(&self, mesh: usize, index: usize, node: &PlacedNode<'a>, transform: &DMat4) -> MeshKey {
        let deforms = node.json.has("skin") || node.json.has("weights");
        MeshKey {
            mesh,
            mirrored: !node.json.has("skin") && DMat3::from_mat4(*transform).determinant() < 0.0,
            deformed_by: deforms.then_some(index),
            scale: self.scale(mesh, &node.json, transform).to_bits(),
        }
    }

    /// The scale with which a node places the thickness of volumes, a mean of all directions; 1 for
    /// meshes without volumes.
    fn scale(&self, mesh: usize, node: &Json<'a>, transform: &DMat4) -> f32 {
        let document = self.accessors.document;
        let has_volume = |primitive: &Json<'a>| {
            let material = material_of(primitive, self.variant, document.materials.len());
            let material = material.map(|material| &document.materials[material]);
            material.is_some_and(|json| json.extension("KHR_materials_volume").is_some())
        };
        let primitives = document.meshes[mesh].objects("primitives");
        if node.has("skin") || !primitives.iter().any(has_volume) {
            return 1.0;
        }
        let volume = DMat3::from_mat4(*transform).determinant().abs();
        volume.cbrt() as f32
    }

    /// The transforms with which a node places its mesh: one, or those of EXT_mesh_gpu_instancing.
    fn transforms(&self, node: &PlacedNode<'a>) -> Option<Vec<DMat4>> {
        let Some(extension) = node.json.extension("EXT_mesh_gpu_instancing") else {
            return Some(vec![node.world_from_node]);
        };
        let attributes = extension.member("attributes")?;
        let vectors = |name: &str, default: DVec3| -> Option<Vec<DVec3>> {
            let Some(at) = attributes.get(name) else {
                return Some(vec![default]);
            };
            let values: Vec<[f32; 3]> = self.accessors.floats(&at, "VEC3", QUANTIZED)?;
            Some(
                values
                    .into_iter()
                    .map(|v| DVec3::from(v.map(f64::from)))
                    .collect(),
            )
        };
        let translations = vectors("TRANSLATION", DVec3::ZERO)?;
        let scales = vectors("SCALE", DVec3::ONE)?;
        let rotations: Vec<[f32; 4]> = match attributes.get("ROTATION") {
            Some(at) => self.accessors.floats(&at, "VEC4", QUANTIZED)?,
            None => vec![[0.0, 0.0, 0.0, 1.0]],
        };
        let count = translations.len().max(scales.len()).max(rotations.len());
        let lengths = [translations.len(), scales.len(), rotations.len()];
        if lengths
            .iter()
            .any(|length| *length != count && *length != 1)
        {
            attributes.error(format!("the attributes have different counts: {lengths:?}"));
            return None;
        }
        let at = |i: usize, length: usize| if length == 1 { 0 } else { i };
        let local = |i: usize| {
            let rotation = DQuat::from_array(rotations[at(i, rotations.len())].map(f64::from));
            DMat4::from_scale_rotation_translation(
                scales[at(i, scales.len())],
                if rotation.length() > 1e-6 {
                    rotation.normalize()
                } else {
                    DQuat::IDENTITY
                },
                translations[at(i, translations.len())],
            )
        };
        Some(
            (0..count)
                .map(|i| node.world_from_node * local(i))
                .collect(),
        )
    }

    /// The parts of a mesh.
    fn build(
        &mut self,
        key: &MeshKey,
        node: &PlacedNode<'a>,
        hierarchy: &Hierarchy<'a>,
        desc: &mut SceneDesc,
    ) -> Vec<Part> {
        let mesh = self.accessors.document.meshes[key.mesh].clone();
        let Some(deformation) = self.deformation(&mesh, node, hierarchy) else {
            return Vec::new();
        };
        let primitives = mesh.objects("primitives");
        let mut parts = Vec::new();
        for primitive in &primitives {
            self.add_primitive(primitive, key, &deformation, desc, &mut parts);
        }
        parts
    }

    fn deformation(
        &self,
        mesh: &Json<'a>,
        node: &PlacedNode<'a>,
        hierarchy: &Hierarchy<'a>,
    ) -> Option<Deformation> {
        let weights = match node.json.has("weights") {
            true => node.json.items("weights"),
            false => mesh.items("weights"),
        };
        let weights = weights.iter().map(Json::as_float).collect::<Option<_>>()?;
        let skins = &self.accessors.document.skins;
        let joints = match node.json.index("skin", "skins", skins.len()) {
            Some(skin) => Some(joint_matrices(
                &skins[skin],
                &hierarchy.world,
                &self.accessors,
            )?),
            None => None,
        };
        Some(Deformation { weights, joints })
    }

    /// Adds the parts of one primitive: two if it emits on both sides.
    fn add_primitive(
        &mut self,
        primitive: &Json<'a>,
        key: &MeshKey,
        deformation: &Deformation,
        desc: &mut SceneDesc,
        parts: &mut Vec<Part>,
    ) -> Option<()> {
        let document = self.accessors.document;
        let material = material_of(primitive, self.variant, document.materials.len());
        let needs = vertex_needs(document, material);
        let mut geometry = Geometry::read(primitive, &needs, &self.accessors)?;
        morph(
            &mut geometry,
            primitive,
            &deformation.weights,
            &self.accessors,
        )?;
        if let Some(joints) = &deformation.joints {
            skin(&mut geometry, primitive, joints, &self.accessors)?;
        }
        geometry.drop_unused_vertices();
        let made = self.growth.make(geometry.bytes(), |most, given| {
            format!(
                "the primitives make more than {most} bytes of geometry from {given} bytes of data"
            )
        });
        if let Err(exceeded) = made {
            if let Some(message) = exceeded.message {
                primitive.error(message);
            }
            return None;
        }
        if needs.tangents && geometry.tangents.is_empty() {
            add_tangents(&mut geometry);
        }
        let bitangents = bitangents(&geometry, key.mirrored);
        if key.mirrored {
            geometry.reverse();
        }
        if geometry.triangles.is_empty() {
            return None;
        }
        let others = geometry.uvs.get(1..).unwrap_or_default();
        let vertices = VertexInputs {
            triangles: &geometry.triangles,
            primary: geometry.uvs.first().map_or(0, |(set, _)| *set),
            uvs: others,
            colors: &geometry.colors,
            scale: f32::from_bits(key.scale),
            is_body: needs.body && emission::is_closed(&geometry),
            bitangents: &bitangents,
        };
        let surface = self.materials.material(document, material, &vertices);
        let emitter = surface
            .radiance
            .map(|radiance| self.emitter(radiance, desc));
        let second = emitter.filter(|_| surface.double_sided);
        // The back of a closed opaque surface is not seen.
        let is_seen = !surface.is_opaque || !emission::is_closed(&geometry);
        let back = second
            .filter(|_| is_seen)
            .map(|_| emission::back(&geometry));
        let sides = [(Some(geometry), surface.id), (back, surface.back)];
        for (geometry, material) in sides {
            let Some(geometry) = geometry else {
                continue;
            };
            let triangles = geometry.triangles.len();
            parts.push(Part {
                shape: add(&mut desc.shapes, Shape::Mesh(into_mesh(geometry))),
                material,
                emitter,
                triangles,
            });
        }
        Some(())
    }

    /// The emitter with this radiance.
    fn emitter(&mut self, radiance: ColorInput, desc: &mut SceneDesc) -> EmitterId {
        let entry = self.emitters.entry(emission::key(radiance));
        *entry.or_insert_with(|| add(&mut desc.emitters, Emitter::Area { radiance }))
    }

    /// The name of a node, or else one from its mesh and its place in the scene.
    fn object_name(&self, key: &MeshKey, index: usize, node: &PlacedNode<'a>) -> String {
        if let Some(name) = node.json.string("name").filter(|name| !name.is_empty()) {
            return name.to_owned();
        }
        let mesh = &self.accessors.document.meshes[key.mesh];
        format!("{}_{index}", mesh.string("name").unwrap_or("mesh"))
    }

    /// Places a mesh.
    fn place(
        &mut self,
        key: MeshKey,
        (index, node): (usize, &PlacedNode<'a>),
        transform: DMat4,
        desc: &mut SceneDesc,
    ) {
        let parts = &self.parts[&key];
        let is_skinned = node.json.has("skin");
        let transform = if is_skinned {
            DMat4::IDENTITY
        } else {
            transform
        };
        let affine = Affine3A::from_mat4(transform.as_mat4());
        if !affine.is_finite() {
            node.json.error("the transform to the world is not finite");
            return;
        }
        if is_singular(&affine) {
            node.json
                .warn_once("flat nodes", "meshes with a scale of 0 are ignored");
            return;
        }
        let uses = self.uses.get(&key).copied().unwrap_or(1);
        let triangles: usize = parts.iter().map(|part| part.triangles).sum();
        let has_emitter = parts.iter().any(|part| part.emitter.is_some());
        let name = &self.object_name(&key, index, node);
        if uses == 1 || has_emitter || triangles.saturating_mul(uses) < INSTANCED_TRIANGLES {
            for part in parts {
                let group = part.emitter.and_then(|_| node.light_group());
                let index = desc.primitives.len();
                set_name(&mut desc.primitive_groups, index, group.unwrap_or_default());
                desc.primitives.push(primitive(part, name, affine));
            }
            return;
        }
        let group = *self.groups.entry(key).or_insert_with(|| {
            let placed = |part| primitive(part, name, Affine3A::IDENTITY);
            desc.groups.push(parts.iter().map(placed).collect());
            desc.groups.len() - 1
        });
        desc.instances.push(InstanceDesc {
            name: name.to_owned(),
            group,
            world_from_group: affine,
        });
    }
}

fn primitive(part: &Part, name: &str, world_from_object: Affine3A) -> PrimitiveDesc {
    PrimitiveDesc {
        name: name.to_owned(),
        shape: part.shape,
        world_from_object,
        flip_normals: false,
        material: part.material,
        emitter: part.emitter,
    }
}

fn into_mesh(geometry: Geometry) -> Mesh {
    let uvs = geometry.uvs.into_iter().next();
    Mesh {
        positions: geometry.positions,
        normals: geometry.normals,
        tangents: geometry.tangents,
        uvs: uvs.map(|(_, uvs)| uvs).unwrap_or_default(),
        triangles: geometry.triangles,
    }
}

/// Whether a transform flattens all shapes.
fn is_singular(transform: &Affine3A) -> bool {
    let matrix = glam::Mat3::from(transform.matrix3).as_dmat3();
    let lengths = matrix.x_axis.length() * matrix.y_axis.length() * matrix.z_axis.length();
    let is_flat = matrix.determinant().abs() <= 1e-12 * lengths;
    is_flat || !matrix.inverse().is_finite()
}

/// Bounds of all placed shapes.
pub(super) fn bounds(desc: &SceneDesc) -> Aabb {
    let of_primitive = |primitive: &PrimitiveDesc| match &desc.shapes[primitive.shape.index()] {
        Shape::Mesh(mesh) => mesh.bounds().transformed(&primitive.world_from_object),
        _ => Aabb::EMPTY,
    };
    let of_instance = |instance: &InstanceDesc| {
        let group = desc.groups[instance.group].iter();
        let bounds = group.map(of_primitive).fold(Aabb::EMPTY, |a, b| a.union(b));
        bounds.transformed(&instance.world_from_group)
    };
    let primitives = desc.primitives.iter().map(of_primitive);
    let instances = desc.instances.iter().map(of_instance);
    primitives
        .chain(instances)
        .fold(Aabb::EMPTY, |a, b| a.union(b))
}
