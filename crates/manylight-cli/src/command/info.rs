//! `manylight info`.

use crate::args::InfoArgs;
use crate::failure::{DONE, Failure};
use crate::names::filter_name;
use crate::output::{human_bytes, human_count, print_data, print_text, print_warnings};
use manylight::film::{Film, Layer};
use manylight::geometry::Shape;
use manylight::math::Aabb;
use manylight::scene::{PrimitiveDesc, Scene, SceneDesc};
use manylight::sensors::{SensorDesc, SensorKind};
use manylight::texture::Texture;
use serde::Serialize;
use serde_json::{Value, json};

/// Version of the shape of the JSON object.
const SCHEMA: &str = "manylight.info/1";

/// Describes a scene.
pub(crate) fn run(args: &InfoArgs) -> Result<u8, Failure> {
    let options = args.gltf.load_options(&args.defines);
    let loaded = manylight_io::load_scene(&args.scene, &options)?;
    let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    print_warnings(&warnings);
    let counts = Counts::new(&loaded.desc);
    let sensors: Vec<Value> = loaded.desc.sensors.iter().map(sensor).collect();
    let memory = Memory::new(&loaded.desc);
    let limits = loaded.desc.limits;
    // Building the scene checks it and computes its bounds.
    let scene = Scene::build(loaded.desc, 0).map_err(|error| Failure::Scene {
        scene: args.scene.clone(),
        message: error.message,
    })?;
    let bounds = scene.geometry.bounds();
    if !args.json {
        print_text(&describe(&counts, bounds, &sensors, &memory))?;
        return Ok(DONE);
    }
    print_data(json!({
        "schema": SCHEMA,
        "version": env!("CARGO_PKG_VERSION"),
        "scene": args.scene.display().to_string(),
        "counts": counts,
        "bounds": corners(bounds),
        "sensors": sensors,
        "limits": {
            "max_depth": limits.max_depth.map_or(json!(-1), Value::from),
            "rr_depth": limits.rr_depth,
            "hide_emitters": limits.hide_emitters,
        },
        "memory_estimate": memory,
        "warnings": warnings,
    }))?;
    Ok(DONE)
}

/// Numbers of the parts of a scene.
#[derive(Debug, Default, PartialEq, Serialize)]
struct Counts {
    /// Triangles, with each group counted once.
    triangles: usize,
    /// Triangles, with each group counted once per instance.
    triangles_with_instances: usize,
    shapes: usize,
    primitives: usize,
    groups: usize,
    instances: usize,
    materials: usize,
    textures: usize,
    emitters: usize,
    /// Primitives with an emitter.
    emitting_primitives: usize,
}

impl Counts {
    fn new(desc: &SceneDesc) -> Self {
        let primitives = || desc.primitives.iter().chain(desc.groups.iter().flatten());
        let triangles = |placed: &[PrimitiveDesc]| -> usize {
            placed
                .iter()
                .map(|p| triangles(&desc.shapes[p.shape.index()]))
                .sum()
        };
        let direct = triangles(&desc.primitives);
        let copies = desc
            .instances
            .iter()
            .map(|i| triangles(&desc.groups[i.group]));
        Counts {
            triangles: direct
                + desc
                    .groups
                    .iter()
                    .map(|group| triangles(group))
                    .sum::<usize>(),
            triangles_with_instances: direct + copies.sum::<usize>(),
            shapes: desc.shapes.len(),
            primitives: primitives().count(),
            groups: desc.groups.len(),
            instances: desc.instances.len(),
            materials: desc.materials.len(),
            textures: desc.textures.len(),
            emitters: desc.emitters.len(),
            emitting_primitives: primitives().filter(|p| p.emitter.is_some()).count(),
        }
    }
}

fn triangles(shape: &Shape) -> usize {
    match shape {
        Shape::Mesh(mesh) => mesh.triangles.len(),
        _ => 0,
    }
}

/// Estimated memory in bytes, without particles and virtual lights.
#[derive(Debug, PartialEq, Serialize)]
struct Memory {
    geometry: u64,
    textures: u64,
    film: u64,
    total: u64,
}

/// Nodes, packed vertices and surface points of a triangle, beside the mesh. Resident memory of
/// renders of meshes with 0.5 and 4.5 million triangles: 186 bytes for each more.
const BYTES_PER_TRIANGLE: usize = 186;

/// Layers of a render.
const LAYERS: [Layer; 9] = [
    Layer::Beauty,
    Layer::Emission,
    Layer::Direct,
    Layer::VirtualLights,
    Layer::Caustics,
    Layer::Albedo,
    Layer::Normal,
    Layer::Depth,
    Layer::Alpha,
];

