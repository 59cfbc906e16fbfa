//! The ends of the segments of a stream, sorted by material.

use crate::geometry::{Hit, Ray};
use crate::ids::MaterialId;
use crate::scene::Scene;
use std::ops::Range;

/// Where the rays of a stream end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Arrivals {
    /// By walk.
    pub(crate) hits: Vec<Option<Hit>>,
    /// Walks that leave the scene.
    pub(crate) escaped: Vec<u32>,
    /// Walks that hit a surface, by material, and in the order of the stream within a material.
    order: Vec<u32>,
    /// Material of each hit of the stream.
    materials: Vec<u32>,
    /// By material: where its next walk goes in `order`.
    places: Vec<u32>,
    runs: Vec<Run>,
}

/// The walks that hit one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) material: MaterialId,
    range: Range<usize>,
}

/// Mark of a ray without a hit among the materials of hits.
const NONE: u32 = u32::MAX;

impl Arrivals {
    /// Intersects rays with the scene.
    pub(crate) fn trace(&mut self, scene: &Scene, rays: &[Ray]) {
        scene.geometry.intersect_stream(rays, &mut self.hits);
        self.sort(scene);
    }

    /// The runs of walks with one material, in the order of materials.
    pub(crate) fn runs(&self) -> impl Iterator<Item = (MaterialId, &[u32])> {
        self.runs
            .iter()
            .map(|run| (run.material, &self.order[run.range.clone()]))
    }

    /// A counting sort by material: stable, so that the order does not depend on anything but the
    /// stream.
    fn sort(&mut self, scene: &Scene) {
        let primitives = scene.geometry.primitives();
        self.places.clear();
        self.places.resize(scene.materials.descriptions().len(), 0);
        self.materials.clear();
        self.escaped.clear();
        for (i, hit) in self.hits.iter().enumerate() {
            let material = match hit {
                Some(hit) => primitives[hit.at.primitive.index()].material.0,
                None => NONE,
            };
            match self.places.get_mut(material as usize) {
                Some(count) => *count += 1,
                None => self.escaped.push(i as u32),
            }
            self.materials.push(material);
        }
        self.runs.clear();
        let mut start = 0;
        for (material, place) in self.places.iter_mut().enumerate() {
            let count = std::mem::replace(place, start as u32) as usize;
            if count > 0 {
                let range = start..start + count;
                start = range.end;
                let material = MaterialId::from(material);
                self.runs.push(Run { material, range });
            }
        }
        self.order.clear();
        self.order.resize(start, 0);
        for (i, &material) in self.materials.iter().enumerate() {
            if let Some(place) = self.places.get_mut(material as usize) {
                self.order[*place as usize] = i as u32;
                *place += 1;
            }
        }
    }
}
