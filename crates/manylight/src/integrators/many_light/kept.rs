//! Virtual lights that are kept beyond a render, as arrays for files: with them a picture of another
//! camera is shaded without photons.
//!
//! What the passes of a group shade with is kept as it is; trees and scattering functions are made
//! again. The same camera and seed give the same bits as the render that made the lights.

use super::compensation_photons::CompensationPhoton;
use super::lights::gather;
use super::passes::PreparedPasses;
use super::radiance_cache::{arrays_of_cache, cache_of_arrays};
use super::schedule::{LightSubsets, MAX_GROUP_PHOTON_PATHS};
use super::settings::are_camera_paths;
use super::{Effort, MAX_CAMERA_PATHS, ManyLight, PassGroup};
use crate::arrays::{
    FoundArray, InvalidArray, NamedArray, arrays_of_records, read_floats, read_words,
    records_of_arrays,
};
use crate::emitters::RayDensities;
use crate::gather::{Assignment, LightIndex, Strategy};
use crate::integrators::context::PassContext;
use crate::maps::{Incident, IncidentMap, KdTree};
use crate::particles::Photon;
use crate::scene::{PathLimits, Scene};
use crate::virtual_lights::kept::{arrays_of_lights, lights_of_arrays};
use crate::virtual_lights::light_groups::NearestLightsOfGroups;
use std::fmt;

/// Name of the array with the passes of a group.
const PASSES: &str = "passes";
/// Name of the array with the division of the lights among passes and pixels.
const SUBSETS: &str = "subsets";
/// Names of the arrays with the effort of a pass.
const EFFORT: [&str; 2] = ["effort", "roulette"];
/// Begin of the names of arrays of photons that arrive straight from the environment.
const INCIDENT: &str = "incident.";
/// Begin of the names of arrays of photons with a specular last event.
const CAUSTICS: &str = "caustics.";
/// Begin of the names of arrays of photons that compensate clamping.
const COMPENSATION: &str = "compensation.";

/// Most emitter samples that a file may ask for: far beyond those of any effort.
const MAX_EMITTER_SAMPLES: u32 = 1 << 10;

/// The virtual lights of all passes of a render, with everything else that the passes shade with.
#[derive(Debug)]
pub struct KeptLights<'s> {
    method: ManyLight,
    groups: Vec<PreparedPasses<'s>>,
}

/// The method and the scene of kept lights.
#[derive(Clone, Copy, Debug)]
pub struct LightsContext<'s> {
    /// As it was asked for, [`ManyLight::first_passes`] included.
    pub method: ManyLight,
    /// The scene.
    pub scene: &'s Scene,
    /// Limits of path length.
    pub limits: PathLimits,
    /// Number of passes.
    pub passes: u32,
    /// Number of light groups; 0 if they are not told apart.
    pub light_groups: usize,
}

/// Why lights cannot be kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotKept;

impl fmt::Display for NotKept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the lights of cuts have a tree, which is not kept")
    }
}

impl std::error::Error for NotKept {}

impl<'s> KeptLights<'s> {
    /// Whether the lights of `method` can be kept.
    ///
    /// # Errors
    /// They are evaluated by cuts.
    pub fn check(method: &ManyLight) -> Result<(), NotKept> {
        match method.strategy {
            Strategy::All => Ok(()),
            Strategy::Cuts(_) | Strategy::Bidirectional(_) => Err(NotKept),
        }
    }

    /// Makes the lights of all passes. The method has a fixed effort; `run` is the context of any
    /// pass. `None` if cancelled.
    pub(in crate::integrators) fn make(cx: &LightsContext<'s>, run: &PassContext) -> Option<Self> {
        let groups = cx.method.pass_groups(cx.passes);
        let prepared = groups.map(|group| {
            (!run.cancelled()).then(|| cx.method.prepare(cx.scene, cx.limits, &group, run))
        });
        Some(KeptLights {
            method: cx.method,
            groups: prepared.collect::<Option<_>>()?,
        })
    }

