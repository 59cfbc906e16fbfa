//! Where Open Image Denoise is searched.
//!
//! The order is: the file that the caller names, the folder of the variable `OIDN_DIR`, the Python
//! package `pyoidn`, and the loader's own search path. A named file ends the search.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;

/// File name of the library, as its packages install it.
pub const LIBRARY_NAME: &str = if cfg!(windows) {
    "OpenImageDenoise.dll"
} else if cfg!(target_os = "macos") {
    "libOpenImageDenoise.2.dylib"
} else {
    "libOpenImageDenoise.so.2"
};

/// Folders of an installation that may contain the library.
const SUBFOLDERS: [&str; 4] = ["", "lib", "lib64", "bin"];

/// Folder of the library's installation within the Python package `pyoidn`.
const IN_PYTHON_PACKAGE: &str = "pyoidn/oidn";

/// Where the library is searched: the given file, and the variables of the environment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SearchPlaces {
    /// The library file itself. If given, nothing else is tried.
    pub file: Option<PathBuf>,
    /// `OIDN_DIR`: the folder of an installation.
    pub oidn_dir: Option<PathBuf>,
    /// `VIRTUAL_ENV`: the folder of a virtual environment of Python.
    pub virtual_env: Option<PathBuf>,
    /// `PATH`: folders in which `python3` is searched.
    pub path: Option<OsString>,
}

/// A place in which the library is searched.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// The place in words.
    pub(crate) name: String,
    /// Library files to try there, in this order. Empty if the place has none.
    pub(crate) files: Vec<PathBuf>,
}

impl SearchPlaces {
    /// The places that the environment of this process names, after `file`.
    pub fn from_environment(file: Option<PathBuf>) -> Self {
        let folder = |name| {
            std::env::var_os(name)
                .filter(|v| !v.is_empty())
                .map(PathBuf::from)
        };
        SearchPlaces {
            file,
            oidn_dir: folder("OIDN_DIR"),
            virtual_env: folder("VIRTUAL_ENV"),
            path: std::env::var_os("PATH"),
        }
    }

    /// The places in their order. Later places are looked up only when the iterator reaches them.
    pub(crate) fn places(&self) -> impl Iterator<Item = Place> + '_ {
        let named = self.file.iter().map(|file| Place {
            name: format!("the given file {}", file.display()),
            // A name without a folder would be searched in the system's folders.
            files: vec![std::path::absolute(file).unwrap_or_else(|_| file.clone())],
        });
        let searched: [fn(&SearchPlaces) -> Place; 3] = [
            SearchPlaces::variable,
            SearchPlaces::python_package,
            SearchPlaces::system,
        ];
        let count = if self.file.is_some() { 0 } else { 3 };
        named.chain(searched.into_iter().take(count).map(|place| place(self)))
    }

    fn variable(&self) -> Place {
        match &self.oidn_dir {
            Some(folder) => Place {
                name: format!("OIDN_DIR={}", folder.display()),
                files: libraries_in(folder),
            },
            None => Place {
                name: "OIDN_DIR (not set)".into(),
                files: Vec::new(),
            },
        }
    }

    fn python_package(&self) -> Place {
        let mut files: Vec<PathBuf> = (self.site_packages().iter())
            .flat_map(|folder| libraries_in(&folder.join(IN_PYTHON_PACKAGE)))
            .collect();
        if files.is_empty()
            && let Some(package) = self.python().and_then(|python| package_folder(&python))
        {
            files = libraries_in(&package.join("oidn"));
        }
        Place {
            name: "the Python package pyoidn".into(),
            files,
        }
    }

    /// The loader's own search: a bare file name.
    fn system(&self) -> Place {
        Place {
            name: format!("the system's library folders ({LIBRARY_NAME})"),
            files: vec![LIBRARY_NAME.into()],
        }
    }

    /// The first `python3` in `PATH`.
    fn python(&self) -> Option<PathBuf> {
        let names = if cfg!(windows) {
            &["python3.exe", "python.exe"][..]
        } else {
            &["python3"]
        };
        let folders = self.path.iter().flat_map(std::env::split_paths);
        let candidates = folders.flat_map(|folder| names.iter().map(move |name| folder.join(name)));
        candidates.into_iter().find(|file| file.is_file())
    }

    /// Existing folders of Python packages: of the virtual environment, then of the installation
    /// around `python3`.
    fn site_packages(&self) -> Vec<PathBuf> {
        let python = self.python();
        let prefix = python.as_deref().and_then(Path::parent).map(|folder| {
            if folder.file_name() == Some(OsStr::new("bin")) {
                folder.parent().unwrap_or(folder).to_owned()
            } else {
                folder.to_owned()
            }
        });
        self.virtual_env
            .iter()
            .chain(&prefix)
            .flat_map(|prefix| package_folders(prefix))
            .collect()
    }
}

