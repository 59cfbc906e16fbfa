//! The shading points of a tile in lanes, those with scattering functions of one form and the same lights together.

use super::{ShadingPoint, Subset};
use crate::bsdf::{FixedWoLanes, LaneModel, Lobes};
use crate::geometry::SurfacePoint;
use crate::lanes::vectors::{abs3, dot, splat3, sub3};
use crate::lanes::{LANES, LaneMask, Lanes, Lanes3, mask};
use crate::math::{Aabb, Cone, Vec3};
use crate::simd::Wide;
use crate::virtual_lights::VirtualLight;
use std::f32::consts::PI;

/// Batches that are connected to lights together: as many points as a mask has bits.
pub(super) const BATCHES: usize = 64 / LANES;

/// A position is known to about so many units in the last place of its largest coordinate.
const POSITION_ROUNDING: f32 = 4.0 * f32::EPSILON;

/// The cylinder about a light's normal, through the light, in which its points lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// Farthest from the light along its normal to either side, in m.
    height: f32,
    /// Farthest from the axis, in m.
    radius: f32,
    /// How far positions may be off by rounding, in m.
    rounding: f32,
}

impl Reach {
    /// Of the points of `light`.
    pub(super) fn of(light: &VirtualLight) -> Self {
        let (mut height, mut radius) = (0.0f32, 0.0f32);
        for &q in &light.points {
            let d = q - light.p;
            let along = d.dot(light.n);
            height = height.max(along.abs());
            radius = radius.max((d - light.n * along).length());
        }
        let rounding = rounding_at(light.p);
        Reach {
            // What is flat but for rounding counts as flat.
            height: if height > rounding { height } else { 0.0 },
            radius,
            rounding,
        }
    }
}

/// How far the coordinates of `p` may be off, in m.
fn rounding_at(p: Vec3) -> f32 {
    POSITION_ROUNDING * p.abs().max_element()
}

/// Up to sixteen points.
#[derive(Debug)]
pub(super) struct Batch<'b, 's> {
    /// Which point each lane is.
    pub members: Vec<usize>,
    /// Positions.
    pub p: Lanes3,
    /// Geometric normals.
    pub ng: Lanes3,
    /// Normals on the side that light is received on; zero for points that see both sides.
    receiving: Lanes3,
    /// Points that see both sides.
    open: LaneMask,
    /// How far positions may be off by rounding, in m.
    rounding: Lanes,
    /// [`ShadingPoint::tolerance`].
    pub tolerance: Lanes,
    /// Random numbers of the points.
    pub u: Lanes,
    /// How they reflect.
    pub receivers: FixedWoLanes<'b, 's>,
    /// Directions that a mirror would reflect to the viewers.
    pub mirrored: Lanes3,
    /// Roughness of the narrowest glossy lobes, 1 without any.
    pub widths: Lanes,
    /// Where shadow rays start that leave by the side of the geometric normal, and by the other.
    pub origins: [[Vec3; LANES]; 2],
    /// Which lights are summed at all of them,
    pub lights: Subset,
    /// and whether those on emitters are among them.
    /// Normals on the side of which light must arrive, for the points in `limited`.
    lit_from: Lanes3,
    limited: LaneMask,
    /// Largest photon depths that fit the path limits; `None` if no lane has one.
    pub depths: Option<[Option<u32>; LANES]>,
}

