//! Error messages of rejected descriptions, and transmittance through transparent surfaces.

use super::*;
use crate::bsdf::Material;
use crate::bsdf::material::ColorShift;
use crate::emitters::Emitter;
use crate::film::{FilmDesc, Filter};
use crate::geometry::{Mesh, Shape};
use crate::ids::{EmitterId, MaterialId, ShapeId, TextureId};
use crate::math::{Affine3A, UVec2, Vec2, Vec3};
use crate::sensors::{FovAxis, SensorDesc, SensorKind};
use crate::texture::{ColorInput, FloatInput};

fn sensor() -> SensorDesc {
    SensorDesc {
        name: String::new(),
        world_from_camera: Affine3A::IDENTITY,
        motion: Vec::new(),
        kind: SensorKind::Perspective {
            fov: 40.0,
            fov_axis: FovAxis::X,
        },
        principal_point_offset: Vec2::ZERO,
        near_clip: 0.01,
        far_clip: 100.0,
        film: FilmDesc {
            size: UVec2::new(4, 3),
            crop_offset: UVec2::ZERO,
            crop_size: UVec2::new(4, 3),
            filter: Filter::Box,
        },
    }
}

fn placed(shape: u32, material: u32, world_from_object: Affine3A) -> PrimitiveDesc {
    PrimitiveDesc {
        name: "pane".to_owned(),
        shape: ShapeId(shape),
        world_from_object,
        flip_normals: false,
        material: MaterialId(material),
        emitter: None,
    }
}

/// Material 0 is opaque, 1 transmits three quarters, 2 transmits everything; shape 0 is a
/// rectangle, 1 a sphere.
fn desc() -> SceneDesc {
    SceneDesc {
        shapes: vec![
            Shape::Mesh(Mesh::rectangle()),
            Shape::Sphere {
                center: Vec3::ZERO,
                radius: 1.0,
            },
        ],
        materials: vec![
            Material::default(),
            Material::Mask {
                opacity: FloatInput::Constant(0.25),
                inner: MaterialId(0),
            },
            Material::Null,
        ],
        emitters: vec![
            Emitter::Area {
                radiance: ColorInput::Constant(Rgb::WHITE),
            },
            Emitter::Constant {
                radiance: Rgb::WHITE,
            },
        ],
        primitives: vec![placed(0, 0, Affine3A::IDENTITY)],
        sensors: vec![sensor()],
        ..SceneDesc::default()
    }
}

#[track_caller]
fn refused(change: impl FnOnce(&mut SceneDesc), message: &str) {
    let mut desc = desc();
    change(&mut desc);
    assert_eq!(
        Scene::build(desc, 0)
            .expect_err("the scene is broken")
            .message,
        message
    );
}

#[test]
fn broken_references_are_refused() {
    refused(
        |d| d.primitives[0].shape = ShapeId(7),
        "primitive \"pane\": there is no shape 7, only 2",
    );
    refused(
        |d| d.primitives[0].material = MaterialId(3),
        "primitive \"pane\": there is no material 3, only 3",
    );
    refused(
        |d| d.primitives[0].emitter = Some(EmitterId(2)),
        "primitive \"pane\": there is no emitter 2, only 2",
    );
    refused(
        |d| d.primitives[0].emitter = Some(EmitterId(1)),
        "primitive \"pane\": emitter 1 is not an area emitter and cannot sit on a surface",
    );
    let texture = ColorInput::Texture(TextureId(0));
    refused(
        |d| {
            d.materials.push(Material::Diffuse {
                reflectance: texture,
            })
        },
        "material 3: there is no texture 0, only 0",
    );
    refused(
        |d| d.emitters[0] = Emitter::Area { radiance: texture },
        "emitter 0: there is no texture 0, only 0",
    );
    refused(
        |d| {
            d.instances.push(InstanceDesc {
                name: String::new(),
                group: 0,
                world_from_group: Affine3A::IDENTITY,
            })
        },
        "instance 0: there is no group 0, only 0",
    );
    assert!(
        Scene::build(desc(), 1)
            .is_err_and(|e| e.message == "sensor 1 was asked for, but the scene has 1")
    );
}

#[test]
fn cycles_of_materials_are_refused_and_shared_ones_are_not() {
    let both = |first, second| Material::Blend {
        weight: FloatInput::Constant(0.5),
        first: MaterialId(first),
        second: MaterialId(second),
    };
    refused(|d| d.materials[2] = both(0, 2), "material 2 wraps itself");
    refused(
        |d| {
            d.materials.extend([
                both(0, 4),
                Material::TwoSided {
                    front: MaterialId(0),
                    back: MaterialId(3),
                },
            ])
        },
        "material 3 wraps itself",
    );
    let mut shared = desc();
    shared
        .materials
        .extend([both(0, 0), both(3, 0), both(4, 3)]);
    assert!(Scene::build(shared, 0).is_ok());
}

