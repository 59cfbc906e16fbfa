//! Curves, as tubes. Curves that follow each other with one material become one mesh.

use super::super::super::description::Additions;
use super::super::super::parameters::{Numbers, Parameters};
use super::super::super::tubes::{Ring, TubeDetail, add_tube, spline};
use super::super::builder::{Builder, PendingCurves};
use super::super::elements::Elements;
use super::super::entities::{MaterialRef, ShapeEntity};
use super::super::transforms::mirrors;
use super::tessellation::append;
use crate::mesh::orient_to_normals;
use manylight::geometry::{Mesh, Shape};
use manylight::ids::ShapeId;
use manylight::math::{Frame, Vec2, Vec3, Vec4};
use manylight::scene::PrimitiveDesc;
use std::f32::consts::PI;

/// Files of PBRT have a curve for each hair.
const DETAIL: TubeDetail = TubeDetail::COARSE;
/// Most triangles of one mesh.
const MAX_TRIANGLES: usize = 1 << 22;

impl Builder<'_> {
    /// Whether a curve cannot be appended to those that are collected.
    pub(super) fn starts_new_curves(&self, shape: &ShapeEntity<'_>) -> bool {
        let params = &shape.entity.params;
        self.curves.as_ref().is_some_and(|pending| {
            pending.transform != shape.entity.transform
                || !same_surface(&pending.material, &shape.material)
                || params.has("alpha")
                || pending.mesh.triangles.len() > MAX_TRIANGLES
        })
    }

    /// Collects a curve.
    pub(super) fn curve(&mut self, shape: &ShapeEntity<'_>) {
        if self.starts_new_curves(shape) {
            self.flush_curves();
        }
        let mesh = self.curve_mesh(shape);
        let world_from_object = self.world_of_shape(shape);
        let (Some(mesh), Some(world_from_object)) = (mesh, world_from_object) else {
            return;
        };
        if let Some(pending) = &mut self.curves {
            append(&mut pending.mesh, mesh);
            shape.entity.params.ignore(&["alpha"]);
            shape.entity.params.finish(self.is_v3);
            return;
        }
        let opacity = self.opacity(shape);
        let material = self.surface(shape, opacity);
        shape.entity.params.finish(self.is_v3);
        self.curves = Some(PendingCurves {
            mesh,
            transform: shape.entity.transform,
            material: shape.material.clone(),
            primitive: PrimitiveDesc {
                name: self.shape_name(shape),
                shape: ShapeId::from(0),
                world_from_object,
                flip_normals: false,
                material,
                emitter: None,
            },
        });
    }

    /// The primitive of the curves that have been collected.
    pub(super) fn collected_curves(&mut self) -> Option<PrimitiveDesc> {
        let mut pending = self.curves.take()?;
        orient_to_normals(&mut pending.mesh, mirrors(pending.transform));
        let shape = self.desc.add(Shape::Mesh(pending.mesh));
        Some(PrimitiveDesc {
            shape,
            ..pending.primitive
        })
    }

    /// The shapes of a curve in PBRT: ribbons along parts of its segments.
    pub(super) fn curve_elements(&self, shape: &ShapeEntity<'_>) -> Elements {
        /// Most halvings of a segment: their number of parts is a number that `f32` represents.
        const MAX_HALVINGS: i32 = 24;
        let halvings = shape.entity.params.integer("splitdepth", 3, 0);
        Elements::Equal {
            triangles: DETAIL.pieces * DETAIL.sides * 2,
            // The area of the tube is π times that of the ribbon in its place.
            power: PI * 2.0f32.powi(halvings.min(MAX_HALVINGS)),
        }
    }

    /// The tube around one curve, in object space.
    pub(super) fn curve_mesh(&self, shape: &ShapeEntity<'_>) -> Option<Mesh> {
        let params = &shape.entity.params;
        params.ignore(&["N", "splitdepth"]);
        let kinds = ["flat", "ribbon", "cylinder"].map(|kind| (kind, kind));
        let kind = params.choice("type", "flat", &kinds);
        if kind != "cylinder" {
            let message = format!("curves of type `{kind}` are replaced by tubes");
            params.unsupported(format!("curve {kind}"), message);
        }
        let bases = [("bezier", false), ("bspline", true)];
        let is_spline = params.choice("basis", false, &bases);
        let degree = params.integer("degree", 3, 2) as usize;
        let width = params.float("width", 1.0);
        let widths = ["width0", "width1"].map(|name| params.float(name, width));
        params.require("P");
        let points = params.vectors("P")?;
        let step = if is_spline { 1 } else { degree };
        let fits = points.len() > degree && (points.len() - 1 - degree).is_multiple_of(step);
        if degree > 3 || !fits {
            let required = format!("the control points of whole segments of degree {degree}");
            params.refuse_named("P", &required);
            return None;
        }
        let segments = (points.len() - 1 - degree) / step + 1;
        let pieces = DETAIL.pieces;
        let samples: Vec<Vec3> = (0..=segments * pieces)
            .map(|i| {
                let segment = (i / pieces).min(segments - 1);
                let t = (i - segment * pieces) as f32 / pieces as f32;
                let control = &points[segment * step..=segment * step + degree];
                if is_spline {
                    let control: Vec<Vec4> = control.iter().map(|p| p.extend(0.0)).collect();
                    spline(&control, t)[0].truncate()
                } else {
                    bezier(control, t)
                }
            })
            .collect();
        Some(tube(&samples, widths))
    }
}

