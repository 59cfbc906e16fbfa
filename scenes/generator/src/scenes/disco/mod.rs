//! The disco: a dance floor under colored spot lights.

mod bar;
mod floor;
mod lights;
mod stage;

use super::Detail;
use crate::build::boxed;
use crate::material::{Material, Metal, coated, glass, matte, metal, tinted_metal};
use crate::scene::{About, Assembly, Camera, MaterialId, Scene};
use glam::DVec3;

/// Half the width of the room.
const HALF_WIDTH: f64 = 5.4;
/// z of the back wall.
const BACK: f64 = -4.9;
/// z of the wall behind the camera.
const FRONT: f64 = 5.2;
const HEIGHT: f64 = 4.2;
/// Center of the dance floor.
const CENTER: DVec3 = DVec3::new(-0.3, 0.0, -0.5);
/// Radius of the dance floor.
const RADIUS: f64 = 2.9;
/// Height of the dance floor above the floor of the room.
const DAIS: f64 = 0.14;

/// Generates the disco.
pub(super) fn scene(detail: Detail) -> Scene {
    let mut scene = Scene::new(
        About {
            title: "Disco",
            text: vec![
                "What it shows: a club before the guests come. Colored spots on a ring of truss shine at curved bands of \
                 brass, copper and steel, which gather the light into soft caustics on pale lacquer; where two of them \
                 cross, their colors add up. A ball of rough metal facets scatters more over walls and ceiling. Nothing \
                 is a mirror, and next to nothing but the floor is lit by the spots themselves."
                    .to_owned(),
                "Units: meters, y up. The room is 10.8 wide (x), 4.2 high and 10.1 deep (z from -4.9 to 5.2), closed on \
                 all sides; the camera stands inside. Written by manylight-scenes."
                    .to_owned(),
            ],
        },
        Camera {
            origin: DVec3::new(-2.7, 1.72, 4.7),
            target: DVec3::new(0.2, 1.15, -1.2),
            fov_x: 60.0,
            size: [640, 360],
            max_depth: 12,
        },
    );
    let materials = DiscoMaterials::new(&mut scene);
    shell(&mut scene, &materials);
    floor::add(&mut scene, &materials, detail);
    stage::add(&mut scene, &materials, detail);
    bar::add(&mut scene, &materials, detail);
    lights::add(&mut scene, &materials, detail);
    scene
}

/// Materials of the disco.
struct DiscoMaterials {
    plaster: MaterialId,
    ceiling: MaterialId,
    carpet: MaterialId,
    panel: MaterialId,
    pale: [MaterialId; 2],
    black: MaterialId,
    steel: MaterialId,
    satin: MaterialId,
    brass: MaterialId,
    copper: MaterialId,
    facet: MaterialId,
    dark: MaterialId,
    cone: MaterialId,
    velvet: MaterialId,
    leather: MaterialId,
    walnut: MaterialId,
    green_glass: MaterialId,
    amber_glass: MaterialId,
    blue_glass: MaterialId,
    label: MaterialId,
    glass: MaterialId,
    lamp: MaterialId,
}

impl DiscoMaterials {
    fn new(scene: &mut Scene) -> DiscoMaterials {
        let mut add = |name: &str, material: Material| scene.add_material(name, material);
        DiscoMaterials {
            plaster: add("plaster", matte([0.55, 0.53, 0.52])),
            ceiling: add("ceiling_paint", matte([0.3, 0.3, 0.32])),
            carpet: add("carpet", matte([0.13, 0.06, 0.085])),
            panel: add("plum_lacquer", coated([0.16, 0.05, 0.1], 0.14)),
            pale: [
                add("pale_lacquer", coated([0.72, 0.71, 0.69], 0.1)),
                add("gray_lacquer", coated([0.5, 0.5, 0.5], 0.1)),
            ],
            black: add("black_lacquer", coated([0.02, 0.02, 0.022], 0.08)),
            steel: add("steel", metal(Metal::Chromium, 0.1)),
            satin: add("satin_aluminium", metal(Metal::Aluminium, 0.2)),
            brass: add("brass", metal(Metal::Brass, 0.08)),
            copper: add("copper", metal(Metal::Copper, 0.09)),
            facet: add("facet", metal(Metal::Silver, 0.06)),
            dark: add("dark_metal", tinted_metal(Metal::Chromium, 0.35, [0.12; 3])),
            cone: add("speaker_cone", coated([0.05, 0.05, 0.055], 0.3)),
            velvet: add("velvet", matte([0.2, 0.05, 0.2])),
            leather: add("leather", coated([0.36, 0.05, 0.04], 0.25)),
            walnut: add("walnut", coated([0.26, 0.12, 0.055], 0.14)),
            green_glass: add("green_bottle", coated([0.03, 0.16, 0.06], 0.06)),
            amber_glass: add("amber_bottle", coated([0.42, 0.15, 0.02], 0.06)),
            blue_glass: add("blue_bottle", coated([0.03, 0.1, 0.34], 0.06)),
            label: add("label", matte([0.7, 0.64, 0.5])),
            glass: add("glass", glass()),
            lamp: add("lamp", matte([0.0; 3])),
        }
    }
}

/// Floor, ceiling and walls.
fn shell(scene: &mut Scene, materials: &DiscoMaterials) {
    let w = HALF_WIDTH;
    let mut assembly = Assembly::default();
    assembly.add(
        materials.carpet,
        &boxed([-w - 0.1, -0.1, BACK - 0.1], [w + 0.1, 0.0, FRONT + 0.1]),
    );
    assembly.add(
        materials.ceiling,
        &boxed(
            [-w - 0.1, HEIGHT, BACK - 0.1],
            [w + 0.1, HEIGHT + 0.1, FRONT + 0.1],
        ),
    );
    for (low, high) in [
        ([-w - 0.1, 0.0, BACK - 0.1], [w + 0.1, HEIGHT, BACK]),
        ([-w - 0.1, 0.0, FRONT], [w + 0.1, HEIGHT, FRONT + 0.1]),
        ([-w - 0.1, 0.0, BACK], [-w, HEIGHT, FRONT]),
        ([w, 0.0, BACK], [w + 0.1, HEIGHT, FRONT]),
    ] {
        assembly.add(materials.plaster, &boxed(low, high));
    }
    scene.place_assembly("room", assembly);
}
