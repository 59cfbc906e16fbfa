//! A coupe with its nose towards +x, modelled about the origin. Its shells are cross-sections
//! lofted along x.

mod body;
mod cabin;
mod fittings;

use super::GarageMaterials;
use crate::pose::Pose;
use crate::scene::{Assembly, Scene};
use crate::scenes::Detail;

/// Half the wheelbase.
pub(super) const AXLE: f64 = 1.27;
/// Radius of the wheels.
pub(super) const WHEEL: f64 = 0.315;

/// Adds the car without its wheels.
pub(super) fn add(scene: &mut Scene, materials: &GarageMaterials, detail: Detail, parked: Pose) {
    let mut assembly = Assembly::default();
    assembly.add(materials.body, &body::shell(detail));
    assembly.add(materials.body, &cabin::shell(detail));
    cabin::windows(&mut assembly, materials, detail);
    body::seams(&mut assembly, materials, detail);
    body::underside(&mut assembly, materials, detail);
    fittings::add(&mut assembly, materials, detail);
    scene.place_assembly("car", assembly.placed(parked));
}
