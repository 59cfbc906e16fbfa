//! Glossy part of the emission: one interface to its forms, tables and mixtures of lobes. No other
//! file tells the forms apart, but for the bounds in [`intensity_bound`](super::intensity_bound).

use super::lobe_fit::{MAX_LOBES, fit_mixture};
use super::octahedral_grid::Grid;
use super::reflection::{EmissionDomain, Reflection, scattered_flux};
use super::tables::{OctahedralTable, OctahedralTables, PackedTable, TableStorage};
use super::von_mises_fisher::{VmfLobe, VmfMixture, VmfMixtures};
use crate::arrays::{FoundArray, InvalidArray, NamedArray};
use crate::color::Rgb;
use crate::lanes::{Color, Mask, Vector, Width};
use crate::math::Vec3;
use crate::sampling::rng::Pcg;

/// The form in which a light stores the radiant intensity of its glossy part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GlossyForm {
    /// Octahedral table.
    Table {
        /// Texels along an edge, even.
        side: u32,
        /// Format of a texel.
        storage: TableStorage,
    },
    /// Mixture of von Mises-Fisher lobes.
    Lobes {
        /// Number of lobes, from 1 to [`GlossyForm::MAX_LOBES`].
        count: u32,
    },
}

impl GlossyForm {
    /// Largest number of lobes of a mixture.
    pub const MAX_LOBES: u32 = MAX_LOBES as u32;

    /// Bytes of the glossy part of one light.
    pub(super) fn bytes(self) -> usize {
        match self {
            GlossyForm::Table { side, storage } => {
                OctahedralTables::bytes_per_table(side as usize, storage)
            }
            GlossyForm::Lobes { count } => VmfMixtures::bytes_per_mixture(count as usize),
        }
    }

    /// A maker of profiles of this form.
    pub(super) fn maker(self) -> ProfileMaker {
        match self {
            GlossyForm::Table { side, storage } => {
                ProfileMaker::Table(Grid::new(side as usize), storage)
            }
            GlossyForm::Lobes { count } => {
                assert!(
                    (1..=GlossyForm::MAX_LOBES).contains(&count),
                    "a mixture has 1 to 8 lobes"
                );
                ProfileMaker::Lobes(count as usize)
            }
        }
    }

    /// An empty store of profiles of this form.
    pub(super) fn store(self) -> Profiles {
        match self {
            GlossyForm::Table { side, storage } => {
                Profiles::Tables(OctahedralTables::new(side as usize, storage))
            }
            GlossyForm::Lobes { count } => Profiles::Lobes(VmfMixtures::new(count as usize)),
        }
    }
}

/// The glossy part of one light before it is stored.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    data: ProfileData,
    pub(super) domain: EmissionDomain,
    /// Flux scattered by the paths, in W: what the profile should integrate to.
    pub(super) target: Rgb,
    /// Integral of the profile over its domain, in W.
    pub(super) flux: Rgb,
}

/// Radiant intensity, in W/sr.
#[derive(Clone, Debug)]
enum ProfileData {
    Table(PackedTable),
    Lobes(Vec<VmfLobe>),
}

/// Makes profiles of one form.
#[derive(Debug)]
pub(super) enum ProfileMaker {
    Table(Grid, TableStorage),
    Lobes(usize),
}

impl ProfileMaker {
    /// The profile of `paths` on a surface with unit normal `n`, scaled so that its integral over
    /// the domain is the scattered flux. `roughness` is the smallest of the lobes.
    pub(super) fn make(
        &self,
        paths: &[Reflection],
        roughness: f32,
        n: Vec3,
        rng: &mut Pcg,
    ) -> Profile {
        let (domain, target) = scattered_flux(paths, n, rng);
        let (data, flux) = match self {
            ProfileMaker::Table(grid, storage) => {
                let (texels, flux) = grid.fill(paths, roughness, domain, target, rng);
                (ProfileData::Table(storage.pack(&texels, grid)), flux)
            }
            ProfileMaker::Lobes(count) => {
                let (lobes, flux) = fit_mixture(*count, paths, roughness, domain, target, rng);
                (ProfileData::Lobes(lobes), flux)
            }
        };
        Profile {
            data,
            domain,
            target,
            flux,
        }
    }
}

/// The profiles of all lights.
#[derive(Clone, Debug)]
pub(super) enum Profiles {
    Tables(OctahedralTables),
    Lobes(VmfMixtures),
}

impl Default for Profiles {
    fn default() -> Self {
        Profiles::Tables(OctahedralTables::default())
    }
}

impl Profiles {
    /// Reserves memory for exactly `count` more profiles.
    pub(super) fn reserve(&mut self, count: usize) {
        match self {
            Profiles::Tables(tables) => tables.reserve(count),
            Profiles::Lobes(mixtures) => mixtures.reserve(count),
        }
    }

    /// Appends a profile and returns its index.
    pub(super) fn push(&mut self, profile: &Profile) -> u32 {
        match (self, &profile.data) {
            (Profiles::Tables(tables), ProfileData::Table(table)) => tables.push(table),
            (Profiles::Lobes(mixtures), ProfileData::Lobes(lobes)) => mixtures.push(lobes),
            _ => unreachable!("invariant: profiles and their store have one form"),
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

    /// Number of profiles.
    pub(super) fn len(&self) -> usize {
        match self {
            Profiles::Tables(tables) => tables.len(),
            Profiles::Lobes(mixtures) => mixtures.len(),
        }
    }

    /// As arrays.
    pub(super) fn arrays(&self) -> Vec<NamedArray<'_>> {
        match self {
            Profiles::Tables(tables) => tables.arrays(),
            Profiles::Lobes(mixtures) => mixtures.arrays(),
        }
    }

    /// The inverse of [`Profiles::arrays`], for profiles of `form`.
    ///
    /// # Errors
    /// Those of `read`, and profiles of another form.
    pub(super) fn of_arrays<E: From<InvalidArray>>(
        form: GlossyForm,
        read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
    ) -> Result<Self, E> {
        Ok(match form {
            GlossyForm::Table { side, storage } => {
                Profiles::Tables(OctahedralTables::of_arrays((side as usize, storage), read)?)
            }
            GlossyForm::Lobes { count } => {
                Profiles::Lobes(VmfMixtures::of_arrays(count as usize, read)?)
            }
        })
    }

    pub(super) fn bytes(&self) -> usize {
        match self {
            Profiles::Tables(tables) => tables.bytes(),
            Profiles::Lobes(mixtures) => mixtures.bytes(),
        }
    }
}

/// The stored glossy part of one light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Glossy<'f> {
    Table(OctahedralTable<'f>),
    Lobes(VmfMixture<'f>),
}

impl Glossy<'_> {
    /// Radiant intensity in the unit directions `w`, in W/sr, also below the horizon; inactive
    /// lanes hold any value.
    #[inline(always)]
    pub(super) fn lookup<S: Width>(&self, w: Vector<S>, active: Mask<S>) -> Color<S> {
        match self {
            Glossy::Table(table) => table.lookup(w, active),
            Glossy::Lobes(mixture) => mixture.lookup(w),
        }
    }
}
