//! The shading points of a tile in lanes: batches of points that have the same lights and
//! scattering functions of one lane model.

use super::{ShadingPoint, Subset};
use crate::bsdf::{FixedWoLanes, LaneModel, Lobes};
use crate::geometry::SurfacePoint;
use crate::lanes::{Float, LANES, LaneMask, Lanes, Lanes3, Sixteen, Vector, Width, mask};
use crate::math::{Aabb, Cone, Vec3};
use crate::virtual_lights::VirtualLight;
use std::f32::consts::PI;

/// Batches that are processed together: 64 points, one per bit of a mask.
pub(super) const BATCHES: usize = 64 / LANES;

/// Rounding error of a position, relative to its largest coordinate.
const POSITION_ROUNDING: f32 = 4.0 * f32::EPSILON;

/// The cylinder around the normal of a light, through its position, that contains its points.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightCylinder {
    /// Largest distance from the light along its normal, to either side, in m.
    height: f32,
    /// Largest distance from the axis, in m.
    radius: f32,
    /// Rounding error of positions, in m.
    rounding: f32,
}

impl LightCylinder {
    /// The cylinder of `light`.
    pub(super) fn of(light: &VirtualLight) -> Self {
        let (mut height, mut radius) = (0.0f32, 0.0f32);
        for &q in &light.points {
            let d = q - light.p;
            let along = d.dot(light.n);
            height = height.max(along.abs());
            radius = radius.max((d - light.n * along).length());
        }
        let rounding = rounding_at(light.p);
        LightCylinder {
            // Flat up to rounding is flat.
            height: if height > rounding { height } else { 0.0 },
            radius,
            rounding,
        }
    }
}

/// Rounding error of the coordinates of `p`, in m.
pub(super) fn rounding_at(p: Vec3) -> f32 {
    POSITION_ROUNDING * p.abs().max_element()
}

/// Up to sixteen points.
#[derive(Debug)]
pub(super) struct Batch<'b, 's> {
    /// Index of the point of each lane.
    pub members: Vec<usize>,
    /// Positions.
    pub p: Lanes3,
    /// Geometric normals.
    pub ng: Lanes3,
    /// Normals on the side that receives light; zero for points that receive on both sides.
    receiving: Lanes3,
    /// Points that receive light on both sides.
    open: LaneMask,
    /// Rounding error of positions, in m.
    rounding: Lanes,
    /// [`ShadingPoint::tolerance`].
    pub tolerance: Lanes,
    /// Random numbers of the points.
    pub u: Lanes,
    /// Scattering functions.
    pub bsdfs: FixedWoLanes<'b, 's>,
    /// Mirror directions of the viewers.
    pub mirrored: Lanes3,
    /// Least roughness of the glossy lobes, 1 without any.
    pub roughness: Lanes,
    /// Origins of shadow rays on the side of the geometric normal, and on the other.
    pub origins: [[Vec3; LANES]; 2],
    /// The lights that are summed at all of them.
    pub lights: Subset,
    /// [`ShadingPoint::lit_from`], for the points in `limited`.
    pub lit_from: Lanes3,
    pub limited: LaneMask,
    /// Largest photon depths that fit the path limits; `None` if no lane has one.
    pub depths: Option<[Option<u32>; LANES]>,
}

