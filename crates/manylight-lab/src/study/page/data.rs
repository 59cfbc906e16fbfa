//! What all sections of a page are made of.

use super::super::method::StudyMethod;
use super::super::plan::{StudyPlan, StudyScene, StudyTask};
use super::super::record::Record;
use super::super::results::Results;
use super::super::runs::run_key;
use crate::document::{DocumentTable, TableCell};

/// A plan with its results.
#[derive(Clone, Copy)]
pub(super) struct PageData<'p> {
    pub(super) plan: &'p StudyPlan,
    pub(super) results: &'p Results,
}

impl<'p> PageData<'p> {
    /// The result of one run.
    pub(super) fn record(
        self,
        task: &StudyTask,
        budget: Option<&str>,
        scene: &StudyScene,
        method: &StudyMethod,
    ) -> Option<&'p Record> {
        let task = task.name_with(budget);
        self.results
            .get(&run_key(&scene.name, &method.label, &task))
    }

    /// Column headings: `first`, then the scenes of a task.
    pub(super) fn head_of(self, task: &StudyTask, first: &[&str]) -> Vec<String> {
        let scenes = self.plan.scenes_of(task).map(|scene| scene.title.clone());
        first
            .iter()
            .copied()
            .map(String::from)
            .chain(scenes)
            .collect()
    }

    /// A table with one row per method and one column per scene of a task.
    pub(super) fn by_method_and_scene(
        self,
        task: &StudyTask,
        cell: impl Fn(&StudyScene, &StudyMethod) -> TableCell,
    ) -> DocumentTable {
        let mut table = DocumentTable::new(self.head_of(task, &["method"]));
        for method in self.plan.methods_of(task) {
            let cells = self.plan.scenes_of(task).map(|scene| cell(scene, method));
            table.push(std::iter::once(TableCell::plain(&method.label)).chain(cells));
        }
        table
    }
}
