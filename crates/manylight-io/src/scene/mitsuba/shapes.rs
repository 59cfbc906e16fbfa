//! Shape plugins, groups and instances.

use super::super::curve_files::CurveBasis;
use super::super::description::Additions;
use super::super::parameters::{Numbers, Parameters};
use super::super::sink::Problem;
use super::builder::{CurrentShape, DescBuilder, IGNORED, PlainMaterial, Substitute};
use super::family::PluginFamily;
use super::object::Param;
use super::props::Props;
use super::transforms::{affine, similarity_scale, without_stretch};
use super::values::{ObjectId, Value};
use crate::mesh::MeshFormat;
use glam::{DMat4, DVec3};
use manylight::geometry::{Mesh, Shape};
use manylight::ids::{EmitterId, MaterialId, ShapeId};
use manylight::math::Affine3A;
use manylight::scene::{InstanceDesc, PrimitiveDesc};

pub(super) const SUPPORTED: &[&str] = &[
    "bsplinecurve",
    "cube",
    "cylinder",
    "disk",
    "instance",
    "linearcurve",
    "merge",
    "obj",
    "ply",
    "rectangle",
    "serialized",
    "shapegroup",
    "sphere",
];

const SUBSTITUTES: &[Substitute] = &[
    ("sdfgrid", IGNORED),
    ("ellipsoids", IGNORED),
    ("ellipsoidsmesh", IGNORED),
    ("blender", IGNORED),
    ("hair", IGNORED),
    ("heightfield", IGNORED),
    ("deformable", IGNORED),
    ("shapeinst", IGNORED),
];

