//! The kitchen: a furnished room late in the day.

mod cabinets;
mod cookware;
mod food;
mod fridge;
mod room;
mod shelves;
mod sink;
mod stove;
mod table;
mod vessels;

use super::Detail;
use crate::material::{Material, Metal, coated, coated_texture, glass, matte, metal, tinted_metal};
use crate::mesh::Mesh;
use crate::noise::fractal_noise;
use crate::pcg::Pcg32;
use crate::png::PngImage;
use crate::scene::{About, Assembly, Camera, MaterialId, Scene};
use glam::DVec3;

/// Half the width of the room.
const HALF_WIDTH: f64 = 2.4;
/// z of the back wall.
const BACK: f64 = -2.0;
/// z of the wall behind the camera.
const FRONT: f64 = 3.2;
const HEIGHT: f64 = 2.6;
/// Height of the worktops.
const WORKTOP: f64 = 0.91;
/// z of the front edge of the worktop at the back wall.
const WORKTOP_FRONT: f64 = BACK + 0.63;
/// Centers (x, z) of the four hobs.
const HOBS: [(f64, f64); 4] = [
    (0.17, BACK + 0.19),
    (0.63, BACK + 0.19),
    (0.17, BACK + 0.45),
    (0.63, BACK + 0.45),
];
/// Center (x, z) of the table.
const TABLE_CENTER: (f64, f64) = (-0.25, 0.75);
/// Height of the table top.
const TABLE_TOP: f64 = 0.76;

/// Generates the kitchen.
pub(super) fn scene(detail: Detail) -> Scene {
    let mut scene = Scene::new(
        About {
            title: "Kitchen",
            text: vec![
                "What it shows: a lived-in kitchen late in the day. Low sun comes in over the sink, grazes the worktop and \
                 lands behind the eye; lamps under the shelves light little but the glazed tiles. The rest is what tiles, \
                 lacquered doors, oiled oak, brushed steel and copper pass on to each other."
                    .to_owned(),
                "Units: meters, y up. The room is 4.8 wide (x), 2.6 high and 5.2 deep (z from -2 to 3.2), closed on all \
                 sides; the camera stands inside. Written by manylight-scenes."
                    .to_owned(),
            ],
        },
        Camera {
            origin: DVec3::new(0.8, 1.5, 2.9),
            target: DVec3::new(-0.12, 1.12, -1.5),
            fov_x: 58.0,
            size: [640, 360],
            max_depth: 16,
        },
    );
    scene.add_texture("oak", oak());
    let materials = KitchenMaterials::new(&mut scene);
    room::add(&mut scene, &materials);
    cabinets::add(&mut scene, &materials, detail);
    fittings(&mut scene, &materials, detail);
    stove::add(&mut scene, &materials, detail);
    vessels::add(&mut scene, &materials, detail);
    table::add(&mut scene, &materials, detail);
    scene
}

/// Shelves, sink and fridge.
fn fittings(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let mut assembly = Assembly::default();
    shelves::add(&mut assembly, materials);
    sink::add(&mut assembly, materials, detail);
    fridge::add(&mut assembly, materials, detail);
    scene.place_assembly("fitting", assembly);
}

/// Materials of the kitchen.
struct KitchenMaterials {
    plaster: MaterialId,
    floor: [MaterialId; 3],
    oak: MaterialId,
    oak_plain: MaterialId,
    walnut: MaterialId,
    crust: MaterialId,
    lentils: MaterialId,
    terracotta: MaterialId,
    lacquer: MaterialId,
    stone: MaterialId,
    tiles: [MaterialId; 3],
    grout: MaterialId,
    steel: MaterialId,
    satin_steel: MaterialId,
    copper: MaterialId,
    brass: MaterialId,
    iron: MaterialId,
    black: MaterialId,
    cream_glaze: MaterialId,
    blue_glaze: MaterialId,
    red_enamel: MaterialId,
    green_glaze: MaterialId,
    glass: MaterialId,
    pasta: MaterialId,
    coffee: MaterialId,
    lemon: MaterialId,
    apple: MaterialId,
    orange: MaterialId,
    leaf: MaterialId,
    linen: MaterialId,
    lamp: MaterialId,
}

