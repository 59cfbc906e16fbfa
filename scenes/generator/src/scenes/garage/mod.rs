//! The garage: a sports car in an underground hall.

mod car;
mod hall;
mod lamps;
mod pipes;
mod wheel;
mod workshop;

use super::Detail;
use crate::material::{
    Material, Metal, Reflectance, coated, coated_texture, matte, metal, tinted_metal,
};
use crate::noise::fractal_noise;
use crate::png::PngImage;
use crate::pose::Pose;
use crate::scene::{About, Camera, MaterialId, Scene};
use glam::DVec3;

/// x of the left wall.
const LEFT: f64 = -5.6;
/// x of the right wall.
const RIGHT: f64 = 5.2;
/// z of the back wall.
const BACK: f64 = -4.2;
/// z of the wall behind the camera.
const FRONT: f64 = 5.0;
const HEIGHT: f64 = 3.1;

/// Generates the garage.
pub(super) fn scene(detail: Detail) -> Scene {
    let mut scene = Scene::new(
        About {
            title: "Garage",
            text: vec![
                "What it shows: a lacquered coupe between wet concrete and a low ceiling, under hundreds of primary \
                 lights: tubes in troughs that shine at the ceiling, strings of bulbs, a sign. The body reflects rows of \
                 lamps and what they light, the puddles reflect the body, and neither is a mirror."
                    .to_owned(),
                "Units: meters, y up. The hall is 10.8 wide (x), 3.1 high and 9.2 deep (z from -4.2 to 5), closed on all \
                 sides; the camera stands inside. Written by manylight-scenes."
                    .to_owned(),
            ],
        },
        Camera {
            origin: DVec3::new(3.35, 1.32, 4.1),
            target: DVec3::new(-0.25, 0.8, -0.35),
            fov_x: 52.0,
            size: [640, 360],
            max_depth: 12,
        },
    );
    scene.add_texture("concrete", concrete());
    scene.add_texture("puddles", puddles());
    let materials = GarageMaterials::new(&mut scene);
    hall::add(&mut scene, &materials, detail);
    lamps::add(&mut scene, &materials, detail);
    let parked = Pose::at(-0.1, 0.0, 0.1).turned(-18.0);
    car::add(&mut scene, &materials, detail, parked);
    wheel::add(&mut scene, &materials, detail, parked);
    workshop::add(&mut scene, &materials, detail);
    scene
}

/// Materials of the garage.
struct GarageMaterials {
    concrete: MaterialId,
    floor: MaterialId,
    dado: MaterialId,
    yellow: MaterialId,
    dark: MaterialId,
    body: MaterialId,
    window: MaterialId,
    chrome: MaterialId,
    rim: MaterialId,
    rubber: MaterialId,
    iron: MaterialId,
    galvanized: MaterialId,
    copper: MaterialId,
    brass: MaterialId,
    red: MaterialId,
    blue: MaterialId,
    orange: MaterialId,
    cream: MaterialId,
    tail_light: MaterialId,
    lens: MaterialId,
    wood: MaterialId,
    card: MaterialId,
    lamp: MaterialId,
}

impl GarageMaterials {
    fn new(scene: &mut Scene) -> GarageMaterials {
        let mut add = |name: &str, material: Material| scene.add_material(name, material);
        let dry = coated_texture("concrete", 0.3);
        // Wet concrete is darker than dry.
        let wet = Material::Coated {
            base: Reflectance::Uniform([0.045, 0.042, 0.038]),
            alpha: 0.04,
            ior: 1.33,
        };
        GarageMaterials {
            concrete: add(
                "concrete",
                Material::Diffuse(Reflectance::Texture("concrete")),
            ),
            floor: add(
                "wet_floor",
                Material::Mixed {
                    first: Box::new(dry),
                    second: Box::new(wet),
                    weight: "puddles",
                },
            ),
            dado: add("dado_paint", coated([0.06, 0.2, 0.22], 0.22)),
            yellow: add("yellow_paint", coated([0.72, 0.45, 0.04], 0.25)),
            dark: add("dark", matte([0.02; 3])),
            body: add("car_lacquer", coated([0.42, 0.018, 0.012], 0.05)),
            window: add("tinted_window", coated([0.008, 0.01, 0.01], 0.03)),
            chrome: add("chrome", metal(Metal::Chromium, 0.06)),
            rim: add("rim_alloy", metal(Metal::Aluminium, 0.14)),
            rubber: add("rubber", coated([0.016; 3], 0.4)),
            iron: add(
                "iron",
                tinted_metal(Metal::Chromium, 0.3, [0.35, 0.34, 0.33]),
            ),
            galvanized: add(
                "galvanized",
                tinted_metal(Metal::Aluminium, 0.3, [0.75, 0.78, 0.8]),
            ),
            copper: add("copper_pipe", metal(Metal::Copper, 0.2)),
            brass: add("brass", metal(Metal::Brass, 0.18)),
            red: add("red_paint", coated([0.48, 0.035, 0.02], 0.14)),
            blue: add("blue_paint", coated([0.04, 0.12, 0.32], 0.16)),
            orange: add("orange_plastic", coated([0.7, 0.2, 0.02], 0.25)),
            cream: add("cream_paint", coated([0.7, 0.64, 0.5], 0.2)),
            tail_light: add("tail_light", coated([0.4, 0.008, 0.008], 0.05)),
            lens: add("lens", coated([0.62, 0.63, 0.62], 0.05)),
            wood: add("bench_wood", coated([0.36, 0.21, 0.1], 0.3)),
            card: add("cardboard", matte([0.4, 0.28, 0.17])),
            lamp: add("lamp", matte([0.0; 3])),
        }
    }
}

/// Concrete: gray clouds, pores and seams.
fn concrete() -> PngImage {
    /// Number of shades between black and white. Few shades keep the file small.
    const SHADES: f64 = 40.0;
    PngImage::from_colors([192, 192], |u, v| {
        let clouds = fractal_noise(u, v, [3, 3], 4, 5);
        let pore = fractal_noise(u, v, [48, 48], 1, 90);
        let pores = if pore > 0.9 { 0.8 } else { 1.0 };
        let seam = if (v * 2.0).fract() < 0.012 { 0.82 } else { 1.0 };
        let shade = ((0.24 + 0.22 * clouds) * seam * pores * SHADES).round() / SHADES;
        [shade * 1.03, shade, shade * 0.94]
    })
}

/// Wetness of the floor, from 0.12 to 1.
fn puddles() -> PngImage {
    PngImage::from_weights([256, 256], |u, v| {
        let depth = fractal_noise(u, v, [5, 4], 4, 31);
        ((depth - 0.5) * 13.0 + 0.7).clamp(0.12, 1.0)
    })
}
