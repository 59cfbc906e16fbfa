//! Jars, plates, cups, bottles and herbs on shelves, worktops and the window sill.

use super::shelves::SHELVES;
use super::{BACK, HALF_WIDTH, KitchenMaterials, WORKTOP};
use crate::build::{bevelled_box, bevelled_cylinder, catmull_rom, superellipsoid, tube};
use crate::mesh::Mesh;
use crate::pcg::Pcg32;
use crate::pose::Pose;
use crate::scene::{MaterialId, MeshId, Scene, ShapeKind};
use crate::scenes::{Detail, props};
use glam::DVec3;

pub(super) fn add(scene: &mut Scene, materials: &KitchenMaterials, detail: Detail) {
    let meshes = VesselMeshes::new(scene, detail);
    on_shelves(scene, materials, &meshes);
    beside_stove(scene, materials, &meshes, detail);
    on_left_worktop(scene, materials, &meshes, detail);
    beside_sink(scene, materials, &meshes);
    on_sill(scene, materials, &meshes);
}

/// Meshes with more than one use.
struct VesselMeshes {
    plate: MeshId,
    bowl: MeshId,
    mug: MeshId,
    jar: MeshId,
    filling: MeshId,
    cork: MeshId,
    bottle: MeshId,
    pot: MeshId,
    herb: MeshId,
}

impl VesselMeshes {
    fn new(scene: &mut Scene, detail: Detail) -> VesselMeshes {
        let round = detail.segments(28);
        let filling = bevelled_cylinder(0.0455, 0.115, 0.004, round);
        let cork = bevelled_cylinder(0.0345, 0.03, 0.003, detail.segments(18));
        let herb = props::strap_plant(26, 0.22, 0.4, &mut Pcg32::new(77));
        VesselMeshes {
            plate: scene.add_mesh("plate", props::turned(&PLATE, 2, round)),
            bowl: scene.add_mesh("bowl", props::bowl(detail)),
            mug: scene.add_mesh("mug", mug(round)),
            jar: scene.add_mesh("jar", props::turned(&JAR, 2, round)),
            filling: scene.add_mesh("filling", filling),
            cork: scene.add_mesh("cork", cork),
            bottle: scene.add_mesh("bottle", props::turned(&BOTTLE, 3, round)),
            pot: scene.add_mesh("herb_pot", props::pot(detail)),
            herb: scene.add_mesh("herb", herb),
        }
    }
}

/// Profile (radius, height) of a plate.
const PLATE: [(f64, f64); 9] = [
    (0.0, 0.0),
    (0.07, 0.0),
    (0.075, 0.003),
    (0.12, 0.018),
    (0.12, 0.018),
    (0.119, 0.021),
    (0.119, 0.021),
    (0.078, 0.008),
    (0.0, 0.006),
];

/// Profile (radius, height) of a glass jar with a wall.
const JAR: [(f64, f64); 16] = [
    (0.0, 0.0),
    (0.046, 0.0),
    (0.046, 0.0),
    (0.05, 0.006),
    (0.05, 0.13),
    (0.038, 0.15),
    (0.038, 0.165),
    (0.038, 0.165),
    (0.035, 0.165),
    (0.035, 0.165),
    (0.035, 0.149),
    (0.0465, 0.129),
    (0.0465, 0.007),
    (0.044, 0.0045),
    (0.044, 0.0045),
    (0.0, 0.0045),
];

/// Profile (radius, height) of a bottle.
const BOTTLE: [(f64, f64); 12] = [
    (0.0, 0.0),
    (0.034, 0.0),
    (0.034, 0.0),
    (0.037, 0.006),
    (0.037, 0.16),
    (0.03, 0.19),
    (0.014, 0.22),
    (0.0125, 0.275),
    (0.0125, 0.275),
    (0.015, 0.278),
    (0.015, 0.29),
    (0.0, 0.29),
];

/// A mug with its handle towards +x.
fn mug(segments: usize) -> Mesh {
    let mut mug = props::turned(
        &[
            (0.0, 0.0),
            (0.034, 0.0),
            (0.034, 0.0),
            (0.04, 0.01),
            (0.042, 0.05),
            (0.042, 0.092),
            (0.042, 0.092),
            (0.038, 0.092),
            (0.038, 0.092),
            (0.037, 0.02),
            (0.03, 0.008),
            (0.0, 0.006),
        ],
        2,
        segments,
    );
    let ear = [
        (0.04, 0.022),
        (0.06, 0.024),
        (0.073, 0.046),
        (0.062, 0.07),
        (0.04, 0.074),
    ]
    .map(|(x, y)| DVec3::new(x, y, 0.0));
    mug.append(&tube(&catmull_rom(&ear, 3), 8, |_| 0.0045));
    mug
}

