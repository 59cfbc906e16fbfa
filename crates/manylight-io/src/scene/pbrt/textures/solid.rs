//! Textures by position: patterns in space, and mappings other than `uv`.

use super::super::super::description::Additions;
use super::super::super::parameters::{Numbers, Parameters};
use super::super::bindings::TextureType;
use super::super::builder::Builder;
use super::super::entities::Entity;
use manylight::ids::TextureId;
use manylight::math::{Affine3A, Mat3, Vec2, Vec3};
use manylight::texture::{ColorInput, Pattern, Projection, ProjectionKind, Solid, Texture};

/// Most octaves of noise: beyond them, noise is finer than the precision of positions.
const MAX_OCTAVES: i32 = 24;

impl Builder<'_> {
    /// A pattern of noise; `None` if the class is none of them.
    pub(super) fn noise(&mut self, entity: &Entity<'_>) -> Option<ColorInput> {
        let params = &entity.params;
        let octaves = || {
            let octaves = params.integer("octaves", 8, 0).min(MAX_OCTAVES);
            let roughness = params.float("roughness", 0.5);
            (octaves as u32, roughness)
        };
        let mut scale = 1.0;
        let pattern = match params.plugin.value.as_str() {
            "fbm" => {
                let (octaves, roughness) = octaves();
                Pattern::Fractal { octaves, roughness }
            }
            "wrinkled" => {
                let (octaves, roughness) = octaves();
                Pattern::Wrinkled { octaves, roughness }
            }
            "windy" => Pattern::Windy,
            "marble" => {
                let (octaves, roughness) = octaves();
                scale = params.float("scale", 1.0);
                Pattern::Marble {
                    octaves,
                    roughness,
                    variation: params.float("variation", 0.2),
                }
            }
            _ => return None,
        };
        Some(self.solid(entity, scale, pattern))
    }

    /// A pattern in the space in which the texture is defined, scaled.
    pub(super) fn solid(
        &mut self,
        entity: &Entity<'_>,
        scale: f32,
        pattern: Pattern,
    ) -> ColorInput {
        let scaled = Affine3A::from_scale(Vec3::splat(scale));
        let pattern_from_world = scaled * self.world_from(entity).inverse();
        ColorInput::Texture(self.desc.add(Texture::Solid(Solid {
            pattern_from_world,
            pattern,
        })))
    }

    /// Discs, of which noise decides the places.
    pub(super) fn dots(&mut self, entity: &Entity<'_>, ty: TextureType) -> ColorInput {
        let inside = self.nested_input(entity, ty, "inside", 1.0);
        let outside = self.nested_input(entity, ty, "outside", 0.0);
        let mapping = self.mapping(entity);
        let dots = self.desc.add(Texture::Dots {
            inside,
            outside,
            uv_transform: mapping.uv_transform,
        });
        ColorInput::Texture(self.at_mapped_uv(mapping, dots))
    }

    /// The texture coordinates at which a texture is looked up.
    pub(super) fn mapping(&self, entity: &Entity<'_>) -> Mapping {
        let params = &entity.params;
        let number = |name, default| params.float(name, default);
        let offset = Vec2::new(number("udelta", 0.0), number("vdelta", 0.0));
        let vector = |name, default| params.point3(name, default);
        let kinds = [
            ("uv", None),
            ("spherical", Some(ProjectionKind::Spherical)),
            ("cylindrical", Some(ProjectionKind::Cylindrical)),
            (
                "planar",
                Some(ProjectionKind::Planar {
                    axes: [vector("v1", Vec3::X), vector("v2", Vec3::Y)],
                    offset,
                }),
            ),
        ];
        let scale = Vec2::new(number("uscale", 1.0), number("vscale", 1.0));
        match params.choice("mapping", None, &kinds) {
            None => Mapping {
                uv_transform: Mat3::from_cols(
                    Vec3::X * scale.x,
                    Vec3::Y * scale.y,
                    offset.extend(1.0),
                ),
                projection: None,
            },
            Some(kind) => Mapping {
                uv_transform: Mat3::IDENTITY,
                projection: Some(Projection {
                    from_world: self.world_from(entity).inverse(),
                    kind,
                }),
            },
        }
    }

    /// `inner` at the texture coordinates of a mapping, of which it has the transform already.
    pub(super) fn at_mapped_uv(&mut self, mapping: Mapping, inner: TextureId) -> TextureId {
        match mapping.projection {
            Some(projection) => self.desc.add(Texture::Projected { projection, inner }),
            None => inner,
        }
    }
}

/// Where a texture is looked up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mapping {
    /// Transform of texture coordinates.
    pub(super) uv_transform: Mat3,
    /// Texture coordinates by position, in place of those of the shape.
    projection: Option<Projection>,
}