#[test]
fn broken_geometry_is_refused() {
    let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
    refused(
        |d| d.primitives[0].world_from_object = flat,
        "primitive \"pane\": the transform is singular",
    );
    let infinite = Affine3A::from_translation(Vec3::INFINITY);
    refused(
        |d| d.primitives[0].world_from_object = infinite,
        "primitive \"pane\": the transform is not finite",
    );
    let mesh = |change: fn(&mut Mesh)| {
        move |d: &mut SceneDesc| {
            let mut mesh = Mesh::rectangle();
            change(&mut mesh);
            d.shapes[0] = Shape::Mesh(mesh);
        }
    };
    refused(
        mesh(|m| m.triangles[1][2] = 4),
        "shape 0: triangle 1 names the vertices [1, 3, 4] of 4",
    );
    refused(
        mesh(|m| m.positions[2].y = f32::NAN),
        "shape 0: position 2 is not finite",
    );
    refused(
        mesh(|m| m.uvs.truncate(3)),
        "shape 0: 3 uvs for 4 positions; none or one each expected",
    );
    refused(
        |d| {
            d.shapes[1] = Shape::Sphere {
                center: Vec3::ZERO,
                radius: 0.0,
            }
        },
        "shape 1: the radius 0 is not positive and finite",
    );
    refused(
        |d| {
            d.shapes[1] = Shape::Cylinder {
                p0: Vec3::X,
                p1: Vec3::X,
                radius: 1.0,
            }
        },
        "shape 1: the axis has no length",
    );
    refused(
        |d| {
            d.groups.push(vec![PrimitiveDesc {
                emitter: Some(EmitterId(0)),
                ..placed(0, 0, Affine3A::IDENTITY)
            }])
        },
        "in a group, primitive \"pane\": has an emitter, which is not possible inside a group",
    );
}

#[test]
fn broken_films_are_refused() {
    refused(
        |d| d.sensors[0].film.size.x = 0,
        "the sensor: the film of 0 x 3 pixels is empty",
    );
    refused(
        |d| d.sensors[0].film.crop_size.y = 0,
        "the sensor: the crop of 4 x 0 pixels is empty",
    );
    refused(
        |d| d.sensors[0].film.crop_offset.x = 1,
        "the sensor: the crop of 4 x 3 at 1 x 0 leaves the film of 4 x 3 pixels",
    );
}

#[test]
fn sensors_out_of_their_domain_are_refused() {
    fn lens(fov: f32, aperture_radius: f32, focus_distance: f32) -> SensorKind {
        SensorKind::ThinLens {
            fov,
            fov_axis: FovAxis::X,
            aperture_radius,
            focus_distance,
        }
    }
    for (fov, message) in [(0.0, "0"), (180.0, "180"), (-3.0, "-3"), (f32::NAN, "NaN")] {
        let message =
            format!("the sensor: the field of view {message} is not between 0 and 180 degrees");
        refused(|d| d.sensors[0].kind = lens(fov, 0.0, 1.0), &message);
        let fov_axis = FovAxis::Y;
        refused(
            |d| d.sensors[0].kind = SensorKind::Perspective { fov, fov_axis },
            &message,
        );
    }
    refused(
        |d| d.sensors[0].kind = lens(40.0, -1.0, 1.0),
        "the sensor: the aperture radius -1 is negative or not finite",
    );
    refused(
        |d| d.sensors[0].kind = lens(40.0, 0.1, f32::INFINITY),
        "the sensor: the focus distance inf is not positive and finite",
    );
    refused(
        |d| d.sensors[0].principal_point_offset.y = f32::NAN,
        "the sensor: the principal point offset [0, NaN] is not finite",
    );
    refused(
        |d| d.sensors[0].near_clip = f32::NAN,
        "the sensor: the clip distances NaN and 100 are not finite or not in order",
    );
    refused(
        |d| d.sensors[0].film.filter = Filter::Gaussian { stddev: 0.0 },
        "the sensor: the radius 0 of the filter is not positive and finite",
    );
    let endless = SensorDesc {
        near_clip: 0.0,
        far_clip: f32::INFINITY,
        ..sensor()
    };
    let sensors = vec![endless];
    assert!(Scene::build(SceneDesc { sensors, ..desc() }, 0).is_ok());
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let not_a_number = Rgb::splat(f32::NAN);
    refused(
        |d| {
            d.emitters.push(Emitter::Point {
                position: Vec3::ZERO,
                intensity: not_a_number,
            })
        },
        "emitter 2: the intensity NaN, NaN, NaN is not finite",
    );
    refused(
        |d| {
            d.emitters.push(Emitter::Directional {
                direction: Vec3::ZERO,
                irradiance: Rgb::WHITE,
            })
        },
        "emitter 2: the direction [0, 0, 0] is not finite or has no length",
    );
    refused(
        |d| {
            d.materials[0] = Material::Diffuse {
                reflectance: ColorInput::Constant(not_a_number),
            }
        },
        "material 0: the color NaN, NaN, NaN is not finite",
    );
    refused(
        |d| {
            d.materials[1] = Material::Mask {
                opacity: FloatInput::Constant(f32::INFINITY),
                inner: MaterialId(0),
            }
        },
        "material 1: a parameter, inf, is not finite",
    );
    refused(
        |d| {
            d.materials[0] = Material::Plastic {
                eta: 0.0,
                diffuse_reflectance: ColorInput::Constant(Rgb::WHITE),
                specular_reflectance: ColorInput::Constant(Rgb::WHITE),
                color_shift: ColorShift::Linear,
                roughness: None,
            }
        },
        "material 0: the index of refraction 0 is not positive and finite",
    );
}