/// Places a mesh.
fn put(scene: &mut Scene, name: &str, mesh: MeshId, pose: Pose, material: MaterialId) {
    scene.place(name, ShapeKind::Mesh(mesh), pose, material);
}

/// A glass jar with a cork and a filling of the material `inside`.
fn jar(
    scene: &mut Scene,
    materials: &KitchenMaterials,
    meshes: &VesselMeshes,
    name: &str,
    pose: Pose,
    inside: MaterialId,
) {
    let lifted = |height: f64| pose.lifted(height * pose.scale.y);
    put(
        scene,
        &format!("{name}_glass"),
        meshes.jar,
        pose,
        materials.glass,
    );
    put(
        scene,
        &format!("{name}_filling"),
        meshes.filling,
        lifted(0.0055),
        inside,
    );
    put(
        scene,
        &format!("{name}_cork"),
        meshes.cork,
        lifted(0.149),
        materials.oak_plain,
    );
}

/// Three jars, named `NAME_INDEX`, with the pose and the filling of each.
fn jars(
    scene: &mut Scene,
    materials: &KitchenMaterials,
    meshes: &VesselMeshes,
    name: &str,
    places: [(Pose, MaterialId); 3],
) {
    for (i, (pose, inside)) in places.into_iter().enumerate() {
        jar(
            scene,
            materials,
            meshes,
            &format!("{name}_{i}"),
            pose,
            inside,
        );
    }
}

/// Jars, bowls, plates and mugs.
fn on_shelves(scene: &mut Scene, materials: &KitchenMaterials, meshes: &VesselMeshes) {
    let (low, high) = (SHELVES[0] + 0.03, SHELVES[1] + 0.03);
    let z = BACK + 0.13;
    let row = [
        (1.03, materials.pasta),
        (1.16, materials.coffee),
        (1.29, materials.lentils),
    ];
    let row = row.map(|(x, inside)| (Pose::at(x, low, z), inside));
    jars(scene, materials, meshes, "jar", row);
    for i in 0..4 {
        let y = low + 0.012 * f64::from(i);
        put(
            scene,
            &format!("soup_bowl_{i}"),
            meshes.bowl,
            Pose::at(1.455, y, z).scaled(0.62),
            materials.blue_glaze,
        );
    }
    for i in 0..6 {
        let y = high + 0.0085 * f64::from(i);
        put(
            scene,
            &format!("plate_{i}"),
            meshes.plate,
            Pose::at(1.09, y, z),
            materials.cream_glaze,
        );
    }
    for (i, (x, turn, glaze)) in [
        (1.28, 40.0, materials.green_glaze),
        (1.385, 10.0, materials.cream_glaze),
        (1.49, -25.0, materials.blue_glaze),
    ]
    .into_iter()
    .enumerate()
    {
        put(
            scene,
            &format!("mug_{i}"),
            meshes.mug,
            Pose::at(x, high, z).turned(turn),
            glaze,
        );
    }
}

/// Objects between stove and fridge: oil, vinegar, a board, a crock with spoons.
fn beside_stove(
    scene: &mut Scene,
    materials: &KitchenMaterials,
    meshes: &VesselMeshes,
    detail: Detail,
) {
    put(
        scene,
        "oil",
        meshes.bottle,
        Pose::at(0.96, WORKTOP, BACK + 0.16),
        materials.green_glaze,
    );
    put(
        scene,
        "vinegar",
        meshes.bottle,
        Pose::at(1.05, WORKTOP, BACK + 0.13).scaled(0.85),
        materials.coffee,
    );
    let board = bevelled_box([-0.14, 0.0, -0.01], [0.14, 0.4, 0.01], 0.005).box_mapped(0.5);
    let leaning = scene.add_mesh("board", board);
    put(
        scene,
        "board",
        leaning,
        Pose::at(1.38, WORKTOP + 0.002, BACK + 0.105).tilted(-11.0),
        materials.oak,
    );
    let spoon = scene.add_mesh("spoon", spoon(detail));
    put(
        scene,
        "crock",
        meshes.pot,
        Pose::at(1.19, WORKTOP, BACK + 0.22).scaled(0.42),
        materials.cream_glaze,
    );
    for (i, (turn, lean)) in [(20.0, 9.0), (140.0, 11.0), (250.0, 8.0)]
        .into_iter()
        .enumerate()
    {
        let pose = Pose::at(1.19, WORKTOP + 0.128, BACK + 0.22)
            .rolled(lean)
            .turned(turn);
        put(
            scene,
            &format!("spoon_{i}"),
            spoon,
            pose,
            materials.oak_plain,
        );
    }
}

