//! Points of many references in lanes: against single points, and against formulas in `f64`.

use super::*;
use crate::lanes::Width;
use crate::math::Frame;
use crate::simd::{Isa, Simd, SimdKernel};
use glam::{DAffine3, DVec2, DVec3};

/// Which attributes the vertices of a mesh have.
#[derive(Clone, Copy)]
struct Attributes {
    normals: bool,
    uvs: bool,
    tangents: bool,
}

fn mesh(random: &mut Random, attributes: Attributes) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..20 {
        let center = random.point(1.0);
        let corners = [Vec3::X, Vec3::Y, Vec3::Z].map(|e| center + e + random.point(0.3));
        mesh.positions.extend(corners);
        mesh.triangles.push([3 * i + 1, 3 * i, 3 * i + 2]);
    }
    let count = mesh.positions.len();
    let unit = |random: &mut Random| (Vec3::splat(-0.6) + random.point(0.4)).normalize();
    if attributes.normals {
        mesh.normals = (0..count).map(|_| unit(random)).collect();
    }
    if attributes.uvs {
        let corner = |i: usize| [Vec2::ZERO, Vec2::X, Vec2::ONE][i % 3];
        mesh.uvs = (0..count)
            .map(|i| corner(i) + 0.3 * random.square())
            .collect();
    }
    if attributes.tangents {
        mesh.tangents = (0..count).map(|_| random.point(1.0)).collect();
    }
    mesh
}

/// All shapes under all transforms, with and without flipped normals, of the world and of a group
/// with two instances; and the shapes.
fn everything() -> (Geometry, Vec<Shape>) {
    let random = &mut Random(Pcg::new(53));
    let mut shapes = vec![ball(), pipe(), Shape::Disk, Shape::Mesh(Mesh::rectangle())];
    for bits in 0..6 {
        let attributes = Attributes {
            normals: bits & 1 != 0 || bits >= 4,
            uvs: bits & 2 != 0 || bits == 5,
            tangents: bits >= 4,
        };
        shapes.push(Shape::Mesh(mesh(random, attributes)));
    }
    let constant_uv = Mesh {
        uvs: vec![Vec2::splat(0.3); 60],
        ..mesh(
            random,
            Attributes {
                normals: true,
                uvs: false,
                tangents: false,
            },
        )
    };
    shapes.push(Shape::Mesh(constant_uv));
    let stretched = turned() * Affine3A::from_scale(Vec3::new(1.0, 2.0, -0.5));
    let transforms = [Affine3A::IDENTITY, enlarged(), mirrored(), stretched];
    let mut primitives = Vec::new();
    for _ in ["world", "group"] {
        for shape in 0..shapes.len() {
            for (i, transform) in transforms.iter().enumerate() {
                primitives.push(Primitive {
                    flip_normals: (shape + i) % 2 == 0,
                    ..placed(shape as u32, *transform)
                });
            }
        }
    }
    let group = primitives.len() / 2..primitives.len();
    let instances = [mirrored(), stretched].map(|world_from_group| Instance {
        group: 0,
        world_from_group,
    });
    let geometry = Geometry::build(shapes.clone(), primitives, vec![group], instances.to_vec());
    (geometry, shapes)
}

/// A reference to a random point. With `Some(primitive)`, of this primitive.
fn reference(random: &mut Random, geometry: &Geometry, primitive: Option<usize>) -> SurfaceRef {
    let count = geometry.primitives().len();
    let draw = |random: &mut Random, n: usize| ((random.number() * n as f32) as usize).min(n - 1);
    let primitive = primitive.unwrap_or_else(|| draw(random, count));
    let shape = geometry.primitives()[primitive].shape;
    let triangles = match &geometry.shapes()[shape.index()] {
        Shape::Mesh(mesh) => mesh.triangles.len(),
        _ => 1,
    };
    let instance = match primitive < count / 2 {
        true => SurfaceRef::NO_INSTANCE,
        false => draw(random, 2) as u32,
    };
    SurfaceRef {
        primitive: PrimitiveId::from(primitive),
        element: draw(random, triangles) as u32,
        instance,
        coordinates: crate::sampling::warp::triangle(random.square()),
    }
}

/// The points of some references in lanes, one by one.
struct Points<'a> {
    geometry: &'a Geometry,
    at: [SurfaceRef; 16],
    derivatives: Derivatives,
}

impl SimdKernel for Points<'_> {
    type Output = [SurfacePoint; 16];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> [SurfacePoint; 16] {
        let s = s.wide();
        let at = s.each(|i| self.at[i]);
        let points = self.geometry.surface_points(s, &at, self.derivatives);
        let points = points.store();
        std::array::from_fn(|i| points.as_ref()[i])
    }
}

