//! Finding the files that a scene names: relative to the file that names them, and leniently about what other systems allow.

use std::path::{Path, PathBuf};

/// A file that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Resolved {
    /// The file.
    pub path: PathBuf,
    /// In what way the name in the scene differs from the name in the file system, if it does.
    pub remark: Option<&'static str>,
}

/// The file called `name` in the first of `folders` that has it. A name with backslashes, or of other case, is found with a remark.
pub fn resolve(name: &str, folders: &[PathBuf]) -> Option<Resolved> {
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
            remark: Some("uses `\\` between folders"),
        });
    }
    let path = folders
        .iter()
        .find_map(|folder| ignoring_case(folder, Path::new(&slashes)))?;
    Some(Resolved {
        path,
        remark: Some("differs in case from the file's name"),
    })
}

/// `folder/name`, each part of `name` compared without regard to case.
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

/// The name of an existing file in the folder of `path` that is most like its name, for a suggestion.
pub fn similar_file(path: &Path) -> Option<String> {
    let wanted = path.file_name()?.to_string_lossy().into_owned();
    let names: Vec<String> = entries(path.parent()?)?
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    let mut names: Vec<&str> = names.iter().map(String::as_str).collect();
    names.sort_unstable();
    similar(&wanted, names.iter().copied()).map(str::to_owned)
}

/// What is in `folder`; the empty path, parent of a bare name, stands for the current folder.
fn entries(folder: &Path) -> Option<impl Iterator<Item = std::fs::DirEntry>> {
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    Some(std::fs::read_dir(folder).ok()?.flatten())
}

/// The name among `known` that `found` was probably meant to be.
pub fn similar<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Below 0.75, suggestions are more often silly than right; measured by Jaro-Winkler similarity.
    const PLAUSIBLE: f64 = 0.75;
    let lower = found.to_lowercase();
    known
        .into_iter()
        .map(|name| (strsim::jaro_winkler(&lower, &name.to_lowercase()), name))
        .filter(|(score, _)| *score >= PLAUSIBLE)
        .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(a.1)))
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_other_systems_are_found_with_a_remark() {
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
    fn bare_names_are_looked_up_in_the_current_folder() {
        // Tests run in the folder of their package.
        assert_eq!(
            similar_file(Path::new("Cargo.tml")).as_deref(),
            Some("Cargo.toml")
        );
        let found = resolve("cargo.TOML", &[PathBuf::new()]).unwrap();
        assert_eq!(found.path, Path::new("Cargo.toml"));
        assert!(found.remark.is_some());
    }

    #[test]
    fn suggestions_are_near_or_absent() {
        let known = ["diffuse", "dielectric", "roughconductor"];
        assert_eq!(similar("difuse", known), Some("diffuse"));
        assert_eq!(similar("Dielektric", known), Some("dielectric"));
        assert_eq!(similar("xyz", known), None);
    }
}
