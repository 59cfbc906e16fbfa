//! Virtual lights on real surfaces: helpers, and tests by subject.

mod bounds;
mod emission;
mod glossy;
mod set;

use super::testing::{candidates, photon, rich_lights, single_lights};
use super::*;
use crate::bsdf::Material;
use crate::color::Rgb;
use crate::geometry::{Ray, SurfaceRef};
use crate::ids::LightId;
use crate::math::octahedral::{direction_from_square, solid_angle_density};
use crate::math::{Vec2, Vec3};
use crate::particles::Photon;
use crate::sampling::rng::Pcg;
use crate::sampling::warp;
use crate::scene::{PathLimits, Scene};
use crate::testing::scenes::Builder;

const TABLE: GlossyForm = GlossyForm::Table {
    side: 32,
    storage: TableStorage::Shared,
};

fn unlimited() -> PathLimits {
    PathLimits::default()
}

/// The square [-1, 1]² at z = 0 with normal +z.
pub(super) fn floor(material: Material) -> Scene {
    let mut b = Builder::new(Vec3::new(0.0, 0.0, 3.0), Vec3::new(0.0, 0.1, 0.0), 60.0, 8);
    let material = b.material(material);
    b.rectangle(Vec3::ZERO, Vec3::X, Vec3::Y, material, None);
    b.build()
}

/// A photon from the vertex `prev` at the first surface from `above` in direction `-n`.
fn falling(scene: &Scene, above: Vec3, n: Vec3, prev: Vec3, flux: Rgb) -> Photon {
    let (hit, x) = scene
        .intersect(&Ray::new(above, -n))
        .expect("a surface below");
    let wi = (prev - x.p).normalize();
    let side = x.normal_towards(wi);
    let diffuse_flux = flux * scene.bsdf(&x).diffuse_weight(wi);
    Photon {
        wi,
        prev,
        flux,
        diffuse_flux,
        at: hit.at,
        ..photon(x.p, side)
    }
}

/// Photons of random colors at random positions of the floor, from random vertices above it.
fn photons_on_floor(scene: &Scene, count: usize, key: u64) -> Vec<Photon> {
    let mut rng = Pcg::new(key);
    let mut next = || rng.next_f32();
    (0..count)
        .map(|i| {
            let p = Vec3::new(2.0 * next() - 1.0, 2.0 * next() - 1.0, 1.0);
            let prev = Vec3::new(4.0 * next() - 2.0, 4.0 * next() - 2.0, 0.2 + 2.0 * next());
            let flux = Rgb::new(next(), 0.2 + next(), next());
            Photon {
                depth: 1 + (i % 4) as u16,
                ..falling(scene, p, Vec3::Z, prev, flux)
            }
        })
        .collect()
}

fn directions(count: usize) -> impl Iterator<Item = Vec3> {
    let mut rng = Pcg::new(5);
    (0..count).map(move |_| warp::sphere(Vec2::new(rng.next_f32(), rng.next_f32())))
}

/// Integral of the intensity of a light over the sphere, by the midpoint rule on 1024² squares of
/// the octahedral map, which divide the texels.
fn emitted(set: &VirtualLights, id: LightId) -> [f64; 3] {
    emitted_in_squares(set, id, 1024)
}

/// Like [`emitted`] with `n`² squares. With an odd `n` no midpoint lies on the horizon of the
/// floor, where intensities are discontinuous.
fn emitted_in_squares(set: &VirtualLights, id: LightId, n: usize) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for i in 0..n * n {
        let uv = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
        let solid_angle = f64::from(solid_angle_density(uv)) / (n * n) as f64;
        let intensity = set.intensity(id, direction_from_square(uv)).to_array();
        (0..3).for_each(|c| sum[c] += f64::from(intensity[c]) * solid_angle);
    }
    sum
}

/// A cluster for each site with its photon twice, at half the flux each: a light of one photon
/// would have no profile.
fn twice(sites: &[Site]) -> PhotonClusters {
    PhotonClusters::of_sites(sites, |site| vec![(site.photon, 0.5 / site.probability); 2])
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs().max(1e-12)
}