impl DescBuilder<'_> {
    /// Adds a shape, group or instance that is nested in the scene.
    pub(super) fn shape(&mut self, id: ObjectId) {
        let props = self.props(id);
        match props.plugin().value.as_str() {
            "shapegroup" => {
                self.group(id);
            }
            "instance" => self.instance(&props),
            "merge" => {
                for (child, _) in merged_shapes(&props) {
                    self.shape(child);
                }
            }
            _ => {
                let primitive = self.primitive(&props);
                self.desc.primitives.extend(primitive);
            }
        }
    }

    /// Index of a shapegroup, added at its first use.
    fn group(&mut self, id: ObjectId) -> usize {
        if let Some(group) = self.made.groups.get(&id) {
            return *group;
        }
        let props = self.props(id);
        let mut primitives = Vec::new();
        let mut children = props.objects(PluginFamily::Shape);
        children.reverse();
        while let Some((child, param)) = children.pop() {
            let child = self.props(child);
            if child.plugin().value == "merge" {
                children.extend(merged_shapes(&child).into_iter().rev());
                continue;
            }
            if matches!(child.plugin().value.as_str(), "shapegroup" | "instance") {
                let message = format!("{} cannot be nested in a shapegroup", child.describe());
                self.sink
                    .error_at("scene::nested_group", param.span, message);
                continue;
            }
            if let Some((_, emitter)) = child.objects(PluginFamily::Emitter).first() {
                let message = "a shape in a shapegroup cannot have an emitter";
                let problem = Problem::new("scene::emitter_in_group", emitter.span, message);
                self.sink
                    .error(problem.help("move the shape out of the shapegroup"));
                continue;
            }
            primitives.extend(self.primitive(&child));
        }
        props.ignore(&["to_world", "id"]);
        props.finish();
        self.desc.groups.push(primitives);
        let group = self.desc.groups.len() - 1;
        self.made.groups.insert(id, group);
        group
    }

    fn instance(&mut self, props: &Props<'_>) {
        let world_from_group = affine(props.to_world());
        let target = props.single(PluginFamily::Shape);
        props.ignore(&["id", "shapegroup"]);
        props.finish();
        let Some(target) = target else {
            let message = "an instance needs a reference to a shapegroup";
            let problem = Problem::new("scene::missing_object", props.span(), message);
            if !props.is_broken() {
                self.sink
                    .error(problem.help("add for example <ref id=\"...\"/>"));
            }
            return;
        };
        if self.tree.get(target).plugin.value != "shapegroup" {
            let message = format!(
                "an instance refers to {}, expected a shapegroup",
                self.props(target).describe()
            );
            self.sink
                .error_at("scene::bad_value", props.span(), message);
            return;
        }
        let group = self.group(target);
        self.desc.instances.push(InstanceDesc {
            name: props.object().id.clone(),
            group,
            world_from_group,
        });
    }

    /// The id of a shape, or else the name of its file or plugin.
    fn shape_name(&mut self, props: &Props<'_>) -> String {
        let object = props.object();
        if !object.id.is_empty() {
            self.shape_names.reserve(&object.id);
            return object.id.clone();
        }
        let file = object.params.iter().find_map(|param| match &param.value {
            Value::String(file) if param.name.value == "filename" => Some(file.value.as_str()),
            _ => None,
        });
        self.shape_names.of_shape(file, &object.plugin.value)
    }

    /// The primitive of a shape. `None` if it is ignored or its geometry is invalid.
    fn primitive(&mut self, props: &Props<'_>) -> Option<PrimitiveDesc> {
        let known = SUPPORTED.contains(&props.plugin().value.as_str());
        if !known {
            self.unsupported(props, SUPPORTED, SUBSTITUTES);
            return None;
        }
        let to_world = props.to_world();
        let shape = self.geometry(props, to_world);
        let flip_normals = props.boolean("flip_normals", false);
        self.current_shape = Some(CurrentShape {
            object: props.id,
            mesh: shape.filter(|&shape| self.assets.is_mesh_file(shape)),
        });
        let emitter = self.area_emitter(props);
        let mut material = self.surface(props, emitter);
        self.current_shape = None;
        let is_curve = matches!(
            props.plugin().value.as_str(),
            "linearcurve" | "bsplinecurve"
        );
        if is_curve {
            material = self.front_of(material);
        }
        props.ignore(&["silhouette_sampling_weight", "id"]);
        self.ignore_nested(props);
        props.finish();
        let name = self.shape_name(props);
        // Curves are read in world space, because transforms do not change their radii.
        let world_from_object = if is_curve {
            Affine3A::IDENTITY
        } else {
            affine(to_world)
        };
        Some(PrimitiveDesc {
            name,
            shape: shape?,
            world_from_object,
            flip_normals,
            material,
            emitter,
        })
    }

    /// Warns about nested objects that are not supported.
    fn ignore_nested(&self, props: &Props<'_>) {
        // Attributes, which textures of the shape's material read.
        props.objects(PluginFamily::Texture);
        props.objects(PluginFamily::Spectrum);
        for (medium, _) in props.objects(PluginFamily::Medium) {
            self.ignore_medium(medium);
        }
        for (subsurface, _) in props.objects(PluginFamily::Subsurface) {
            let inner = self.props(subsurface);
            let message = format!("{} is not supported; it is ignored", inner.describe());
            inner.unsupported("subsurface", message);
        }
        for (sensor, _) in props.objects(PluginFamily::Sensor) {
            let inner = self.props(sensor);
            let object = inner.describe();
            let message = format!("{object} on a shape is not supported; it is ignored");
            inner.unsupported("sensor on shape", message);
        }
    }

    /// The material of a shape.
    fn surface(&mut self, props: &Props<'_>, emitter: Option<EmitterId>) -> MaterialId {
        match props.single(PluginFamily::Bsdf) {
            Some(bsdf) => self.material(bsdf),
            None if emitter.is_some() => self.plain_material(PlainMaterial::Black),
            // In 0.x, a medium without a bsdf has no surface.
            None if props.is_v0() && !props.objects(PluginFamily::Medium).is_empty() => {
                self.plain_material(PlainMaterial::Null)
            }
            None => self.plain_material(PlainMaterial::Gray),
        }
    }

    /// The geometry of a supported shape. `None` if its mesh file is missing.
    fn geometry(&mut self, props: &Props<'_>, to_world: DMat4) -> Option<ShapeId> {
        let radius =
            |default| props.float_where("radius", default, |radius| radius > 0.0, "positive");
        Some(match props.plugin().value.as_str() {
            "obj" => return self.mesh_file(props, MeshFormat::Obj, to_world),
            "ply" => return self.mesh_file(props, MeshFormat::Ply, to_world),
            "serialized" => {
                let shape_index = props.integer("shape_index", 0, 0) as usize;
                return self.mesh_file(props, MeshFormat::Serialized { shape_index }, to_world);
            }
            "linearcurve" => return self.curve_file(props, CurveBasis::Linear, to_world),
            "bsplinecurve" => return self.curve_file(props, CurveBasis::BSpline, to_world),
            "rectangle" => self.builtin(props, "rectangle", || Shape::Mesh(Mesh::rectangle())),
            "cube" => self.builtin(props, "cube", || Shape::Mesh(Mesh::cube())),
            "disk" => self.builtin(props, "disk", || Shape::Disk),
            "sphere" => {
                let center = props.vector("center").unwrap_or(DVec3::ZERO).as_vec3();
                let shape = Shape::Sphere {
                    center,
                    radius: radius(1.0),
                };
                self.warn_distorted(props, to_world);
                self.desc.add(shape)
            }
            "cylinder" => {
                let p0 = props.vector("p0").unwrap_or(DVec3::ZERO);
                let p1 = props.vector("p1").unwrap_or(DVec3::Z);
                if p0 == p1 {
                    let message = "`p0` and `p1` of a cylinder must differ";
                    self.sink
                        .error_at("scene::bad_value", props.span(), message);
                }
                let shape = Shape::Cylinder {
                    p0: p0.as_vec3(),
                    p1: p1.as_vec3(),
                    radius: radius(1.0),
                };
                self.warn_distorted(props, without_stretch(to_world, p1 - p0));
                self.desc.add(shape)
            }
            _ => return None,
        })
    }

    /// A shape without parameters, added at its first use.
    fn builtin(
        &mut self,
        props: &Props<'_>,
        name: &'static str,
        make: impl FnOnce() -> Shape,
    ) -> ShapeId {
        if name != "disk" {
            // The faces are flat, so `face_normals` has no effect.
            props.ignore(&["face_normals"]);
        }
        if let Some(shape) = self.made.builtin_shapes.get(name) {
            return *shape;
        }
        let shape = self.desc.add(make());
        self.made.builtin_shapes.insert(name, shape);
        shape
    }

    /// Warns if `to_world` is not a similarity, because Mitsuba does not define the shape in this
    /// case.
    fn warn_distorted(&self, props: &Props<'_>, to_world: DMat4) {
        if similarity_scale(to_world).is_none() {
            let message = format!(
                "`to_world` of {} scales it non-uniformly; the shape may differ from that in Mitsuba",
                props.describe()
            );
            let span = props
                .get("to_world")
                .map_or(props.span(), |param| param.name.span);
            let problem = Problem::new("scene::distorted", span, message);
            self.sink.warn_once("distorted quadric", problem);
        }
    }
}

/// The shapes nested in a `merge`, which is their union.
fn merged_shapes<'a>(props: &Props<'a>) -> Vec<(ObjectId, &'a Param)> {
    let shapes = props.objects(PluginFamily::Shape);
    props.ignore(&["id"]);
    props.finish();
    shapes
}
