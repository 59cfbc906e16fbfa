//! Shapes of mesh files and of files of curves.

use super::super::assets::{MeshContent, MeshRequest, Normals};
use super::super::curve_files::{CurveBasis, CurveFile};
use super::super::description::Additions;
use super::super::files::find_file;
use super::super::parameters::Parameters;
use super::builder::{DescBuilder, PlainMaterial};
use super::props::Props;
use super::transforms::{affine, similarity_scale};
use crate::mesh::MeshFormat;
use glam::DMat4;
use manylight::bsdf::Material;
use manylight::ids::{MaterialId, ShapeId};
use manylight::math::Affine3A;

impl DescBuilder<'_> {
    /// The shape of a mesh file.
    pub(super) fn mesh_file(
        &mut self,
        props: &Props<'_>,
        format: MeshFormat,
        to_world: DMat4,
    ) -> Option<ShapeId> {
        let faceted = props.boolean("face_normals", false);
        // v points up in OBJ files, but down in images.
        let flip_v = props.boolean("flip_tex_coords", matches!(format, MeshFormat::Obj));
        if props.is_v0() {
            props.ignore(&["collapse", "srgb"]);
        }
        self.warn_feature(props, "max_smooth_angle", "is not supported; it is ignored");
        let name = props.required_string("filename")?;
        let path = find_file(self.sink, &props.object().folders, name, "mesh file")?;
        let normals = if faceted {
            Normals::Faceted
        } else {
            let keeps_angles = similarity_scale(to_world).is_some_and(|scale| scale > 0.0);
            Normals::Smooth {
                placement: if keeps_angles {
                    Affine3A::IDENTITY
                } else {
                    linear_part(to_world)
                },
            }
        };
        let request = MeshRequest {
            path,
            content: MeshContent::Mesh(format),
            flip_v,
            normals,
        };
        Some(self.assets.mesh(request, name.span, &mut self.desc.shapes))
    }

    /// The shape of a file of curves, in world space.
    pub(super) fn curve_file(
        &mut self,
        props: &Props<'_>,
        basis: CurveBasis,
        to_world: DMat4,
    ) -> Option<ShapeId> {
        let name = props.required_string("filename")?;
        let path = find_file(self.sink, &props.object().folders, name, "file of curves")?;
        let request = MeshRequest {
            path,
            content: MeshContent::Curves(CurveFile {
                basis,
                world_from_object: affine(to_world),
            }),
            flip_v: false,
            normals: Normals::Smooth {
                placement: Affine3A::IDENTITY,
            },
        };
        Some(self.assets.mesh(request, name.span, &mut self.desc.shapes))
    }

    /// The material on its front side, and nothing on the other one: the backs of curves are
    /// invisible, as in Mitsuba.
    pub(super) fn front_of(&mut self, material: MaterialId) -> MaterialId {
        if let Some(front) = self.made.fronts.get(&material) {
            return *front;
        }
        let front = match self.desc.materials[material.index()] {
            Material::TwoSided { front, .. } => front,
            _ => material,
        };
        let back = self.plain_material(PlainMaterial::Null);
        let one_sided = self.desc.add(Material::TwoSided { front, back });
        self.made.fronts.insert(material, one_sided);
        one_sided
    }
}

fn linear_part(matrix: DMat4) -> Affine3A {
    Affine3A {
        translation: glam::Vec3A::ZERO,
        ..affine(matrix)
    }
}