#[test]
fn another_sensor_sees_the_same_scene() {
    let mut scene = Scene::build(desc(), 0).unwrap();
    let mut other = sensor();
    other.film.size = UVec2::new(8, 6);
    scene.set_sensor(other.clone()).unwrap();
    assert_eq!(scene.sensor.desc().film.size, UVec2::new(8, 6));
    let center = |scene: &Scene| scene.sensor.ray(Vec2::new(2.0, 1.5), Vec2::ZERO).d;
    let before = center(&scene);
    other.film.crop_size = UVec2::ZERO;
    assert!(scene.set_sensor(other).is_err());
    assert_eq!(center(&scene), before);
    assert_ne!(center(&Scene::build(desc(), 0).unwrap()), before);
}

#[test]
fn a_small_scale_is_not_singular() {
    let mut small = desc();
    small.primitives[0].world_from_object = Affine3A::from_scale(Vec3::splat(1e-14));
    assert!(Scene::build(small, 0).is_ok());
}

fn with(primitives: Vec<PrimitiveDesc>) -> Scene {
    Scene::build(
        SceneDesc {
            primitives,
            ..desc()
        },
        0,
    )
    .expect("the description is sound")
}

fn at(z: f32) -> Affine3A {
    Affine3A::from_translation(Vec3::Z * z)
}

#[track_caller]
fn check(scene: &Scene, from: Vec3, to: Vec3, transmittance: f32, crossings: u32) {
    for (from, to) in [(from, to), (to, from)] {
        let (through, count) = scene.transmittance_and_crossings(&Segment { from, to });
        assert!(
            (through.r - transmittance).abs() < 1e-5 && count == crossings,
            "{through:?} {count}"
        );
        assert_eq!(scene.transmittance(&Segment { from, to }), through);
    }
}

#[test]
fn light_passes_masks_and_null_surfaces() {
    let (from, to) = (Vec3::new(0.1, 0.2, -5.0), Vec3::new(0.2, 0.3, 5.0));
    check(&with(vec![]), from, to, 1.0, 0);
    check(&with(vec![placed(0, 1, at(0.0))]), from, to, 0.75, 1);
    check(
        &with(vec![placed(0, 1, at(0.0)), placed(0, 1, at(1.0))]),
        from,
        to,
        0.5625,
        2,
    );
    check(
        &with(vec![placed(0, 1, at(0.0)), placed(0, 1, at(9.0))]),
        from,
        to,
        0.75,
        1,
    );
    check(
        &with(vec![placed(1, 2, at(0.0)), placed(0, 1, at(0.5))]),
        from,
        to,
        0.75,
        3,
    );
    check(
        &with(vec![placed(0, 1, at(0.0)), placed(0, 0, at(1.0))]),
        from,
        to,
        0.0,
        0,
    );
}

#[test]
fn crossings_are_counted_once_at_any_scale_and_angle() {
    let stack = (0..50).map(|i| placed(0, 1, at(0.01 * i as f32)));
    for scale in [1e-3, 1.0, 1e3] {
        for shift in [Vec3::ZERO, Vec3::new(100.0, -30.0, 50.0)] {
            let transform =
                Affine3A::from_scale(Vec3::splat(scale)) * Affine3A::from_translation(shift);
            let scene = with(
                stack
                    .clone()
                    .map(|p| PrimitiveDesc {
                        world_from_object: transform * p.world_from_object,
                        ..p
                    })
                    .collect(),
            );
            let through = |from: Vec3, to: Vec3, count: i32| {
                let [from, to] = [from, to].map(|p| transform.transform_point3(p));
                check(&scene, from, to, 0.75f32.powi(count), count as u32);
            };
            through(Vec3::new(0.3, 0.1, -1.0), Vec3::new(0.2, 0.3, 1.0), 50);
            // Along the edge that the two triangles share.
            through(Vec3::new(0.3, -0.3, -1.0), Vec3::new(0.3, -0.3, 1.0), 50);
            // Nearly within the panes.
            through(Vec3::new(-0.9, 0.1, 0.005), Vec3::new(0.9, 0.3, 0.035), 3);
        }
    }
}

#[test]
fn coincident_surfaces_do_not_trap_the_light() {
    let scene = with(vec![placed(0, 1, at(0.0)); 5]);
    let segment = Segment {
        from: Vec3::new(0.1, 0.2, -1.0),
        to: Vec3::new(0.1, 0.2, 1.0),
    };
    let (through, crossings) = scene.transmittance_and_crossings(&segment);
    assert!((1..=5).contains(&crossings));
    assert!((through.r - 0.75f32.powi(crossings as i32)).abs() < 1e-5);
}
