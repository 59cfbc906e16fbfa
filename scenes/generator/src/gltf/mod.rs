//! glTF 2.0 scene files.
//!
//! The format says less than the others: coats over diffuse bases become dielectrics of
//! metallic-roughness with the albedo of the coated base, metals follow Schlick's approximation,
//! mixtures are mixed in textures, and film size and path length are missing. Lamps and emitting
//! surfaces are in W/sr and W/(m² sr).

mod buffer;
mod materials;

use crate::build::ball;
use crate::mesh::Mesh;
use crate::png::PngImage;
use crate::pose::Pose;
use crate::rounding::rounded;
use crate::scene::{Camera, MaterialId, MeshId, PlacedShape, Scene, ShapeKind, SpotLight};
use buffer::Buffer;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use materials::MaterialList;
use serde_json::{Value, json};

/// Segments around a sphere, which glTF has only as a mesh.
const SPHERE_SEGMENTS: usize = 64;
/// Steps in 1 to which all numbers are rounded.
const STEPS: f64 = 1e6;

/// A scene as glTF.
#[derive(Clone, Debug)]
pub struct GltfDocument {
    /// The text of `scene.gltf`.
    pub json: String,
    /// The content of `scene.bin`.
    pub binary: Vec<u8>,
    /// The textures, by name.
    pub images: Vec<(String, PngImage)>,
}

/// The files of a scene. Images are referred to as `textures/NAME.png`.
pub fn encode(scene: &Scene) -> GltfDocument {
    let mut builder = Builder {
        scene,
        buffer: Buffer::default(),
        materials: MaterialList::default(),
        meshes: Vec::new(),
        placed: Vec::new(),
    };
    let mut nodes = vec![camera_node(&scene.camera)];
    for (i, spot) in scene.spots.iter().enumerate() {
        nodes.push(spot_node(i, spot));
    }
    for shape in &scene.shapes {
        nodes.push(builder.shape(shape));
    }
    let Builder {
        buffer,
        materials,
        meshes,
        ..
    } = builder;
    let [width, height] = scene.camera.size;
    let mut extensions_used = materials.extensions.clone();
    let mut root = json!({
        "asset": {
            "version": "2.0",
            "generator": "manylight-scenes",
            "copyright": "CC0-1.0",
            "extras": { "title": scene.about.title, "width": width, "height": height },
        },
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "cameras": [camera(&scene.camera)],
        "meshes": meshes,
        "materials": materials.materials,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{ "uri": "scene.bin", "byteLength": buffer.bytes.len() }],
    });
    if !materials.images.is_empty() {
        let uris = materials
            .images
            .iter()
            .map(|(name, _)| json!({ "uri": format!("textures/{name}.png") }));
        root["images"] = uris.collect();
        root["textures"] = (0..materials.images.len())
            .map(|i| json!({ "source": i }))
            .collect();
    }
    if !scene.spots.is_empty() {
        extensions_used.push("KHR_lights_punctual");
        let lights: Vec<Value> = scene.spots.iter().map(spot_light).collect();
        root["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    }
    extensions_used.sort_unstable();
    extensions_used.dedup();
    root["extensionsUsed"] = json!(extensions_used);
    GltfDocument {
        json: format!("{root:#}\n"),
        binary: buffer.bytes,
        images: materials.images,
    }
}

/// A shape with the material and the emission of its surface.
#[derive(Clone, Copy, PartialEq)]
struct Surface {
    kind: ShapeKind,
    material: MaterialId,
    emission: Option<[f64; 3]>,
}

/// Collects meshes and materials at their first use.
struct Builder<'a> {
    scene: &'a Scene,
    buffer: Buffer,
    materials: MaterialList,
    meshes: Vec<Value>,
    /// The surface of each mesh of the file.
    placed: Vec<Surface>,
}

impl Builder<'_> {
    /// The node of a shape.
    fn shape(&mut self, shape: &PlacedShape) -> Value {
        let surface = Surface {
            kind: shape.kind,
            material: shape.material,
            emission: shape.emission,
        };
        let known = self.placed.iter().position(|other| *other == surface);
        let mesh = known.unwrap_or_else(|| self.mesh(surface));
        let mut node = json!({ "name": shape.name, "mesh": mesh });
        push_pose(&mut node, &shape.pose);
        node
    }

    /// Adds the mesh of a surface.
    fn mesh(&mut self, surface: Surface) -> usize {
        let material = self
            .materials
            .add(self.scene, surface.material, surface.emission);
        let (name, key) = match surface.kind {
            ShapeKind::Mesh(MeshId(i)) => (self.scene.meshes[i].0.clone(), i),
            ShapeKind::Rectangle => ("rectangle".to_owned(), self.scene.meshes.len()),
            ShapeKind::Sphere => ("sphere".to_owned(), self.scene.meshes.len() + 1),
        };
        let built;
        let geometry = match surface.kind {
            ShapeKind::Mesh(MeshId(i)) => &self.scene.meshes[i].1,
            ShapeKind::Rectangle => {
                built = rectangle();
                &built
            }
            ShapeKind::Sphere => {
                built = ball(1.0, SPHERE_SEGMENTS);
                &built
            }
        };
        let mut primitive = self.buffer.geometry(key, geometry);
        primitive["material"] = json!(material);
        self.meshes
            .push(json!({ "name": name, "primitives": [primitive] }));
        self.placed.push(surface);
        self.meshes.len() - 1
    }
}

