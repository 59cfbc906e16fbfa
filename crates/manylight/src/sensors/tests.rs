//! Rays of Mitsuba 3.9.1, and importance against rays.

use super::*;
use crate::film::Filter;
use crate::geometry::Ray;
use crate::lanes::{LANES, LaneKernel, Pair, Width};
use crate::sampling::{Sampler, Stream};
use crate::simd::{Instructions, Isa};

/// `Transform.look_at([1, 2, 3], [0, 0.5, -1], [0, 1, 0])` of Mitsuba.
fn look_at() -> Affine3A {
    let forward = Vec3::new(-1.0, -1.5, -4.0).normalize();
    let left = Vec3::Y.cross(forward).normalize();
    Affine3A::from_mat3_translation(
        crate::math::Mat3::from_cols(left, forward.cross(left), forward),
        Vec3::new(1.0, 2.0, 3.0),
    )
}

/// One sampled ray of Mitsuba: parameters, sample, result.
struct Case {
    kind: SensorKind,
    size: [u32; 2],
    crop: [u32; 4],
    offset: [f32; 2],
    clip: [f32; 2],
    scale: [f32; 3],
    film: [f32; 2],
    lens: [f32; 2],
    o: [f32; 3],
    d: [f32; 3],
    t_max: f32,
}

impl Case {
    fn sensor(&self) -> Sensor {
        Sensor::new(SensorDesc {
            name: String::new(),
            world_from_camera: look_at() * Affine3A::from_scale(Vec3::from(self.scale)),
            motion: Vec::new(),
            kind: self.kind,
            principal_point_offset: Vec2::from(self.offset),
            near_clip: self.clip[0],
            far_clip: self.clip[1],
            film: FilmDesc {
                size: UVec2::from(self.size),
                crop_offset: UVec2::new(self.crop[0], self.crop[1]),
                crop_size: UVec2::new(self.crop[2], self.crop[3]),
                filter: Filter::Box,
            },
        })
    }
}

fn perspective(fov_axis: FovAxis) -> SensorKind {
    SensorKind::Perspective {
        fov: 50.0,
        fov_axis,
    }
}

fn thin_lens(fov_axis: FovAxis) -> SensorKind {
    SensorKind::ThinLens {
        fov: 50.0,
        fov_axis,
        aperture_radius: 0.3,
        focus_distance: 4.0,
    }
}

