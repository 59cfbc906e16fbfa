//! The images of a study in groups for the viewer.

use super::folders::StudyFolders;
use super::plan::StudyPlan;
use super::runs::Run;
use crate::compare::{Comparison, ComparisonImage, compare_file, read_image};
use crate::error::LabError;
use crate::viewer::ImageGroup;
use std::path::Path;

/// Groups of the images that the folder `images` holds: one group per task and scene, with one
/// image per method. Of a task with several budgets, the last is used. The groups are made one by
/// one, because each holds all pixels of its images.
pub fn image_groups<'a>(
    plan: &'a StudyPlan,
    runs: &'a [Run<'a>],
    references: &'a StudyFolders,
    images: &'a Path,
) -> impl Iterator<Item = Result<ImageGroup, LabError>> + 'a {
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
            .filter(|run| images.join(file_name(run)).exists())
            .collect();
        let title = format!("{}: {}", task.title, scene.title);
        let reference = references.path(&scene.reference);
        (!of_group.is_empty()).then(|| group(title, &of_group, &reference, images))
    })
}

/// File name of the image of a run.
fn file_name(run: &Run) -> String {
    format!("{}.exr", run.key())
}

fn group(
    title: String,
    runs: &[&Run],
    reference_path: &Path,
    images: &Path,
) -> Result<ImageGroup, LabError> {
    let reference = read_image(reference_path, None)?;
    let measure = |run: &&Run| {
        let path = images.join(file_name(run));
        let (image, comparison) = compare_file(&path, reference_path, &reference, None)?;
        let named = Comparison {
            image: run.method.label.clone(),
            ..comparison
        };
        Ok((image, named))
    };
    let measured = runs.iter().map(measure);
    let measured = measured.collect::<Result<Vec<(ComparisonImage, Comparison)>, LabError>>()?;
    let (images, comparisons): (Vec<ComparisonImage>, Vec<Comparison>) =
        measured.into_iter().unzip();
    let of = (&reference, "reference");
    Ok(ImageGroup::new(title, &images, &comparisons, of))
}