#[track_caller]
fn assert_same(a: &SurfacePoint, b: &SurfacePoint, derivatives: Derivatives) {
    let close = |name: &str, u: Vec3, v: Vec3, tolerance: f32| {
        let error = (u - v).length();
        assert!(
            error <= tolerance * v.length().max(1.0),
            "{name}: {u} {v} at {:?}",
            b.at
        );
    };
    assert_eq!(a.at, b.at);
    close("p", a.p, b.p, 1e-6);
    close("ng", a.ng, b.ng, 1e-6);
    close("s", a.frame.s, b.frame.s, 2e-5);
    close("t", a.frame.t, b.frame.t, 2e-5);
    close("n", a.frame.n, b.frame.n, 2e-6);
    close("uv", a.uv.extend(a.offset), b.uv.extend(b.offset), 1e-6);
    if derivatives == Derivatives::OfPosition {
        close("dp_du", a.dp_du, b.dp_du, 1e-5);
        close("dp_dv", a.dp_dv, b.dp_dv, 1e-5);
    }
}

#[test]
fn points_in_lanes_are_those_of_single_references() {
    let (geometry, _) = everything();
    let random = &mut Random(Pcg::new(12));
    for set in Instructions::available() {
        let isa = Isa::new(set).expect("available");
        for round in 0..600 {
            // Lanes with all kinds of primitives, with one each, and with a single one.
            let at = std::array::from_fn(|i| match round % 3 {
                0 => reference(random, &geometry, None),
                1 => reference(
                    random,
                    &geometry,
                    Some((round / 3) % geometry.primitives().len()),
                ),
                _ => reference(random, &geometry, Some(16 + i)),
            });
            for derivatives in [Derivatives::OfPosition, Derivatives::Unspecified] {
                let points = isa.run(Points {
                    geometry: &geometry,
                    at,
                    derivatives,
                });
                for (point, at) in points.iter().zip(at) {
                    assert_same(point, &geometry.surface_point(at), derivatives);
                    assert!((geometry.uv(at) - point.uv).length() < 1e-6);
                }
            }
        }
    }
}

#[test]
fn points_of_meshes_follow_from_the_description() {
    let (geometry, shapes) = everything();
    let random = &mut Random(Pcg::new(71));
    for round in 0..5000 {
        let at = reference(random, &geometry, None);
        let primitive = &geometry.primitives()[at.primitive.index()];
        let Shape::Mesh(mesh) = &shapes[primitive.shape.index()] else {
            continue;
        };
        if at.instance != SurfaceRef::NO_INSTANCE
            || mesh.uvs.first() == mesh.uvs.get(1) && round % 2 == 0
        {
            continue;
        }
        check_point(&geometry.surface_point(at), mesh, primitive);
    }
}

/// Compares a point of a mesh with its definition.
#[track_caller]
fn check_point(x: &SurfacePoint, mesh: &Mesh, primitive: &Primitive) {
    let m = &primitive.world_from_object;
    let to_world = DAffine3::from_cols_array(&m.to_cols_array().map(f64::from));
    let normals = to_world.matrix3.inverse().transpose();
    let corners = mesh.triangles[x.at.element as usize].map(|i| i as usize);
    let (u, v) = (f64::from(x.at.coordinates.x), f64::from(x.at.coordinates.y));
    let mix = |[a, b, c]: [DVec3; 3]| a * (1.0 - u - v) + b * u + c * v;
    let flip = if primitive.flip_normals { -1.0 } else { 1.0 };
    let [a, b, c] = corners.map(|i| to_world.transform_point3(mesh.positions[i].as_dvec3()));
    let ng = flip * (b - a).cross(c - a).normalize();
    let uvs = match mesh.uvs.is_empty() {
        true => [DVec2::ZERO, DVec2::X, DVec2::Y],
        false => corners.map(|i| mesh.uvs[i].as_dvec2()),
    };
    let uv = mix(uvs.map(|uv| uv.extend(0.0))).truncate();
    let (d, e) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
    let determinant = d.perp_dot(e);
    let mut derivatives = [
        ((b - a) * e.y - (c - a) * d.y) / determinant,
        ((c - a) * d.x - (b - a) * e.x) / determinant,
    ];
    if determinant == 0.0 {
        let frame = Frame::from_normal(ng.as_vec3());
        derivatives = [frame.s.as_dvec3(), frame.t.as_dvec3()];
    }
    let n = match mesh.normals.is_empty() {
        true => ng,
        false => {
            flip * mix(corners.map(|i| (normals * mesh.normals[i].as_dvec3()).normalize()))
                .normalize()
        }
    };
    let tangent = match mesh.tangents.is_empty() {
        true => derivatives[0],
        false => to_world.transform_vector3(mix(corners.map(|i| mesh.tangents[i].as_dvec3()))),
    };
    let s = (tangent - n * n.dot(tangent)).normalize();
    let expected = SurfacePoint {
        p: mix([a, b, c]).as_vec3(),
        ng: ng.as_vec3(),
        frame: Frame {
            s: s.as_vec3(),
            t: n.cross(s).as_vec3(),
            n: n.as_vec3(),
        },
        uv: uv.as_vec2(),
        dp_du: derivatives[0].as_vec3(),
        dp_dv: derivatives[1].as_vec3(),
        ..*x
    };
    assert_same(x, &expected, Derivatives::OfPosition);
}
