//! Voronoi cells of the sites: the nearest light to a location, on the same surface.
//!
//! This is the rule by which [`assign`](super::assign::assign) gives photons to lights. It depends
//! on the location alone, so bias compensation can evaluate it for any surface point after the
//! lights are built.

use super::select::Site;
use super::surfaces::{SurfaceLocation, Surfaces};
use crate::arrays::{
    FoundArray, InvalidArray, NamedArray, arrays_of_records, read_floats, read_words,
    records_of_arrays,
};
use crate::ids::LightId;
use crate::maps::{KdTree, Neighbors, Patch};
use crate::math::Vec3;
use crate::particles::Photon;
use rayon::prelude::*;

/// Number of neighbors that define the spacing of a site; the site itself is one of them, so that
/// it is the distance to the 8th other.
const SPACING_NEIGHBORS: usize = 9;
/// Largest distance from a location to its site, in spacings. If this many spacings hold no site of
/// the location's surface, that surface is considered to have none. Larger values leave fewer
/// photons unassigned and move flux farther. At 1.5 and 6 (2 passes of 128 lights at 72x40, 3
/// seeds; Kitchen, Glossy Room): relMSE +11 and +0.9 % (standard error 5 %), shadow rays -11 and +3
/// %.
const MAX_SPACINGS: f32 = 3.0;
/// Distance to the site, in spacings, above which a visibility test is made. The spacing reaches to
/// the 8th neighbor: of photons around sites at random on a plane, `exp(-8 s²)` are tested, 14 %;
/// 61 % at 0.25, none at 1.
const VISIBILITY_TEST_SPACINGS: f32 = 0.5;
/// Index of no site and of no light.
pub(super) const UNASSIGNED: u32 = u32::MAX;

/// The nearest light to each location: Voronoi cells of the sites, restricted to their surfaces.
#[derive(Clone, Debug)]
pub struct NearestLights {
    patches: Vec<Patch>,
    tree: KdTree<Vec3>,
    /// Distance of each site to its 8th neighbor, in m.
    spacings: Vec<f32>,
    /// For each site the index of its light, or [`UNASSIGNED`].
    lights: Vec<u32>,
}

impl NearestLights {
    /// The cells of `sites`, without lights yet; see [`NearestLights::set_lights`].
    pub(super) fn new(surfaces: &impl Surfaces, photons: &[Photon], sites: &[Site]) -> Self {
        let patches: Vec<Patch> = sites
            .par_iter()
            .map(|site| surfaces.patch(&photons[site.photon as usize]))
            .collect();
        let tree = KdTree::build(patches.iter().map(|patch| patch.p).collect::<Vec<Vec3>>());
        let spacings: Vec<f32> = patches
            .par_iter()
            .map_init(
                || Neighbors::new(SPACING_NEIGHBORS),
                |found, patch| {
                    tree.nearest(patch.p, f32::INFINITY, found);
                    found.radius_squared().sqrt()
                },
            )
            .collect();
        NearestLights {
            patches,
            tree,
            spacings,
            lights: vec![UNASSIGNED; sites.len()],
        }
    }

    /// As arrays, whose names begin with `prefix`.
    pub(super) fn arrays<'a>(&'a self, prefix: &str) -> Vec<NamedArray<'a>> {
        let mut arrays = arrays_of_records(prefix, &self.patches[..]);
        let spacings = || self.spacings.iter().copied();
        arrays.push(NamedArray::floats(
            format!("{prefix}spacing"),
            [self.spacings.len()],
            spacings,
        ));
        let lights = || self.lights.iter().copied();
        arrays.push(NamedArray::words(
            format!("{prefix}light"),
            [self.lights.len()],
            lights,
        ));
        arrays
    }

    /// The inverse of [`NearestLights::arrays`], of `count` lights.
    ///
    /// # Errors
    /// Those of `read`, and arrays of other lights.
    pub(super) fn of_arrays<E: From<InvalidArray>>(
        prefix: &str,
        count: usize,
        read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
    ) -> Result<Self, E> {
        let patches: Vec<Patch> = records_of_arrays(prefix, read)?;
        let spacings = read_floats(&format!("{prefix}spacing"), 1, read)?;
        let name = format!("{prefix}light");
        let lights = read_words(&name, 1, read)?;
        let is_light = |&light: &u32| light == UNASSIGNED || (light as usize) < count;
        let sites = patches.len();
        if spacings.len() != sites || lights.len() != sites || !lights.iter().all(is_light) {
            let message = format!("expected {sites} indices of {count} lights");
            return Err(InvalidArray::new(name, message).into());
        }
        Ok(NearestLights {
            tree: KdTree::build(patches.iter().map(|patch| patch.p).collect()),
            patches,
            spacings,
            lights,
        })
    }

    /// No cells: every location is unassigned.
    pub fn empty() -> Self {
        NearestLights {
            patches: Vec::new(),
            tree: KdTree::build(Vec::new()),
            spacings: Vec::new(),
            lights: Vec::new(),
        }
    }

    /// Sets the index of the light made of each site; [`UNASSIGNED`] for sites without photons.
    pub(super) fn set_lights(&mut self, lights: Vec<u32>) {
        self.lights = lights;
    }

    /// Counts the lights on from `first`.
    pub(super) fn move_lights(&mut self, first: u32) {
        let assigned = self.lights.iter_mut().filter(|light| **light != UNASSIGNED);
        assigned.for_each(|light| *light += first);
    }

    /// The light to which a photon at `location` is assigned; `None` if it is unassigned.
    pub fn light(&self, surfaces: &impl Surfaces, location: &SurfaceLocation) -> Option<LightId> {
        let light = *self.lights.get(self.site(surfaces, location) as usize)?;
        (light != UNASSIGNED).then_some(LightId(light))
    }

    /// The site to which a photon at `location` is assigned, or [`UNASSIGNED`].
    ///
    /// It is the nearest compatible site in the metric of [`Patch::distance_squared`], within
    /// [`MAX_SPACINGS`]; beyond [`VISIBILITY_TEST_SPACINGS`] the nearest visible one.
    pub(super) fn site(&self, surfaces: &impl Surfaces, location: &SurfaceLocation) -> u32 {
        let cost = |k: u32| {
            self.patches[k as usize].distance_squared(location.p, location.n, location.material)
        };
        let mut reach = 0.0;
        let reach_of = |any: u32, d2: f32| {
            // If the nearest site of any surface is at distance d and its 8th neighbor at s, the
            // location's 8th neighbor is no farther than d + s.
            reach = (MAX_SPACINGS * (d2.sqrt() + self.spacings[any as usize])).powi(2);
            reach
        };
        let Some((k, d2)) = self.tree.cheapest_around(location.p, reach_of, cost) else {
            return UNASSIGNED;
        };
        let is_visible = |k: u32| surfaces.connected(location, &self.patches[k as usize]);
        if d2 <= (VISIBILITY_TEST_SPACINGS * self.spacings[k as usize]).powi(2) || is_visible(k) {
            return k;
        }
        self.tree
            .cheapest(location.p, reach, |k, _| cost(k).filter(|_| is_visible(k)))
            .map_or(UNASSIGNED, |(k, _)| k)
    }
}
