//! The compatibility test between a photon and a light: same material, same side, similar normal,
//! near the tangent plane.

use crate::arrays::{Fields, Record};
use crate::ids::MaterialId;
use crate::math::Vec3;

/// Smallest cosine between normals on one diffuse surface: 25°. Smaller angles separate facets of
/// smooth objects; larger ones mix orientations, so that photons of other surfaces bias the image.
/// At 12.5° and 50° (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room): relMSE 0 and
/// -0.7 % (standard error 5 %). At 12.5° and 50° (2 passes of `photon-map` at 72x40, 3 seeds;
/// Glossy Room, Kitchen): relMSE +1.1 and +11 % (standard error 6 %), mean -0.4 and +1.2 %.
pub(super) const MIN_COS: f32 = 0.906_308;
/// Largest angle between compatible normals on glossy surfaces, in rad per unit of roughness.
/// Profiles evaluate the lobe of every photon about the photon's normal, so this limits the error
/// of position and not that of direction. At 1 and 4 (2 passes of 128 lights at 72x40, 3 seeds;
/// Kitchen, Glossy Room): relMSE +7.5 and -0.8 % (standard error 6 %).
const ANGLE_PER_ALPHA: f32 = 2.0;
/// Largest offset from the tangent plane relative to the distance. At 0.075 and 0.3 (2 passes of
/// 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room): relMSE +4.0 and +2.2 % (standard error 7
/// %), shadow rays -4 and -1 %.
const MAX_SLOPE: f32 = 0.15;
/// Factor on distances along the normal in the metric of [`Patch::distance_squared`]. At 2.5 and 10
/// (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room): relMSE +1.5 and -1.7 %
/// (standard error 4 %).
const NORMAL_STRETCH: f32 = 5.0;

/// A small piece of surface, for the compatibility test.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Center.
    pub p: Vec3,
    /// Geometric normal on the lit side, unit.
    pub n: Vec3,
    /// Material.
    pub material: MaterialId,
    /// Smallest cosine between compatible normals.
    pub min_cos: f32,
}

impl Patch {
    /// The patch around `p` with unit normal `n`; `roughness` is that of the narrowest glossy lobe,
    /// 1 without glossy lobes.
    pub fn new(p: Vec3, n: Vec3, material: MaterialId, roughness: f32) -> Self {
        let angle = (ANGLE_PER_ALPHA * roughness).min(std::f32::consts::FRAC_PI_2);
        Patch {
            p,
            n,
            material,
            min_cos: angle.cos().max(MIN_COS),
        }
    }

    /// Squared distance in m² to the location `p` with unit normal `n`, in a metric stretched along
    /// the normals; never below the Euclidean one. `None` if the location is not compatible.
    #[inline]
    pub fn distance_squared(&self, p: Vec3, n: Vec3, material: MaterialId) -> Option<f32> {
        if material != self.material || n.dot(self.n) < self.min_cos {
            return None;
        }
        let step = p - self.p;
        let d2 = step.x * step.x + step.y * step.y + step.z * step.z;
        // On a smooth surface the offsets from both tangent planes are small.
        let (h0, h1) = (self.n.dot(step), n.dot(step));
        let h2 = (h0 * h0).max(h1 * h1);
        (h0 * h0 <= MAX_SLOPE * MAX_SLOPE * d2)
            .then_some(d2 + (NORMAL_STRETCH * NORMAL_STRETCH - 1.0) * h2)
    }
}

impl Record for Patch {
    const EMPTY: Self = Patch {
        p: Vec3::ZERO,
        n: Vec3::ZERO,
        material: MaterialId(0),
        min_cos: 0.0,
    };

    fn fields(&mut self, f: &mut impl Fields) {
        f.vec3("p", &mut self.p);
        f.vec3("n", &mut self.n);
        f.word("material", &mut self.material.0);
        f.float("min_cos", &mut self.min_cos);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const M: MaterialId = MaterialId(0);

    #[test]
    fn the_faces_of_a_box_and_the_sides_of_a_wall_stay_apart() {
        let patch = Patch::new(Vec3::ZERO, Vec3::Z, M, 1.0);
        let near = Vec3::new(0.1, 0.0, 0.0);
        assert!(patch.distance_squared(near, Vec3::Z, M).is_some());
        // Round the edge, behind the wall, another material, another shelf.
        assert_eq!(patch.distance_squared(near, Vec3::X, M), None);
        assert_eq!(
            patch.distance_squared(near - Vec3::Z * 1e-3, -Vec3::Z, M),
            None
        );
        assert_eq!(patch.distance_squared(near, Vec3::Z, MaterialId(1)), None);
        assert_eq!(
            patch.distance_squared(near + Vec3::Z * 0.03, Vec3::Z, M),
            None
        );
    }

    #[test]
    fn glossy_patches_are_stricter_about_normals() {
        let tilted = Vec3::new(0.3, 0.0, 1.0).normalize();
        let near = Vec3::new(0.1, 0.0, 0.0);
        assert!(
            Patch::new(Vec3::ZERO, Vec3::Z, M, 1.0)
                .distance_squared(near, tilted, M)
                .is_some()
        );
        assert!(
            Patch::new(Vec3::ZERO, Vec3::Z, M, 0.1)
                .distance_squared(near, tilted, M)
                .is_none()
        );
    }

    #[test]
    fn the_metric_never_falls_below_the_euclidean_one() {
        let patch = Patch::new(Vec3::ZERO, Vec3::Z, M, 1.0);
        let p = Vec3::new(0.1, 0.05, 0.01);
        let d2 = patch
            .distance_squared(p, Vec3::Z, M)
            .expect("a smooth surface");
        assert!(d2 > p.length_squared());
        assert_eq!(patch.distance_squared(Vec3::ZERO, Vec3::Z, M), Some(0.0));
    }
}
