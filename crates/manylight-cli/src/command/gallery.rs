//! The pictures of a study in groups: one for each scene and task, of what is the same but for the method.

use super::compare;
use crate::compare::{Comparison, Frame};
use crate::failure::Failure;
use crate::study::{Files, Plan, Run};
use crate::viewer::Group;
use std::path::Path;

/// The groups of which pictures are kept in the folder `images`, made one by one: each holds all its pixels. Of several budgets, the last.
pub(super) fn groups<'a>(
    plan: &'a Plan,
    runs: &'a [Run<'a>],
    references: &'a Files,
    images: &'a Path,
) -> impl Iterator<Item = Result<Group, Failure>> + 'a {
    let tasks = plan.tasks.iter().map(|task| {
        let last = task.budget_values().last().copied().flatten();
        (task, task.name_with(last))
    });
    let places = tasks.flat_map(move |(task, name)| {
        plan.scenes_of(task)
            .map(move |scene| (task, name.clone(), scene))
    });
    places.filter_map(move |(task, name, scene)| {
        let belongs = |run: &&Run| run.task_name == name && run.scene.name == scene.name;
        let of_group: Vec<&Run> = (runs.iter())
            .filter(belongs)
            .filter(|run| images.join(picture(run)).exists())
            .collect();
        let title = format!("{}: {}", task.title, scene.title);
        let reference = references.path(&scene.reference);
        (!of_group.is_empty()).then(|| group(title, &of_group, &reference, images))
    })
}

fn picture(run: &Run) -> String {
    format!("{}.exr", run.key())
}

fn group(
    title: String,
    runs: &[&Run],
    reference_path: &Path,
    images: &Path,
) -> Result<Group, Failure> {
    let reference = compare::read(reference_path, None)?;
    let measure = |run: &&Run| {
        let path = images.join(picture(run));
        let (frame, comparison) = compare::measure(&path, reference_path, &reference, None)?;
        let image = run.method.label.clone();
        Ok((
            frame,
            Comparison {
                image,
                ..comparison
            },
        ))
    };
    let measured = runs.iter().map(measure);
    let measured = measured.collect::<Result<Vec<(Frame, Comparison)>, Failure>>()?;
    let (frames, comparisons): (Vec<Frame>, Vec<Comparison>) = measured.into_iter().unzip();
    let of = (&reference, "reference");
    Ok(Group::new(title, &frames, &comparisons, of))
}