/// Existing library files of the installation in `folder`.
fn libraries_in(folder: &Path) -> Vec<PathBuf> {
    SUBFOLDERS
        .iter()
        .map(|sub| folder.join(sub).join(LIBRARY_NAME))
        .filter(|file| file.is_file())
        .collect()
}

/// Existing folders of Python packages below the installation `prefix`; of several versions of
/// Python, the highest first.
fn package_folders(prefix: &Path) -> Vec<PathBuf> {
    let mut versions: Vec<(u32, PathBuf)> = Vec::new();
    for lib in ["lib", "lib64", "local/lib"] {
        for entry in std::fs::read_dir(prefix.join(lib)).into_iter().flatten() {
            let Ok(entry) = entry else { continue };
            let name = entry.file_name();
            let Some(version) = name.to_str().and_then(|n| n.strip_prefix("python3")) else {
                continue;
            };
            let minor = version.strip_prefix('.').and_then(|v| v.parse().ok());
            versions.push((minor.unwrap_or(0), entry.path()));
        }
    }
    versions.sort_by_key(|&(minor, _)| std::cmp::Reverse(minor));
    let folders = versions.into_iter().flat_map(|(_, folder)| {
        ["site-packages", "dist-packages"].map(|packages| folder.join(packages))
    });
    // On Windows there is one folder for all versions.
    folders
        .chain([prefix.join("Lib").join("site-packages")])
        .filter(|folder| folder.is_dir())
        .collect()
}

/// The folder of the package `pyoidn`, as the interpreter tells it: in some installations it does
/// not lie beside the interpreter.
fn package_folder(python: &Path) -> Option<PathBuf> {
    const PROGRAM: &str = "import importlib.util as u; s = u.find_spec('pyoidn'); print(s.submodule_search_locations[0] if s else '')";
    let output = Command::new(python).args(["-c", PROGRAM]).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let folder = text.trim();
    (output.status.success() && !folder.is_empty()).then(|| folder.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    /// Creates an empty file with the library's name in `folder`, and returns its path.
    fn install(root: &TempDir, folder: &str) -> PathBuf {
        let folder = root.path().join(folder);
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join(LIBRARY_NAME);
        std::fs::write(&file, "").unwrap();
        file
    }

    fn files(places: &SearchPlaces) -> Vec<PathBuf> {
        places.places().flat_map(|place| place.files).collect()
    }

    #[test]
    fn a_given_file_is_the_only_place() {
        let root = TempDir::new().unwrap();
        install(&root, "lib");
        let places = SearchPlaces {
            file: Some("/a/b.so".into()),
            oidn_dir: Some(root.path().into()),
            ..SearchPlaces::default()
        };
        assert_eq!(files(&places), [PathBuf::from("/a/b.so")]);
    }

    #[test]
    fn the_variable_comes_before_python_and_python_before_the_system() {
        let root = TempDir::new().unwrap();
        let expected = [
            install(&root, "oidn/lib"),
            install(&root, "oidn/bin"),
            install(&root, "venv/lib/python3.11/site-packages/pyoidn/oidn/lib"),
            install(&root, "venv/lib/python3.9/site-packages/pyoidn/oidn/lib"),
            LIBRARY_NAME.into(),
        ];
        let places = SearchPlaces {
            oidn_dir: Some(root.path().join("oidn")),
            virtual_env: Some(root.path().join("venv")),
            ..SearchPlaces::default()
        };
        assert_eq!(files(&places), expected);
        let names: Vec<String> = places.places().map(|place| place.name).collect();
        assert!(
            names[0].starts_with("OIDN_DIR=") && names[1].contains("pyoidn"),
            "{names:?}"
        );
    }

    #[test]
    fn the_variable_may_name_the_folder_of_the_file_itself() {
        let root = TempDir::new().unwrap();
        let file = install(&root, "");
        let places = SearchPlaces {
            oidn_dir: Some(root.path().into()),
            ..SearchPlaces::default()
        };
        assert_eq!(files(&places)[0], file);
    }

    #[test]
    fn python_is_found_by_path() {
        let root = TempDir::new().unwrap();
        let file = install(&root, "usr/lib/python3/dist-packages/pyoidn/oidn/lib");
        let bin = root.path().join("usr").join("bin");
        std::fs::create_dir_all(&bin).unwrap();
        let name = if cfg!(windows) {
            "python3.exe"
        } else {
            "python3"
        };
        std::fs::write(bin.join(name), "").unwrap();
        let paths = [root.path().join("empty"), bin];
        let places = SearchPlaces {
            path: Some(std::env::join_paths(paths).unwrap()),
            ..SearchPlaces::default()
        };
        assert_eq!(files(&places), [file, LIBRARY_NAME.into()]);
    }

    #[test]
    fn nothing_but_the_system_without_variables() {
        let places = SearchPlaces::default();
        assert_eq!(files(&places), [PathBuf::from(LIBRARY_NAME)]);
        let names: Vec<String> = places.places().map(|place| place.name).collect();
        assert_eq!(names.len(), 3);
        assert_eq!(names[0], "OIDN_DIR (not set)");
    }
}
