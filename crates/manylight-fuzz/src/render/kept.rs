//! Renders by kept virtual lights, as a damaged or forged file would have them.

#![allow(
    clippy::unwrap_used,
    reason = "a target whose own scene fails is to panic"
)]

use super::check_film;
use super::numbers::Numbers;
use crate::folder::with_file;
use arbitrary::Unstructured;
use manylight::arrays::{ArrayValues, FoundArray, InvalidArray};
use manylight::film::blocks::DEFAULT_BLOCK;
use manylight::integrators::many_light::{EmissionKind, GlossyForm, TableStorage};
use manylight::integrators::{
    ExtraLayers, KeptLights, LightsContext, ManyLight, Method, MethodKind,
};
use manylight::prelude::*;
use manylight::render::{RenderJob, Stats, make_lights, render};
use manylight::scene::{LightGroupNames, PathLimits};
use manylight_io::{LoadOptions, load_scene};
use std::collections::BTreeMap;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

/// A box with a glossy floor, a glass ball, a lamp and a sky, in two light groups.
const SCENE: &str = r#"<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="5"/></integrator>
<sensor type="perspective"><float name="fov" value="70"/>
 <transform name="to_world"><lookat origin="0,0,3.5" target="0,0,0" up="0,1,0"/></transform>
 <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="3"/><rfilter type="box"/></film></sensor>
<shape type="cube"><boolean name="flip_normals" value="true"/><transform name="to_world"><scale x="2" y="2" z="1"/></transform>
 <bsdf type="diffuse"/></shape>
<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/><translate y="-0.9"/></transform>
 <bsdf type="roughplastic"><float name="alpha" value="0.2"/></bsdf></shape>
<shape type="sphere"><point name="center" x="0.3" y="-0.4" z="0"/><float name="radius" value="0.4"/><bsdf type="dielectric"/></shape>
<shape type="rectangle" id="lamp"><transform name="to_world"><scale value="0.4"/><translate z="1.5"/></transform>
 <emitter type="area"><rgb name="radiance" value="5,4,3"/></emitter></shape>
<emitter type="constant" id="sky"><rgb name="radiance" value="0.5"/></emitter>
</scene>"#;

/// Passes that have lights: two groups of passes.
const PASSES: u32 = 12;
/// Most changes of the arrays.
const MAX_CHANGES: usize = 8;
/// The number of light groups of the methods, every other of which tells them apart.
const GROUPS: [usize; 2] = [0, 2];

/// Arrays by name, for each group of passes.
type Arrays = Vec<BTreeMap<String, FoundArray>>;

/// Changes numbers and lengths of the arrays of lights that were made before. What is accepted is
/// rendered, and every value of the film is finite; what is refused has a message.
pub(crate) fn check(input: &[u8]) {
    static LIGHTS: OnceLock<Vec<Arrays>> = OnceLock::new();
    let mut numbers = Numbers::new(Unstructured::new(input));
    let choice = numbers.below(methods().len() * GROUPS.len());
    let mut arrays = LIGHTS.get_or_init(|| (0..methods().len() * GROUPS.len()).map(made).collect())
        [choice]
        .clone();
    let changes = numbers.below(MAX_CHANGES + 1);
    for _ in 0..changes {
        change(&mut numbers, &mut arrays);
    }
    let job = job(choice);
    let MethodKind::ManyLight(method) = job.method.kind else {
        unreachable!("all methods have virtual lights")
    };
    let cx = LightsContext {
        method: method.of_frames(Some(PASSES)),
        scene: job.scene,
        limits: job.method.limits,
        passes: PASSES,
        light_groups: job.method.extra.light_groups,
    };
    let read = |group: usize, name: &str| -> Result<FoundArray, InvalidArray> {
        arrays[group]
            .get(name)
            .cloned()
            .ok_or_else(|| InvalidArray {
                name: name.to_owned(),
                message: "missing".to_owned(),
            })
    };
    match KeptLights::of_arrays(&cx, read) {
        Ok(lights) => {
            let job = RenderJob {
                lights: Some(&lights),
                ..job
            };
            let never = AtomicBool::new(false);
            check_film(
                &render(&job, &Stats::default(), &never, &mut ()).film,
                PASSES,
            );
        }
        Err(error) => {
            assert!(
                changes > 0,
                "lights as they were made are refused: {error:?}"
            );
            assert!(!error.message.is_empty(), "an error without a message");
        }
    }
}

