//! Surface points against the surface interactions of Mitsuba 3.

use super::*;

/// p, geometric normal, shading normal, x of the shading frame, uv, dp_du, dp_dv.
type Expected = (
    [f32; 3],
    [f32; 3],
    [f32; 3],
    [f32; 3],
    [f32; 2],
    [f32; 3],
    [f32; 3],
);

/// Compares the nearest hit of the ray from (4, 3, 2) through `through`.
#[track_caller]
fn check(geometry: &Geometry, through: [f32; 3], expected: Expected) {
    let eye = Vec3::new(4.0, 3.0, 2.0);
    check_ray(
        geometry,
        &Ray::new(eye, (Vec3::from(through) - eye).normalize()),
        expected,
    );
}

#[track_caller]
fn check_ray(geometry: &Geometry, ray: &Ray, (p, ng, ns, s, uv, dp_du, dp_dv): Expected) {
    let hit = geometry.intersect(ray).expect("the ray hits");
    let x = geometry.surface_point(hit.at);
    let close = |name: &str, a: Vec3, b: [f32; 3]| {
        assert!((a - Vec3::from(b)).length() < 5e-5, "{name}: {a} {b:?}")
    };
    close("p", x.p, p);
    close("t", ray.at(hit.t), p);
    close("ng", x.ng, ng);
    close("ns", x.frame.n, ns);
    close("s", x.frame.s, s);
    close("uv", x.uv.extend(0.0), [uv[0], uv[1], 0.0]);
    close("dp_du", x.dp_du, dp_du);
    close("dp_dv", x.dp_dv, dp_dv);
}

#[test]
#[rustfmt::skip]
fn meshes_match_mitsuba() {
    let rectangle = || Shape::Mesh(Mesh::rectangle());
    let cube = || Shape::Mesh(Mesh::cube());
    let n = [0.414109, -0.431316, 0.801549];
    let back = [-0.414109, 0.431316, -0.801549];
    let s = [0.801549, 0.590077, -0.0965871];
    let mirrored_s = [-0.801549, -0.590077, 0.0965871];
    let (du, dv) = ([2.40465, 1.77023, -0.289761], [-1.29395, 2.04743, 1.77023]);
    let mirrored_du = [-2.40465, -1.77023, 0.289761];
    let (p, uv) = ([0.694976, -2.47038, 0.404471], [0.329057, 0.418055]);
    let target = [1.1, -1.8, 0.6];
    check(&alone(rectangle(), enlarged()), target, (p, n, n, s, uv, du, dv));
    // A reflection reverses the geometric normals of triangles, not the vertex normals.
    let uv = [0.670944, 0.418054];
    check(&alone(rectangle(), mirrored()), target, (p, back, n, mirrored_s, uv, mirrored_du, dv));
    check(&flipped(rectangle(), mirrored()), target, (p, n, back, mirrored_s, uv, mirrored_du, dv));

    let (p, n) = ([2.02731, -0.799256, 0.830998], [0.801549, 0.590077, -0.0965871]);
    let back = [-0.801549, -0.590077, 0.0965871];
    let s = [-0.431316, 0.682478, 0.590077];
    let (du, dv) = ([-1.29395, 2.04743, 1.77023], [-1.24233, 1.29395, -2.40465]);
    let target = [1.3, -2.2, 0.4];
    check(&alone(cube(), enlarged()), target, (p, n, n, s, [0.690567, 0.44239], du, dv));
    let dv = [1.24233, -1.29395, 2.40465];
    check(&alone(cube(), mirrored()), target, (p, back, n, s, [0.690567, 0.55761], du, dv));
    check(&flipped(cube(), mirrored()), target, (p, n, back, s, [0.690567, 0.55761], du, dv));
}

