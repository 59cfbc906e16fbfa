//! Parts of a render, made apart, have the bits of the whole.

use crate::common::{methods, methods_with_cuts};
use manylight::arrays::{ArrayValues, InvalidArray};
use manylight::emitters::EmissionGuide;
use manylight::film::arrays::{arrays_of_sums, sums_of_arrays};
use manylight::film::blocks::{BLOCK_STEP, block_count};
use manylight::film::{Film, IdLayer, PassSums};
use manylight::integrators::{ExtraLayers, Method, MethodKind, PassContext, Renderer};
use manylight::render::{Budget, Observer, RenderJob, Stats, Stop, render, render_blocks, resume};
use manylight::sampling::Pass;
use manylight::scene::Scene;
use manylight::testing::scenes::grouped_box;
use std::collections::HashMap;
use std::num::NonZeroU32;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

static NEVER: AtomicBool = AtomicBool::new(false);
/// Two whole blocks and a part of a third.
const PASSES: u32 = 2 * BLOCK_STEP + 3;

fn job(scene: &Scene, kind: MethodKind) -> RenderJob<'_> {
    let has_camera_paths = kind != MethodKind::LightTracer;
    let extra = ExtraLayers {
        position: has_camera_paths,
        objects: has_camera_paths,
        materials: has_camera_paths,
        light_groups: match kind {
            MethodKind::Aov => 0,
            _ => scene.light_groups.count(),
        },
        ..ExtraLayers::default()
    };
    RenderJob {
        scene,
        method: Method {
            kind,
            limits: scene.limits,
            extra,
        },
        budget: Budget::passes(PASSES),
        seed: 3,
        frame: None,
        lights: None,
        block: NonZeroU32::new(BLOCK_STEP).unwrap(),
        guide: None,
    }
}

fn whole(job: &RenderJob) -> Film {
    render(job, &Stats::default(), &NEVER, &mut ()).film
}

/// Asserts that two films hold the same sums, and give the same images.
fn assert_same(a: &Film, b: &Film, context: &str) {
    assert_eq!(a.passes(), b.passes(), "{context}");
    assert!(
        a.completed() == b.completed() && a.current() == b.current(),
        "{context}: other sums"
    );
    for &layer in a.layers() {
        assert!(a.image(layer) == b.image(layer), "{context}: {layer:?}");
        assert!(
            a.layer_variance(layer) == b.layer_variance(layer),
            "{context}: variance of {layer:?}"
        );
    }
    for layer in [IdLayer::Object, IdLayer::Material] {
        assert!(
            a.ranked_ids(layer) == b.ranked_ids(layer),
            "{context}: {layer:?}"
        );
    }
    assert!(
        a.block_variance() == b.block_variance(),
        "{context}: variance of blocks"
    );
    assert_eq!(a.mean_variance(), b.mean_variance(), "{context}");
}

/// A pass does not depend on the passes that were rendered before it.
#[test]
fn a_pass_alone_is_what_it_is_in_a_run() {
    let scene = grouped_box(16, None).build();
    for kind in methods().into_iter().chain(methods_with_cuts()) {
        let job = job(&scene, kind.clone());
        let guide = if job.method.emits_photons() {
            scene.infinite_light_guide()
        } else {
            EmissionGuide::default()
        };
        let stats = Stats::default();
        let pass = |renderer: &mut Renderer, index: u32| {
            let mut film = job.film(0);
            let pass = Pass {
                seed: job.seed,
                index,
            };
            let run = PassContext {
                light_groups: film.light_groups(),
                ..PassContext::of_picture(&scene, pass, &guide, &stats, &NEVER)
            };
            assert!(renderer.render_pass(&run, &mut film));
            film
        };
        let mut run = Renderer::new(&scene, job.method.clone(), 1);
        for index in 0..PASSES {
            let in_run = pass(&mut run, index);
            if [1, 3, 6, 13, PASSES - 1].contains(&index) {
                let alone = pass(&mut Renderer::new(&scene, job.method.clone(), 1), index);
                assert_same(&alone, &in_run, &format!("{kind:?}, pass {index}"));
            }
        }
    }
}

#[test]
fn blocks_made_apart_merge_to_the_whole() {
    let scene = grouped_box(8, None).build();
    for kind in methods().into_iter().chain(methods_with_cuts()) {
        let job = job(&scene, kind.clone());
        let count = block_count(PASSES, job.block);
        assert_eq!(count, 3);
        let block =
            |k: u32| render_blocks(&job, k..k + 1, &Stats::default(), &NEVER, &mut ()).unwrap();
        // Made in another order than they are merged.
        let mut blocks: Vec<PassSums> = (0..count).rev().flat_map(block).collect();
        blocks.reverse();
        let mut merged = job.film(0);
        blocks.into_iter().for_each(|block| merged.append(block));
        assert_same(&merged, &whole(&job), &format!("{kind:?}"));
    }
}

