//! Which primitive a triangle belongs to.

use crate::ids::PrimitiveId;

/// Maps the index of a triangle in the table to a primitive and its triangle. Each primitive has a
/// run of consecutive indices.
#[derive(Debug)]
pub(in crate::geometry) struct Numbering {
    /// First index of each run, and its primitive; ascending.
    runs: Vec<(u32, PrimitiveId)>,
    /// Run of each multiple of [`Numbering::BUCKET`], so that a lookup searches few runs.
    buckets: Vec<u32>,
}

impl Numbering {
    /// Triangles per bucket. Smaller buckets take more memory, larger ones longer searches among
    /// small primitives.
    const BUCKET: u32 = 16;

    /// `runs` as below; `count` is the number of triangles.
    pub(super) fn new(runs: Vec<(u32, PrimitiveId)>, count: u32) -> Self {
        let mut buckets = Vec::with_capacity((count / Self::BUCKET + 2) as usize);
        let mut run = 0;
        for first in (0..count).step_by(Self::BUCKET as usize) {
            while runs.get(run + 1).is_some_and(|next| next.0 <= first) {
                run += 1;
            }
            buckets.push(run as u32);
        }
        buckets.push(runs.len().saturating_sub(1) as u32);
        Numbering { runs, buckets }
    }

    /// The primitive of the triangle with an index, and its index in the mesh.
    #[inline]
    pub(in crate::geometry) fn locate(&self, id: u32) -> (PrimitiveId, u32) {
        let bucket = (id / Self::BUCKET) as usize;
        let (low, high) = (
            self.buckets[bucket] as usize,
            self.buckets[bucket + 1] as usize,
        );
        let run = low + self.runs[low + 1..=high].partition_point(|run| run.0 <= id);
        let (first, primitive) = self.runs[run];
        (primitive, id - first)
    }
}