#[rustfmt::skip]
const CASES: &[fn() -> Case] = &[
    || Case { kind: perspective(FovAxis::X), size: [64, 40], crop: [0, 0, 64, 40], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [40.0, 35.88], lens: [0.776, 0.225], o: [0.97609, 1.86016, 2.7842], d: [-0.09258, -0.54146, -0.83561], t_max: 103.0441 },
    || Case { kind: perspective(FovAxis::Y), size: [64, 40], crop: [0, 0, 64, 40], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [19.2, 34.96], lens: [0.005, 0.821], o: [0.87787, 1.83258, 2.8191], d: [-0.44398, -0.6086, -0.65764], t_max: 109.7579 },
    || Case { kind: perspective(FovAxis::Diagonal), size: [64, 40], crop: [0, 0, 64, 40], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [51.008, 18.72], lens: [0.303, 0.278], o: [0.99966, 1.91825, 2.75653], d: [-0.00133, -0.31832, -0.94798], t_max: 102.4768 },
    || Case { kind: perspective(FovAxis::Smaller), size: [64, 40], crop: [0, 0, 64, 40], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [16.32, 17.8], lens: [0.505, 0.553], o: [0.85329, 1.92658, 2.78999], d: [-0.55053, -0.2755, -0.78805], t_max: 106.3301 },
    || Case { kind: perspective(FovAxis::Larger), size: [64, 40], crop: [0, 0, 64, 40], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [63.744, 31.72], lens: [0.622, 0.989], o: [1.05875, 1.87441, 2.75819], d: [0.21077, -0.45058, -0.8675], t_max: 111.2177 },
    || Case { kind: perspective(FovAxis::Y), size: [40, 64], crop: [0, 0, 40, 64], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [8.6, 10.24], lens: [0.613, 0.044], o: [0.89616, 1.98903, 2.75586], d: [-0.39107, -0.04133, -0.91943], t_max: 105.9485 },
    || Case { kind: perspective(FovAxis::Diagonal), size: [40, 64], crop: [0, 0, 40, 64], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [1.44, 32.96], lens: [0.466, 0.917], o: [0.88764, 1.91174, 2.78697], d: [-0.43804, -0.34407, -0.83051], t_max: 102.3467 },
    || Case { kind: perspective(FovAxis::Smaller), size: [40, 64], crop: [0, 0, 40, 64], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [25.16, 32.896], lens: [0.497, 0.248], o: [0.97263, 1.90962, 2.76652], d: [-0.10867, -0.35885, -0.92705], t_max: 100.4909 },
    || Case { kind: perspective(FovAxis::Larger), size: [40, 64], crop: [0, 0, 40, 64], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [0.48, 12.288], lens: [0.692, 0.201], o: [0.86808, 1.98201, 2.76551], d: [-0.48923, -0.0667, -0.8696], t_max: 107.5923 },
    || Case { kind: perspective(FovAxis::X), size: [64, 40], crop: [10, 5, 20, 30], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [7.4, 0.12], lens: [0.83, 0.154], o: [0.88692, 1.96547, 2.767], d: [-0.43277, -0.13215, -0.89176], t_max: 104.2509 },
    || Case { kind: perspective(FovAxis::Y), size: [64, 40], crop: [10, 5, 20, 30], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [5.36, 26.4], lens: [0.51, 0.847], o: [0.85443, 1.85208, 2.81764], d: [-0.52691, -0.53541, -0.66008], t_max: 110.2301 },
    || Case { kind: perspective(FovAxis::Diagonal), size: [64, 40], crop: [10, 5, 20, 30], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [12.8, 22.26], lens: [0.091, 0.541], o: [0.91731, 1.89345, 2.78641], d: [-0.32736, -0.42179, -0.84554], t_max: 100.7906 },
    || Case { kind: perspective(FovAxis::Smaller), size: [64, 40], crop: [10, 5, 20, 30], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [10.16, 26.13], lens: [0.361, 0.598], o: [0.88145, 1.85356, 2.81033], d: [-0.44345, -0.54775, -0.70945], t_max: 106.6694 },
    || Case { kind: perspective(FovAxis::X), size: [64, 40], crop: [0, 0, 64, 40], offset: [0.1, -0.2], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [3.776, 15.52], lens: [0.323, 0.15], o: [0.86212, 1.95726, 2.77628], d: [-0.51787, -0.16055, -0.84026], t_max: 106.2331 },
    || Case { kind: perspective(FovAxis::Y), size: [64, 40], crop: [10, 5, 20, 30], offset: [0.1, -0.2], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [16.32, 11.37], lens: [0.979, 0.59], o: [0.94147, 1.97823, 2.74858], d: [-0.22593, -0.08402, -0.97051], t_max: 103.3657 },
    || Case { kind: perspective(FovAxis::X), size: [64, 40], crop: [0, 0, 64, 40], offset: [0.0, 0.0], clip: [0.5, 20.0], scale: [-1.0, 1.0, 1.0], film: [38.72, 25.52], lens: [0.676, 0.151], o: [0.84187, 1.79126, 2.56937], d: [-0.31374, -0.41416, -0.85442], t_max: 19.656 },
    || Case { kind: thin_lens(FovAxis::X), size: [64, 40], crop: [0, 0, 64, 40], offset: [0.0, 0.0], clip: [0.5, 20.0], scale: [1.0, 1.0, 1.0], film: [28.16, 9.6], lens: [0.402, 0.097], o: [0.9088, 1.70506, 2.58497], d: [-0.30348, -0.14029, -0.94245], t_max: 19.9723 },
    || Case { kind: thin_lens(FovAxis::Diagonal), size: [64, 40], crop: [10, 5, 20, 30], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [19.36, 6.45], lens: [0.672, 0.3], o: [0.87196, 1.85684, 2.81148], d: [-0.24998, -0.21876, -0.94322], t_max: 100.5869 },
    || Case { kind: SensorKind::Orthographic, size: [64, 40], crop: [0, 0, 64, 40], offset: [0.0, 0.0], clip: [0.5, 20.0], scale: [2.0, 2.0, 1.0], film: [55.936, 26.48], lens: [0.132, 0.845], o: [2.37095, 1.44846, 2.31565], d: [-0.22792, -0.34188, -0.91168], t_max: 19.5 },
    || Case { kind: SensorKind::Orthographic, size: [40, 64], crop: [10, 5, 20, 30], offset: [0.0, 0.0], clip: [0.25, 100.0], scale: [1.0, 1.0, 1.0], film: [18.9, 27.12], lens: [0.57, 0.145], o: [1.37523, 1.90889, 2.66614], d: [-0.22792, -0.34188, -0.91168], t_max: 99.75 },
    || Case { kind: SensorKind::Orthographic, size: [40, 64], crop: [0, 0, 40, 64], offset: [0.0, 0.0], clip: [0.5, 20.0], scale: [2.0, 2.0, 2.0], film: [7.68, 59.392], lens: [0.552, 0.181], o: [-0.19601, -0.91602, 3.29564], d: [-0.22792, -0.34188, -0.91168], t_max: 19.5 },
];