/// The forms that lights have in files.
fn methods() -> [ManyLight; 4] {
    let rich = ManyLight::rich_vpl();
    let blocks = EmissionKind::Rich(GlossyForm::Table {
        side: 16,
        storage: TableStorage::Blocks,
    });
    [
        rich,
        ManyLight {
            emission: blocks,
            ..rich
        },
        ManyLight {
            emission: EmissionKind::LOBES,
            ..ManyLight::rich_vsl()
        },
        ManyLight::vpl(),
    ]
}

/// The render of a choice among methods and light groups.
fn job(choice: usize) -> RenderJob<'static> {
    static SCENES: OnceLock<[Scene; 2]> = OnceLock::new();
    let (method, k) = (methods()[choice / GROUPS.len()], choice % GROUPS.len());
    let scene = &SCENES.get_or_init(|| GROUPS.map(scene))[k];
    let method = ManyLight {
        light_count: 16,
        photon_paths: 300,
        importon_paths: 100,
        ..method
    };
    RenderJob {
        scene,
        method: Method {
            kind: MethodKind::ManyLight(method),
            limits: PathLimits {
                max_depth: Some(5),
                ..PathLimits::default()
            },
            extra: ExtraLayers {
                light_groups: GROUPS[k],
                ..ExtraLayers::default()
            },
        },
        budget: Budget::passes(PASSES),
        seed: 1,
        frame: None,
        lights: None,
        block: DEFAULT_BLOCK,
        guide: None,
    }
}

fn scene(groups: usize) -> Scene {
    let mut built = None;
    with_file(SCENE.as_bytes(), "scene.xml", |path| {
        let desc = load_scene(path, &LoadOptions::default()).unwrap().desc;
        let names = LightGroupNames::of(&desc);
        let mut scene = Scene::build(desc, 0).unwrap();
        if groups > 0 {
            scene.set_light_groups(&names);
            assert_eq!(scene.light_groups.count(), groups);
        }
        built = Some(scene);
    });
    built.unwrap()
}

/// The arrays of lights that are made.
fn made(choice: usize) -> Arrays {
    let (stats, never) = (Stats::default(), AtomicBool::new(false));
    let lights = make_lights(&job(choice), &stats, &never).unwrap();
    let of_group = |group: Vec<manylight::arrays::NamedArray>| {
        let arrays = group.into_iter();
        arrays
            .map(|array| (array.name.clone(), (array.shape.clone(), array.values())))
            .collect()
    };
    lights.arrays().into_iter().map(of_group).collect()
}

/// Sets a value of an array, or shortens it by a row.
fn change(numbers: &mut Numbers, arrays: &mut Arrays) {
    let group = numbers.below(arrays.len());
    let which = numbers.below(arrays[group].len());
    let Some((shape, values)) = arrays[group].values_mut().nth(which) else {
        return;
    };
    if values.count() == 0 {
        return;
    }
    if numbers.rarely(8) {
        let row = values.count() / shape[0];
        shape[0] -= 1;
        match values {
            ArrayValues::F64(values) => values.truncate(values.len() - row),
            ArrayValues::F32(values) => values.truncate(values.len() - row),
            ArrayValues::U32(values) => values.truncate(values.len() - row),
        }
        return;
    }
    let at = (numbers.below(256) * 256 + numbers.below(256)) % values.count();
    match values {
        ArrayValues::F64(values) => values[at] = f64::from(numbers.float(-2.0, 2.0)),
        ArrayValues::F32(values) => values[at] = numbers.float(-2.0, 2.0),
        ArrayValues::U32(values) => {
            let byte = u32::from(numbers.byte());
            values[at] = numbers.choose(&[byte, values[at] ^ byte, byte << 24, u32::MAX - byte]);
        }
    }
}
