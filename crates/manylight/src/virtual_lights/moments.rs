//! Extent: where the photons of a light lie, as four points with their second moments (ALGORITHMS 1.6 D; ERRATA E10).

use crate::geometry::{Ray, SurfacePoint};
use crate::ids::MaterialId;
use crate::maps::Patch;
use crate::math::{Frame, Vec3};
use crate::particles::Photon;
use crate::scene::Scene;

/// A point farther from every photon of its light than this many mean distances lies in a hole: under a chair, behind a wall.
const HOLE: f32 = 3.0;
/// Rays to the surface start this share of the radius above it: clear of hollows, below most neighbors.
const PROBE_HEIGHT: f32 = 0.5;

/// Center and second moment of flux on a tangent plane.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Flux-weighted mean position; on curved surfaces not on the surface.
    pub centroid: Vec3,
    /// Principal axes in the tangent plane, each of the length of its standard deviation, in m.
    pub axes: [Vec3; 2],
    /// Radius of the uniform disc with the same second moment, in m.
    pub radius: f32,
}

impl Extent {
    /// The moments of photons near the tangent plane with normal `n`. There must be at least one with flux.
    pub fn of<'p>(photons: impl Iterator<Item = &'p Photon> + Clone, n: Vec3) -> Self {
        let frame = Frame::from_normal(n);
        let weight = |photon: &Photon| f64::from(photon.flux.luminance());
        let total: f64 = photons.clone().map(weight).sum();
        let centroid = photons
            .clone()
            .map(|photon| photon.p.as_dvec3() * (weight(photon) / total))
            .sum::<glam::DVec3>()
            .as_vec3();
        // Covariance [[a, b], [b, c]] in the tangent plane.
        let (mut a, mut b, mut c) = (0.0, 0.0, 0.0);
        for photon in photons {
            let d = frame.to_local(photon.p - centroid).as_dvec3();
            let w = weight(photon) / total;
            a += w * d.x * d.x;
            b += w * d.x * d.y;
            c += w * d.y * d.y;
        }
        let (mean, difference) = (0.5 * (a + c), 0.5 * (a - c));
        let root = (difference * difference + b * b).sqrt();
        let (sin, cos) = (0.5 * b.atan2(difference)).sin_cos();
        let (major, minor) = ((mean + root).max(0.0).sqrt(), (mean - root).max(0.0).sqrt());
        let axis = |x: f64, y: f64| frame.to_world(Vec3::new(x as f32, y as f32, 0.0));
        Extent {
            centroid,
            axes: [
                axis(major * cos, major * sin),
                axis(-minor * sin, minor * cos),
            ],
            // A uniform disc has E|δ|² = r²/2.
            radius: (2.0 * (a + c)).sqrt() as f32,
        }
    }

    /// The four points `c ± √λ₁ e₁ ± √λ₂ e₂`: same mean and covariance, and inside a rectangular cell.
    pub fn points(&self) -> [Vec3; 4] {
        let [e1, e2] = self.axes;
        [e1 + e2, e1 - e2, -e1 + e2, -e1 - e2].map(|e| self.centroid + e)
    }
}

/// The surface of a light, and the way onto it.
pub(super) struct Footprint<'a, I> {
    pub(super) scene: &'a Scene,
    /// Around the photon that the light stands on.
    pub(super) patch: Patch,
    /// Its photons.
    pub(super) photons: I,
    pub(super) count: usize,
    pub(super) radius: f32,
}

