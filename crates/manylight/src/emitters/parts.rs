//! The parts among which the light tree chooses: primitives, triangles of larger meshes, points and spots.

use super::Emitter;
use super::flat::Flat;
use crate::color::Rgb;
use crate::geometry::{Geometry, Shape, SurfacePoint, SurfaceRef};
use crate::ids::{EmitterId, PrimitiveId};
use crate::math::trig::sin_cos_turns;
use crate::math::{Aabb, Affine3A, Cone, Frame, Vec2, Vec3};
use crate::sampling::warp;
use crate::texture::{ColorInput, Texture};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// What a part looks like.
#[derive(Clone, Copy, Debug)]
pub(super) enum Form {
    /// A whole primitive, by area.
    Primitive,
    /// A sphere or cylinder under a transform that stretches its area unevenly: by area of the undistorted shape.
    Distorted {
        undistorted: fn(&SurfacePoint) -> f32,
    },
    /// One triangle of a mesh, by area.
    Triangle { element: u32 },
    /// A sphere, by the solid angle of what is visible of it.
    Sphere {
        center: Vec3,
        radius: f32,
        offset: f32,
    },
    /// A point or a spot.
    Point { position: Vec3 },
}

/// A part of an emitter that is sampled as a whole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) emitter: EmitterId,
    /// Meaningless for points.
    pub(super) primitive: PrimitiveId,
    pub(super) form: Form,
    /// In m²; 0 for points.
    pub(super) area: f32,
    /// How it is seen, where that is simple.
    flat: Option<Flat>,
}

/// What the light tree knows about a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartBounds {
    pub(super) bounds: Aabb,
    /// Holds every normal.
    pub(super) normals: Cone,
    /// Light leaves up to this angle from some normal.
    pub(super) emission: f32,
    pub(super) power: Rgb,
}

/// Meshes of up to this many triangles are sampled as a whole: rectangles keep the stratification of their numbers.
const WHOLE_MESH_TRIANGLES: usize = 2;

/// Textured radiance is averaged over so many points a side.
const RADIANCE_GRID: usize = 8;

/// The average is not trusted below this fraction of the largest radiance in the texture: bright texels may fall between the points.
pub(super) const RADIANCE_FLOOR: f32 = 0.01;

/// A point of a surface as seen from somewhere.
pub(super) struct SeenPoint {
    /// Unit direction to the point.
    pub(super) wi: Vec3,
    /// Moved off the surface.
    pub(super) target: Vec3,
    /// Per solid angle.
    pub(super) pdf: f32,
    /// Radiance towards the viewer.
    pub(super) radiance: Rgb,
}