/// Whether two shapes have the same material.
fn same_surface(a: &MaterialRef, b: &MaterialRef) -> bool {
    match (a, b) {
        (MaterialRef::Default, MaterialRef::Default) => true,
        (MaterialRef::Index(a), MaterialRef::Index(b)) => a == b,
        (MaterialRef::Named(a, p), MaterialRef::Named(b, q)) => a.value == b.value && p == q,
        _ => false,
    }
}

/// A point of a Bézier segment, by de Casteljau's algorithm.
fn bezier(control: &[Vec3], t: f32) -> Vec3 {
    let mut points = control.to_vec();
    while points.len() > 1 {
        points = points
            .windows(2)
            .map(|pair| pair[0].lerp(pair[1], t))
            .collect();
    }
    points[0]
}

/// An open tube around a polyline, with a width that changes linearly along it. The first texture
/// coordinate is the place along it.
fn tube(points: &[Vec3], widths: [f32; 2]) -> Mesh {
    let last = points.len() - 1;
    let mut side = Vec3::ZERO;
    let rings: Vec<Ring> = points
        .iter()
        .enumerate()
        .map(|(i, &center)| {
            let tangent = points[(i + 1).min(last)] - points[i.saturating_sub(1)];
            let tangent = tangent.normalize_or(Vec3::Z);
            // The side that turns least from the one before.
            side = (side - tangent * side.dot(tangent)).normalize_or(Frame::from_normal(tangent).s);
            let along = i as f32 / last as f32;
            Ring {
                center,
                radius: 0.5 * (widths[0] + (widths[1] - widths[0]) * along),
                axes: [side, tangent.cross(side)],
                lean: [1.0, 0.0],
                along,
            }
        })
        .collect();
    let mut mesh = Mesh::default();
    add_tube(&mut mesh, &rings, DETAIL.sides, |turn, along| {
        Vec2::new(along, turn)
    });
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bezier_segments_meet_their_points() {
        let line: Vec<Vec3> = (0..4).map(|i| Vec3::X * i as f32).collect();
        assert!(bezier(&line, 0.5).abs_diff_eq(Vec3::X * 1.5, 1e-6));
    }

    #[test]
    fn a_tube_narrows_with_its_width() {
        let mesh = tube(&[Vec3::ZERO, Vec3::Z, Vec3::Z * 2.0], [0.4, 0.2]);
        let sides = DETAIL.sides;
        let radius = |i: usize| mesh.positions[i].truncate().length();
        assert!((radius(0) / radius(2 * (sides + 1)) - 2.0).abs() < 1e-5);
        assert_eq!(mesh.triangles.len(), 2 * sides * 2);
        assert_eq!(mesh.uvs[sides + 1].x, 0.5);
    }
}
