//! The light tracer is the adjoint of the path tracer: all differences between the two directions
//! must cancel.

use crate::common::film;
use manylight::color::Rgb;
use manylight::film::Layer;
use manylight::geometry::{Mesh, Shape};
use manylight::integrators::MethodKind;
use manylight::math::{Affine3A, Vec3};
use manylight::scene::{PathLimits, Scene};
use manylight::testing::scenes::{Builder, glass, glossy_box};
use manylight::testing::statistics::{block_z_scores, channel_means};

fn check(scene: &Scene, path_passes: u32, light_passes: u32) {
    let path = film(scene, MethodKind::Path, path_passes, 1);
    let light = film(scene, MethodKind::LightTracer, light_passes, 2);
    for ((a, se_a), (b, se_b)) in channel_means(&path).into_iter().zip(channel_means(&light)) {
        // Pixels of the light tracer are correlated along paths: 2 % covers that beside the pixel
        // variances.
        assert!(
            (a - b).abs() < 4.0 * (se_a + se_b) + 0.02 * a,
            "means {a} and {b}, standard errors {se_a}, {se_b}"
        );
    }
    let z = block_z_scores(&path, &light, 8);
    let far = z.iter().filter(|z| z.abs() > 4.0).count();
    assert!(
        far * 50 <= z.len(),
        "{far} of {} blocks beyond 4 standard errors: {z:?}",
        z.len()
    );
}

#[test]
fn glossy_room() {
    check(&glossy_box(32).build(), 256, 512);
}

/// A coarse sphere with interpolated normals: shading and geometric normals differ by up to 20
/// degrees.
#[test]
fn shading_normals() {
    let mut b = glossy_box(32);
    let white = b.material(manylight::testing::scenes::diffuse(0.8, 0.8, 0.8));
    b.place(
        Shape::Mesh(coarse_sphere()),
        Affine3A::from_scale(Vec3::splat(0.45)),
        white,
        None,
    );
    check(&b.build(), 256, 512);
}

/// A glass ball above a diffuse floor: η² and caustics. The camera sees only the floor.
#[test]
fn refraction() {
    let mut b = Builder::new(
        Vec3::new(0.0, 2.0, -3.0),
        Vec3::new(0.0, 0.0, 0.0),
        40.0,
        32,
    );
    let white = b.material(manylight::testing::scenes::diffuse(0.7, 0.7, 0.7));
    let ball = b.material(glass());
    b.rectangle(Vec3::ZERO, Vec3::Z * 1.5, Vec3::X * 1.5, white, None);
    let lamp = b.area_light(Rgb::splat(20.0));
    // The ball stands outside the view; its caustic falls inside.
    b.place(
        Shape::Sphere {
            center: Vec3::new(0.0, 2.6, 0.3),
            radius: 0.5,
        },
        Affine3A::IDENTITY,
        ball,
        None,
    );
    b.rectangle(
        Vec3::new(0.0, 4.5, 0.3),
        Vec3::X * 0.4,
        Vec3::Z * 0.4,
        white,
        Some(lamp),
    );
    b.desc.limits = PathLimits {
        max_depth: Some(5),
        ..PathLimits::default()
    };
    check(&b.build(), 1024, 512);
}

/// A block of smooth glass in one half of the view. No photon that meets the camera can come from a
/// delta event: that half is black, as documented. The other half agrees with path tracing, with
/// the light that comes through the glass.
#[test]
fn smooth_glass_in_view_is_black() {
    let mut b = Builder::new(Vec3::new(0.0, 2.0, -1.5), Vec3::ZERO, 40.0, 32);
    let white = b.material(manylight::testing::scenes::diffuse(0.7, 0.7, 0.7));
    let block = b.material(glass());
    b.rectangle(Vec3::ZERO, Vec3::Z * 1.5, Vec3::X * 1.5, white, None);
    let place = Affine3A::from_translation(Vec3::new(0.7, 0.8, -0.3))
        * Affine3A::from_scale(Vec3::new(0.7, 0.1, 1.2));
    b.place(Shape::Mesh(Mesh::cube()), place, block, None);
    let lamp = b.area_light(Rgb::splat(20.0));
    b.rectangle(
        Vec3::new(0.3, 3.0, 0.3),
        Vec3::X * 0.4,
        Vec3::Z * 0.4,
        white,
        Some(lamp),
    );
    let scene = b.build();
    let halves = |kind, passes| {
        let film = film(&scene, kind, passes, 3);
        let image = film.image(Layer::Beauty).expect("every film has a beauty");
        let mut sums = [0.0f64; 2];
        for (i, value) in image.data.iter().enumerate() {
            let column = i / image.channels % image.width;
            sums[usize::from(2 * column >= image.width)] += f64::from(*value);
        }
        sums
    };
    let path = halves(MethodKind::Path, 1024);
    let light = halves(MethodKind::LightTracer, 512);
    let glass = usize::from(light[1] < light[0]);
    assert_eq!(light[glass], 0.0);
    let (truth, ours) = (path[1 - glass], light[1 - glass]);
    assert!(
        path[glass] > 0.5 * truth,
        "the glass shows the floor: {path:?}"
    );
    assert!(
        (ours / truth - 1.0).abs() < 0.01,
        "{ours} instead of {truth}"
    );
}

/// An octahedron subdivided twice, with the normals of the sphere at its vertices.
fn coarse_sphere() -> Mesh {
    let mut positions = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    for _ in 0..1 {
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let mut middle = |i: u32, j: u32| {
                    positions.push((positions[i as usize] + positions[j as usize]).normalize());
                    positions.len() as u32 - 1
                };
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh {
        normals: positions.clone(),
        positions,
        tangents: Vec::new(),
        uvs: Vec::new(),
        triangles,
    }
}
