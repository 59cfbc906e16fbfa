//! Extent of a light: the second moment of its photons as a disc, and the points from which the
//! light is seen.

use crate::math::{Frame, Vec2, Vec3};
use crate::particles::Photon;

/// Number of points of a light.
pub const POINTS: usize = 16;
/// Number of strips over which the points are spread.
const STRIPS: usize = 4;

/// Center and second moment of the flux of photons in a tangent plane.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Flux-weighted mean position; not on the surface if that is curved.
    pub centroid: Vec3,
    /// Principal axes in the tangent plane; the length of each is the standard deviation along it,
    /// in m.
    pub axes: [Vec3; 2],
    /// Radius of the uniform disc with the same second moment, in m.
    pub radius: f32,
}

/// Luminance of the flux of a photon with a weight, in W.
fn flux((photon, weight): (&Photon, f32)) -> f64 {
    f64::from(photon.flux.luminance() * weight)
}

impl Extent {
    /// The moments of photons, given with their weights, in the tangent plane with unit normal `n`.
    /// At least one must have flux.
    pub fn of<'p>(photons: impl Iterator<Item = (&'p Photon, f32)> + Clone, n: Vec3) -> Self {
        let frame = Frame::from_normal(n);
        let total: f64 = photons.clone().map(flux).sum();
        let centroid = photons
            .clone()
            .map(|one| one.0.p.as_dvec3() * (flux(one) / total))
            .sum::<glam::DVec3>()
            .as_vec3();
        // Covariance [[a, b], [b, c]] in the tangent plane.
        let (mut a, mut b, mut c) = (0.0, 0.0, 0.0);
        for one in photons {
            let d = frame.to_local(one.0.p - centroid).as_dvec3();
            let w = flux(one) / total;
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
            // A uniform disc of radius r has E|δ|² = r²/2.
            radius: (2.0 * (a + c)).sqrt() as f32,
        }
    }
}

/// [`POINTS`] positions of photons, each drawn with probability proportional to flux, spread over
/// the extent.
///
/// Strips along the major axis, traversed in alternating direction, are cut into [`POINTS`] pieces
/// of equal flux; `u[0]` in [0, 1) places one point in each piece. `u[1]` rotates the order, so
/// that the first point is any of them with equal probability; each four points from a multiple of
/// four lie in different strips.
///
/// The expectation over `u` of a mean over the points is the flux-weighted mean over the photons,
/// for any function. Points constructed from the moments instead may lie under a chair or behind a
/// wall, where no photon arrives.
pub fn spread_points<'p>(
    photons: impl Iterator<Item = (&'p Photon, f32)>,
    extent: &Extent,
    u: [f32; 2],
) -> [Vec3; POINTS] {
    let mut order: Vec<((&Photon, f32), Vec2)> = photons
        .map(|one| {
            let d = one.0.p - extent.centroid;
            (one, Vec2::new(extent.axes[0].dot(d), extent.axes[1].dot(d)))
        })
        .collect();
    let total: f64 = order.iter().map(|(one, _)| flux(*one)).sum();
    order.sort_by(|a, b| a.1.x.total_cmp(&b.1.x));
    let mut sum = 0.0;
    let mut strips: Vec<(usize, f32, (&Photon, f32))> = order
        .into_iter()
        .map(|(one, at)| {
            sum += flux(one);
            let strip = ((sum / total * STRIPS as f64) as usize).min(STRIPS - 1);
            (
                strip,
                if strip.is_multiple_of(2) { at.y } else { -at.y },
                one,
            )
        })
        .collect();
    strips.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));

    let mut points = [strips[0].2.0.p; POINTS];
    let (mut sum, mut next) = (0.0, 0);
    for (_, _, one) in strips {
        sum += flux(one);
        while next < POINTS && (next as f64 + f64::from(u[0])) * total < sum * POINTS as f64 {
            points[next] = one.0.p;
            next += 1;
        }
    }
    let first = (u[1] * POINTS as f32) as usize % POINTS;
    let (strip, within) = (first / STRIPS, first % STRIPS);
    std::array::from_fn(|i| points[(i + strip) % STRIPS * STRIPS + (i / STRIPS + within) % STRIPS])
}

#[cfg(test)]
mod tests {
    use super::super::testing::photon;
    use super::*;

    fn each(photons: &[Photon]) -> impl Iterator<Item = (&Photon, f32)> + Clone {
        photons.iter().map(|photon| (photon, 1.0))
    }

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
        let extent = Extent::of(each(&photons), Vec3::Z);
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
    fn the_points_are_spread_in_proportion_to_flux() {
        let mut photons = rectangle(1.0, 0.7, 1.1);
        for photon in &mut photons {
            photon.flux *= photon.p.x;
        }
        let extent = Extent::of(each(&photons), Vec3::Z);
        let trials = 64;
        let (mut mean, mut worst) = (Vec3::ZERO, 0.0f32);
        for t in 0..trials {
            let points = spread_points(
                each(&photons),
                &extent,
                [(t as f32 + 0.5) / trials as f32, 0.3],
            );
            let center = points.iter().sum::<Vec3>() / POINTS as f32;
            mean += center / trials as f32;
            worst = worst.max(center.distance(extent.centroid));
            let radius = Extent::of(each(&points.map(|p| photon(p, Vec3::Z))), Vec3::Z).radius;
            assert!(
                (radius / extent.radius - 1.0).abs() < 0.15,
                "{radius} and {}",
                extent.radius
            );
        }
        assert!(
            mean.distance(extent.centroid) < 5e-3,
            "{mean} and {}",
            extent.centroid
        );
        // Sixteen independent photons would miss the center by a quarter of the deviation.
        assert!(worst < 0.1 * extent.radius, "{worst}");
    }

    #[test]
    fn one_photon_is_a_point() {
        let photons = [photon(Vec3::ONE, Vec3::X)];
        let extent = Extent::of(each(&photons), Vec3::X);
        assert_eq!(extent.radius, 0.0);
        assert_eq!(
            spread_points(each(&photons), &extent, [0.5, 0.5]),
            [Vec3::ONE; POINTS]
        );
    }
}
