//! Which definition a name has at a place of the file, by the rules of PBRT v3: the last one
//! before the place counts, and definitions in a block end with the block.

use std::collections::HashMap;

/// The type of a texture, as its directive says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum TextureType {
    Float,
    Spectrum,
}

/// Textures of both types and named materials have separate names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum NameSpace {
    Texture(TextureType),
    Material,
}

/// A place of the file, counted in changes of names before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place(usize);

type Key = (NameSpace, String);

/// The definitions of names, as indices in the lists of declarations.
#[derive(Debug, Default)]
pub(super) struct Bindings {
    here: Place,
    /// For each name, its definition from each place on at which it changes; `None` where the block
    /// of its only definition has ended.
    changes: HashMap<Key, Vec<(Place, Option<usize>)>>,
    /// For each open block, the names that it defines, with their definitions before.
    open: Vec<Vec<(Key, Option<usize>)>>,
}

impl Bindings {
    /// The current place.
    pub(super) fn here(&self) -> Place {
        self.here
    }

    fn change(&mut self, key: Key, index: Option<usize>) {
        self.here.0 += 1;
        self.changes
            .entry(key)
            .or_default()
            .push((self.here, index));
    }

    /// Defines a name from here on.
    pub(super) fn define(&mut self, space: NameSpace, name: &str, index: usize) {
        let former = self.at(space, name, self.here);
        let key = (space, name.to_owned());
        if let Some(block) = self.open.last_mut() {
            block.push((key.clone(), former));
        }
        self.change(key, Some(index));
    }

    pub(super) fn begin_block(&mut self) {
        self.open.push(Vec::new());
    }

    /// Ends the innermost block.
    pub(super) fn end_block(&mut self) {
        for (key, former) in self.open.pop().into_iter().flatten().rev() {
            self.change(key, former);
        }
    }

    /// The definition of a name at a place.
    pub(super) fn at(&self, space: NameSpace, name: &str, place: Place) -> Option<usize> {
        let changes = self.changes.get(&(space, name.to_owned()))?;
        let before = changes.partition_point(|(from, _)| *from <= place);
        changes[..before].last()?.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_definitions_hold_until_their_block_ends() {
        let mut bindings = Bindings::default();
        let space = NameSpace::Texture(TextureType::Spectrum);
        let mut places = vec![bindings.here()];
        bindings.define(space, "t", 0);
        places.push(bindings.here());
        bindings.begin_block();
        bindings.define(space, "t", 1);
        bindings.define(space, "u", 2);
        places.push(bindings.here());
        bindings.end_block();
        places.push(bindings.here());
        let found = |name: &str| -> Vec<Option<usize>> {
            places
                .iter()
                .map(|p| bindings.at(space, name, *p))
                .collect()
        };
        assert_eq!(found("t"), [None, Some(0), Some(1), Some(0)]);
        assert_eq!(found("u"), [None, None, Some(2), None]);
        assert_eq!(bindings.at(NameSpace::Material, "t", places[1]), None);
    }
}