    /// The method with its effort as it was found when the lights were made.
    pub fn method(&self) -> &ManyLight {
        &self.method
    }

    /// Number of passes that have lights.
    pub fn passes(&self) -> u32 {
        self.groups.last().map_or(0, |last| last.group.passes.end)
    }

    /// Number of virtual lights.
    pub fn light_count(&self) -> usize {
        self.groups
            .iter()
            .map(|group| group.lights.set.lights().len())
            .sum()
    }

    /// Bytes of the virtual lights, tables included.
    pub fn light_bytes(&self) -> usize {
        self.groups
            .iter()
            .map(|group| group.lights.set.bytes())
            .sum()
    }

    /// What the passes of each group shade with.
    pub fn groups(&self) -> &[PreparedPasses<'s>] {
        &self.groups
    }

    /// The arrays of each group of passes.
    pub fn arrays(&self) -> Vec<Vec<NamedArray<'_>>> {
        self.groups
            .iter()
            .map(|group| arrays_of_passes(&self.method, group))
            .collect()
    }

    /// The inverse of [`KeptLights::arrays`]: `read` gives an array of a group of passes by its
    /// name. The effort of `cx.method` is ignored.
    ///
    /// # Errors
    /// Those of `read`, and arrays that do not belong to the method or the scene.
    pub fn of_arrays<E: From<InvalidArray>>(
        cx: &LightsContext<'s>,
        mut read: impl FnMut(usize, &str) -> Result<FoundArray, E>,
    ) -> Result<Self, E> {
        let method = with_effort(&cx.method, &mut |name: &str| read(0, name))?;
        let cx = LightsContext { method, ..*cx };
        let groups = method.pass_groups(cx.passes).enumerate();
        let prepared =
            groups.map(|(k, group)| passes_of_arrays(&cx, group, &mut |name: &str| read(k, name)));
        let groups: Result<Vec<PreparedPasses>, E> = prepared.collect();
        Ok(KeptLights {
            method,
            groups: groups?,
        })
    }
}

/// `method` with the effort that arrays state.
fn with_effort<E: From<InvalidArray>>(
    method: &ManyLight,
    read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
) -> Result<ManyLight, E> {
    let words = read_words(EFFORT[0], 1, read)?;
    let [light_count, photon_paths, emitter_samples, camera_paths] = words[..] else {
        let message = format!("found {} numbers, expected 4", words.len());
        return Err(InvalidArray::new(EFFORT[0], message).into());
    };
    let most = [
        (light_count, method.light_count),
        (
            photon_paths,
            method.photon_paths.max(MAX_GROUP_PHOTON_PATHS),
        ),
        (emitter_samples, MAX_EMITTER_SAMPLES),
    ];
    if let Some((found, most)) = most
        .into_iter()
        .find(|&(found, most)| found == 0 || found > most)
    {
        let message = format!("found {found}, expected 1 to {most}");
        return Err(InvalidArray::new(EFFORT[0], message).into());
    }
    if !are_camera_paths(camera_paths) {
        let message = format!(
            "found {camera_paths} camera paths, expected a power of two up to {MAX_CAMERA_PATHS}"
        );
        return Err(InvalidArray::new(EFFORT[0], message).into());
    }
    let [roulette] = read_floats(EFFORT[1], 1, read)?[..] else {
        return Err(InvalidArray::new(EFFORT[1], "expected one number").into());
    };
    Ok(ManyLight {
        light_count,
        photon_paths,
        emitter_samples,
        camera_paths,
        roulette,
        effort: Effort::Fixed,
        ..*method
    })
}

