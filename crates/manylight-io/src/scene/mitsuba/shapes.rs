//! Shape plugins, groups and instances.

use super::super::curve_files::CurveBasis;
use super::super::sink::Problem;
use super::bsdfs::PlainMaterial;
use super::object::{ObjectId, Param, PluginFamily};
use super::props::Props;
use super::values::Value;
use super::{CurrentShape, DescBuilder, IGNORED, Substitute};
use crate::mesh::MeshFormat;
use glam::{DMat3, DMat4, DVec3};
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

/// The affine part of a matrix, in single precision.
pub(super) fn affine(matrix: DMat4) -> Affine3A {
    Affine3A::from_mat4(matrix.as_mat4())
}

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
        if let Some(group) = self.groups.get(&id) {
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
                    .error(Problem::new("scene::nested_group", param.span, message));
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
        self.groups.insert(id, group);
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
                .error(Problem::new("scene::bad_value", props.span(), message));
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
            Value::String(file) if param.name.value == "filename" => Some(file.as_str()),
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
            self.sink.warn_once(
                "subsurface",
                Problem::new("scene::unsupported", inner.span(), message),
            );
        }
        for (sensor, _) in props.objects(PluginFamily::Sensor) {
            let inner = self.props(sensor);
            let message = format!(
                "{} on a shape is not supported; it is ignored",
                inner.describe()
            );
            self.sink.warn_once(
                "sensor on shape",
                Problem::new("scene::unsupported", inner.span(), message),
            );
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

    fn add_shape(&mut self, shape: Shape) -> ShapeId {
        self.desc.shapes.push(shape);
        ShapeId::from(self.desc.shapes.len() - 1)
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
                self.add_shape(shape)
            }
            "cylinder" => {
                let p0 = props.vector("p0").unwrap_or(DVec3::ZERO);
                let p1 = props.vector("p1").unwrap_or(DVec3::Z);
                if p0 == p1 {
                    let message = "`p0` and `p1` of a cylinder must differ";
                    self.sink
                        .error(Problem::new("scene::bad_value", props.span(), message));
                }
                let shape = Shape::Cylinder {
                    p0: p0.as_vec3(),
                    p1: p1.as_vec3(),
                    radius: radius(1.0),
                };
                self.warn_distorted(props, without_stretch(to_world, p1 - p0));
                self.add_shape(shape)
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
        if let Some(shape) = self.builtin_shapes.get(name) {
            return *shape;
        }
        let shape = self.add_shape(make());
        self.builtin_shapes.insert(name, shape);
        shape
    }

    /// Warns if `to_world` is not a similarity, because Mitsuba does not define the shape in this case.
    fn warn_distorted(&self, props: &Props<'_>, to_world: DMat4) {
        if similarity_scale(to_world).is_none() {
            let message = format!(
                "`to_world` of {} scales it non-uniformly; the shape may differ from that in Mitsuba",
                props.describe()
            );
            let span = props
                .get("to_world")
                .map_or(props.span(), |param| param.name.span);
            self.sink.warn_once(
                "distorted quadric",
                Problem::new("scene::distorted", span, message),
            );
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

/// `matrix` after a rotation of z to `axis`, with the scale along `axis` set to the scale across it.
fn without_stretch(matrix: DMat4, axis: DVec3) -> DMat4 {
    let along = axis.normalize_or(DVec3::Z);
    let (a, b) = along.any_orthonormal_pair();
    let turned = matrix * DMat4::from_mat3(DMat3::from_cols(a, b, along));
    let z_axis = turned.z_axis.normalize_or_zero() * turned.x_axis.length();
    DMat4 { z_axis, ..turned }
}

/// The scale of a similarity, negative if it mirrors. `None` if `matrix` changes angles.
pub(super) fn similarity_scale(matrix: DMat4) -> Option<f64> {
    /// Relative tolerance; matrices in files have about seven digits.
    const TOLERANCE: f64 = 1e-5;
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate());
    let scale_squared = axes[0].length_squared();
    let near = |a: f64, b: f64| (a - b).abs() <= TOLERANCE * scale_squared;
    let keeps = near(axes[1].length_squared(), scale_squared)
        && near(axes[2].length_squared(), scale_squared)
        && near(axes[0].dot(axes[1]), 0.0)
        && near(axes[1].dot(axes[2]), 0.0)
        && near(axes[2].dot(axes[0]), 0.0);
    keeps.then(|| scale_squared.sqrt() * matrix.determinant().signum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cylinders_may_be_stretched_along_their_axis_alone() {
        let keeps = |scale: DVec3, axis: DVec3| {
            let turned = DMat4::from_rotation_y(0.7) * DMat4::from_scale(scale);
            similarity_scale(without_stretch(turned, axis)).is_some()
        };
        let long = DVec3::new(0.4, 0.4, 1.1);
        assert!(keeps(long, DVec3::Z) && keeps(DVec3::splat(2.0), DVec3::ONE));
        assert!(!keeps(long, DVec3::X) && !keeps(long, DVec3::new(0.0, 1.0, 1.0)));
    }
}