/// The parts of one primitive that carries an area emitter: the element that each stands for (0 for whole primitives), the
/// part, its bounds.
pub(super) fn parts_of_primitive(
    geometry: &Geometry,
    textures: &[Texture],
    primitive: PrimitiveId,
    emitter: EmitterId,
    radiance: ColorInput,
) -> Vec<(u32, Part, PartBounds)> {
    let placed = &geometry.primitives()[primitive.index()];
    let to_world = &placed.world_from_object;
    let whole = |(form, bounds, normals)| {
        let part = Part {
            emitter,
            primitive,
            form,
            area: geometry.area(primitive),
            flat: None,
        };
        vec![(0, part, bounds, normals)]
    };
    let parts: Vec<(u32, Part, Aabb, Cone)> = match &geometry.shapes()[placed.shape.index()] {
        Shape::Mesh(mesh) => {
            let triangles =
                (0..mesh.triangles.len() as u32).map(|t| triangle(geometry, primitive, emitter, t));
            if mesh.triangles.len() > WHOLE_MESH_TRIANGLES {
                triangles
                    .zip(0..)
                    .map(|((part, bounds, normals), t)| (t, part, bounds, normals))
                    .collect()
            } else {
                let lit = triangles.filter(|(part, ..)| part.area > 0.0);
                let (bounds, normals) = lit.fold(
                    (Aabb::EMPTY, Cone::EMPTY),
                    |(b, n), (_, bounds, normals)| (b.union(bounds), n.union(normals)),
                );
                whole((Form::Primitive, bounds, normals))
            }
        }
        Shape::Sphere { center, radius } => {
            whole(sphere(geometry, primitive, *center, *radius, radiance))
        }
        Shape::Disk => {
            let square = Aabb {
                min: Vec3::new(-1.0, -1.0, 0.0),
                max: Vec3::new(1.0, 1.0, 0.0),
            };
            let sample = geometry.sample_area(primitive, Vec2::splat(0.5));
            let normals = sample.map_or(Cone::FULL, |sample| Cone::from_axis(sample.point.frame.n));
            whole((Form::Primitive, square.transformed(to_world), normals))
        }
        Shape::Cylinder { p0, p1, radius } => {
            let r = Vec3::splat(*radius);
            let ends = Aabb {
                min: p0.min(*p1) - r,
                max: p0.max(*p1) + r,
            };
            let form = match similarity_scale(to_world) {
                Some(_) => Form::Primitive,
                None => Form::Distorted {
                    undistorted: |_| 1.0,
                },
            };
            whole((form, ends.transformed(to_world), Cone::FULL))
        }
    };
    let lit = |(element, part, bounds, normals): (u32, Part, Aabb, Cone)| {
        let flat = match radiance {
            ColorInput::Constant(_) => flat(geometry, &part),
            ColorInput::Texture(_) => None,
        };
        let part = Part { flat, ..part };
        let power = mean_radiance(geometry, textures, &part, radiance) * (PI * part.area);
        (
            element,
            part,
            PartBounds {
                bounds,
                normals,
                emission: FRAC_PI_2,
                power,
            },
        )
    };
    parts
        .into_iter()
        .filter(|(_, part, ..)| part.area > 0.0)
        .map(lit)
        .collect()
}

/// What direct light needs of a part of one color, if it is flat.
fn flat(geometry: &Geometry, part: &Part) -> Option<Flat> {
    let at = |element, coordinates| {
        geometry.surface_point(reference(part.primitive, element, coordinates))
    };
    let corners = |element| [Vec2::ZERO, Vec2::X, Vec2::Y].map(|c| at(element, c));
    let shape = geometry.primitives()[part.primitive.index()].shape;
    match (part.form, &geometry.shapes()[shape.index()]) {
        (Form::Triangle { element }, _) => Flat::triangles(&[corners(element)]),
        (Form::Primitive, Shape::Mesh(mesh)) if mesh.triangles.len() == 1 => {
            Flat::triangles(&[corners(0)])
        }
        (Form::Primitive, Shape::Mesh(mesh)) if mesh.triangles.len() == 2 => {
            Flat::triangles(&[corners(0), corners(1)])
        }
        (Form::Primitive, Shape::Disk) => {
            let [center, u, v] = corners(0);
            Some(Flat::disk([&center, &u, &v], part.area))
        }
        _ => None,
    }
}

/// How a sphere is sampled, its box and its normals.
fn sphere(
    geometry: &Geometry,
    primitive: PrimitiveId,
    center: Vec3,
    radius: f32,
    radiance: ColorInput,
) -> (Form, Aabb, Cone) {
    let to_world = &geometry.primitives()[primitive.index()].world_from_object;
    let r = Vec3::splat(radius);
    let bounds = Aabb {
        min: center - r,
        max: center + r,
    }
    .transformed(to_world);
    let center = to_world.transform_point3(center);
    let sample = geometry
        .sample_area(primitive, Vec2::splat(0.5))
        .map(|sample| sample.point);
    // The cone of visible points has no texture coordinates, and shows the outside only.
    let by_angle = |y: &SurfacePoint| {
        matches!(radiance, ColorInput::Constant(_)) && (y.p - center).dot(y.ng) > 0.0
    };
    let form = match (similarity_scale(to_world), sample.filter(by_angle)) {
        (Some(scale), Some(y)) => Form::Sphere {
            center,
            radius: radius * scale,
            offset: y.offset,
        },
        (Some(_), None) => Form::Primitive,
        // Of the unit sphere: 4π over the area element 2π² sin(π v) of its parameters.
        (None, _) => Form::Distorted {
            undistorted: |y| (PI * y.uv.y).sin() * FRAC_PI_2,
        },
    };
    (form, bounds, Cone::FULL)
}