fn arrays_of_passes<'a>(method: &ManyLight, prepared: &'a PreparedPasses) -> Vec<NamedArray<'a>> {
    let PassGroup { passes, .. } = &prepared.group;
    let passes = [passes.start, passes.end];
    let effort = [
        method.light_count,
        method.photon_paths,
        method.emitter_samples,
        method.camera_paths,
    ];
    let (subsets, roulette) = (prepared.subsets.numbers(), method.roulette);
    let mut arrays = vec![
        NamedArray::words(PASSES, [2], move || passes),
        NamedArray::words(EFFORT[0], [4], move || effort),
        NamedArray::floats(EFFORT[1], [1], move || [roulette]),
        NamedArray::words(SUBSETS, [3], move || subsets),
    ];
    arrays.extend(arrays_of_lights(&prepared.lights.set));
    arrays.extend(prepared.nearest.arrays());
    arrays.extend(arrays_of_records(INCIDENT, prepared.incident.photons()));
    arrays.extend(arrays_of_records(CAUSTICS, prepared.caustics.items()));
    arrays.push(prepared.ray_densities.array());
    arrays.extend(arrays_of_cache(&prepared.cache));
    arrays.extend(arrays_of_records(
        COMPENSATION,
        prepared.compensation_photons.items(),
    ));
    arrays
}

fn passes_of_arrays<'s, E: From<InvalidArray>>(
    cx: &LightsContext<'s>,
    group: PassGroup,
    read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
) -> Result<PreparedPasses<'s>, E> {
    let LightsContext {
        method,
        scene,
        limits,
        light_groups,
        ..
    } = *cx;
    let passes = read_words(PASSES, 1, read)?;
    if passes != [group.passes.start, group.passes.end] {
        let message = format!("found {passes:?}, expected {:?}", group.passes);
        return Err(InvalidArray::new(PASSES, message).into());
    }
    let numbers = read_words(SUBSETS, 1, read)?;
    let subsets = LightSubsets::of_numbers(&method, &group, &numbers)
        .ok_or_else(|| InvalidArray::new(SUBSETS, format!("found {numbers:?}")))?;
    let form = method.emission.glossy_form();
    let lights = lights_of_arrays(scene, (form, light_groups), read)?;
    let count = lights.lights().len();
    let nearest = NearestLightsOfGroups::of_arrays(light_groups.max(1), count, read)?;
    let incident: Vec<Incident> = records_of_arrays(INCIDENT, read)?;
    let caustics: Vec<Photon> = records_of_arrays(CAUSTICS, read)?;
    let compensation: Vec<CompensationPhoton> = records_of_arrays(COMPENSATION, read)?;
    let compensating = || compensation.iter().map(|photon| &photon.reflected.photon);
    for (name, is_sound) in [
        (CAUSTICS, are_sound(scene, light_groups, caustics.iter())),
        (COMPENSATION, are_sound(scene, light_groups, compensating())),
        (
            COMPENSATION,
            compensation
                .iter()
                .all(|photon| has_light(&photon.assignment, count)),
        ),
    ] {
        if !is_sound {
            let message = "a photon names a surface, group or light that is not there";
            return Err(InvalidArray::new(name, message).into());
        }
    }
    let cache = cache_of_arrays(&group, limits, (light_groups, count), read)?;
    Ok(PreparedPasses {
        scene,
        limits,
        light_groups,
        compensation: method.compensation,
        emitter_samples: method.emitter_samples,
        camera_paths: method.started_paths(),
        gather: gather(&method, &group, &lights, &subsets),
        lights: LightIndex::new(lights).of_groups(light_groups),
        subsets,
        tolerance: 0.0,
        nearest,
        incident: IncidentMap::of_photons(incident),
        caustics: KdTree::of_ordered(caustics),
        ray_densities: RayDensities::of_array(&scene.emitters, read)?,
        cache,
        compensation_photons: KdTree::of_ordered(compensation),
        group,
    })
}

/// Whether the surfaces and light groups of photons are those of the scene.
fn are_sound<'p>(
    scene: &Scene,
    light_groups: usize,
    mut photons: impl Iterator<Item = &'p Photon>,
) -> bool {
    photons.all(|photon| {
        scene.geometry.has_surface(&photon.at) && photon.group.index() < light_groups.max(1)
    })
}

/// Whether a photon is assigned to one of `count` lights, or to none.
fn has_light(assignment: &Assignment, count: usize) -> bool {
    match assignment {
        Assignment::Light(light) => light.index() < count,
        Assignment::Unassigned { .. } => true,
    }
}