/// The square from -1 to 1 that faces +z.
fn rectangle() -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    Mesh {
        positions: corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
        normals: vec![DVec3::Z; 4],
        uvs: corners
            .map(|(x, y)| DVec2::new(0.5 + 0.5 * x, 0.5 + 0.5 * y))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

fn camera(camera: &Camera) -> Value {
    let aspect = f64::from(camera.size[0]) / f64::from(camera.size[1]);
    let yfov = 2.0 * ((camera.fov_x.to_radians() / 2.0).tan() / aspect).atan();
    json!({
        "type": "perspective",
        "perspective": { "yfov": number(yfov), "aspectRatio": number(aspect), "znear": 0.01 },
    })
}

fn camera_node(camera: &Camera) -> Value {
    let rotation = looking(camera.target - camera.origin);
    json!({
        "name": "camera",
        "camera": 0,
        "translation": vector(camera.origin),
        "rotation": quaternion(rotation),
    })
}

/// The rotation of an object that looks along -z with y up.
fn looking(direction: DVec3) -> DQuat {
    let back = -direction.normalize();
    let up = if back.y.abs() < 0.99 {
        DVec3::Y
    } else {
        DVec3::X
    };
    let right = up.cross(back).normalize();
    DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back))
}

fn spot_node(i: usize, spot: &SpotLight) -> Value {
    json!({
        "name": format!("light_{i}"),
        "translation": vector(spot.origin),
        "rotation": quaternion(looking(spot.target - spot.origin)),
        "extensions": { "KHR_lights_punctual": { "light": i } },
    })
}

/// A spot with the power of the scene's one; see [`SpotLight::smooth_cutoff`].
fn spot_light(spot: &SpotLight) -> Value {
    let strength = spot.intensity.into_iter().fold(0.0, f64::max);
    let scale = if strength > 0.0 {
        strength.recip()
    } else {
        0.0
    };
    json!({
        "type": "spot",
        "color": spot.intensity.map(|v| number(v * scale)),
        "intensity": number(strength),
        "spot": {
            "innerConeAngle": number(spot.beam.to_radians()),
            "outerConeAngle": number(spot.smooth_cutoff().to_radians()),
        },
    })
}

/// The transform of a pose.
fn push_pose(node: &mut Value, pose: &Pose) {
    if pose.position != DVec3::ZERO {
        node["translation"] = vector(pose.position);
    }
    let unscaled = Pose {
        scale: DVec3::ONE,
        ..*pose
    };
    let DAffine3 { matrix3, .. } = unscaled.matrix();
    if matrix3 != DMat3::IDENTITY {
        node["rotation"] = quaternion(DQuat::from_mat3(&matrix3));
    }
    if pose.scale != DVec3::ONE {
        node["scale"] = vector(pose.scale);
    }
}

fn number(x: f64) -> Value {
    json!(rounded(x, STEPS))
}

fn vector(v: DVec3) -> Value {
    v.to_array().map(number).to_vec().into()
}

/// A quaternion with a positive real part, so that the last bit of a matrix does not choose between
/// two signs.
fn quaternion(q: DQuat) -> Value {
    let q = if q.w < 0.0 { -q } else { q };
    q.to_array().map(number).to_vec().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::small_scene;

    fn parsed() -> (Value, GltfDocument) {
        let document = encode(&small_scene());
        (serde_json::from_str(&document.json).unwrap(), document)
    }

    #[test]
    fn nodes_have_the_poses_of_shapes() {
        let (json, document) = parsed();
        let names: Vec<&str> = json["nodes"]
            .as_array()
            .unwrap()
            .iter()
            .map(|n| n["name"].as_str().unwrap())
            .collect();
        assert_eq!(names, ["camera", "light_0", "box", "lamp"]);
        let node = &json["nodes"][2];
        assert_eq!(node["translation"], json!([1.0, 0.0, 0.0]));
        assert_eq!(node["scale"], json!([2.0, 2.0, 2.0]));
        let half = number(std::f64::consts::FRAC_1_SQRT_2);
        assert_eq!(node["rotation"], json!([0.0, half, 0.0, half]));
        assert_eq!(
            json["buffers"][0]["byteLength"],
            json!(document.binary.len())
        );
        assert_eq!(
            json["extensionsUsed"],
            json!([
                "KHR_lights_punctual",
                "KHR_materials_emissive_strength",
                "KHR_materials_specular"
            ])
        );
    }

    #[test]
    fn lights_look_at_their_targets() {
        let spot = &small_scene().spots[0];
        let q = looking(spot.target - spot.origin);
        assert!((q * DVec3::NEG_Z).distance(DVec3::NEG_Y) < 1e-12);
        let light = spot_light(spot);
        assert_eq!(light["intensity"], json!(3.0));
        assert_eq!(light["color"], json!([0.333_333, 0.666_667, 1.0]));
    }

    #[test]
    fn shapes_of_one_mesh_and_material_share_it() {
        let mut scene = small_scene();
        let first = scene.shapes[0].clone();
        scene.place("again", first.kind, Pose::at(0.0, 1.0, 0.0), first.material);
        let json: Value = serde_json::from_str(&encode(&scene).json).unwrap();
        assert_eq!(json["meshes"].as_array().unwrap().len(), 2);
        assert_eq!(json["nodes"][4]["mesh"], json["nodes"][2]["mesh"]);
    }
}
