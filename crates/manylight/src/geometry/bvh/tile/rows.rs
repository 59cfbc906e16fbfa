//! Triangles against the segments of a visibility tile.
//!
//! Let p be a point, l a light, and e and m the direction and midpoint of an edge. The sign of
//! `(e × (p - m)) · (l - p)` tells on which side of the edge the segment passes. The function is
//! linear in p and in l. Three tests follow, each for the segments left by the one before:
//! 1. a whole shaft, by the range of the function over the boxes of a group of points and a group
//!    of lights;
//! 2. a row, all segments of one point to a group of lights, by its range over the box of the
//!    lights;
//! 3. single segments, sixteen lights at a time.
//!
//! One bit per point and light tells on which side of the triangle's plane it lies. Tolerances are
//! those of [`EdgeVolumes`](crate::geometry::bvh::edge_volumes::EdgeVolumes).

use super::ends::{Boxes, EndGroups, GROUPS, SIDE, boxes};
use super::triangle::{EdgePlanes, LeafTriangles, Triangle};
use crate::geometry::bvh::edge_volumes::{ROUNDINGS, sum_of_sizes};
use crate::geometry::bvh::shaft::middle_and_half;
use crate::lanes::{Float, LANES, Sixteen, Vector, lane};
use crate::math::{Aabb, Vec3};
use crate::simd::Simd;

/// Number of shafts: pairs of a group of points and a group of lights.
const SHAFTS: usize = GROUPS * GROUPS;

/// The open segments of a tile, by row. Coordinates are relative to `origin`.
pub(super) struct Rows {
    pub(super) origin: Vec3,
    points: EndGroups,
    lights: EndGroups,
    /// Center and half extents of the box of all points, and of all lights.
    all: [(Vec3, Vec3); 2],
    /// Boxes of the points, and of the lights, of each shaft.
    point_boxes: Boxes<LANES>,
    light_boxes: Boxes<LANES>,
    /// Upper bound of the components of all segments.
    size: f32,
    /// Mask of the open lights, by shaft and point.
    open: [[u16; LANES]; SHAFTS],
    /// By shaft, the points with a mask that is not zero.
    open_rows: [u32; SHAFTS],
    /// The shafts with open segments.
    pub(super) active: u32,
}

impl Rows {
    #[inline(always)]
    pub(super) fn new<S: Simd>(
        s: S,
        mut points: EndGroups,
        mut lights: EndGroups,
        wanted: &[u64],
    ) -> Self {
        let both = points.all.union(lights.all);
        let origin = both.center();
        let mut open = [[0; LANES]; SHAFTS];
        let mut open_rows = [0; SHAFTS];
        let mut active = 0;
        for (i, &mask) in wanted.iter().enumerate() {
            for j in 0..GROUPS {
                let shaft = GROUPS * (i / LANES) + j;
                let row = (mask >> (LANES * j)) as u16;
                open[shaft][i % LANES] = row;
                open_rows[shaft] |= u32::from(row != 0) << (i % LANES);
                active |= u32::from(row != 0) << shaft;
            }
        }
        points.move_by(s.wide(), -origin);
        lights.move_by(s.wide(), -origin);
        let (point_boxes, light_boxes) = (
            boxes(&points, origin, |lane| lane / GROUPS),
            boxes(&lights, origin, |lane| lane % GROUPS),
        );
        let relative = |b: &Aabb| {
            let (middle, half) = middle_and_half(b);
            (middle - origin, half)
        };
        Rows {
            origin,
            all: [relative(&points.all), relative(&lights.all)],
            points,
            lights,
            point_boxes,
            light_boxes,
            size: both.extent().max_element(),
            open,
            open_rows,
            active,
        }
    }

    /// The triangles with a plane that may separate some point from some light; conservative.
    #[inline(always)]
    pub(super) fn crossed<S: Simd>(&self, s: S, triangles: &LeafTriangles) -> u32 {
        let n = Vector::load(s, &triangles.normal);
        let height = Float::load(s, &triangles.height);
        let size = n.abs();
        let [(p, p_half), (l, l_half)] = self.all;
        let at_p = n.dot(Vector::splat(s, p)) - height;
        let at_l = n.dot(Vector::splat(s, l)) - height;
        let p_reach = size.dot(Vector::splat(s, p_half));
        let l_reach = size.dot(Vector::splat(s, l_half));
        let up = (at_p - p_reach).lt(0.0) & (at_l + l_reach).gt(0.0);
        let down = (at_p + p_reach).gt(0.0) & (at_l - l_reach).lt(0.0);
        (up | down).bits()
    }

    /// Closes the segments of `shafts` that the triangle in `lane` blocks.
    #[inline(always)]
    pub(super) fn block<S: Sixteen>(
        &mut self,
        s: S,
        triangles: &LeafTriangles,
        lane: usize,
        shafts: u32,
    ) {
        let triangle = Triangle::new(s, triangles, lane);
        let (mut partly, wholly) = self.classify(s, &triangle);
        partly &= shafts & !wholly;
        self.close(wholly & shafts);
        while partly != 0 {
            let group = partly.trailing_zeros() as usize / GROUPS;
            let with = partly >> (GROUPS * group) & 0xf;
            partly &= !(0xf << (GROUPS * group));
            self.block_rows(s, &triangle, group, with);
        }
    }

    /// Closes all segments of `shafts`.
    fn close(&mut self, shafts: u32) {
        let mut left = shafts;
        while left != 0 {
            let shaft = left.trailing_zeros() as usize % SHAFTS;
            left &= left - 1;
            self.open[shaft] = [0; LANES];
            self.open_rows[shaft] = 0;
        }
        self.active &= !shafts;
    }

