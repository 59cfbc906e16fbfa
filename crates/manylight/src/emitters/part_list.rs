//! The parts of all emitters that are somewhere: found by emitter (photons), or by surface (hits).

use super::parts::{self, Part, PartBounds};
use super::point::point_power;
use super::{Emitter, Strength};
use crate::color::Rgb;
use crate::geometry::{Geometry, SurfaceRef};
use crate::ids::{EmitterId, PrimitiveId};
use crate::sampling::alias::Alias;
use crate::texture::Texture;

/// All parts.
#[derive(Debug)]
pub(super) struct PartList {
    parts: Vec<Part>,
    of_emitter: Vec<Choice>,
    /// Per primitive: where its elements' parts are listed in `part_of_element`.
    elements_of: Vec<Option<Elements>>,
    part_of_element: Vec<u32>,
}

/// The parts of one emitter, for photons.
#[derive(Clone, Debug, Default)]
struct Choice {
    parts: Vec<u32>,
    by_power: Option<Alias>,
}

/// The entries of one primitive: a single one if it is sampled as a whole.
#[derive(Clone, Copy, Debug)]
struct Elements {
    start: u32,
    count: u32,
}

/// No part: a triangle without area.
const NO_PART: u32 = u32::MAX;

impl PartList {
    /// The parts of area emitters on `geometry`'s primitives, and those of points and spots; and what is known of each.
    pub(super) fn collect(
        emitters: &[Emitter],
        geometry: &Geometry,
        textures: &[Texture],
    ) -> (Self, Vec<PartBounds>) {
        let mut list = PartList {
            parts: Vec::new(),
            of_emitter: Vec::new(),
            elements_of: vec![None; geometry.primitives().len()],
            part_of_element: Vec::new(),
        };
        let mut bounds = Vec::new();
        for (i, primitive) in geometry.primitives().iter().enumerate() {
            let Some(id) = primitive.emitter else {
                continue;
            };
            if let Some(Emitter::Area { radiance }) = emitters.get(id.index()) {
                let primitive = PrimitiveId::from(i);
                let parts = parts::parts_of_primitive(geometry, textures, primitive, id, *radiance);
                bounds.extend(list.add_primitive(primitive, parts));
            }
        }
        for (i, emitter) in emitters.iter().enumerate() {
            let power = point_power(emitter, textures);
            if let Some((part, known)) = parts::part_of_point(EmitterId::from(i), emitter, power) {
                list.parts.push(part);
                bounds.push(known);
            }
        }
        list.of_emitter = list.choices(&bounds, emitters.len());
        (list, bounds)
    }

    /// Flux of each emitter in W, for as many emitters as there are.
    pub(super) fn powers(&self, bounds: &[PartBounds]) -> Vec<Rgb> {
        let mut powers = vec![Rgb::BLACK; self.of_emitter.len()];
        for (part, known) in self.parts.iter().zip(bounds) {
            powers[part.emitter.index()] += known.power;
        }
        powers
    }

    /// One of an emitter's parts by its power, with the probability.
    pub(super) fn choose(&self, emitter: EmitterId, u: f32) -> Option<(&Part, f32)> {
        let choice = &self.of_emitter[emitter.index()];
        let (k, pmf) = choice.by_power.as_ref()?.sample(u);
        Some((self.part(choice.parts[k] as usize), pmf))
    }

    /// One part.
    #[inline]
    pub(super) fn part(&self, index: usize) -> &Part {
        &self.parts[index]
    }

    /// The part at a place of a surface.
    #[inline]
    pub(super) fn index_at(&self, at: SurfaceRef) -> Option<usize> {
        let elements = self
            .elements_of
            .get(at.primitive.index())
            .copied()
            .flatten()?;
        // A primitive that is sampled as a whole has one entry for all its elements.
        let element = if elements.count == 1 { 0 } else { at.element };
        let part = (element < elements.count)
            .then(|| self.part_of_element[(elements.start + element) as usize])?;
        (part != NO_PART).then_some(part as usize)
    }

    fn choices(&self, bounds: &[PartBounds], emitters: usize) -> Vec<Choice> {
        let mut lists = vec![Vec::new(); emitters];
        for (i, part) in self.parts.iter().enumerate() {
            lists[part.emitter.index()].push(i as u32);
        }
        let strength = |i: &u32| bounds[*i as usize].power.strength();
        let choice = |parts: Vec<u32>| {
            let strengths: Vec<f32> = parts.iter().map(strength).collect();
            Choice {
                by_power: Alias::new(&strengths),
                parts,
            }
        };
        lists.into_iter().map(choice).collect()
    }

    /// Adds the parts of one primitive, each with its element; returns what is known of them.
    fn add_primitive(
        &mut self,
        primitive: PrimitiveId,
        parts: Vec<(u32, Part, PartBounds)>,
    ) -> Vec<PartBounds> {
        let Some(last) = parts.last() else {
            return Vec::new();
        };
        let (start, count) = (self.part_of_element.len() as u32, last.0 + 1);
        self.part_of_element
            .resize((start + count) as usize, NO_PART);
        self.elements_of[primitive.index()] = Some(Elements { start, count });
        let add = |(element, part, known)| {
            self.part_of_element[(start + element) as usize] = self.parts.len() as u32;
            self.parts.push(part);
            known
        };
        parts.into_iter().map(add).collect()
    }
}