impl KitchenMaterials {
    fn new(scene: &mut Scene) -> KitchenMaterials {
        let mut add = |name: &str, material: Material| scene.add_material(name, material);
        KitchenMaterials {
            plaster: add("plaster", matte([0.8, 0.75, 0.66])),
            floor: [
                add("terracotta", coated([0.34, 0.15, 0.085], 0.17)),
                add("dark_terracotta", coated([0.28, 0.12, 0.07], 0.14)),
                add("pale_terracotta", coated([0.4, 0.19, 0.11], 0.2)),
            ],
            oak: add("oak", coated_texture("oak", 0.22)),
            oak_plain: add("plain_oak", coated([0.45, 0.28, 0.13], 0.3)),
            walnut: add("walnut", coated([0.2, 0.095, 0.045], 0.18)),
            crust: add("crust", coated([0.42, 0.19, 0.065], 0.4)),
            lentils: add("lentils", coated([0.45, 0.14, 0.04], 0.35)),
            terracotta: add("flower_pot", matte([0.5, 0.22, 0.12])),
            lacquer: add("green_lacquer", coated([0.055, 0.13, 0.115], 0.16)),
            stone: add("worktop_stone", coated([0.5, 0.48, 0.44], 0.1)),
            tiles: [
                add("white_tile", coated([0.74, 0.71, 0.62], 0.07)),
                add("cream_tile", coated([0.68, 0.62, 0.5], 0.08)),
                add("sea_tile", coated([0.52, 0.62, 0.55], 0.07)),
            ],
            grout: add("grout", matte([0.42, 0.39, 0.34])),
            steel: add("steel", metal(Metal::Chromium, 0.1)),
            satin_steel: add("satin_steel", metal(Metal::Chromium, 0.25)),
            copper: add("copper", metal(Metal::Copper, 0.1)),
            brass: add("brass", metal(Metal::Brass, 0.15)),
            iron: add("cast_iron", tinted_metal(Metal::Chromium, 0.35, [0.16; 3])),
            black: add("black_glass", coated([0.012; 3], 0.05)),
            cream_glaze: add("cream_glaze", coated([0.74, 0.68, 0.54], 0.09)),
            blue_glaze: add("blue_glaze", coated([0.04, 0.11, 0.27], 0.07)),
            red_enamel: add("red_enamel", coated([0.46, 0.04, 0.025], 0.07)),
            green_glaze: add("green_glaze", coated([0.1, 0.24, 0.12], 0.08)),
            glass: add("glass", glass()),
            pasta: add("pasta", coated([0.72, 0.5, 0.2], 0.35)),
            coffee: add("coffee", coated([0.07, 0.032, 0.015], 0.25)),
            lemon: add("lemon", coated([0.78, 0.56, 0.04], 0.25)),
            apple: add("apple", coated([0.5, 0.05, 0.03], 0.15)),
            orange: add("orange", coated([0.75, 0.27, 0.02], 0.24)),
            leaf: add("leaf", coated([0.08, 0.2, 0.04], 0.28)),
            linen: add("linen", matte([0.66, 0.62, 0.53])),
            lamp: add("lamp", matte([0.0; 3])),
        }
    }
}

/// Oak with its grain along v and darker growth rings.
fn oak() -> PngImage {
    /// Number of shades between dark and pale. Few shades keep the file small.
    const SHADES: f64 = 14.0;
    PngImage::from_colors([128, 256], |u, v| {
        let drift = fractal_noise(u, v, [3, 2], 2, 40) - 0.5;
        let across = (u + 0.06 * drift).rem_euclid(1.0);
        let rings = fractal_noise(across, v, [22, 1], 2, 51);
        let pores = fractal_noise(across, v, [64, 6], 1, 77);
        let shade = ((0.7 * rings + 0.3 * pores) * SHADES).round() / SHADES;
        let dark = [0.25, 0.125, 0.05];
        let pale = [0.52, 0.33, 0.165];
        [0, 1, 2].map(|c| dark[c] + (pale[c] - dark[c]) * shade)
    })
}

/// A glazed tile that faces +z, `depth` above the plane z = 0: a face with a bevelled edge, without
/// a back.
fn tile(width: f64, height: f64, depth: f64) -> Mesh {
    /// Width of the bevel.
    const EDGE: f64 = 0.003;
    let mut mesh = Mesh::default();
    for (inset, z) in [(EDGE, depth), (0.0, depth - 1.5 * EDGE)] {
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            mesh.positions.push(DVec3::new(
                x * (width / 2.0 - inset),
                y * (height / 2.0 - inset),
                z,
            ));
            let outwards = DVec3::new(x, y, 0.8).normalize();
            mesh.normals
                .push(if inset > 0.0 { DVec3::Z } else { outwards });
        }
    }
    mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
    for i in 0..4 {
        let next = (i + 1) % 4;
        mesh.triangles.push([i, 4 + i, 4 + next]);
        mesh.triangles.push([i, 4 + next, next]);
    }
    mesh
}

/// One of three materials at random, with probabilities 1/2, 1/3 and 1/6.
fn pick(kinds: [MaterialId; 3], rng: &mut Pcg32) -> MaterialId {
    kinds[[0, 0, 0, 1, 1, 2][rng.index(6)]]
}