/// Objects on the left worktop: jars, a bread bin, a bowl.
fn on_left_worktop(
    scene: &mut Scene,
    materials: &KitchenMaterials,
    meshes: &VesselMeshes,
    detail: Detail,
) {
    let row = [
        (-0.15, 1.25, materials.pasta),
        (-0.31, 1.1, materials.lentils),
        (-0.46, 0.95, materials.coffee),
    ];
    let row = row.map(|(z, scale, inside)| {
        let pose = Pose::at(-HALF_WIDTH + 0.15, WORKTOP, z).scaled(scale);
        (pose, inside)
    });
    jars(scene, materials, meshes, "tall_jar", row);
    let bin = bevelled_box([-0.2, 0.0, -0.14], [0.2, 0.22, 0.14], 0.03);
    let bin = scene.add_mesh("bread_bin", bin);
    put(
        scene,
        "bread_bin",
        bin,
        Pose::at(-HALF_WIDTH + 0.2, WORKTOP, -1.2).turned(90.0),
        materials.satin_steel,
    );
    let knob = scene.add_mesh(
        "bin_knob",
        bevelled_cylinder(0.014, 0.03, 0.004, detail.segments(14)),
    );
    put(
        scene,
        "bin_knob",
        knob,
        Pose::at(-HALF_WIDTH + 0.339, WORKTOP + 0.12, -1.2)
            .tilted(90.0)
            .turned(90.0),
        materials.brass,
    );
    put(
        scene,
        "left_bowl",
        meshes.bowl,
        Pose::at(-HALF_WIDTH + 0.3, WORKTOP, 0.2).scaled(0.95),
        materials.blue_glaze,
    );
}

/// A mug and a bowl right of the sink.
fn beside_sink(scene: &mut Scene, materials: &KitchenMaterials, meshes: &VesselMeshes) {
    put(
        scene,
        "washed_mug",
        meshes.mug,
        Pose::at(-0.7, WORKTOP, BACK + 0.2).turned(60.0),
        materials.red_enamel,
    );
    put(
        scene,
        "washed_bowl",
        meshes.bowl,
        Pose::at(-0.5, WORKTOP, BACK + 0.24).scaled(0.7),
        materials.cream_glaze,
    );
}

/// A wooden spoon, upright, with its bowl at the top.
fn spoon(detail: Detail) -> Mesh {
    let stick = tube(
        &[DVec3::new(0.0, -0.11, 0.0), DVec3::new(0.0, 0.16, 0.0)],
        detail.segments(8),
        |_| 0.0055,
    );
    let bowl = superellipsoid([0.024, 0.036, 0.007], 1.0, 1.0, detail.segments(16));
    Mesh::joined(&[stick, bowl.placed(Pose::at(0.0, 0.185, 0.0))])
}

/// Herbs in pots on the window sill.
fn on_sill(scene: &mut Scene, materials: &KitchenMaterials, meshes: &VesselMeshes) {
    // Height of the sill.
    let y = 1.084;
    for (i, (x, scale, glaze)) in [
        (-1.55, 0.38, materials.cream_glaze),
        (-0.82, 0.42, materials.terracotta),
    ]
    .into_iter()
    .enumerate()
    {
        let pose = Pose::at(x, y, BACK - 0.03).scaled(scale);
        put(scene, &format!("herb_pot_{i}"), meshes.pot, pose, glaze);
        let above = Pose::at(x, y + 0.3 * scale, BACK - 0.03).turned(100.0 * i as f64);
        put(
            scene,
            &format!("herb_{i}"),
            meshes.herb,
            above,
            materials.leaf,
        );
    }
}