#[test]
fn rays_match_mitsuba() {
    for (i, case) in CASES.iter().enumerate() {
        let case = case();
        let ray = case
            .sensor()
            .ray(Vec2::from(case.film), Vec2::from(case.lens));
        assert!(
            (ray.o - Vec3::from(case.o)).length() < 2e-4,
            "case {i}: origin {} for {:?}",
            ray.o,
            case.o
        );
        assert!(
            (ray.d - Vec3::from(case.d)).length() < 5e-5,
            "case {i}: direction {} for {:?}",
            ray.d,
            case.d
        );
        assert!(
            (ray.t_max / case.t_max - 1.0).abs() < 1e-4,
            "case {i}: {} for {}",
            ray.t_max,
            case.t_max
        );
    }
}

/// The ray through a point of the film and one of the lens per lane.
struct InLanes<'a>(&'a Sensor, &'a [(Vec2, Vec2)]);

impl LaneKernel for InLanes<'_> {
    type Output = Vec<Ray>;

    #[inline(always)]
    fn run<S: Width>(self, s: S) -> Vec<Ray> {
        let InLanes(sensor, points) = self;
        let points = s.each(|i| points[i]);
        let film = Pair::from_fn(s, |i| points.as_ref()[i].0);
        let lens = Pair::from_fn(s, |i| points.as_ref()[i].1);
        sensor.rays(film, lens).store().as_ref().to_vec()
    }
}