/// The part of a point or spot.
pub(super) fn part_of_point(
    emitter: EmitterId,
    description: &Emitter,
    power: Rgb,
) -> Option<(Part, PartBounds)> {
    let (position, normals, emission) = match *description {
        Emitter::Point { position, .. } => (position, Cone::FULL, 0.0),
        Emitter::Spot {
            position,
            direction,
            cutoff,
            ..
        } => (
            position,
            Cone::from_axis(direction.normalize_or_zero()),
            cutoff,
        ),
        _ => return None,
    };
    let bounds = Aabb {
        min: position,
        max: position,
    };
    let part = Part {
        emitter,
        primitive: PrimitiveId(u32::MAX),
        form: Form::Point { position },
        area: 0.0,
        flat: None,
    };
    Some((
        part,
        PartBounds {
            bounds,
            normals,
            emission,
            power,
        },
    ))
}

impl Part {
    /// A point seen from `p`, in proportion to area or solid angle. `None` if no light comes from there.
    pub(super) fn sample(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        radiance: ColorInput,
        p: Vec3,
        u: Vec2,
    ) -> Option<SeenPoint> {
        if let (Some(flat), ColorInput::Constant(radiance)) = (&self.flat, radiance) {
            return flat.sample(radiance, p, u);
        }
        if let Some(cone) = self.visible_cone(p) {
            return self.sample_sphere(&cone, radiance, p, u);
        }
        let y = self.sample_area(geometry, u)?;
        let d = y.p - p;
        let wi = d.try_normalize()?;
        if y.frame.n.dot(wi) >= 0.0 {
            return None;
        }
        let pdf = self.pdf(p, &y);
        let radiance = radiance.eval(y.uv, textures);
        if !(pdf > 0.0 && pdf.is_finite()) || radiance.is_black() {
            return None;
        }
        Some(SeenPoint {
            wi,
            target: y.offset_towards(-wi),
            pdf,
            radiance,
        })
    }

    /// Density per solid angle with which [`Part::sample`] at `p` finds `y`.
    pub(super) fn pdf(&self, p: Vec3, y: &SurfacePoint) -> f32 {
        if let Some(cone) = self.visible_cone(p) {
            return if y.ng.dot(p - y.p) > 0.0 {
                1.0 / (TAU * cone.one_minus_cos)
            } else {
                0.0
            };
        }
        let d = y.p - p;
        let d2 = d.length_squared();
        let cos = y.ng.dot(d).abs() / d2.sqrt();
        if cos > 0.0 {
            d2 * self.pdf_area(y) / cos
        } else {
            0.0
        }
    }

    /// Density of [`Part::sample_area`] in 1/m².
    pub(super) fn pdf_area(&self, y: &SurfacePoint) -> f32 {
        match self.form {
            Form::Distorted { undistorted } => undistorted(y) / y.dp_du.cross(y.dp_dv).length(),
            _ => 1.0 / self.area,
        }
    }

    /// A point, uniform by area unless distorted.
    pub(super) fn sample_area(&self, geometry: &Geometry, u: Vec2) -> Option<SurfacePoint> {
        match self.form {
            Form::Primitive | Form::Sphere { .. } | Form::Distorted { .. } => {
                Some(geometry.sample_area(self.primitive, u)?.point)
            }
            Form::Triangle { element } => {
                Some(geometry.surface_point(reference(self.primitive, element, warp::triangle(u))))
            }
            Form::Point { .. } => None,
        }
    }

    fn visible_cone(&self, p: Vec3) -> Option<VisibleCone> {
        let Form::Sphere {
            center,
            radius,
            offset,
        } = self.form
        else {
            return None;
        };
        let to_center = center - p;
        let d2 = to_center.length_squared();
        // Inside, or too near the surface to tell: by area.
        if d2 <= (radius + offset) * (radius + offset) {
            return None;
        }
        let sin2 = radius * radius / d2;
        // 1 - cos without cancellation, for spheres that are small or far away.
        let one_minus_cos = sin2 / (1.0 + (1.0 - sin2).sqrt());
        Some(VisibleCone {
            center,
            radius,
            offset,
            distance: d2.sqrt(),
            one_minus_cos,
        })
    }

