//! Scattering functions of sixteen points against those of one, in all instruction sets. The tests
//! of this folder check those of one.

use super::cases::{surface_at, unequal_lobes};
use super::*;
use crate::bsdf::model_sample::Numbers;
use crate::bsdf::{BsdfSample, BsdfSamples, DirectResponses};
use crate::geometry::{SurfacePoint, SurfacePoints};
use crate::ids::MaterialId;
use crate::lanes::{Color, Float, LANES, LaneKernel, Pair, Vector, Width};
use crate::simd::{Instructions, Isa};

/// [`DirectResponses`] at one point.
struct DirectResponse {
    non_specular: Rgb,
    near_delta: Rgb,
    pdf: f32,
}

/// What the walks and next-event estimation ask for, at one point.
struct Answers {
    direct: Option<DirectResponse>,
    wi: Option<BsdfSample>,
    wo: Option<BsdfSample>,
    transmittance: Rgb,
    receiving_normal: Option<Vec3>,
    has_finite: bool,
}

/// Points with directions and numbers.
struct Packet<'a> {
    case: &'a Case,
    points: [SurfacePoint; LANES],
    given: [Vec3; LANES],
    other: [Vec3; LANES],
    u: [BsdfNumbers; LANES],
    lobes: Lobes,
}

fn single(packet: &Packet, i: usize) -> Answers {
    let bsdf = packet.case.bsdf_at(&packet.points[i]);
    let (given, other, u) = (packet.given[i], packet.other[i], packet.u[i]);
    Answers {
        direct: direct_of(&bsdf.direct_responses(other.into(), given.into()), 0),
        wi: bsdf.sample_wi(given, u, packet.lobes),
        wo: bsdf.sample_wo(given, u, packet.lobes),
        transmittance: bsdf.transmittance(given),
        receiving_normal: bsdf.receiving_normal(given),
        has_finite: bsdf.lobes().has(Lobes::FINITE),
    }
}

impl LaneKernel for &Packet<'_> {
    type Output = Vec<Answers>;

    #[inline(always)]
    fn run<S: Width>(self, s: S) -> Vec<Answers> {
        let Case {
            materials,
            textures,
            ..
        } = self.case;
        let root = MaterialId::from(materials.descriptions().len() - 1);
        let points = SurfacePoints::load(s, &s.each(|i| self.points[i]));
        let mut bsdf = Bsdf::without_leaves(&points);
        materials.add_leaves(root, &points, textures, &mut bsdf);
        self.answers(&bsdf)
    }
}

/// A packet in which all lanes have the function of the first point.
struct Alike<'a>(&'a Packet<'a>);

impl LaneKernel for Alike<'_> {
    type Output = Vec<Answers>;

    #[inline(always)]
    fn run<S: Width>(self, s: S) -> Vec<Answers> {
        let Alike(packet) = self;
        packet.answers(&packet.case.bsdf_at(&packet.points[0]).in_lanes(s))
    }
}

impl Packet<'_> {
    #[inline(always)]
    fn answers<S: Width>(&self, bsdf: &Bsdf<S>) -> Vec<Answers> {
        let s = bsdf.width();
        let given = Vector::from_fn(s, |i| self.given[i]);
        let other = Vector::from_fn(s, |i| self.other[i]);
        let u = Numbers {
            lobe: Float::from_fn(s, |i| self.u[i].lobe),
            direction: Pair::from_fn(s, |i| self.u[i].direction),
        };
        let direct = bsdf.direct_responses(other, given);
        let wi = bsdf.sample_each_wi(given, u, self.lobes);
        let wo = bsdf.sample_each_wo(given, u, self.lobes);
        let through = bsdf.transmittances(given).unwrap_or(Color::black(s));
        let (normal, is_one_sided) = bsdf.receiving_normals(given);
        let has_finite = bsdf.has(Lobes::FINITE).bits();
        let answer = |i: usize| Answers {
            direct: direct_of(&direct, i),
            wi: sample_of(&wi, i),
            wo: sample_of(&wo, i),
            transmittance: color_of(through, i),
            receiving_normal: (is_one_sided.bits() >> i & 1 != 0).then(|| vector_of(normal, i)),
            has_finite: has_finite >> i & 1 != 0,
        };
        (0..S::LANES).map(answer).collect()
    }
}

#[inline(always)]
fn color_of<S: Width>(color: Color<S>, i: usize) -> Rgb {
    Rgb::from(color.store().map(|channel| channel.as_ref()[i]))
}

