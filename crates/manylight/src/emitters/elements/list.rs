//! The elements of all emitters, found by emitter (for photons) and by surface (for rays that hit
//! one).

use super::element::{ElementBounds, EmitterElement};
use super::of_primitive::{AreaEmitter, IndexedElement, element_of_point};
use super::sampling::ElementSampling;
use crate::color::Rgb;
use crate::emitters::Emitter;
use crate::geometry::{Geometry, SurfaceRef};
use crate::ids::{EmitterId, PrimitiveId};
use crate::sampling::alias::Alias;
use crate::texture::{Texture, TextureBounds};

/// All elements of a scene.
#[derive(Debug)]
pub(in crate::emitters) struct ElementList {
    elements: Vec<EmitterElement>,
    /// By element.
    pub(super) sampling: Vec<ElementSampling>,
    /// By emitter.
    of_emitter: Vec<EmitterElements>,
    /// By primitive: its range of `of_triangle`; `None` without an area emitter.
    of_primitive: Vec<Option<TriangleRange>>,
    /// By triangle of the primitives with area emitters: index of the element, or [`NO_ELEMENT`].
    of_triangle: Vec<u32>,
    /// Whether there are surfaces that no ray meets.
    pub(super) has_invisible: bool,
}

/// The elements of one emitter.
#[derive(Clone, Debug, Default)]
struct EmitterElements {
    indices: Vec<u32>,
    /// Choice of an element by power; `None` without power.
    by_power: Option<Alias>,
}

/// The triangles of one primitive; one entry for a primitive that is one element.
#[derive(Clone, Copy, Debug)]
struct TriangleRange {
    start: u32,
    count: u32,
}

/// Marks triangles without area.
const NO_ELEMENT: u32 = u32::MAX;

impl ElementList {
    /// The elements of the area emitters on `geometry`'s primitives, and of points and spots; and
    /// the bounds of each.
    pub(in crate::emitters) fn collect(
        emitters: &[Emitter],
        geometry: &Geometry,
        textures: &[Texture],
    ) -> (Self, Vec<ElementBounds>) {
        let mut list = ElementList {
            elements: Vec::new(),
            sampling: Vec::new(),
            of_emitter: Vec::new(),
            of_primitive: vec![None; geometry.primitives().len()],
            of_triangle: Vec::new(),
            has_invisible: emitters.iter().any(Emitter::is_invisible),
        };
        let mut bounds = Vec::new();
        let textures = &TextureBounds::new(textures);
        for (i, primitive) in geometry.primitives().iter().enumerate() {
            let Some(id) = primitive.emitter else {
                continue;
            };
            let emitter = emitters.get(id.index());
            if let Some(radiance) = emitter.and_then(Emitter::surface_radiance) {
                let area = AreaEmitter {
                    geometry,
                    textures,
                    primitive: PrimitiveId::from(i),
                    emitter: id,
                    radiance,
                };
                bounds.extend(list.add_primitive(area.primitive, area.elements()));
            }
        }
        for (i, emitter) in emitters.iter().enumerate() {
            let of_point = element_of_point(EmitterId::from(i), emitter, textures);
            if let Some((element, sampling, bound)) = of_point {
                list.elements.push(element);
                list.sampling.push(sampling);
                bounds.push(bound);
            }
        }
        list.of_emitter = list.by_emitter(&bounds, emitters.len());
        (list, bounds)
    }

    /// Flux of each emitter in W; black for infinite lights.
    pub(in crate::emitters) fn powers(&self, bounds: &[ElementBounds]) -> Vec<Rgb> {
        let mut powers = vec![Rgb::BLACK; self.of_emitter.len()];
        for (element, bound) in self.elements.iter().zip(bounds) {
            powers[element.emitter.index()] += bound.power;
        }
        powers
    }

    /// One of an emitter's elements, chosen by power, and the probability of the choice.
    pub(in crate::emitters) fn choose(
        &self,
        emitter: EmitterId,
        u: f32,
    ) -> Option<(&EmitterElement, f32)> {
        let elements = &self.of_emitter[emitter.index()];
        let (k, pmf) = elements.by_power.as_ref()?.sample(u);
        Some((self.element(elements.indices[k] as usize), pmf))
    }

    /// Number of elements.
    pub(in crate::emitters) fn len(&self) -> usize {
        self.elements.len()
    }

    /// The element with this index.
    #[inline]
    pub(in crate::emitters) fn element(&self, index: usize) -> &EmitterElement {
        &self.elements[index]
    }

    /// Index of the element at a surface point.
    #[inline]
    pub(in crate::emitters) fn index_at(&self, at: SurfaceRef) -> Option<usize> {
        let range = self
            .of_primitive
            .get(at.primitive.index())
            .copied()
            .flatten()?;
        // A primitive that is one element has one entry for all triangles.
        let triangle = if range.count == 1 { 0 } else { at.element };
        let element = (triangle < range.count)
            .then(|| self.of_triangle[(range.start + triangle) as usize])?;
        (element != NO_ELEMENT).then_some(element as usize)
    }

    fn by_emitter(&self, bounds: &[ElementBounds], emitters: usize) -> Vec<EmitterElements> {
        let mut lists = vec![Vec::new(); emitters];
        for (i, element) in self.elements.iter().enumerate() {
            lists[element.emitter.index()].push(i as u32);
        }
        let weight = |i: &u32| bounds[*i as usize].power.selection_weight();
        let elements = |indices: Vec<u32>| {
            let weights: Vec<f32> = indices.iter().map(weight).collect();
            EmitterElements {
                by_power: Alias::new(&weights),
                indices,
            }
        };
        lists.into_iter().map(elements).collect()
    }

    /// Adds the elements of one primitive, in ascending order of their triangles. Returns their
    /// bounds.
    fn add_primitive(
        &mut self,
        primitive: PrimitiveId,
        elements: Vec<IndexedElement>,
    ) -> Vec<ElementBounds> {
        let Some(last) = elements.last() else {
            return Vec::new();
        };
        let (start, count) = (self.of_triangle.len() as u32, last.triangle + 1);
        self.of_triangle
            .resize((start + count) as usize, NO_ELEMENT);
        self.of_primitive[primitive.index()] = Some(TriangleRange { start, count });
        let add = |of: IndexedElement| {
            self.of_triangle[(start + of.triangle) as usize] = self.elements.len() as u32;
            self.elements.push(of.element);
            self.sampling.push(of.sampling);
            of.bounds
        };
        elements.into_iter().map(add).collect()
    }
}
