//! A scene as plain data, independent of the file format.

use crate::material::{LinearRgb, Material};
use crate::mesh::Mesh;
use crate::png::PngImage;
use crate::pose::Pose;
use glam::DVec3;

/// Everything that one image needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Title and description.
    pub about: About,
    /// Camera, film and path length.
    pub camera: Camera,
    /// Materials by name.
    pub materials: Vec<(String, Material)>,
    /// Meshes by name. Several shapes may share a mesh.
    pub meshes: Vec<(String, Mesh)>,
    /// Textures by name.
    pub textures: Vec<(&'static str, PngImage)>,
    /// Shapes in the order of the scene file.
    pub shapes: Vec<PlacedShape>,
    /// Spot lights. Area lights are shapes with emission.
    pub spots: Vec<SpotLight>,
}

/// The comment at the head of a scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct About {
    /// Title, without a full stop.
    pub title: &'static str,
    /// Paragraphs of the description.
    pub text: Vec<String>,
}

/// A pinhole camera with y up, its film and the longest path.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Position.
    pub origin: DVec3,
    /// Point in the middle of the image.
    pub target: DVec3,
    /// Horizontal field of view in degrees.
    pub fov_x: f64,
    /// Width and height of the image in pixels.
    pub size: [u32; 2],
    /// Number of edges of the longest path.
    pub max_depth: u32,
}

/// Index into [`Scene::materials`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MaterialId(pub usize);

/// Index into [`Scene::meshes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshId(pub usize);

/// A shape with its pose, material and emission.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedShape {
    /// Name, unique in the scene.
    pub name: String,
    /// Shape in object space.
    pub kind: ShapeKind,
    /// Transform from object space to the scene.
    pub pose: Pose,
    /// Material.
    pub material: MaterialId,
    /// Emitted radiance on the outer side.
    pub emission: Option<LinearRgb>,
}

/// A shape in object space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeKind {
    /// A mesh of the scene.
    Mesh(MeshId),
    /// The square from -1 to 1 in x and y, facing +z.
    Rectangle,
    /// The unit sphere about the origin.
    Sphere,
}

/// A point light that emits into a cone.
#[derive(Clone, Debug, PartialEq)]
pub struct SpotLight {
    /// Position.
    pub origin: DVec3,
    /// A point on the axis of the cone.
    pub target: DVec3,
    /// Radiant intensity on the axis.
    pub intensity: LinearRgb,
    /// Half angle of the cone in degrees.
    pub cutoff: f64,
    /// Half angle, in degrees, up to which the intensity is constant.
    pub beam: f64,
}

impl SpotLight {
    /// The cutoff in degrees with which a falloff that is point-symmetric in the cosine, as in PBRT
    /// and Blender, gives the power of Mitsuba's falloff, which is linear in the angle. The beam
    /// stays the same.
    pub fn smooth_cutoff(&self) -> f64 {
        let (beam, cutoff) = (self.beam.to_radians(), self.cutoff.to_radians());
        if cutoff - beam < 1e-6 {
            return self.cutoff;
        }
        let mean_cos = (cutoff.sin() - beam.sin()) / (cutoff - beam);
        (2.0 * mean_cos - beam.cos()).acos().to_degrees()
    }
}

impl Scene {
    /// An empty scene.
    pub fn new(about: About, camera: Camera) -> Scene {
        Scene {
            about,
            camera,
            materials: Vec::new(),
            meshes: Vec::new(),
            textures: Vec::new(),
            shapes: Vec::new(),
            spots: Vec::new(),
        }
    }

    /// Adds a material.
    pub fn add_material(&mut self, name: &str, material: Material) -> MaterialId {
        self.materials.push((name.to_owned(), material));
        MaterialId(self.materials.len() - 1)
    }

    /// Adds a mesh without placing it.
    pub fn add_mesh(&mut self, name: &str, mesh: Mesh) -> MeshId {
        self.meshes.push((name.to_owned(), mesh));
        MeshId(self.meshes.len() - 1)
    }