/// Ends a render after some passes.
struct EndAfter(u32);

impl Observer for EndAfter {
    fn pass_done(&mut self, film: &Film, _: &Stats, _: Duration) -> ControlFlow<()> {
        if film.passes() == self.0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// Keeps the film after some passes as arrays, which is what a file of a running render holds.
struct Keep {
    after: u32,
    arrays: [Option<Arrays>; 2],
}

type Arrays = HashMap<String, (Vec<usize>, ArrayValues)>;

fn arrays_of(film: &Film, sums: &PassSums) -> Arrays {
    let arrays = arrays_of_sums(film, sums).into_iter();
    arrays
        .map(|array| (array.name.clone(), (array.shape.clone(), array.values())))
        .collect()
}

fn sums_of(film: &Film, arrays: &Arrays) -> Result<PassSums, InvalidArray> {
    sums_of_arrays(film, |name, shape| match arrays.get(name) {
        Some((found, values)) if found == shape => Ok(values.clone()),
        found => Err(InvalidArray {
            name: name.into(),
            message: format!(
                "found {:?}, expected {shape:?}",
                found.map(|(shape, _)| shape)
            ),
        }),
    })
}

impl Observer for Keep {
    fn pass_done(&mut self, film: &Film, _: &Stats, _: Duration) -> ControlFlow<()> {
        if film.passes() < self.after {
            return ControlFlow::Continue(());
        }
        self.arrays = [
            film.completed().map(|sums| arrays_of(film, sums)),
            Some(arrays_of(film, film.current())),
        ];
        ControlFlow::Break(())
    }
}

#[test]
fn a_resumed_render_has_the_bits_of_one_without_a_break() {
    let scene = grouped_box(8, None).build();
    for kind in methods().into_iter().chain(methods_with_cuts()) {
        let job = job(&scene, kind.clone());
        let whole = whole(&job);
        // In a set of lights, at the end of a block, after the first pass of one.
        for after in [6, BLOCK_STEP, 2 * BLOCK_STEP + 1] {
            let mut keep = Keep {
                after,
                arrays: [None, None],
            };
            render(&job, &Stats::default(), &NEVER, &mut keep);
            let mut film = job.film(0);
            let [completed, current] = keep.arrays;
            let completed = completed.map(|arrays| sums_of(&film, &arrays).unwrap());
            let current = sums_of(&film, &current.unwrap()).unwrap();
            film.restore(completed, current);
            assert_eq!(film.passes(), after);
            let rest = resume(
                &job,
                film,
                Duration::ZERO,
                &Stats::default(),
                &NEVER,
                &mut (),
            );
            assert_eq!(rest.stop, Stop::Budget);
            assert_same(
                &rest.film,
                &whole,
                &format!("{kind:?} after {after} passes"),
            );
        }
    }
}

#[test]
fn arrays_that_do_not_fit_are_refused() {
    let scene = grouped_box(16, None).build();
    let job = job(&scene, MethodKind::Path);
    let film = render(&job, &Stats::default(), &NEVER, &mut EndAfter(2)).film;
    let good = arrays_of(&film, film.current());
    assert_eq!(&sums_of(&film, &good).unwrap(), film.current());
    let refused = |name: &str, change: &dyn Fn(&mut ArrayValues)| {
        let mut arrays = good.clone();
        change(&mut arrays.get_mut(name).unwrap().1);
        sums_of(&film, &arrays).unwrap_err().name
    };
    let words = |words: &'static [u32]| {
        move |values: &mut ArrayValues| *values = ArrayValues::U32(words.to_vec())
    };
    assert_eq!(refused("passes", &words(&[2, 0])), "passes");
    assert_eq!(refused("passes", &words(&[0])), "passes");
    assert_eq!(refused("passes", &words(&[0, 1])), "passes");
    assert_eq!(refused("sum.direct", &words(&[7])), "sum.direct");
    let wrong_type = |values: &mut ArrayValues| *values = ArrayValues::F64(vec![0.0, 2.0]);
    assert_eq!(refused("passes", &wrong_type), "passes");
    let more = |values: &mut ArrayValues| {
        if let ArrayValues::U32(counts) = values {
            counts[0] += 1;
        }
    };
    assert_eq!(refused("object.count", &more), "object.id");
}