    /// The shafts that the triangle may block, and among them those that it blocks completely.
    #[inline(always)]
    fn classify<S: Sixteen>(&self, s: S, triangle: &Triangle<S>) -> (u32, u32) {
        let p = Vector::load(s, &self.point_boxes.middle);
        let p_half = Vector::load(s, &self.point_boxes.half);
        let l = Vector::load(s, &self.light_boxes.middle);
        let l_half = Vector::load(s, &self.light_boxes.half);
        let size = triangle.normal.abs();
        let at_p = triangle.normal.dot(p) - triangle.height;
        let at_l = triangle.normal.dot(l) - triangle.height;
        let (p_reach, l_reach) = (size.dot(p_half), size.dot(l_half));
        let (p_least, p_greatest) = (at_p - p_reach, at_p + p_reach);
        let (l_least, l_greatest) = (at_l - l_reach, at_l + l_reach);
        // Upwards means along the normal.
        let mut up = p_least.lt(0.0) & l_greatest.gt(0.0);
        let mut down = p_greatest.gt(0.0) & l_least.lt(0.0);
        let mut all_up = p_greatest.lt(0.0) & l_least.gt(0.0);
        let mut all_down = p_least.gt(0.0) & l_greatest.lt(0.0);
        let d = l - p;
        let product = Vector::new(
            p_half.y.mul_add(l_half.z, p_half.z * l_half.y),
            p_half.z.mul_add(l_half.x, p_half.x * l_half.z),
            p_half.x.mul_add(l_half.y, p_half.y * l_half.x),
        );
        for edge in triangle.edges {
            let e = edge.direction;
            let (from, to) = (p - edge.middle, l - edge.middle);
            let n = e.cross(from);
            let value = n.dot(d);
            let by_light = n.abs().dot(l_half);
            let by_point = to.cross(e).abs().dot_add(p_half, by_light);
            let slack = sum_of_sizes(n) * (ROUNDINGS * self.size);
            let reach = e.abs().dot_add(product, by_point) + slack;
            let (least, greatest) = (value - reach, value + reach);
            up = up & greatest.ge(0.0);
            down = down & least.le(0.0);
            all_up = all_up & least.ge(0.0);
            all_down = all_down & greatest.le(0.0);
        }
        ((up | down).bits(), (all_up | all_down).bits())
    }

    /// Closes the blocked segments between one group of points and the groups of lights in `with`.
    #[inline(always)]
    fn block_rows<S: Sixteen>(
        &mut self,
        s: S,
        triangle: &Triangle<S>,
        group: usize,
        mut with: u32,
    ) {
        let p = Vector::load(s, &self.points.p[group]);
        let at_p = triangle.normal.dot(p) - triangle.height;
        let (below, above) = (at_p.lt(0.0).bits(), at_p.gt(0.0).bits());
        // Oriented so that inside is positive in either direction of the segments.
        let upwards = 0.0 - at_p;
        let planes = [
            EdgePlanes::new(triangle.edges[0], p, upwards, self.size),
            EdgePlanes::new(triangle.edges[1], p, upwards, self.size),
            EdgePlanes::new(triangle.edges[2], p, upwards, self.size),
        ];
        while with != 0 {
            let other = with.trailing_zeros() as usize % GROUPS;
            with &= with - 1;
            let shaft = GROUPS * group + other;
            let l = Vector::load(s, &self.lights.p[other]);
            let at_l = triangle.normal.dot(l) - triangle.height;
            let (lights_below, lights_above) = (at_l.lt(0.0).bits(), at_l.gt(0.0).bits());
            let rows_up = if lights_above == 0 { 0 } else { below };
            let rows_down = if lights_below == 0 { 0 } else { above };
            let mut rows = (rows_up | rows_down) & self.open_rows[shaft];
            if rows == 0 {
                continue;
            }
            let (possible, certain) = self.rows_inside(s, &planes, shaft);
            rows &= possible;
            while rows != 0 {
                let row = rows.trailing_zeros() as usize % LANES;
                rows &= rows - 1;
                let side = if below >> row & 1 == 1 {
                    lights_above
                } else {
                    lights_below
                };
                let open = &mut self.open[shaft][row];
                let blocked = if certain >> row & 1 == 1 {
                    side
                } else if u32::from(*open) & side == 0 {
                    continue;
                } else {
                    side & planes[0].inside(row, l)
                        & planes[1].inside(row, l)
                        & planes[2].inside(row, l)
                };
                *open &= !(blocked as u16);
                self.open_rows[shaft] &= !(u32::from(*open == 0) << row);
            }
            self.active &= !(u32::from(self.open_rows[shaft] == 0) << shaft);
        }
    }

    /// The rows in which some light may be inside of all edges, and those in which all lights are.
    #[inline(always)]
    fn rows_inside<S: Sixteen>(&self, s: S, planes: &[EdgePlanes; 3], shaft: usize) -> (u32, u32) {
        let middle = Vector::splat(s, lane(&self.light_boxes.middle, shaft).into());
        let half = Vector::splat(s, lane(&self.light_boxes.half, shaft).into());
        let (mut possible, mut certain) = (0xffff, 0xffff);
        for plane in planes {
            let n = Vector::load(s, &plane.normal);
            let value = n.dot_add(middle, Float::load(s, &plane.offset));
            let reach = n.abs().dot(half);
            possible &= (value + reach).ge(0.0).bits();
            certain &= (value - reach).ge(0.0).bits();
        }
        (possible, certain)
    }

    /// For each point the mask of its open lights.
    pub(super) fn open_by_point(&self) -> [u64; SIDE] {
        std::array::from_fn(|i| {
            let row = |j: usize| u64::from(self.open[GROUPS * (i / LANES) + j][i % LANES]);
            row(0) | row(1) << 16 | row(2) << 32 | row(3) << 48
        })
    }
}