    fn sample_sphere(
        &self,
        cone: &VisibleCone,
        radiance: ColorInput,
        p: Vec3,
        u: Vec2,
    ) -> Option<SeenPoint> {
        let ColorInput::Constant(radiance) = radiance else {
            return None;
        };
        let axis = (cone.center - p) / cone.distance;
        let drop = u.y * cone.one_minus_cos;
        let (cos, sin) = (1.0 - drop, (drop * (2.0 - drop)).sqrt());
        let (sin_phi, cos_phi) = sin_cos_turns(u.x);
        let wi = Frame::from_normal(axis)
            .to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos))
            .normalize();
        // The nearer of the two points of the sphere on the ray.
        let half_chord2 = cone.radius * cone.radius - (cone.distance * sin).powi(2);
        let y = p + wi * (cone.distance * cos - half_chord2.max(0.0).sqrt());
        let n = (y - cone.center).normalize();
        let target = cone.center + n * (cone.radius + cone.offset);
        Some(SeenPoint {
            wi,
            target,
            pdf: 1.0 / (TAU * cone.one_minus_cos),
            radiance,
        })
    }
}

/// The directions from a point outside a sphere to the sphere.
struct VisibleCone {
    center: Vec3,
    radius: f32,
    offset: f32,
    distance: f32,
    one_minus_cos: f32,
}

fn reference(primitive: PrimitiveId, element: u32, coordinates: Vec2) -> SurfaceRef {
    SurfaceRef {
        primitive,
        element,
        instance: SurfaceRef::NO_INSTANCE,
        coordinates,
    }
}

fn triangle(
    geometry: &Geometry,
    primitive: PrimitiveId,
    emitter: EmitterId,
    element: u32,
) -> (Part, Aabb, Cone) {
    let corners = [Vec2::ZERO, Vec2::X, Vec2::Y]
        .map(|c| geometry.surface_point(reference(primitive, element, c)));
    let [a, b, c] = corners.map(|x| x.p);
    let area = 0.5 * (b - a).cross(c - a).length();
    // Interpolated normals lie between those of the corners, so a cone narrower than a half-space holds them all.
    let mut normals = corners.iter().fold(Cone::EMPTY, |cone, x| {
        cone.union(Cone::from_axis(x.frame.n))
    });
    if normals.half_angle >= FRAC_PI_2 {
        normals = Cone::FULL;
    }
    let part = Part {
        emitter,
        primitive,
        form: Form::Triangle { element },
        area,
        flat: None,
    };
    (part, Aabb::from_points([a, b, c]), normals)
}

fn mean_radiance(
    geometry: &Geometry,
    textures: &[Texture],
    part: &Part,
    radiance: ColorInput,
) -> Rgb {
    let id = match radiance {
        ColorInput::Constant(c) => return c,
        ColorInput::Texture(id) => id,
    };
    let count = (RADIANCE_GRID * RADIANCE_GRID) as f32;
    let grid = (0..RADIANCE_GRID * RADIANCE_GRID).map(|i| {
        Vec2::new(
            (i % RADIANCE_GRID) as f32 + 0.5,
            (i / RADIANCE_GRID) as f32 + 0.5,
        ) / RADIANCE_GRID as f32
    });
    let sum: Rgb = grid
        .filter_map(|u| part.sample_area(geometry, u))
        .map(|y| radiance.eval(y.uv, textures))
        .sum();
    let floor = textures[id.index()].max_luminance(textures) * RADIANCE_FLOOR;
    (sum / count).map(|v| v.max(floor))
}

/// The scale of a transform that keeps angles; `None` for others.
fn similarity_scale(transform: &Affine3A) -> Option<f32> {
    let m = &transform.matrix3;
    let scale2 = m.x_axis.length_squared();
    let tolerance = 1e-4 * scale2;
    let equal = |v: f32, expected: f32| (v - expected).abs() <= tolerance;
    let similar = equal(m.y_axis.length_squared(), scale2)
        && equal(m.z_axis.length_squared(), scale2)
        && equal(m.x_axis.dot(m.y_axis), 0.0)
        && equal(m.x_axis.dot(m.z_axis), 0.0)
        && equal(m.y_axis.dot(m.z_axis), 0.0);
    (similar && scale2 > 0.0).then(|| scale2.sqrt())
}