    /// Adds a texture.
    pub fn add_texture(&mut self, name: &'static str, image: PngImage) {
        self.textures.push((name, image));
    }

    /// Adds the meshes of an assembly, named `NAME_MATERIAL`, without placing them.
    pub fn add_meshes(&mut self, name: &str, assembly: Assembly) -> Vec<(MaterialId, MeshId)> {
        let mut added = Vec::new();
        for (material, mesh) in assembly.parts {
            let name = format!("{name}_{}", self.materials[material.0].0);
            added.push((material, self.add_mesh(&name, mesh)));
        }
        added
    }

    /// Places a shape that does not emit.
    pub fn place(&mut self, name: &str, kind: ShapeKind, pose: Pose, material: MaterialId) {
        self.shapes.push(PlacedShape {
            name: name.to_owned(),
            kind,
            pose,
            material,
            emission: None,
        });
    }

    /// Places a shape that emits `radiance` on its outer side.
    pub fn place_emitter(
        &mut self,
        name: &str,
        kind: ShapeKind,
        pose: Pose,
        material: MaterialId,
        radiance: LinearRgb,
    ) {
        self.shapes.push(PlacedShape {
            name: name.to_owned(),
            kind,
            pose,
            material,
            emission: Some(radiance),
        });
    }

    /// Adds a mesh and places it without a transform.
    pub fn place_mesh(&mut self, name: &str, mesh: Mesh, material: MaterialId) {
        let id = self.add_mesh(name, mesh);
        self.place(name, ShapeKind::Mesh(id), Pose::identity(), material);
    }

    /// Adds the meshes of an assembly, named `NAME_MATERIAL`, and places each without a transform.
    pub fn place_assembly(&mut self, name: &str, assembly: Assembly) {
        for (material, mesh) in assembly.parts {
            let name = format!("{name}_{}", self.materials[material.0].0);
            self.place_mesh(&name, mesh, material);
        }
    }

    /// Adds the meshes of an assembly and places each in every pose, named `NAME_MATERIAL_INDEX`.
    pub fn place_copies(&mut self, name: &str, assembly: Assembly, poses: &[Pose]) {
        for (material, mesh) in self.add_meshes(name, assembly) {
            let name = self.meshes[mesh.0].0.clone();
            for (i, &pose) in poses.iter().enumerate() {
                self.place(
                    &format!("{name}_{i}"),
                    ShapeKind::Mesh(mesh),
                    pose,
                    material,
                );
            }
        }
    }

    /// Number of triangles of all mesh shapes; a shared mesh counts once for each shape.
    pub fn triangle_count(&self) -> usize {
        self.shapes
            .iter()
            .map(|shape| match shape.kind {
                ShapeKind::Mesh(MeshId(i)) => self.meshes[i].1.triangles.len(),
                ShapeKind::Rectangle | ShapeKind::Sphere => 0,
            })
            .sum()
    }
}

/// Parts of an object, merged into one mesh for each material so that the object becomes few
/// shapes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assembly {
    parts: Vec<(MaterialId, Mesh)>,
}

impl Assembly {
    /// Adds a part.
    pub fn add(&mut self, material: MaterialId, mesh: &Mesh) {
        match self.parts.iter_mut().find(|part| part.0 == material) {
            Some(part) => part.1.append(mesh),
            None => self.parts.push((material, mesh.clone())),
        }
    }

    /// Adds all parts of another assembly, transformed by `pose`.
    pub fn add_placed(&mut self, other: &Assembly, pose: Pose) {
        for (material, mesh) in &other.parts {
            self.add(*material, &mesh.placed(pose));
        }
    }

    /// The assembly, transformed by `pose`.
    pub fn placed(&self, pose: Pose) -> Assembly {
        let mut placed = Assembly::default();
        placed.add_placed(self, pose);
        placed
    }
}