#[test]
fn rays_in_lanes_are_those_of_single_points() {
    let mut sampler = Sampler::new(2, 0, Stream::Test, 0);
    for case in CASES {
        let sensor = case().sensor();
        let size = sensor.desc().film.crop_size.as_vec2();
        let points: Vec<(Vec2, Vec2)> = (0..LANES)
            .map(|_| (sampler.next_2d() * size, sampler.next_2d()))
            .collect();
        for isa in Instructions::available().into_iter().filter_map(Isa::new) {
            let rays = isa.run_lanes(InLanes(&sensor, &points));
            for (ray, &(film, lens)) in rays.iter().zip(&points) {
                let single = sensor.ray(film, lens);
                assert!((ray.o - single.o).length() < 1e-5 * (1.0 + single.o.length()));
                assert!((ray.d - single.d).length() < 1e-6);
                assert!((ray.t_max / single.t_max - 1.0).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn connections_find_the_ray_again() {
    for (i, case) in CASES.iter().enumerate() {
        let case = case();
        let sensor = case.sensor();
        let ray = sensor.ray(Vec2::from(case.film), Vec2::from(case.lens));
        let c = sensor
            .connect(ray.at(3.0), Vec2::from(case.lens))
            .expect("a point on a camera ray is seen");
        assert!(
            (c.film_position - Vec2::from(case.film)).length() < 2e-3,
            "case {i}: {}",
            c.film_position
        );
        assert!(
            (c.w + ray.d).length() < 1e-4 && (c.target - ray.o).length() < 1e-3,
            "case {i}"
        );
        assert!(
            sensor
                .connect(ray.at(-0.1), Vec2::from(case.lens))
                .is_none(),
            "case {i}: before the near plane"
        );
        assert!(
            sensor
                .connect(ray.at(ray.t_max * 1.01), Vec2::from(case.lens))
                .is_none(),
            "case {i}: beyond the far plane"
        );
    }
}

/// An emitting parallelogram of unit radiance, summed over all pixels by rays and by connections.
#[test]
fn importance_is_adjoint_to_rays() {
    for (i, case) in CASES.iter().enumerate() {
        let case = case();
        let sensor = case.sensor();
        let through = sensor.ray(
            Vec2::new(case.crop[2] as f32, case.crop[3] as f32) * 0.5,
            Vec2::splat(0.5),
        );
        let corner = through.at(5.0);
        let (e1, e2) = (Vec3::new(1.5, 0.15, 0.3), Vec3::new(-0.15, 0.9, 0.9));
        let normal = e1.cross(e2);
        let inside = |ray: &Ray| {
            let q = ray.at((corner - ray.o).dot(normal) / ray.d.dot(normal)) - corner;
            let (a, b) = (q.cross(e2).dot(normal), e1.cross(q).dot(normal));
            let area2 = normal.length_squared();
            (0.0..area2).contains(&a) && (0.0..area2).contains(&b)
        };
        let mut sampler = Sampler::new(1, 0, Stream::Test, i as u64);
        let n = 200_000;
        let crop = sensor.desc().film.crop_size.as_vec2();
        let (mut by_rays, mut by_connections) = (0.0f64, 0.0f64);
        for k in 0..n {
            // Stratified over the film and the patch, so that 1 % is many deviations.
            let stratum = Vec2::new((k % 400) as f32, (k / 400) as f32) / Vec2::new(400.0, 500.0);
            let u = stratum + sampler.next_2d() / Vec2::new(400.0, 500.0);
            if inside(&sensor.ray(u * crop, sampler.next_2d())) {
                by_rays += f64::from(crop.x * crop.y) / n as f64;
            }
            let p = corner + e1 * u.x + e2 * u.y;
            if let Some(c) = sensor.connect(p, sampler.next_2d()) {
                by_connections += f64::from(normal.dot(c.w).abs() * c.importance) / n as f64;
            }
        }
        assert!(
            by_rays > 0.0 && (by_connections / by_rays - 1.0).abs() < 0.01,
            "case {i}: {by_connections} for {by_rays}"
        );
    }
}

#[test]
fn the_field_of_view_follows_the_resized_film() {
    let mut desc = CASES[4]().sensor().desc().clone();
    desc.film.size = UVec2::new(40, 64);
    desc.film.crop_size = desc.film.size;
    desc.kind = perspective(FovAxis::Smaller);
    let Projection::Perspective { tan_half_fov_x } = Sensor::new(desc).projection() else {
        panic!("a perspective sensor has a perspective projection");
    };
    assert!((tan_half_fov_x - 25f32.to_radians().tan()).abs() < 1e-6);
}
