//! The U-shaped corridor: lit by a window at the end of one leg, seen from the end of the other.

mod furnishing;
mod shell;

use super::Detail;
use crate::material::{Metal, coated, matte, metal, tinted_metal};
use crate::scene::{About, Camera, MaterialId, Scene};
use glam::DVec3;

/// Distance of the outer walls from the plane x = 0.
const OUTER: f64 = 3.0;
/// Distance of the inner walls from the plane x = 0.
const INNER: f64 = 0.6;
/// z of the ends of both legs.
const NEAR: f64 = 2.2;
/// z of the far wall.
const FAR: f64 = -7.4;
/// z of the inner wall of the part that joins the legs.
const BEND: f64 = -5.0;
const HEIGHT: f64 = 2.8;

/// Generates the corridor.
pub(super) fn scene(detail: Detail) -> Scene {
    let mut scene = Scene::new(
        About {
            title: "U-shaped corridor",
            text: vec![
                "What it shows: the corridor of a grand hotel, bent twice. The only light is a tall window at the end of \
                 one leg; the eye stands at the end of the other. All that is seen has come round two corners, mostly over \
                 polished stone, lacquer, champagne-colored metal and brass, so that there is next to no direct light, and \
                 light that diffuse virtual lights cannot carry."
                    .to_owned(),
                "Units: meters, y up. The legs run along z, 2.4 wide and 2.8 high; x < 0 is that of the camera. Written \
                 by manylight-scenes."
                    .to_owned(),
            ],
        },
        Camera {
            origin: DVec3::new(-1.95, 1.42, 1.85),
            target: DVec3::new(-1.62, 1.12, -4.0),
            fov_x: 64.0,
            size: [640, 360],
            max_depth: 24,
        },
    );
    let materials = CorridorMaterials::new(&mut scene);
    shell::add(&mut scene, &materials, detail);
    furnishing::add(&mut scene, &materials, detail);
    scene
}

/// Materials of the corridor.
struct CorridorMaterials {
    stone: [MaterialId; 2],
    backing: MaterialId,
    plaster: MaterialId,
    sage: MaterialId,
    walnut: MaterialId,
    champagne: MaterialId,
    brass: MaterialId,
    bronze: MaterialId,
    leather: MaterialId,
    black: MaterialId,
    glaze: MaterialId,
    opal: MaterialId,
    leaf: MaterialId,
    soil: MaterialId,
    cover: [MaterialId; 2],
}

impl CorridorMaterials {
    fn new(scene: &mut Scene) -> CorridorMaterials {
        CorridorMaterials {
            stone: [
                scene.add_material("dark_stone", coated([0.055, 0.07, 0.065], 0.09)),
                scene.add_material("pale_stone", coated([0.62, 0.56, 0.47], 0.11)),
            ],
            backing: scene.add_material("backing", matte([0.05, 0.045, 0.04])),
            plaster: scene.add_material("plaster", matte([0.82, 0.79, 0.73])),
            sage: scene.add_material("sage_lacquer", coated([0.64, 0.74, 0.66], 0.16)),
            walnut: scene.add_material("walnut", coated([0.38, 0.185, 0.085], 0.14)),
            champagne: scene.add_material(
                "champagne_metal",
                tinted_metal(Metal::Aluminium, 0.2, [0.86, 0.8, 0.71]),
            ),
            brass: scene.add_material("brass", metal(Metal::Brass, 0.12)),
            bronze: scene.add_material("bronze", metal(Metal::Bronze, 0.1)),
            leather: scene.add_material("leather", coated([0.45, 0.085, 0.045], 0.3)),
            black: scene.add_material("black_lacquer", coated([0.02, 0.02, 0.022], 0.08)),
            glaze: scene.add_material("teal_glaze", coated([0.02, 0.17, 0.19], 0.08)),
            opal: scene.add_material("opal_glass", coated([0.85, 0.82, 0.76], 0.1)),
            leaf: scene.add_material("leaf", coated([0.1, 0.28, 0.06], 0.25)),
            soil: scene.add_material("soil", matte([0.07, 0.045, 0.03])),
            cover: [
                scene.add_material("red_cloth", coated([0.42, 0.07, 0.05], 0.35)),
                scene.add_material("sand_cloth", coated([0.6, 0.48, 0.3], 0.35)),
            ],
        }
    }
}