impl Memory {
    fn new(desc: &SceneDesc) -> Self {
        let geometry = desc.shapes.iter().map(geometry_bytes).sum::<usize>() as u64;
        let textures = desc.textures.iter().map(texture_bytes).sum::<usize>() as u64;
        let film_bytes = |s: &SensorDesc| Film::bytes_for(s.film.crop_size, &LAYERS, &[], 1);
        let film = desc.sensors.first().map_or(0, film_bytes);
        Memory {
            geometry,
            textures,
            film,
            total: film.saturating_add(geometry + textures),
        }
    }
}

fn geometry_bytes(shape: &Shape) -> usize {
    match shape {
        Shape::Mesh(mesh) => {
            size_of_val(mesh.positions.as_slice())
                + size_of_val(mesh.normals.as_slice())
                + size_of_val(mesh.uvs.as_slice())
                + size_of_val(mesh.triangles.as_slice())
                + mesh.triangles.len() * BYTES_PER_TRIANGLE
        }
        _ => size_of::<Shape>(),
    }
}

fn texture_bytes(texture: &Texture) -> usize {
    match texture {
        Texture::Bitmap(bitmap) => size_of_val(bitmap.image.data.as_slice()),
        Texture::VertexColors(colors) => {
            size_of_val(colors.triangles.as_slice()) + size_of_val(colors.values.as_slice())
        }
        Texture::OtherUv { uvs, .. } => {
            size_of_val(uvs.triangles.as_slice()) + size_of_val(uvs.values.as_slice())
        }
        Texture::Checkerboard { .. }
        | Texture::Product { .. }
        | Texture::Mix { .. }
        | Texture::Dots { .. }
        | Texture::Power { .. }
        | Texture::Step { .. }
        | Texture::Transformed { .. }
        | Texture::Solid(_)
        | Texture::Projected { .. } => 0,
    }
}

fn sensor(desc: &SensorDesc) -> Value {
    let (kind, fov) = match desc.kind {
        SensorKind::Perspective { fov, .. } => ("perspective", Some(fov)),
        SensorKind::ThinLens { fov, .. } => ("thinlens", Some(fov)),
        SensorKind::Orthographic => ("orthographic", None),
    };
    json!({
        "name": desc.name,
        "kind": kind,
        "fov": fov,
        "size": desc.film.size.to_array(),
        "crop_offset": desc.film.crop_offset.to_array(),
        "crop_size": desc.film.crop_size.to_array(),
        "filter": filter_name(&desc.film.filter),
        "frames": desc.motion.len(),
    })
}

/// Corners of the bounding box; `null` for a scene without surfaces.
fn corners(bounds: Aabb) -> Value {
    if bounds.is_empty() {
        return Value::Null;
    }
    json!({ "min": bounds.min.to_array(), "max": bounds.max.to_array() })
}

fn describe(counts: &Counts, bounds: Aabb, sensors: &[Value], memory: &Memory) -> String {
    let count = |n: usize| human_count(n as u64);
    let bytes = human_bytes;
    let mut lines = vec![
        format!("triangles    {}", count(counts.triangles)),
        format!("shapes       {}", count(counts.shapes)),
        format!("primitives   {}", count(counts.primitives)),
        format!(
            "instances    {} of {} groups ({} triangles in all)",
            count(counts.instances),
            count(counts.groups),
            count(counts.triangles_with_instances)
        ),
        format!("materials    {}", count(counts.materials)),
        format!("textures     {}", count(counts.textures)),
        format!(
            "emitters     {} ({} emitting primitives)",
            count(counts.emitters),
            count(counts.emitting_primitives)
        ),
        match bounds.is_empty() {
            true => "bounds       none".into(),
            false => format!("bounds       {:.4} to {:.4}", bounds.min, bounds.max),
        },
    ];
    for (i, sensor) in sensors.iter().enumerate() {
        let size = &sensor["size"];
        let frames = match sensor["frames"].as_u64().unwrap_or_default() {
            0 => String::new(),
            count => format!(", {count} frames"),
        };
        lines.push(format!(
            "sensor {i}     {} {}x{}, filter {}{frames}",
            sensor["kind"].as_str().unwrap_or_default(),
            size[0],
            size[1],
            sensor["filter"].as_str().unwrap_or_default()
        ));
    }
    lines.push(format!(
        "memory       about {} (geometry {}, textures {}, film {}); plus virtual lights",
        bytes(memory.total),
        bytes(memory.geometry),
        bytes(memory.textures),
        bytes(memory.film)
    ));
    lines.join("\n")
}