#[test]
#[rustfmt::skip]
fn vertex_normals_and_uvs_are_optional_as_in_mitsuba() {
    let positions = vec![Vec3::ZERO, Vec3::new(1.0, 0.0, 0.2), Vec3::new(0.0, 1.0, 0.1)];
    let normals: Vec<Vec3> =
        [[0.1, 0.0, 1.0], [0.0, 0.2, 1.0], [-0.1, 0.1, 0.9]].map(|n| Vec3::from(n).normalize()).to_vec();
    let uvs = vec![Vec2::new(0.1, 0.8), Vec2::new(0.8, 0.7), Vec2::new(0.3, 0.1)];
    let mesh = |normals: &[Vec3], uvs: &[Vec2]| {
        let (positions, normals, uvs) = (positions.clone(), normals.to_vec(), uvs.to_vec());
        alone(Shape::Mesh(Mesh { positions, normals, tangents: Vec::new(), uvs, triangles: vec![[0, 1, 2]] }), Affine3A::IDENTITY)
    };
    let ray = Ray::new(Vec3::new(0.25, 0.25, 3.0), Vec3::NEG_Z);
    let p = [0.25, 0.25, 0.075];
    let (ng, ns) = ([-0.19518, -0.09759, 0.9759], [0.0224718, 0.077022, 0.996776]);
    let (du, dv) = ([1.0, 0.0, 0.2], [0.0, 1.0, 0.1]);
    check_ray(&mesh(&[], &[]), &ray, (p, ng, ng, [0.980581, 0.0, 0.196116], [0.25, 0.25], du, dv));
    check_ray(&mesh(&normals, &[]), &ray, (p, ng, ns, [0.999628, -0.0171648, -0.0212098], [0.25, 0.25], du, dv));
    let (du, dv) = ([1.48936, -0.212766, 0.276596], [0.425532, -1.48936, -0.0638298]);
    check_ray(&mesh(&[], &uvs), &ray, (p, ng, ng, [0.973632, -0.13909, 0.180817], [0.325, 0.6], du, dv));
    check_ray(&mesh(&normals, &uvs), &ray, (p, ng, ns, [0.987589, -0.15673, -0.010154], [0.325, 0.6], du, dv));
    // Where uv is constant any tangent will do, and Mitsuba takes the frame of the normal.
    let frame = crate::math::Frame::from_normal(Vec3::from(ng));
    let (du, dv) = (frame.s.to_array(), frame.t.to_array());
    check_ray(&mesh(&[], &[Vec2::splat(0.5); 3]), &ray, (p, ng, ng, du, [0.5, 0.5], du, dv));
}

#[test]
#[rustfmt::skip]
fn analytic_shapes_match_mitsuba() {
    let n = [0.334393, 0.885384, 0.322919];
    check(&alone(ball(), enlarged()), [1.3, -2.2, 0.4], (
        [1.95348, -0.941445, 0.787248], n, n, [-0.849059, 0.134325, 0.510936], [0.112752, 0.495088],
        [-6.40099, 1.01266, 3.8519], [-1.54189, 1.67773, -3.00334],
    ));
    // Under a reflection only the normal of the sphere points inwards.
    let (n, back) = ([-0.642106, -0.762781, -0.0765829], [0.642106, 0.762781, 0.0765829]);
    let (p, s, uv) = ([1.60134, -1.61964, 0.578573], [0.644438, -0.482966, -0.592826], [0.453368, 0.500545]);
    let (du, dv) = ([4.85894, -3.64147, -4.4698], [-1.5653, 1.6211, -3.02227]);
    check(&alone(ball(), mirrored()), [1.3, -2.2, 0.4], (p, n, n, s, uv, du, dv));
    check(&flipped(ball(), mirrored()), [1.3, -2.2, 0.4], (p, back, back, s, uv, du, dv));

    let n = [0.414109, -0.431316, 0.801549];
    let (p, s, du) = ([0.694977, -2.47038, 0.404472], [-0.536347, -0.827113, -0.167975], [-0.804521, -1.24067, -0.251963]);
    let target = [1.1, -1.8, 0.6];
    check(&alone(Shape::Disk, enlarged()), target, (p, n, n, s, [0.379136, 0.571144], du, [2.62786, -1.28762, -2.05052]));
    check(&alone(Shape::Disk, mirrored()), target, (p, n, n, s, [0.379136, 0.928856], du, [-2.62786, 1.28762, 2.05052]));

    let n = [0.264161, -0.0666574, 0.962172];
    check(&alone(pipe(), enlarged()), [1.6, -2.2, 1.1], (
        [1.91879, -1.50928, 1.21955], n, n, [0.954921, 0.15817, -0.251213], [0.812157, 0.414283],
        [5.39995, 0.894431, -1.42058], [-0.307441, 2.23622, 0.239328],
    ));
}

#[test]
#[rustfmt::skip]
fn instances_match_mitsuba() {
    let group = placed(0, Affine3A::from_scale(Vec3::new(1.0, 2.0, 1.0)));
    let instance = Instance { group: 0, world_from_group: mirrored() };
    let geometry = Geometry::build(vec![Shape::Mesh(Mesh::rectangle())], vec![group], one_group(), vec![instance]);
    let n = [0.414109, -0.431316, 0.801549];
    check(&geometry, [1.1, -1.8, 0.6], (
        [0.694975, -2.47039, 0.40447], n, n, [-0.801549, -0.590077, 0.0965871], [0.670943, 0.459027],
        [-2.40465, -1.77023, 0.289761], [-2.58789, 4.09487, 3.54046],
    ));
    assert_eq!(geometry.triangle_count(), 2);
}