impl<'a, I: Iterator<Item = &'a Photon> + Clone> Footprint<'a, I> {
    /// The point of the surface that stands for `target` near it, with its normal on the lit side. Where the surface has
    /// a hole there, or none of its kind is found along the normal, that is the nearest photon of the light.
    pub(super) fn project(&self, target: Vec3) -> (SurfacePoint, Vec3) {
        let nearest = self.nearest_photon(target);
        let in_hole = nearest.p.distance(target) > HOLE * self.radius / (self.count as f32).sqrt();
        if !in_hole && let Some(found) = self.probe(target) {
            return found;
        }
        let x = SurfacePoint {
            p: nearest.p,
            ..self.scene.surface_point(nearest.at)
        };
        (x, nearest.n)
    }

    fn nearest_photon(&self, target: Vec3) -> &'a Photon {
        let distance = |photon: &Photon| photon.p.distance_squared(target);
        self.photons
            .clone()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .expect("a light has at least one photon")
    }

    /// Looks for the surface from above, then from just below.
    fn probe(&self, target: Vec3) -> Option<(SurfacePoint, Vec3)> {
        let n = self.patch.n;
        let height = PROBE_HEIGHT * self.radius;
        let cast = |from: Vec3, w: Vec3, reach: f32| {
            let ray = Ray {
                t_max: reach,
                ..Ray::new(from, w)
            };
            self.scene.intersect(&ray).and_then(|(_, x)| self.accept(x))
        };
        cast(target + n * height, -n, height + self.radius).or_else(|| cast(target, n, self.radius))
    }

    fn accept(&self, x: SurfacePoint) -> Option<(SurfacePoint, Vec3)> {
        let side = x.ng * 1.0f32.copysign(x.ng.dot(self.patch.n));
        let same = self.material(&x) == self.patch.material
            && side.dot(self.patch.n) >= self.patch.min_cos;
        same.then_some((x, side))
    }

    fn material(&self, x: &SurfacePoint) -> MaterialId {
        self.scene.geometry.primitives()[x.at.primitive.index()].material
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::photon;
    use super::*;

    /// Photons on a fine grid over the rectangle `a` x `b`, turned by `angle`, about (1, 2, 3).
    fn rectangle(a: f32, b: f32, angle: f32) -> Vec<Photon> {
        let side = 100;
        let (sin, cos) = angle.sin_cos();
        (0..side * side)
            .map(|i| {
                let grid = |i: i32| (i as f32 + 0.5) / side as f32 - 0.5;
                let (x, y) = (a * grid(i % side), b * grid(i / side));
                photon(
                    Vec3::new(1.0 + cos * x - sin * y, 2.0 + sin * x + cos * y, 3.0),
                    Vec3::Z,
                )
            })
            .collect()
    }

    #[test]
    fn a_uniform_rectangle_has_its_known_moments() {
        let photons = rectangle(2.0, 0.5, 0.3);
        let extent = Extent::of(photons.iter(), Vec3::Z);
        assert!((extent.centroid - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-5);
        // Variance a²/12: the points lie at 0.577 of the half widths.
        assert!((extent.axes[0].length() - 2.0 / 12f32.sqrt()).abs() < 1e-3);
        assert!((extent.axes[1].length() - 0.5 / 12f32.sqrt()).abs() < 1e-3);
        assert!(
            (extent.axes[0]
                .normalize()
                .dot(Vec3::new(0.3f32.cos(), 0.3f32.sin(), 0.0))
                .abs()
                - 1.0)
                .abs()
                < 1e-4
        );
        let r2 = 2.0 * (4.0 + 0.25) / 12.0;
        assert!((extent.radius * extent.radius - r2).abs() < 1e-3);
    }

    #[test]
    fn the_four_points_have_the_moments_of_the_photons() {
        let mut photons = rectangle(1.0, 0.7, 1.1);
        for photon in &mut photons {
            photon.flux *= photon.p.x;
        }
        let extent = Extent::of(photons.iter(), Vec3::Z);
        let points = extent.points().map(|p| photon(p, Vec3::Z));
        let of_points = Extent::of(points.iter(), Vec3::Z);
        assert!((of_points.centroid - extent.centroid).length() < 1e-5);
        assert!((of_points.radius - extent.radius).abs() < 1e-4);
        assert!((of_points.axes[0].length() - extent.axes[0].length()).abs() < 1e-4);
    }

    #[test]
    fn one_photon_is_a_point() {
        let extent = Extent::of([photon(Vec3::ONE, Vec3::X)].iter(), Vec3::X);
        assert_eq!((extent.radius, extent.points()), (0.0, [Vec3::ONE; 4]));
    }
}
