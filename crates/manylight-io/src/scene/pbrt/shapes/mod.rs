//! Shapes.

mod curves;
mod meshes;
mod quadrics;
mod subdivision;
mod tessellation;

use super::super::description::{Additions, add_front_alone, faded_radiance};
use super::super::parameters::Parameters;
use super::super::sink::Problem;
use super::builder::Builder;
use super::elements::Elements;
use super::entities::ShapeEntity;
use super::lights::{AreaLight, EmittingSurface};
use super::transforms::mirrors;
use crate::mesh::{orient_to_normals, smooth_normals};
use manylight::emitters::Emitter;
use manylight::geometry::{Mesh, Shape};
use manylight::ids::MaterialId;
use manylight::math::{Affine3A, Vec3};
use manylight::scene::{PrimitiveDesc, SceneDesc};
use manylight::texture::FloatInput;
use tessellation::Geometry;

pub(super) const SUPPORTED: &[&str] = &[
    "bilinearmesh",
    "cone",
    "curve",
    "cylinder",
    "disk",
    "heightfield",
    "hyperboloid",
    "loopsubdiv",
    "paraboloid",
    "plymesh",
    "sphere",
    "trianglemesh",
];

/// Distance of the back of a two-sided emitter from its front, relative to the magnitude of its
/// coordinates. Much larger than the offset of ray origins (12 roundings of `f32`), and below what
/// an image resolves.
const BACK_DISTANCE: f32 = 2e-5;

