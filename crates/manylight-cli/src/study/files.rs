//! Where the files are that a plan names.

use super::plan::Plan;
use super::runs::Run;
use crate::args::StudyArgs;
use crate::failure::Failure;
use manylight_io::FileError;
use std::io;
use std::path::{Path, PathBuf};

/// Scenes or references: those that start with `./` are beside the plan, the others in a folder of their own.
#[derive(Debug)]
pub(crate) struct Files {
    beside_plan: PathBuf,
    /// Not known if none of them is there.
    elsewhere: Option<PathBuf>,
}

impl Files {
    /// The scenes of some runs.
    pub(crate) fn scenes(args: &StudyArgs, plan: &Plan, runs: &[&Run]) -> Result<Self, Failure> {
        let names = runs.iter().map(|run| &run.scene.file);
        Files::new(plan, args.scenes.as_deref(), "scenes", names)
    }

    /// The references of some runs.
    pub(crate) fn references(
        args: &StudyArgs,
        plan: &Plan,
        runs: &[&Run],
    ) -> Result<Self, Failure> {
        let names = runs.iter().map(|run| &run.scene.reference);
        Files::new(plan, args.references.as_deref(), "references", names)
    }

    /// By option or variable.
    fn new<'n>(
        plan: &Plan,
        option: Option<&Path>,
        what: &str,
        mut names: impl Iterator<Item = &'n String>,
    ) -> Result<Self, Failure> {
        let mut files = Files {
            beside_plan: absolute(plan.folder()),
            elsewhere: None,
        };
        let Some(name) = names.find(|name| !is_beside(name)) else {
            return Ok(files);
        };
        let variable = format!("MANYLIGHT_{}", what.to_uppercase());
        let folder = option
            .map(PathBuf::from)
            .or_else(|| std::env::var_os(&variable).map(PathBuf::from));
        let Some(folder) = folder else {
            return Err(Failure::usage(
                format!("the folder of {what} is not known; the plan names {name}"),
                format!("add --{what} DIR, or set the variable {variable}"),
            ));
        };
        if !folder.is_dir() {
            let error = io::Error::from(io::ErrorKind::NotADirectory);
            return Err(FileError::unreadable(&folder, error).into());
        }
        files.elsewhere = Some(absolute(&folder));
        Ok(files)
    }

    /// The folder that a file is relative to.
    pub(crate) fn folder_of(&self, name: &str) -> &Path {
        match &self.elsewhere {
            Some(folder) if !is_beside(name) => folder,
            _ => &self.beside_plan,
        }
    }

    /// The folder of the plan.
    pub(crate) fn beside_plan(&self) -> &Path {
        &self.beside_plan
    }

    /// A file.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder_of(name).join(name)
    }

    /// All folders.
    pub(crate) fn folders(&self) -> impl Iterator<Item = &Path> {
        let elsewhere = self.elsewhere.as_deref();
        elsewhere.into_iter().chain([self.beside_plan.as_path()])
    }
}

fn is_beside(name: &str) -> bool {
    name.starts_with("./")
}

pub(crate) fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}
