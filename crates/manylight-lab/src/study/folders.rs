//! The folders of the files that a plan names.

use super::plan::StudyPlan;
use super::runs::Run;
use crate::error::LabError;
use manylight_io::FileError;
use std::io;
use std::path::{Path, PathBuf};

/// Folders of the scenes, or of the references, of a study. Names that begin with `./` are relative
/// to the folder of the plan, all others to a separate folder.
#[derive(Debug)]
pub struct StudyFolders {
    plan: PathBuf,
    /// `None` if all names begin with `./`.
    separate: Option<PathBuf>,
}

impl StudyFolders {
    /// The folders of the scene files of `runs`. The separate folder is `folder`, or else that in
    /// the environment variable `MANYLIGHT_SCENES`.
    ///
    /// # Errors
    /// The separate folder is needed, but not given or not there.
    pub fn scenes(
        folder: Option<&Path>,
        plan: &StudyPlan,
        runs: &[&Run],
    ) -> Result<Self, LabError> {
        let names = runs.iter().map(|run| run.scene.file.clone());
        StudyFolders::new(plan, folder, "scenes", names)
    }

    /// The folders of the references of `runs`, by `folder` or the environment variable
    /// `MANYLIGHT_REFERENCES`.
    ///
    /// # Errors
    /// The separate folder is needed, but not given or not there.
    pub fn references(
        folder: Option<&Path>,
        plan: &StudyPlan,
        runs: &[&Run],
    ) -> Result<Self, LabError> {
        let names = runs.iter().map(|run| run.reference());
        StudyFolders::new(plan, folder, "references", names)
    }

    fn new(
        plan: &StudyPlan,
        folder: Option<&Path>,
        kind: &str,
        mut names: impl Iterator<Item = String>,
    ) -> Result<Self, LabError> {
        let mut folders = StudyFolders {
            plan: absolute(plan.folder()),
            separate: None,
        };
        let Some(name) = names.find(|name| !is_beside_plan(name)) else {
            return Ok(folders);
        };
        let variable = format!("MANYLIGHT_{}", kind.to_uppercase());
        let folder = folder
            .map(PathBuf::from)
            .or_else(|| std::env::var_os(&variable).map(PathBuf::from));
        let Some(folder) = folder else {
            return Err(LabError::usage(
                format!("the folder of {kind} is not known; the plan names {name}"),
                format!("add --{kind} DIR, or set the variable {variable}"),
            ));
        };
        if !folder.is_dir() {
            let error = io::Error::from(io::ErrorKind::NotADirectory);
            return Err(FileError::unreadable(&folder, error).into());
        }
        folders.separate = Some(absolute(&folder));
        Ok(folders)
    }

    /// The folder that the file `name` of the plan is relative to.
    pub(super) fn folder_of(&self, name: &str) -> &Path {
        match &self.separate {
            Some(folder) if !is_beside_plan(name) => folder,
            _ => &self.plan,
        }
    }

    /// The folder of the plan.
    pub(super) fn plan_folder(&self) -> &Path {
        &self.plan
    }

    /// The path of the file `name` of the plan.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.folder_of(name).join(name)
    }

    /// Both folders.
    pub(super) fn all(&self) -> impl Iterator<Item = &Path> {
        let separate = self.separate.as_deref();
        separate.into_iter().chain([self.plan.as_path()])
    }
}

fn is_beside_plan(name: &str) -> bool {
    name.starts_with("./")
}

/// `path` made absolute, without looking at the file system; unchanged if that fails.
pub(super) fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}
