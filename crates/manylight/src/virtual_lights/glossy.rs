//! The glossy part of lights: every form that it can be kept in, told apart here alone.

use super::lobe_fit::{MAX_LOBES, mixture};
use super::octahedral_grid::Grid;
use super::sources::{Range, Source, reflected};
use super::tables::{PackedTable, Table, TableStorage, Tables};
use super::von_mises_fisher::{Lobe, Mixture, Mixtures};
use crate::color::Rgb;
use crate::lanes::{LaneMask, Lanes3};
use crate::math::Vec3;
use crate::sampling::rng::Pcg;
use crate::simd::Wide;

/// In what form a light keeps the radiant intensity of its glossy part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GlossyForm {
    /// Octahedral table.
    Table {
        /// Texels along an edge, even.
        side: u32,
        /// What a texel is.
        storage: TableStorage,
    },
    /// Mixture of von Mises-Fisher lobes.
    Lobes {
        /// How many, from 1 to [`GlossyForm::MAX_LOBES`].
        count: u32,
    },
}

impl GlossyForm {
    /// Most lobes of a mixture.
    pub const MAX_LOBES: u32 = MAX_LOBES as u32;

    /// Bytes of the glossy part of one light.
    pub(super) fn bytes(self) -> usize {
        match self {
            GlossyForm::Table { side, storage } => Tables::bytes_per_table(side as usize, storage),
            GlossyForm::Lobes { count } => Mixtures::bytes_per_mixture(count as usize),
        }
    }

    /// What makes profiles of this form.
    pub(super) fn maker(self) -> ProfileMaker {
        match self {
            GlossyForm::Table { side, storage } => {
                ProfileMaker::Table(Grid::new(side as usize), storage)
            }
            GlossyForm::Lobes { count } => {
                assert!(
                    (1..=GlossyForm::MAX_LOBES).contains(&count),
                    "a mixture has some lobes"
                );
                ProfileMaker::Lobes(count as usize)
            }
        }
    }

    /// No profiles of this form yet.
    pub(super) fn store(self) -> Profiles {
        match self {
            GlossyForm::Table { side, storage } => {
                Profiles::Tables(Tables::new(side as usize, storage))
            }
            GlossyForm::Lobes { count } => Profiles::Lobes(Mixtures::new(count as usize)),
        }
    }
}

/// The glossy part of a light on its way into the field.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    shape: Shape,
    pub(super) range: Range,
    /// Flux that it should hold, in W.
    pub(super) target: Rgb,
    /// Flux that it holds.
    pub(super) flux: Rgb,
}

/// Radiant intensity, in W/sr.
#[derive(Clone, Debug)]
enum Shape {
    Table(PackedTable),
    Lobes(Vec<Lobe>),
}

/// Makes profiles.
#[derive(Debug)]
pub(super) enum ProfileMaker {
    Table(Grid, TableStorage),
    Lobes(usize),
}

impl ProfileMaker {
    /// The profile of `sources`, whose narrowest lobe has roughness `width`, on a surface with normal `n`: the integral of what is
    /// looked up above its horizon is the flux that they reflect.
    pub(super) fn make(&self, sources: &[Source], width: f32, n: Vec3, rng: &mut Pcg) -> Profile {
        let (range, target) = reflected(sources, n, rng);
        let (shape, flux) = match self {
            ProfileMaker::Table(grid, storage) => {
                let (texels, flux) = grid.fill(sources, width, range, target, rng);
                (Shape::Table(storage.pack(&texels, grid)), flux)
            }
            ProfileMaker::Lobes(count) => {
                let (lobes, flux) = mixture(*count, sources, width, range, target, rng);
                (Shape::Lobes(lobes), flux)
            }
        };
        Profile {
            shape,
            range,
            target,
            flux,
        }
    }
}

/// The profiles of all lights.
#[derive(Clone, Debug)]
pub(super) enum Profiles {
    Tables(Tables),
    Lobes(Mixtures),
}

impl Default for Profiles {
    fn default() -> Self {
        Profiles::Tables(Tables::default())
    }
}

impl Profiles {
    /// Makes room for exactly so many profiles.
    pub(super) fn reserve(&mut self, count: usize) {
        match self {
            Profiles::Tables(tables) => tables.reserve(count),
            Profiles::Lobes(mixtures) => mixtures.reserve(count),
        }
    }

    /// Appends a profile and returns its index.
    pub(super) fn push(&mut self, profile: &Profile) -> u32 {
        match (self, &profile.shape) {
            (Profiles::Tables(tables), Shape::Table(table)) => tables.push(table),
            (Profiles::Lobes(mixtures), Shape::Lobes(lobes)) => mixtures.push(lobes),
            _ => unreachable!("invariant: one form makes the profiles and their store"),
        }
    }

    /// The profile with the given index.
    #[inline(always)]
    pub(super) fn get(&self, index: u32) -> Glossy<'_> {
        match self {
            Profiles::Tables(tables) => Glossy::Table(tables.get(index)),
            Profiles::Lobes(mixtures) => Glossy::Lobes(mixtures.get(index)),
        }
    }

    pub(super) fn bytes(&self) -> usize {
        match self {
            Profiles::Tables(tables) => tables.bytes(),
            Profiles::Lobes(mixtures) => mixtures.bytes(),
        }
    }
}

/// The glossy part of one light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Glossy<'f> {
    Table(Table<'f>),
    Lobes(Mixture<'f>),
}

impl Glossy<'_> {
    /// Radiant intensity towards the unit vector `w`, horizon not counted, in W/sr.
    pub(super) fn lookup(&self, w: Vec3) -> Rgb {
        match self {
            Glossy::Table(table) => table.lookup(w),
            Glossy::Lobes(mixture) => mixture.lookup(w),
        }
    }

    /// The same in the directions opposite to `wi`; of lanes that are not active, anything.
    #[inline(always)]
    pub(super) fn lookups<W: Wide>(&self, w: W, wi: &Lanes3, active: LaneMask) -> Lanes3 {
        match self {
            Glossy::Table(table) => table.lookups(w, wi, active),
            Glossy::Lobes(mixture) => mixture.lookups(w, wi),
        }
    }
}