impl<'b, 's> Batch<'b, 's> {
    /// The points of a tile in batches, sorted by subset, lane model and position, so that rays to
    /// common lights are coherent.
    pub(super) fn all<P: AsRef<ShadingPoint<'s>>>(points: &'b [P]) -> Vec<Self> {
        let mut kinds: Vec<((LaneModel, Subset), Vec<usize>)> = Vec::new();
        for (i, point) in points.iter().enumerate() {
            let point = point.as_ref();
            let kind = (LaneModel::of(&point.bsdf), point.lights);
            match kinds.iter_mut().find(|(k, _)| *k == kind) {
                Some((_, members)) => members.push(i),
                None => kinds.push((kind, vec![i])),
            }
        }
        kinds.sort_by_key(|((_, lights), _)| *lights);
        for (_, members) in &mut kinds {
            sort_in_compact_runs(members, &|i| points[i].as_ref().x.p);
        }
        let count = (kinds.iter()).map(|(_, members)| members.len().div_ceil(LANES));
        let mut batches = Vec::with_capacity(count.sum());
        for ((model, _), members) in &kinds {
            for members in members.chunks(LANES) {
                batches.push(Batch::new(*model, members, points));
            }
        }
        batches
    }

    fn new<P: AsRef<ShadingPoint<'s>>>(
        model: LaneModel,
        members: &[usize],
        points: &'b [P],
    ) -> Self {
        // Lanes beyond the last point repeat it: they are never active.
        let point = |m: usize| points[m].as_ref();
        let at = |i: usize| point(members[i.min(members.len() - 1)]);
        let receiving = |i: usize| at(i).bsdf.receiving_normal(at(i).wo);
        let origin = |i: usize, side: f32| offset(&at(i).x, side);
        Batch {
            members: members.to_vec(),
            p: Lanes3::from_fn(|i| at(i).x.p),
            ng: Lanes3::from_fn(|i| at(i).x.ng),
            receiving: Lanes3::from_fn(|i| receiving(i).unwrap_or(Vec3::ZERO)),
            open: mask(|i| receiving(i).is_none()),
            rounding: std::array::from_fn(|i| rounding_at(at(i).x.p)),
            tolerance: std::array::from_fn(|i| at(i).tolerance),
            u: std::array::from_fn(|i| at(i).u),
            bsdfs: FixedWoLanes::new(
                model,
                Lobes::NON_SPECULAR,
                members.iter().map(|&m| (&point(m).bsdf, point(m).wo)),
            ),
            mirrored: Lanes3::from_fn(|i| mirrored(at(i).wo, at(i).x.frame.n)),
            roughness: std::array::from_fn(|i| at(i).bsdf.glossy_roughness()),
            origins: [1.0, -1.0].map(|side| std::array::from_fn(|i| origin(i, side))),
            lights: at(0).lights,
            lit_from: Lanes3::from_fn(|i| at(i).lit_from.unwrap_or(Vec3::ZERO)),
            limited: mask(|i| at(i).lit_from.is_some()),
            depths: members
                .iter()
                .any(|&m| point(m).max_photon_depth.is_some())
                .then(|| std::array::from_fn(|i| at(i).max_photon_depth)),
        }
    }

    /// The lanes that are points.
    #[inline(always)]
    pub(super) fn used(&self) -> LaneMask {
        (((1u32 << self.members.len()) - 1) & u32::from(LaneMask::MAX)) as LaneMask
    }

    /// The vectors from all points to `p`.
    #[inline(always)]
    pub(super) fn towards<S: Sixteen>(&self, s: S, p: Vec3) -> Vector<S> {
        Vector::splat(s, p) - self.p.vectors(s)
    }

    /// The points that may receive light from `light`, at the ends of the vectors `to`: part of the
    /// light is on the receiving side of the point, and, for a one-sided light, the point is on the
    /// emitting side of part of it. Points in the plane of a flat light receive nothing, up to
    /// rounding.
    #[inline(always)]
    pub(super) fn facing<S: Sixteen>(
        &self,
        to: Vector<S>,
        light: &VirtualLight,
        reach: &LightCylinder,
    ) -> LaneMask {
        let s = to.z.width();
        let (receiving, n) = (self.receiving.vectors(s), Vector::splat(s, light.n));
        let rounding = Float::load(s, &self.rounding) + reach.rounding;
        // The points of the light lie in a cylinder around ±n. Its radius counts by the sine of the
        // angle between the normals, which the chord between them bounds.
        let cos = receiving.dot(n);
        let apart = abs(receiving - n * cos.sign());
        let chord = apart.x + apart.y + apart.z;
        let highest = chord.mul_add(cos.same(reach.radius), receiving.dot(to));
        let highest = cos.abs().mul_add(cos.same(reach.height), highest);
        let above = highest.gt(rounding).bits() as LaneMask;
        let before = if light.one_sided {
            (reach.height - n.dot(to)).gt(rounding).bits() as LaneMask
        } else {
            LaneMask::MAX
        };
        self.used() & (above | self.open) & before
    }

    /// The points that may receive light from some light of a cluster; see [`Batch::facing`]. All
    /// lights of the cluster have their points in `bounds` and their normals, on the emitting side,
    /// in `normals`.
    #[inline(always)]
    pub(super) fn facing_cluster<S: Sixteen>(
        &self,
        s: S,
        bounds: &Aabb,
        normals: &Cone,
    ) -> LaneMask {
        let (center, half) = (bounds.center(), Vector::splat(s, bounds.extent() * 0.5));
        let rounding = Float::load(s, &self.rounding) + rounding_at(center);
        let (receiving, to) = (self.receiving.vectors(s), self.towards(s, center));
        let highest = receiving.dot(to) + abs(receiving).dot(half);
        let above = highest.gt(rounding).bits() as LaneMask;
        // The chord to the farthest normal, times the distance, is how much nearer to a horizon a
        // point may be.
        let chord = 2.0 * (0.5 * normals.half_angle.clamp(0.0, PI)).sin();
        let axis = Vector::splat(s, normals.axis);
        let farthest = to.length() + half.length();
        let nearest = axis.dot(to) - abs(axis).dot(half) - chord * farthest;
        let before = nearest.lt(-rounding).bits() as LaneMask;
        self.used() & (above | self.open) & before
    }
}

/// Magnitude of each component.
#[inline(always)]
fn abs<S: Width>(v: Vector<S>) -> Vector<S> {
    Vector::new(v.x.abs(), v.y.abs(), v.z.abs())
}

/// Mirror direction of `w` about the normal `n`.
pub(super) fn mirrored(w: Vec3, n: Vec3) -> Vec3 {
    n * (2.0 * n.dot(w)) - w
}

fn offset(x: &SurfacePoint, side: f32) -> Vec3 {
    x.offset_towards(x.ng * side)
}

/// Sorts so that runs of the points of one batch, and of all batches of a group, are compact: by
/// halves along the longest axis.
fn sort_in_compact_runs(members: &mut [usize], position: &impl Fn(usize) -> Vec3) {
    if members.len() <= LANES {
        return;
    }
    let run = if members.len() > BATCHES * LANES {
        BATCHES * LANES
    } else {
        LANES
    };
    let runs = members.len().div_ceil(run);
    let p = position;
    let extent = Aabb::from_points(members.iter().map(|&i| p(i))).extent();
    let axis = extent.max_position();
    let half = runs / 2 * run;
    members.select_nth_unstable_by(half, |&i, &j| p(i)[axis].total_cmp(&p(j)[axis]));
    let (low, high) = members.split_at_mut(half);
    sort_in_compact_runs(low, position);
    sort_in_compact_runs(high, position);
}