impl Builder<'_> {
    /// Adds a shape to the world.
    pub(super) fn shape(&mut self, shape: &ShapeEntity<'_>) {
        if shape.entity.params.plugin.value == "curve" && shape.area_light.is_none() {
            self.curve(shape);
            return;
        }
        self.flush_curves();
        let primitives = self.primitives(shape, false);
        self.desc.primitives.extend(primitives);
    }

    /// Adds the curves that have been collected.
    pub(super) fn flush_curves(&mut self) {
        let primitive = self.collected_curves();
        self.desc.primitives.extend(primitive);
    }

    /// The primitives of an object.
    pub(super) fn group(&mut self, shapes: &[ShapeEntity<'_>]) -> Vec<PrimitiveDesc> {
        let mut primitives = Vec::new();
        for shape in shapes {
            if shape.entity.params.plugin.value == "curve" {
                if self.starts_new_curves(shape) {
                    primitives.extend(self.collected_curves());
                }
                self.curve(shape);
            } else {
                primitives.extend(self.primitives(shape, true));
            }
        }
        primitives.extend(self.collected_curves());
        primitives
    }

    /// The primitives of a shape: none if it is ignored or invalid, two if both sides emit.
    fn primitives(&mut self, shape: &ShapeEntity<'_>, in_group: bool) -> Vec<PrimitiveDesc> {
        let geometry = self.geometry(shape);
        let opacity = self.opacity(shape);
        let mut material = self.surface(shape, opacity);
        shape.entity.params.finish(self.is_v3);
        let Some(Geometry {
            shape: id,
            world_from_object,
            is_reversed,
            elements,
        }) = geometry
        else {
            return Vec::new();
        };
        let mut light = None;
        if in_group && shape.area_light.is_some() {
            let message = "surfaces in objects do not emit light, as in PBRT";
            let span = shape.entity.params.plugin.span;
            let problem = Problem::new("scene::emitter_in_group", span, message);
            self.sink.warn_once("emitter in object", problem);
        } else {
            let surface = EmittingSurface {
                shape: id,
                world_from_object,
                elements,
            };
            light = self.area_light(shape, surface);
        }
        if let (Some(AreaLight { emitter, two_sided }), Some(opacity)) = (&light, opacity) {
            let emitter = *emitter;
            // PBRT samples such lights, and lets rays pass: they light as if they were opaque.
            let is_invisible = opacity == FloatInput::Constant(0.0);
            // After the power, which does not depend on the opacity.
            self.after_loading(move |desc: &mut SceneDesc| {
                if let Emitter::Area { radiance } = desc.emitters[emitter.index()] {
                    desc.emitters[emitter.index()] = if is_invisible {
                        Emitter::InvisibleArea { radiance }
                    } else {
                        let radiance = faded_radiance(&mut desc.textures, radiance, opacity);
                        Emitter::Area { radiance }
                    };
                }
            });
            if *two_sided && !is_invisible {
                material = add_front_alone(&mut self.desc.materials, material);
            }
        }
        let front = PrimitiveDesc {
            name: self.shape_name(shape),
            shape: id,
            world_from_object,
            flip_normals: shape.reverse_orientation != is_reversed,
            material,
            emitter: light.map(|light| light.emitter),
        };
        let back = light
            .filter(|light| light.two_sided)
            .and_then(|_| self.back(&front));
        std::iter::once(front).chain(back).collect()
    }

    /// A name from the mesh file or the plugin of a shape: shapes have no names in PBRT.
    pub(super) fn shape_name(&mut self, shape: &ShapeEntity<'_>) -> String {
        let params = &shape.entity.params;
        let is_file = params.plugin.value == "plymesh";
        let file = is_file.then(|| params.string("filename")).flatten();
        let file = file.map(|file| file.value.as_str());
        self.shape_names.of_shape(file, &params.plugin.value)
    }

    /// The opacity of a shape, if it has one.
    fn opacity(&mut self, shape: &ShapeEntity<'_>) -> Option<FloatInput> {
        let params = &shape.entity.params;
        params.ignore(&["shadowalpha"]);
        let opacity = self.maybe_float_input(&shape.entity, "alpha")?;
        (opacity != FloatInput::Constant(1.0)).then_some(opacity)
    }

    /// The material of a shape behind its opacity.
    fn surface(&mut self, shape: &ShapeEntity<'_>, opacity: Option<FloatInput>) -> MaterialId {
        let material = self.resolve_material(&shape.material);
        let Some(opacity) = opacity else {
            return material;
        };
        let key = (material, format!("{opacity:?}"));
        if let Some(masked) = self.made.masks.get(&key) {
            return *masked;
        }
        let masked = self.masked(material, opacity);
        self.made.masks.insert(key, masked);
        masked
    }

    /// Adds a mesh in object space.
    fn add_mesh(
        &mut self,
        shape: &ShapeEntity<'_>,
        mut mesh: Mesh,
        elements: Elements,
    ) -> Option<Geometry> {
        let world_from_object = self.world_of_shape(shape)?;
        orient_to_normals(&mut mesh, mirrors(shape.entity.transform));
        Some(Geometry {
            shape: self.desc.add(Shape::Mesh(mesh)),
            world_from_object,
            is_reversed: false,
            elements,
        })
    }

    /// Adds the mesh of a surface that the file describes by some numbers. `None` if there are too
    /// many of them, which is reported.
    fn add_tessellated(
        &mut self,
        shape: &ShapeEntity<'_>,
        mesh: Mesh,
        elements: Elements,
    ) -> Option<Geometry> {
        let bytes = size_of_val(&mesh.positions[..])
            + size_of_val(&mesh.normals[..])
            + size_of_val(&mesh.uvs[..])
            + size_of_val(&mesh.triangles[..]);
        let made = self.tessellated.make(bytes, |most, given| {
            format!(
                "the shapes make more than {most} bytes of triangles from {given} bytes of text"
            )
        });
        if let Err(exceeded) = made {
            let span = shape.entity.params.plugin.span;
            exceeded.report(self.sink, "scene::too_many_triangles", span);
            return None;
        }
        self.add_mesh(shape, mesh, elements)
    }

    fn world_of_shape(&self, shape: &ShapeEntity<'_>) -> Option<Affine3A> {
        let entity = &shape.entity;
        self.placement(entity.transform, entity.params.plugin.span)
    }

    /// The geometry of a shape. `None` if it is invalid or unknown, which is reported.
    fn geometry(&mut self, shape: &ShapeEntity<'_>) -> Option<Geometry> {
        let params = &shape.entity.params;
        match params.plugin.value.as_str() {
            "sphere" => self.sphere(shape),
            "disk" => self.disk(shape),
            "cylinder" => self.cylinder(shape),
            "cone" | "paraboloid" | "hyperboloid" => self.old_quadric(shape),
            "trianglemesh" => self.triangle_mesh(shape),
            "bilinearmesh" => self.bilinear_mesh(shape),
            "heightfield" | "heightfield2" => self.height_field(shape),
            "plymesh" => self.ply_mesh(shape),
            "loopsubdiv" => self.subdivision_surface(shape),
            "curve" => {
                let mesh = self.curve_mesh(shape)?;
                let elements = self.curve_elements(shape);
                self.add_tessellated(shape, mesh, elements)
            }
            "nurbs" => {
                let message = "shape `nurbs` is not supported; it is ignored";
                params.unsupported("shape nurbs", message);
                params.ignore_all();
                None
            }
            _ => {
                self.unknown_plugin(&shape.entity, SUPPORTED.iter().copied());
                params.ignore_all();
                None
            }
        }
    }

    /// The back of a two-sided emitter: the same surface with reversed normals, slightly behind the
    /// front. `None` for closed shapes.
    fn back(&mut self, front: &PrimitiveDesc) -> Option<PrimitiveDesc> {
        let world = front.world_from_object;
        let magnitude = |shape_extent: f32| {
            let m = world.matrix3;
            let scale = m
                .x_axis
                .length()
                .max(m.y_axis.length())
                .max(m.z_axis.length());
            world.translation.abs().max_element() + scale * shape_extent
        };
        let side = if front.flip_normals { -1.0 } else { 1.0 };
        let mut back = PrimitiveDesc {
            flip_normals: !front.flip_normals,
            ..front.clone()
        };
        match self.desc.shapes[front.shape.index()] {
            Shape::Sphere { .. } => return None,
            Shape::Disk => {
                let thickness = world.matrix3.z_axis.length();
                let distance = BACK_DISTANCE * magnitude(1.0) / thickness;
                let behind = Vec3::new(0.0, 0.0, -side * distance);
                back.world_from_object = world * Affine3A::from_translation(behind);
            }
            Shape::Cylinder { p0, p1, radius } => {
                let extent = p0.abs().max(p1.abs()).max_element() + radius;
                let scale = world.matrix3.x_axis.length();
                let distance = BACK_DISTANCE * magnitude(extent) / scale;
                back.shape = self.desc.add(Shape::Cylinder {
                    p0,
                    p1,
                    radius: (radius - side * distance).max(0.5 * radius),
                });
            }
            Shape::Mesh(_) => {
                let source = front.shape;
                back.shape = self.desc.add(Shape::Mesh(Mesh::default()));
                let target = back.shape;
                self.after_loading(move |desc: &mut SceneDesc| {
                    let mesh = &desc.shapes[source.index()];
                    let moved = moved_along_normals(mesh, &world, side);
                    desc.shapes[target.index()] = moved;
                });
            }
        }
        Some(back)
    }
}

/// The mesh with every vertex moved against its normal, by [`BACK_DISTANCE`] of its coordinates in
/// the world.
fn moved_along_normals(shape: &Shape, world: &Affine3A, side: f32) -> Shape {
    let Shape::Mesh(mesh) = shape else {
        return shape.clone();
    };
    let mut moved = mesh.clone();
    let mut directions = mesh.clone();
    smooth_normals(&mut directions);
    // The winding of a mirrored mesh has been reversed.
    let side = if world.matrix3.determinant() < 0.0 {
        -side
    } else {
        side
    };
    let scale = world.matrix3.determinant().abs().cbrt();
    for (p, n) in moved.positions.iter_mut().zip(&directions.normals) {
        let magnitude = world.transform_point3(*p).abs().max_element();
        let extent = world.translation.abs().max_element().max(magnitude);
        *p -= *n * (side * BACK_DISTANCE * extent / scale);
    }
    Shape::Mesh(moved)
}
