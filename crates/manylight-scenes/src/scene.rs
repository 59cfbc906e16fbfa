//! A scene as plain data, whatever the format that it will be written in.

use crate::material::{Material, Rgb};
use crate::mesh::Mesh;
use crate::picture::Picture;
use crate::pose::Pose;
use glam::DVec3;

/// Everything that one picture needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name of the scene, and one paragraph for each string about what it shows.
    pub about: About,
    /// Where it is seen from.
    pub camera: Camera,
    /// Materials by name.
    pub materials: Vec<(String, Material)>,
    /// Meshes by name; several shapes may share one.
    pub meshes: Vec<(String, Mesh)>,
    /// Pictures by name.
    pub pictures: Vec<(&'static str, Picture)>,
    /// What stands in it, in order.
    pub shapes: Vec<Shape>,
    /// Lights that are no shapes.
    pub spots: Vec<Spot>,
}

/// The words at the head of a scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct About {
    /// Name, as in a sentence.
    pub title: &'static str,
    /// Paragraphs.
    pub text: Vec<String>,
}

/// A pinhole camera, its film, and how long its paths may be.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub origin: DVec3,
    /// What is in the middle of the picture.
    pub target: DVec3,
    /// Angle of view across the picture's width, in degrees.
    pub fov_x: f64,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Edges of the longest path.
    pub max_depth: u32,
}

/// Index of a material of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MaterialId(pub usize);

/// Index of a mesh of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshId(pub usize);

/// A placed surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Unlike that of any other shape.
    pub name: String,
    /// Surface in its own space.
    pub geometry: Geometry,
    /// Where it stands.
    pub pose: Pose,
    /// What it is made of.
    pub material: MaterialId,
    /// Radiance that it emits on its outer side.
    pub emission: Option<Rgb>,
}

/// The surface of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// A mesh of the scene.
    Mesh(MeshId),
    /// From -1 to 1 in x and y, facing z.
    Rectangle,
    /// Radius 1 about the origin.
    Sphere,
}

/// A cone of light from a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// Where from.
    pub origin: DVec3,
    /// A point on its axis.
    pub target: DVec3,
    /// Radiant intensity on the axis.
    pub intensity: Rgb,
    /// Half angle of the cone, in degrees.
    pub cutoff: f64,
    /// Half angle within which it is at its full intensity, in degrees.
    pub beam: f64,
}

impl Scene {
    /// An empty scene.
    pub fn new(about: About, camera: Camera) -> Scene {
        Scene {
            about,
            camera,
            materials: Vec::new(),
            meshes: Vec::new(),
            pictures: Vec::new(),
            shapes: Vec::new(),
            spots: Vec::new(),
        }
    }

    /// Adds a material.
    pub fn material(&mut self, name: &str, material: Material) -> MaterialId {
        self.materials.push((name.to_owned(), material));
        MaterialId(self.materials.len() - 1)
    }

    /// Adds a mesh without placing it.
    pub fn mesh(&mut self, name: &str, mesh: Mesh) -> MeshId {
        self.meshes.push((name.to_owned(), mesh));
        MeshId(self.meshes.len() - 1)
    }

    /// Adds a picture.
    pub fn picture(&mut self, name: &'static str, picture: Picture) {
        self.pictures.push((name, picture));
    }

    /// Places a surface.
    pub fn place(&mut self, name: &str, geometry: Geometry, pose: Pose, material: MaterialId) {
        self.shapes.push(Shape {
            name: name.to_owned(),
            geometry,
            pose,
            material,
            emission: None,
        });
    }

    /// Adds a mesh and places it as it is.
    pub fn add(&mut self, name: &str, mesh: Mesh, material: MaterialId) {
        let id = self.mesh(name, mesh);
        self.place(name, Geometry::Mesh(id), Pose::identity(), material);
    }

    /// Places one mesh in many poses; the shapes' names are numbered.
    pub fn place_all(&mut self, name: &str, mesh: MeshId, poses: &[Pose], material: MaterialId) {
        for (i, &pose) in poses.iter().enumerate() {
            self.place(&format!("{name}_{i}"), Geometry::Mesh(mesh), pose, material);
        }
    }

    /// Places a batch in many poses; its meshes are shared.
    pub fn place_batch(&mut self, name: &str, batch: &Batch, poses: &[Pose]) {
        for (material, mesh) in self.batch_meshes(name, batch) {
            let part = self.meshes[mesh.0].0.clone();
            self.place_all(&part, mesh, poses, material);
        }
    }

    /// Lets the shape that was placed last emit light.
    pub fn emitting(&mut self, radiance: Rgb) {
        if let Some(shape) = self.shapes.last_mut() {
            shape.emission = Some(radiance);
        }
    }

    /// Adds each material's meshes of a batch as one without placing it.
    pub fn batch_meshes(&mut self, name: &str, batch: &Batch) -> Vec<(MaterialId, MeshId)> {
        let name_of = |scene: &Scene, id: MaterialId| format!("{name}_{}", scene.materials[id.0].0);
        batch
            .parts
            .iter()
            .map(|(material, mesh)| {
                (
                    *material,
                    self.mesh(&name_of(self, *material), mesh.clone()),
                )
            })
            .collect()
    }

    /// Adds each material's meshes of a batch as one, and places them as they are.
    pub fn add_batch(&mut self, name: &str, batch: Batch) {
        for (material, mesh) in batch.parts {
            let of = self.materials[material.0].0.clone();
            self.add(&format!("{name}_{of}"), mesh, material);
        }
    }

    /// Triangles of all shapes, each counted as often as it is placed. Shapes without a mesh do not count.
    pub fn triangles(&self) -> usize {
        self.shapes
            .iter()
            .map(|shape| match shape.geometry {
                Geometry::Mesh(MeshId(i)) => self.meshes[i].1.triangles.len(),
                _ => 0,
            })
            .sum()
    }
}

/// Meshes gathered by material, so that a thing of many parts becomes few shapes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    parts: Vec<(MaterialId, Mesh)>,
}

impl Batch {
    /// Adds a part.
    pub fn add(&mut self, material: MaterialId, mesh: &Mesh) {
        match self.parts.iter_mut().find(|part| part.0 == material) {
            Some(part) => part.1.append(mesh),
            None => self.parts.push((material, mesh.clone())),
        }
    }

    /// Adds all parts of another batch, moved to a pose.
    pub fn add_placed(&mut self, other: &Batch, pose: Pose) {
        for (material, mesh) in &other.parts {
            self.add(*material, &mesh.placed(pose));
        }
    }
}
