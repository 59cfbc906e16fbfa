//! Triangles against blocks of segments.
//!
//! For a point p, a light l and the edge of a triangle with direction e through m, the sign of `(e × (p - m)) · (l - p)` says on
//! which side of the edge the segment passes. It is linear in l and in p: its range over the boxes of a group of points and
//! a group of lights settles most shafts, for a single point its range over the box of the lights settles most rows, and the
//! rest are evaluated, sixteen lights at a time. On which sides of the plane the ends lie is one bit each.
//! Edge functions compare like those of packets ([`EdgeVolumes`](super::triangles::EdgeVolumes)).

use super::shaft::middle_and_half;
use super::tile::SIDE;
use super::triangles::{ROUNDINGS, TriangleBlock};
use crate::lanes::vectors::{
    abs3, add3, cross, dot, dot_add, load3, scale3, splat3, spread3, store3, sub3,
};
use crate::math::{Aabb, Vec3, Vec3A};
use crate::simd::{Floats, NARROW, Simd, WIDE};

/// Groups of sixteen among 64.
pub(super) const GROUPS: usize = SIDE / WIDE;
const SHAFTS: usize = GROUPS * GROUPS;

/// Points or lights in groups.
pub(super) struct EndGroups {
    /// Group, axis, lane. Places that are not used hold a point of the group that is.
    p: [[[f32; WIDE]; 3]; GROUPS],
    /// Around those that are used.
    pub(super) bounds: [Aabb; GROUPS],
    pub(super) all: Aabb,
}

impl EndGroups {
    #[inline(always)]
    pub(super) fn new(points: &[Vec3], used: u64) -> Self {
        let any = points[used.trailing_zeros() as usize % SIDE];
        let mut ends = EndGroups {
            p: [[[0.0; WIDE]; 3]; GROUPS],
            bounds: [Aabb::EMPTY; GROUPS],
            all: Aabb::EMPTY,
        };
        for group in 0..GROUPS {
            let used = used >> (WIDE * group) & 0xffff;
            let members = &points[(WIDE * group).min(points.len())..];
            let some = if used == 0 {
                any
            } else {
                members[used.trailing_zeros() as usize % WIDE]
            };
            let (mut min, mut max) = (Vec3A::from(some), Vec3A::from(some));
            for lane in 0..WIDE {
                let member = members.get(lane).filter(|_| used >> lane & 1 == 1);
                let p = member.copied().unwrap_or(some);
                (min, max) = (min.min(p.into()), max.max(p.into()));
                let [x, y, z] = &mut ends.p[group];
                (x[lane], y[lane], z[lane]) = (p.x, p.y, p.z);
            }
            ends.bounds[group] = Aabb {
                min: min.into(),
                max: max.into(),
            };
            ends.all = ends.all.union(ends.bounds[group]);
        }
        ends
    }

    pub(super) fn mean_half(&self) -> Vec3 {
        let sum = |sum: Vec3, b: &Aabb| sum + b.extent();
        self.bounds.iter().fold(Vec3::ZERO, sum) * (0.5 / GROUPS as f32)
    }

    #[inline(always)]
    fn move_by<W: Floats<16>>(&mut self, w: W, by: Vec3) {
        for group in &mut self.p {
            *group = store3(w, add3(w, load3(w, group), splat3(w, by)));
        }
    }
}

/// Middles and half extents of boxes, in lanes.
struct Boxes<const N: usize> {
    middle: [[f32; N]; 3],
    half: [[f32; N]; 3],
}

/// Eight triangles, relative to the middle of a tile.
pub(super) struct LeafTriangles {
    /// Corner, axis, lane.
    corners: [[[f32; NARROW]; 3]; 3],
    normal: [[f32; NARROW]; 3],
    /// Normal times a corner.
    height: [f32; NARROW],
}

impl LeafTriangles {
    #[inline(always)]
    pub(super) fn new<S: Simd>(s: S, block: &TriangleBlock, origin: Vec3) -> Self {
        let o = splat3(s, origin);
        let [a, b, c] = [
            load3(s, &block.corners[0]),
            load3(s, &block.corners[1]),
            load3(s, &block.corners[2]),
        ];
        let normal = cross(s, sub3(s, c, a), sub3(s, a, b));
        let [a, b, c] = [sub3(s, a, o), sub3(s, b, o), sub3(s, c, o)];
        LeafTriangles {
            corners: [store3(s, a), store3(s, b), store3(s, c)],
            normal: store3(s, normal),
            height: s.store(dot(s, normal, a)),
        }
    }
}