impl<'b, 's> Batch<'b, 's> {
    /// The points of a tile in batches, sorted by selection, form and place: rays to common lights should be alike.
    pub(super) fn all(points: &'b [ShadingPoint<'s>]) -> Vec<Self> {
        let mut kinds: Vec<((LaneModel, Subset), Vec<usize>)> = Vec::new();
        for (i, point) in points.iter().enumerate() {
            let kind = (point.bsdf.lane_model(), point.lights);
            match kinds.iter_mut().find(|(k, _)| *k == kind) {
                Some((_, members)) => members.push(i),
                None => kinds.push((kind, vec![i])),
            }
        }
        kinds.sort_by_key(|((_, lights), _)| *lights);
        for (_, members) in &mut kinds {
            sort_in_compact_runs(members, points);
        }
        kinds
            .iter()
            .flat_map(|((form, _), members)| {
                members
                    .chunks(LANES)
                    .map(|members| Batch::new(*form, members, points))
            })
            .collect()
    }

    fn new(form: LaneModel, members: &[usize], points: &'b [ShadingPoint<'s>]) -> Self {
        // Lanes beyond the last point repeat it: they are never active.
        let at = |i: usize| &points[members[i.min(members.len() - 1)]];
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
            receivers: FixedWoLanes::new(
                form,
                Lobes::NON_SPECULAR,
                members.iter().map(|&m| (&points[m].bsdf, points[m].wo)),
            ),
            mirrored: Lanes3::from_fn(|i| mirrored(at(i).wo, at(i).x.frame.n)),
            widths: std::array::from_fn(|i| at(i).bsdf.glossy_width()),
            origins: [1.0, -1.0].map(|side| std::array::from_fn(|i| origin(i, side))),
            lights: at(0).lights,
            lit_from: Lanes3::from_fn(|i| at(i).lit_from.unwrap_or(Vec3::ZERO)),
            limited: mask(|i| at(i).lit_from.is_some()),
            depths: members
                .iter()
                .any(|&m| points[m].max_photon_depth.is_some())
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
    pub(super) fn towards<W: Wide>(&self, w: W, p: Vec3) -> [W::F; 3] {
        sub3(w, splat3(w, p), self.p.load(w))
    }

    /// The points that `light` may reach, which stands at the ends of the vectors `to`: some part lies on the lit side of the point, which
    /// lies on the lit side of some part if the light is one-sided. Others receive nothing; nor do points in the plane of a flat
    /// light, as far as rounding lets one tell.
    #[inline(always)]
    pub(super) fn facing<W: Wide>(
        &self,
        w: W,
        to: [W::F; 3],
        light: &VirtualLight,
        reach: &Reach,
    ) -> LaneMask {
        let (receiving, n) = (self.receiving.load(w), splat3(w, light.n));
        let rounding = w.add(w.load(&self.rounding), w.splat(reach.rounding));
        // Parts lie in a cylinder about ±n. Its radius counts by the sine, which the chord between the normals bounds; exact where it is 0.
        let cos = dot(w, receiving, n);
        let along = [
            w.mul_sign(n[0], cos),
            w.mul_sign(n[1], cos),
            w.mul_sign(n[2], cos),
        ];
        let [x, y, z] = abs3(w, sub3(w, receiving, along));
        let chord = w.add(w.add(x, y), z);
        let highest = w.mul_add(chord, w.splat(reach.radius), dot(w, receiving, to));
        let highest = w.mul_add(w.abs(cos), w.splat(reach.height), highest);
        let above = w.bits(w.lt(rounding, highest)) as LaneMask;
        let before = if light.one_sided {
            let farthest = w.sub(w.splat(reach.height), dot(w, n, to));
            w.bits(w.lt(rounding, farthest)) as LaneMask
        } else {
            LaneMask::MAX
        };
        self.used() & (above | self.open) & before
    }

    /// The points that some light of a cluster may reach: see [`Batch::facing`], here of boxes. All lights of the cluster have their points in
    /// `bounds` and their normals in `normals`, on the side of which alone they shine.
    #[inline(always)]
    pub(super) fn facing_cluster<W: Wide>(&self, w: W, bounds: &Aabb, normals: &Cone) -> LaneMask {
        let (center, half) = (bounds.center(), splat3(w, bounds.extent() * 0.5));
        let rounding = w.add(w.load(&self.rounding), w.splat(rounding_at(center)));
        let (receiving, to) = (self.receiving.load(w), self.towards(w, center));
        let highest = w.add(dot(w, receiving, to), dot(w, abs3(w, receiving), half));
        let above = w.bits(w.lt(rounding, highest)) as LaneMask;
        // The chord to the farthest normal, times the distance, is how much nearer to a horizon a point may be.
        let chord = 2.0 * (0.5 * normals.half_angle.clamp(0.0, PI)).sin();
        let axis = splat3(w, normals.axis);
        let farthest = w.add(w.sqrt(dot(w, to, to)), w.sqrt(dot(w, half, half)));
        let nearest = w.sub(dot(w, axis, to), dot(w, abs3(w, axis), half));
        let nearest = w.sub(nearest, w.mul(w.splat(chord), farthest));
        let before = w.bits(w.lt(nearest, w.sub(w.splat(0.0), rounding))) as LaneMask;
        self.used() & (above | self.open) & before
    }

    /// The points at which light counts that arrives from the unit directions `wi`.
    #[inline(always)]
    pub(super) fn lit<W: Wide>(&self, w: W, wi: [W::F; 3]) -> LaneMask {
        if self.limited == 0 {
            return LaneMask::MAX;
        }
        let side = dot(w, self.lit_from.load(w), wi);
        w.bits(w.lt(w.splat(0.0), side)) as LaneMask | !self.limited
    }
}

/// Where a mirror with normal `n` would send what comes from `w`.
pub(super) fn mirrored(w: Vec3, n: Vec3) -> Vec3 {
    n * (2.0 * n.dot(w)) - w
}

fn offset(x: &SurfacePoint, side: f32) -> Vec3 {
    x.offset_towards(x.ng * side)
}

/// So that runs of as many points as there are lanes, or in all batches together, are compact: halves along the longest axis.
fn sort_in_compact_runs(members: &mut [usize], points: &[ShadingPoint]) {
    if members.len() <= LANES {
        return;
    }
    let run = if members.len() > BATCHES * LANES {
        BATCHES * LANES
    } else {
        LANES
    };
    let runs = members.len().div_ceil(run);
    let p = |i: usize| points[i].x.p;
    let extent = Aabb::from_points(members.iter().map(|&i| p(i))).extent();
    let axis = extent.max_position();
    let half = runs / 2 * run;
    members.select_nth_unstable_by(half, |&i, &j| p(i)[axis].total_cmp(&p(j)[axis]));
    let (low, high) = members.split_at_mut(half);
    sort_in_compact_runs(low, points);
    sort_in_compact_runs(high, points);
}
