//! Triangles against the segments of a visibility tile.
//!
//! Let p be a point, l a light, and e and m the direction and midpoint of an edge. The sign of `(e × (p - m)) · (l - p)` tells on which side
//! of the edge the segment passes. The function is linear in p and in l. Three tests follow, each for the segments left by the one before:
//! 1. a whole shaft, by the range of the function over the boxes of a group of points and a group of lights;
//! 2. a row, all segments of one point to a group of lights, by its range over the box of the lights;
//! 3. single segments, sixteen lights at a time.
//!
//! One bit per point and light tells on which side of the triangle's plane it lies. Tolerances are those of
//! [`EdgeVolumes`](super::edge_volumes::EdgeVolumes).

use super::edge_volumes::ROUNDINGS;
use super::end_groups::{Boxes, EndGroups, GROUPS, boxes};
use super::shaft::middle_and_half;
use super::tile::SIDE;
use super::tile_triangle::{EdgePlanes, LeafTriangles, Triangle, sum_of_sizes};
use crate::lanes::vectors::{abs3, broadcast3, cross, dot, dot_add, load3, splat3, sub3};
use crate::math::{Aabb, Vec3};
use crate::simd::{LANES, Simd, Sixteen};

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
        let n = load3(s, &triangles.normal);
        let height = s.load(&triangles.height);
        let zero = s.splat(0.0);
        let size = abs3(s, n);
        let [(p, p_half), (l, l_half)] = self.all;
        let at_p = s.sub(dot(s, n, splat3(s, p)), height);
        let at_l = s.sub(dot(s, n, splat3(s, l)), height);
        let p_reach = dot(s, size, splat3(s, p_half));
        let l_reach = dot(s, size, splat3(s, l_half));
        let up = s.and(
            s.lt(s.sub(at_p, p_reach), zero),
            s.lt(zero, s.add(at_l, l_reach)),
        );
        let down = s.and(
            s.lt(zero, s.add(at_p, p_reach)),
            s.lt(s.sub(at_l, l_reach), zero),
        );
        s.bits(s.or(up, down))
    }

    /// Closes the segments of `shafts` that the triangle in `lane` blocks.
    #[inline(always)]
    pub(super) fn block<W: Sixteen>(
        &mut self,
        w: W,
        triangles: &LeafTriangles,
        lane: usize,
        shafts: u32,
    ) {
        let triangle = Triangle::new(w, triangles, lane);
        let (mut partly, wholly) = self.classify(w, &triangle);
        partly &= shafts & !wholly;
        self.close(wholly & shafts);
        while partly != 0 {
            let group = partly.trailing_zeros() as usize / GROUPS;
            let with = partly >> (GROUPS * group) & 0xf;
            partly &= !(0xf << (GROUPS * group));
            self.block_rows(w, &triangle, group, with);
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
    fn classify<W: Sixteen>(&self, w: W, triangle: &Triangle<W>) -> (u32, u32) {
        let zero = w.splat(0.0);
        let p = load3(w, &self.point_boxes.middle);
        let p_half = load3(w, &self.point_boxes.half);
        let l = load3(w, &self.light_boxes.middle);
        let l_half = load3(w, &self.light_boxes.half);
        let size = abs3(w, triangle.normal);
        let at_p = w.sub(dot(w, triangle.normal, p), triangle.height);
        let at_l = w.sub(dot(w, triangle.normal, l), triangle.height);
        let (p_reach, l_reach) = (dot(w, size, p_half), dot(w, size, l_half));
        let (p_least, p_greatest) = (w.sub(at_p, p_reach), w.add(at_p, p_reach));
        let (l_least, l_greatest) = (w.sub(at_l, l_reach), w.add(at_l, l_reach));
        // Upwards means along the normal.
        let mut up = w.and(w.lt(p_least, zero), w.lt(zero, l_greatest));
        let mut down = w.and(w.lt(zero, p_greatest), w.lt(l_least, zero));
        let mut all_up = w.and(w.lt(p_greatest, zero), w.lt(zero, l_least));
        let mut all_down = w.and(w.lt(zero, p_least), w.lt(l_greatest, zero));
        let d = sub3(w, l, p);
        let product = [
            w.mul_add(p_half[1], l_half[2], w.mul(p_half[2], l_half[1])),
            w.mul_add(p_half[2], l_half[0], w.mul(p_half[0], l_half[2])),
            w.mul_add(p_half[0], l_half[1], w.mul(p_half[1], l_half[0])),
        ];
        for (e, m) in triangle.edges {
            let (from, to) = (sub3(w, p, m), sub3(w, l, m));
            let n = cross(w, e, from);
            let value = dot(w, n, d);
            let by_light = dot(w, abs3(w, n), l_half);
            let by_point = dot_add(w, abs3(w, cross(w, to, e)), p_half, by_light);
            let reach = dot_add(w, abs3(w, e), product, by_point);
            let slack = w.mul(sum_of_sizes(w, n), w.splat(ROUNDINGS * self.size));
            let reach = w.add(reach, slack);
            let (least, greatest) = (w.sub(value, reach), w.add(value, reach));
            up = w.and(up, w.le(zero, greatest));
            down = w.and(down, w.le(least, zero));
            all_up = w.and(all_up, w.le(zero, least));
            all_down = w.and(all_down, w.le(greatest, zero));
        }
        (w.bits(w.or(up, down)), w.bits(w.or(all_up, all_down)))
    }

    /// Closes the blocked segments between one group of points and the groups of lights in `with`.
    #[inline(always)]
    fn block_rows<W: Sixteen>(
        &mut self,
        w: W,
        triangle: &Triangle<W>,
        group: usize,
        mut with: u32,
    ) {
        let p = load3(w, &self.points.p[group]);
        let zero = w.splat(0.0);
        let at_p = w.sub(dot(w, triangle.normal, p), triangle.height);
        let (below, above) = (w.bits(w.lt(at_p, zero)), w.bits(w.lt(zero, at_p)));
        // Oriented so that inside is positive in either direction of the segments.
        let upwards = w.sub(zero, at_p);
        let planes = [
            EdgePlanes::new(w, triangle.edges[0], p, upwards, self.size),
            EdgePlanes::new(w, triangle.edges[1], p, upwards, self.size),
            EdgePlanes::new(w, triangle.edges[2], p, upwards, self.size),
        ];
        while with != 0 {
            let other = with.trailing_zeros() as usize % GROUPS;
            with &= with - 1;
            let shaft = GROUPS * group + other;
            let l = load3(w, &self.lights.p[other]);
            let at_l = w.sub(dot(w, triangle.normal, l), triangle.height);
            let lights_above = w.bits(w.lt(zero, at_l));
            let lights_below = w.bits(w.lt(at_l, zero));
            let rows_up = if lights_above == 0 { 0 } else { below };
            let rows_down = if lights_below == 0 { 0 } else { above };
            let mut rows = (rows_up | rows_down) & self.open_rows[shaft];
            if rows == 0 {
                continue;
            }
            let (possible, certain) = self.rows_inside(w, &planes, shaft);
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
                    side & planes[0].inside(w, row, l)
                        & planes[1].inside(w, row, l)
                        & planes[2].inside(w, row, l)
                };
                *open &= !(blocked as u16);
                self.open_rows[shaft] &= !(u32::from(*open == 0) << row);
            }
            self.active &= !(u32::from(self.open_rows[shaft] == 0) << shaft);
        }
    }

    /// The rows in which some light may be inside of all edges, and those in which all lights are.
    #[inline(always)]
    fn rows_inside<W: Sixteen>(&self, w: W, planes: &[EdgePlanes; 3], shaft: usize) -> (u32, u32) {
        let middle = broadcast3(w, &self.light_boxes.middle, shaft);
        let half = broadcast3(w, &self.light_boxes.half, shaft);
        let zero = w.splat(0.0);
        let (mut possible, mut certain) = (0xffff, 0xffff);
        for plane in planes {
            let n = load3(w, &plane.normal);
            let value = dot_add(w, n, middle, w.load(&plane.offset));
            let reach = dot(w, abs3(w, n), half);
            possible &= w.bits(w.le(zero, w.add(value, reach)));
            certain &= w.bits(w.le(zero, w.sub(value, reach)));
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