/// Which segments are open, and what is needed to close them. Coordinates are relative to `origin`.
pub(super) struct Rows {
    pub(super) origin: Vec3,
    points: EndGroups,
    lights: EndGroups,
    /// All points, and all lights.
    all: [(Vec3, Vec3); 2],
    /// The groups of each shaft.
    point_boxes: Boxes<WIDE>,
    light_boxes: Boxes<WIDE>,
    /// Bounds the components of all segments.
    size: f32,
    /// Shaft, point: a mask of lights.
    open: [[u16; WIDE]; SHAFTS],
    /// Per shaft the points whose masks are not zero.
    open_rows: [u32; SHAFTS],
    /// The shafts with such points.
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
        let mut open = [[0; WIDE]; SHAFTS];
        let mut open_rows = [0; SHAFTS];
        let mut active = 0;
        for (i, &mask) in wanted.iter().enumerate() {
            for j in 0..GROUPS {
                let shaft = GROUPS * (i / WIDE) + j;
                let row = (mask >> (WIDE * j)) as u16;
                open[shaft][i % WIDE] = row;
                open_rows[shaft] |= u32::from(row != 0) << (i % WIDE);
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

    /// The triangles whose plane may lie between some point and some light.
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
    pub(super) fn block<W: Floats<16>>(
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

    fn close(&mut self, shafts: u32) {
        let mut left = shafts;
        while left != 0 {
            let shaft = left.trailing_zeros() as usize % SHAFTS;
            left &= left - 1;
            self.open[shaft] = [0; WIDE];
            self.open_rows[shaft] = 0;
        }
        self.active &= !shafts;
    }

    /// The shafts that the triangle may block in part, and those that it blocks as a whole.
    #[inline(always)]
    fn classify<W: Floats<16>>(&self, w: W, triangle: &Triangle<W>) -> (u32, u32) {
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
        // Upwards is along the normal.
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

    /// Against the rows of one group of points: `with` are the groups of lights.
    #[inline(always)]
    fn block_rows<W: Floats<16>>(
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
        // Turned so that inside is positive, whichever way the segments pass.
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
                let row = rows.trailing_zeros() as usize % WIDE;
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

    /// The rows in which some light may be inside of all edges, and those in which all are.
    #[inline(always)]
    fn rows_inside<W: Floats<16>>(
        &self,
        w: W,
        planes: &[EdgePlanes; 3],
        shaft: usize,
    ) -> (u32, u32) {
        let middle = spread3(w, &self.light_boxes.middle, shaft);
        let half = spread3(w, &self.light_boxes.half, shaft);
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

    /// For each point the lights that are open.
    pub(super) fn open_by_point(&self) -> [u64; SIDE] {
        std::array::from_fn(|i| {
            let row = |j: usize| u64::from(self.open[GROUPS * (i / WIDE) + j][i % WIDE]);
            row(0) | row(1) << 16 | row(2) << 32 | row(3) << 48
        })
    }
}

fn boxes(ends: &EndGroups, origin: Vec3, group: impl Fn(usize) -> usize) -> Boxes<WIDE> {
    let mut boxes = Boxes {
        middle: [[0.0; WIDE]; 3],
        half: [[0.0; WIDE]; 3],
    };
    for lane in 0..WIDE {
        let (middle, half) = middle_and_half(&ends.bounds[group(lane)]);
        let middle = middle - origin;
        for axis in 0..3 {
            boxes.middle[axis][lane] = middle[axis];
            boxes.half[axis][lane] = half[axis];
        }
    }
    boxes
}

/// Direction and middle of an edge.
type Edge<V> = ([V; 3], [V; 3]);

/// One triangle in all lanes.
struct Triangle<W: Floats<16>> {
    edges: [Edge<W::F>; 3],
    normal: [W::F; 3],
    height: W::F,
}

impl<W: Floats<16>> Triangle<W> {
    #[inline(always)]
    fn new(w: W, triangles: &LeafTriangles, lane: usize) -> Self {
        let [a, b, c] = [
            spread3(w, &triangles.corners[0], lane),
            spread3(w, &triangles.corners[1], lane),
            spread3(w, &triangles.corners[2], lane),
        ];
        Triangle {
            edges: [edge(w, a, b), edge(w, b, c), edge(w, c, a)],
            normal: spread3(w, &triangles.normal, lane),
            height: w.splat(triangles.height[lane]),
        }
    }
}

/// The middle of an edge loses less than its ends, and is the same for both triangles at it.
#[inline(always)]
fn edge<W: Floats<16>>(w: W, a: [W::F; 3], b: [W::F; 3]) -> Edge<W::F> {
    let half = w.splat(0.5);
    (sub3(w, b, a), scale3(w, add3(w, a, b), half))
}

/// The planes through sixteen points and one edge; inside is where `normal · l + offset >= 0`.
struct EdgePlanes {
    normal: [[f32; WIDE]; 3],
    offset: [f32; WIDE],
}

impl EdgePlanes {
    #[inline(always)]
    fn new<W: Floats<16>>(
        w: W,
        (e, m): Edge<W::F>,
        p: [W::F; 3],
        upwards: W::F,
        size: f32,
    ) -> Self {
        let n = cross(w, e, sub3(w, p, m));
        let n = [
            w.mul_sign(n[0], upwards),
            w.mul_sign(n[1], upwards),
            w.mul_sign(n[2], upwards),
        ];
        let slack = w.mul(sum_of_sizes(w, n), w.splat(ROUNDINGS * size));
        let offset = w.sub(slack, dot(w, n, p));
        EdgePlanes {
            normal: store3(w, n),
            offset: w.store(offset),
        }
    }

    #[inline(always)]
    fn inside<W: Floats<16>>(&self, w: W, row: usize, l: [W::F; 3]) -> u32 {
        let n = spread3(w, &self.normal, row);
        let value = dot_add(w, n, l, w.splat(self.offset[row]));
        w.bits(w.le(w.splat(0.0), value))
    }
}

#[inline(always)]
fn sum_of_sizes<W: Floats<16>>(w: W, n: [W::F; 3]) -> W::F {
    let [x, y, z] = abs3(w, n);
    w.add(w.add(x, y), z)
}