#[inline(always)]
fn vector_of<S: Width>(v: Vector<S>, i: usize) -> Vec3 {
    Vec3::from(v.store().map(|component| component.as_ref()[i]))
}

#[inline(always)]
fn direct_of<S: Width>(direct: &DirectResponses<S>, i: usize) -> Option<DirectResponse> {
    let (non_specular, near_delta) = (
        color_of(direct.non_specular, i),
        color_of(direct.near_delta, i),
    );
    (!non_specular.is_black() || !near_delta.is_black()).then(|| DirectResponse {
        non_specular,
        near_delta,
        pdf: direct.pdf.store().as_ref()[i],
    })
}

#[inline(always)]
fn sample_of<S: Width>(sample: &BsdfSamples<S>, i: usize) -> Option<BsdfSample> {
    (sample.valid.bits() >> i & 1 != 0).then(|| BsdfSample {
        w: vector_of(sample.w, i),
        weight: color_of(sample.weight, i),
        pdf: sample.pdf.store().as_ref()[i],
        lobe: Lobes(sample.lobe.store().as_ref()[i] as u8),
        eta: sample.eta.store().as_ref()[i],
    })
}

/// Rounding moves narrow lobes: relative tolerance of densities and values.
const TOLERANCE: f32 = 5e-3;

/// Whether both samples are the same up to rounding.
fn agree(a: &Option<BsdfSample>, b: &Option<BsdfSample>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            a.lobe == b.lobe
                && a.w.abs_diff_eq(b.w, 1e-3)
                && near(a.pdf, b.pdf)
                && near(a.weight.g, b.weight.g)
                && near(a.eta, b.eta)
        }
        _ => false,
    }
}

fn near(a: f32, b: f32) -> bool {
    (a - b).abs() <= TOLERANCE * a.abs().max(b.abs()) + 1e-6
}

#[test]
fn packets_have_the_answers_of_single_points() {
    assert_answers_of_single_points(
        20,
        |sampler| std::array::from_fn(|_| sampler.next_2d()),
        |isa, packet| isa.run_lanes(packet),
    );
}

#[test]
fn one_function_in_all_lanes_has_its_answers() {
    assert_answers_of_single_points(
        5,
        |sampler| [sampler.next_2d(); LANES],
        |isa, packet| isa.run_lanes(Alike(packet)),
    );
}

/// Compares `rounds` packets of each case, with these texture coordinates, with single points.
fn assert_answers_of_single_points(
    rounds: usize,
    uvs: impl Fn(&mut Sampler) -> [Vec2; LANES],
    answers: impl Fn(Isa, &Packet) -> Vec<Answers>,
) {
    let unequal = unequal_lobes();
    for case in cases().iter().chain(&unequal) {
        let mut sampler = sampler(21);
        let (mut asked, mut differ) = (0, 0);
        for lobes in [Lobes::ALL, Lobes::NON_SPECULAR, Lobes::SPECULAR] {
            for ng in normals() {
                for _ in 0..rounds {
                    let uvs = uvs(&mut sampler);
                    let packet = Packet {
                        case,
                        points: uvs.map(|uv| surface_at(ng, uv)),
                        given: std::array::from_fn(|_| direction(&mut sampler)),
                        other: std::array::from_fn(|_| direction(&mut sampler)),
                        u: std::array::from_fn(|_| numbers(&mut sampler)),
                        lobes,
                    };
                    for set in Instructions::available() {
                        let isa = Isa::new(set).expect("available");
                        let answers = answers(isa, &packet);
                        for (i, packed) in answers.iter().enumerate() {
                            asked += 1;
                            differ += u32::from(!are_equal(&single(&packet, i), packed, case.name));
                        }
                    }
                }
            }
        }
        // Rounding may change a choice between lobes, or whether a direction is above the horizon.
        assert!(differ * 200 <= asked, "{}: {differ} of {asked}", case.name);
    }
}

fn are_equal(one: &Answers, packed: &Answers, name: &str) -> bool {
    assert_eq!(one.has_finite, packed.has_finite, "{name}");
    assert_eq!(
        one.receiving_normal.is_some(),
        packed.receiving_normal.is_some(),
        "{name}"
    );
    let direct = match (&one.direct, &packed.direct) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            near(a.pdf, b.pdf)
                && near(a.non_specular.g, b.non_specular.g)
                && near(a.near_delta.g, b.near_delta.g)
        }
        _ => false,
    };
    direct
        && agree(&one.wi, &packed.wi)
        && agree(&one.wo, &packed.wo)
        && near(one.transmittance.g, packed.transmittance.g)
}
