//! File lookup for scenes, tolerant of names written on other systems.

use crate::suggest::similar;
use std::path::{Path, PathBuf};

/// The result of a successful lookup.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Resolved {
    /// Path of the file or folder.
    pub(crate) path: PathBuf,
    /// How the name in the scene differs from the name in the file system, if it does.
    pub(crate) remark: Option<&'static str>,
}

/// Looks for `name` in `folders`, in this order: as written, then with `\` replaced by `/`, then
/// ignoring case.
pub(crate) fn resolve(name: &str, folders: &[PathBuf]) -> Option<Resolved> {
    let candidates = |name: &str| {
        folders
            .iter()
            .map(|folder| folder.join(name))
            .collect::<Vec<_>>()
    };
    if let Some(path) = candidates(name).into_iter().find(|path| path.exists()) {
        return Some(Resolved { path, remark: None });
    }
    let slashes = name.replace('\\', "/");
    if slashes != name
        && let Some(path) = candidates(&slashes).into_iter().find(|path| path.exists())
    {
        return Some(Resolved {
            path,
            remark: Some("uses `\\` as the folder separator"),
        });
    }
    let path = folders
        .iter()
        .find_map(|folder| ignoring_case(folder, Path::new(&slashes)))?;
    Some(Resolved {
        path,
        remark: Some("differs from the name of the file in upper and lower case"),
    })
}

/// An existing path `folder/name`, with each component of `name` compared ignoring case.
fn ignoring_case(folder: &Path, name: &Path) -> Option<PathBuf> {
    let mut path = if name.is_absolute() {
        PathBuf::from("/")
    } else {
        folder.to_owned()
    };
    for part in name.components() {
        use std::path::Component;
        match part {
            Component::Normal(part) if !path.join(part).exists() => {
                let wanted = part.to_string_lossy().to_lowercase();
                let mut names: Vec<_> = entries(&path)?.map(|entry| entry.file_name()).collect();
                names.sort();
                path.push(
                    names
                        .into_iter()
                        .find(|name| name.to_string_lossy().to_lowercase() == wanted)?,
                );
            }
            Component::Normal(part) => path.push(part),
            Component::ParentDir => path.push(".."),
            Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
        }
    }
    path.exists().then_some(path)
}

/// The file name most similar to that of `path` in the same folder, if one is similar enough to
/// suggest.
pub(crate) fn similar_file(path: &Path) -> Option<String> {
    let wanted = path.file_name()?.to_string_lossy().into_owned();
    let names: Vec<String> = entries(path.parent()?)?
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    let mut names: Vec<&str> = names.iter().map(String::as_str).collect();
    names.sort_unstable();
    names.retain(|name| *name != wanted);
    similar(&wanted, names).map(str::to_owned)
}

/// Where a file that does not exist was looked for, with a suggestion if there is a similar name.
pub(crate) fn looked_for(path: &Path) -> String {
    match similar_file(path) {
        Some(similar) => format!("looked for `{}`; did you mean `{similar}`?", path.display()),
        None => format!("looked for `{}`", path.display()),
    }
}

/// The entries of `folder`. The empty path, which is the parent of a bare file name, means the
/// current folder.
fn entries(folder: &Path) -> Option<impl Iterator<Item = std::fs::DirEntry>> {
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    Some(std::fs::read_dir(folder).ok()?.flatten())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backslashes_and_other_case_are_found_with_a_remark() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("Textures")).unwrap();
        std::fs::write(folder.path().join("Textures/Wood.png"), "").unwrap();
        let folders = [folder.path().to_owned()];
        let found = |name: &str| resolve(name, &folders).map(|resolved| resolved.remark.is_some());
        assert_eq!(found("Textures/Wood.png"), Some(false));
        assert_eq!(found("Textures\\Wood.png"), Some(true));
        assert_eq!(found("textures/wood.PNG"), Some(true));
        assert_eq!(found("textures/stone.png"), None);
    }

    #[test]
    fn bare_file_names_refer_to_the_current_folder() {
        // The working directory of a test is the folder of its package.
        assert_eq!(
            similar_file(Path::new("Cargo.tml")).as_deref(),
            Some("Cargo.toml")
        );
        let found = resolve("cargo.TOML", &[PathBuf::new()]).unwrap();
        assert_eq!(found.path, Path::new("Cargo.toml"));
        assert!(found.remark.is_some());
    }
}
