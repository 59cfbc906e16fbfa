//! The pieces of all emitters that are somewhere: found by emitter (photons), or by surface (hits).

use super::parts::{self, Part, PartBounds};
use super::point::point_power;
use super::{Emitter, Strength};
use crate::color::Rgb;
use crate::geometry::{Geometry, SurfaceRef};
use crate::ids::{EmitterId, PrimitiveId};
use crate::sampling::alias::Alias;
use crate::texture::{ColorInput, Texture};

/// All pieces.
#[derive(Debug)]
pub(super) struct Pieces {
    parts: Vec<Part>,
    /// What is known of each part.
    bounds: Vec<PartBounds>,
    of_emitter: Vec<Choice>,
    /// Per primitive: where its elements' pieces are listed in `part_of_element`.
    elements_of: Vec<Option<Elements>>,
    part_of_element: Vec<u32>,
}

/// The pieces of one emitter, for photons.
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

/// No piece: a triangle without area.
const NO_PART: u32 = u32::MAX;

impl Pieces {
    /// The pieces of area emitters on `geometry`'s primitives, and those of points and spots.
    pub(super) fn new(emitters: &[Emitter], geometry: &Geometry, textures: &[Texture]) -> Self {
        let mut pieces = Pieces {
            parts: Vec::new(),
            bounds: Vec::new(),
            of_emitter: Vec::new(),
            elements_of: vec![None; geometry.primitives().len()],
            part_of_element: Vec::new(),
        };
        for (i, primitive) in geometry.primitives().iter().enumerate() {
            let Some(id) = primitive.emitter else {
                continue;
            };
            if let Some(Emitter::Area { radiance }) = emitters.get(id.index()) {
                pieces.add_primitive(geometry, textures, PrimitiveId::from(i), id, *radiance);
            }
        }
        for (i, emitter) in emitters.iter().enumerate() {
            let power = point_power(emitter, textures);
            pieces.add(parts::part_of_point(EmitterId::from(i), emitter, power));
        }
        pieces.of_emitter = pieces.choices(emitters.len());
        pieces
    }

    /// What is known of each piece.
    pub(super) fn bounds(&self) -> &[PartBounds] {
        &self.bounds
    }

    /// Flux of each emitter in W, for as many emitters as there are.
    pub(super) fn powers(&self) -> Vec<Rgb> {
        let mut powers = vec![Rgb::BLACK; self.of_emitter.len()];
        for (part, known) in self.parts.iter().zip(&self.bounds) {
            powers[part.emitter.index()] += known.power;
        }
        powers
    }

    /// One of an emitter's pieces by its power, with the probability.
    pub(super) fn choose(&self, emitter: EmitterId, u: f32) -> Option<(&Part, f32)> {
        let choice = &self.of_emitter[emitter.index()];
        let (k, pmf) = choice.by_power.as_ref()?.sample(u);
        Some((self.part(choice.parts[k] as usize), pmf))
    }

    /// One piece.
    #[inline]
    pub(super) fn part(&self, index: usize) -> &Part {
        &self.parts[index]
    }

    /// The piece at a place of a surface.
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

    fn choices(&self, emitters: usize) -> Vec<Choice> {
        let mut lists = vec![Vec::new(); emitters];
        for (i, part) in self.parts.iter().enumerate() {
            lists[part.emitter.index()].push(i as u32);
        }
        let strength = |i: &u32| self.bounds[*i as usize].power.strength();
        let choice = |parts: Vec<u32>| {
            let strengths: Vec<f32> = parts.iter().map(strength).collect();
            Choice {
                by_power: Alias::new(&strengths),
                parts,
            }
        };
        lists.into_iter().map(choice).collect()
    }

    fn add(&mut self, pieces: impl IntoIterator<Item = (Part, PartBounds)>) {
        for (part, bounds) in pieces {
            self.parts.push(part);
            self.bounds.push(bounds);
        }
    }

    fn add_primitive(
        &mut self,
        geometry: &Geometry,
        textures: &[Texture],
        primitive: PrimitiveId,
        emitter: EmitterId,
        radiance: ColorInput,
    ) {
        let pieces = parts::parts_of_primitive(geometry, textures, primitive, emitter, radiance);
        let Some(last) = pieces.last() else { return };
        let (start, count) = (self.part_of_element.len() as u32, last.0 + 1);
        self.part_of_element
            .resize((start + count) as usize, NO_PART);
        for (k, (element, ..)) in pieces.iter().enumerate() {
            self.part_of_element[(start + element) as usize] = (self.parts.len() + k) as u32;
        }
        self.elements_of[primitive.index()] = Some(Elements { start, count });
        self.add(pieces.into_iter().map(|(_, part, bounds)| (part, bounds)));
    }
}
