//! Virtual lights as arrays, and back: what files keep of a set.
//!
//! A light keeps the reference of its surface instead of its scattering function, which is evaluated
//! again.

use super::areas::LightAreas;
use super::depth_limits::DepthFractions;
use super::glossy::{GlossyForm, Profiles};
use super::light::{Emission, VirtualLight};
use super::moments::POINTS;
use super::reflection::Reflection;
use super::set::{ProfileFlux, VirtualLights};
use crate::arrays::{
    Fields, FoundArray, InvalidArray, NamedArray, Record, arrays_of_records, read_floats,
    records_of_arrays,
};
use crate::color::Rgb;
use crate::geometry::SurfaceRef;
use crate::ids::LightGroup;
use crate::math::Vec3;
use crate::scene::Scene;

/// Begin of the names of the arrays with a row for each light.
const PREFIX: &str = "lights.";
/// Name of the array with [`LightAreas::unassigned_surface`].
const UNASSIGNED_SURFACE: &str = "lights.unassigned_surface";
/// [`KeptLight::profile`] of a light without a glossy profile.
const NO_PROFILE: u32 = u32::MAX;

/// A light as it is kept.
#[derive(Clone, Copy, Debug)]
struct KeptLight {
    p: Vec3,
    points: [Vec3; POINTS],
    n: Vec3,
    ns: Vec3,
    radius: f32,
    area: f32,
    offset: f32,
    flux: Rgb,
    group: LightGroup,
    one_sided: bool,
    at: SurfaceRef,
    /// Whether the emission is the reflection of one light path: [`Emission::Single`].
    is_single: bool,
    /// Of that path: unit direction of incidence.
    wi: Vec3,
    /// Of other lights: [`Emission::Rich`].
    diffuse: Rgb,
    profile: u32,
}

impl Record for KeptLight {
    const EMPTY: Self = KeptLight {
        p: Vec3::ZERO,
        points: [Vec3::ZERO; POINTS],
        n: Vec3::ZERO,
        ns: Vec3::ZERO,
        radius: 0.0,
        area: 0.0,
        offset: 0.0,
        flux: Rgb::BLACK,
        group: LightGroup(0),
        one_sided: true,
        at: SurfaceRef::FIRST,
        is_single: false,
        wi: Vec3::ZERO,
        diffuse: Rgb::BLACK,
        profile: NO_PROFILE,
    };

    fn fields(&mut self, f: &mut impl Fields) {
        f.vec3("p", &mut self.p);
        f.floats("points", bytemuck::cast_slice_mut(&mut self.points));
        f.vec3("n", &mut self.n);
        f.vec3("ns", &mut self.ns);
        f.float("radius", &mut self.radius);
        f.extended("area", &mut self.area);
        f.float("offset", &mut self.offset);
        f.rgb("flux", &mut self.flux);
        f.word("group", &mut self.group.0);
        f.flag("one_sided", &mut self.one_sided);
        self.at.fields(f);
        f.flag("single", &mut self.is_single);
        f.vec3("wi", &mut self.wi);
        f.rgb("diffuse", &mut self.diffuse);
        f.word("profile", &mut self.profile);
    }
}

impl KeptLight {
    fn of(set: &VirtualLights, k: usize) -> Self {
        let light = &set.lights[k];
        let kept = KeptLight {
            p: light.p,
            points: light.points,
            n: light.n,
            ns: light.ns,
            radius: light.radius,
            area: light.area,
            offset: light.offset,
            flux: light.flux,
            group: light.group,
            one_sided: light.one_sided,
            at: set.surfaces[k],
            ..KeptLight::EMPTY
        };
        match light.emission {
            Emission::Single(index) => KeptLight {
                is_single: true,
                wi: set.reflection(index).wi,
                ..kept
            },
            Emission::Rich {
                diffuse, glossy, ..
            } => KeptLight {
                diffuse,
                profile: glossy.unwrap_or(NO_PROFILE),
                ..kept
            },
        }
    }

    /// The light in `scene`. The reflection of a single path is appended to `reflections`.
    fn restored<'s>(
        &self,
        scene: &'s Scene,
        reflections: &mut Vec<Reflection<'s>>,
    ) -> VirtualLight<'s> {
        let bsdf = scene.bsdf(&scene.surface_point(self.at));
        let emission = if self.is_single {
            reflections.push(Reflection {
                wi: self.wi,
                flux: self.flux,
                bsdf,
            });
            Emission::Single((reflections.len() - 1) as u32)
        } else {
            Emission::Rich {
                diffuse: self.diffuse,
                exit: bsdf.exit_transmittance(),
                glossy: (self.profile != NO_PROFILE).then_some(self.profile),
            }
        };
        VirtualLight {
            p: self.p,
            points: self.points,
            n: self.n,
            ns: self.ns,
            radius: self.radius,
            radius_of_all: self.radius,
            area: self.area,
            offset: self.offset,
            flux: self.flux,
            group: self.group,
            one_sided: self.one_sided,
            emission,
        }
    }
}

/// The lights as arrays.
pub(crate) fn arrays_of_lights<'a>(set: &'a VirtualLights) -> Vec<NamedArray<'a>> {
    let kept: Vec<KeptLight> = (0..set.lights.len())
        .map(|k| KeptLight::of(set, k))
        .collect();
    let mut arrays = arrays_of_records(PREFIX, kept);
    arrays.extend(set.profiles.arrays());
    arrays.push(set.depths.array());
    let surface = set.areas.unassigned_surface();
    arrays.push(NamedArray::floats(UNASSIGNED_SURFACE, [1], move || {
        [surface]
    }));
    arrays
}

/// The inverse of [`arrays_of_lights`], for lights of `form` and `groups` light groups.
///
/// # Errors
/// Those of `read`, and lights that do not belong to the scene.
pub(crate) fn lights_of_arrays<'s, E: From<InvalidArray>>(
    scene: &'s Scene,
    (form, groups): (Option<GlossyForm>, usize),
    read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
) -> Result<VirtualLights<'s>, E> {
    let kept: Vec<KeptLight> = records_of_arrays(PREFIX, read)?;
    let profiles = match form {
        Some(form) => Profiles::of_arrays(form, read)?,
        None => Profiles::default(),
    };
    let refuse = |field: &str, k: usize| {
        let message = format!("row {k} names what is not there");
        InvalidArray::new(format!("{PREFIX}{field}"), message)
    };
    for (k, light) in kept.iter().enumerate() {
        let has_profile = light.profile == NO_PROFILE || (light.profile as usize) < profiles.len();
        let fault = match () {
            () if !scene.geometry.has_surface(&light.at) => "primitive",
            () if light.group.index() >= groups.max(1) => "group",
            () if !has_profile => "profile",
            () => continue,
        };
        return Err(refuse(fault, k).into());
    }
    let depths = DepthFractions::of_array(kept.len(), read)?;
    let [unassigned_surface] = read_floats(UNASSIGNED_SURFACE, 1, read)?[..] else {
        return Err(InvalidArray::new(UNASSIGNED_SURFACE, "expected one number").into());
    };
    let positions = kept.iter().map(|light| light.p).collect();
    let mut reflections = Vec::new();
    let lights = kept
        .iter()
        .map(|light| light.restored(scene, &mut reflections));
    Ok(VirtualLights {
        lights: lights.collect(),
        reflections,
        profiles,
        depths,
        areas: LightAreas::new(positions, unassigned_surface),
        surfaces: kept.iter().map(|light| light.at).collect(),
        profile_flux: ProfileFlux::default(),
    })
}
