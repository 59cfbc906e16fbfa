//! A folder with the files of an input.
//!
//! An input is the content of one file, or of several: after the first one, a line `#### FILE name`
//! starts the next. Every folder also has the files of [`ASSETS`], so that scenes have something to
//! refer to.

use std::cell::RefCell;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// What starts a further file.
const SEPARATOR: &[u8] = b"\n#### FILE ";

/// Files of every folder.
const ASSETS: &[(&str, &[u8])] = &[
    ("mesh.ply", include_bytes!("../assets/mesh.ply")),
    ("mesh.obj", include_bytes!("../assets/mesh.obj")),
    (
        "mesh.serialized",
        include_bytes!("../assets/mesh.serialized"),
    ),
    ("curves.txt", include_bytes!("../assets/curves.txt")),
    ("image.png", include_bytes!("../assets/image.png")),
    ("image.exr", include_bytes!("../assets/image.exr")),
    ("image.hdr", include_bytes!("../assets/image.hdr")),
    ("values.spd", include_bytes!("../assets/values.spd")),
    ("data.bin", include_bytes!("../assets/data.bin")),
];

thread_local! {
    /// One folder for all inputs of a thread: making one takes longer than reading most inputs.
    static FOLDER: RefCell<Option<TempDir>> = const { RefCell::new(None) };
}

/// Calls `f` with the path of a file `name` of this content.
pub(crate) fn with_file(content: &[u8], name: &str, f: impl FnOnce(&Path)) {
    with_folder(|folder| {
        let path = folder.join(name);
        write(&path, content);
        f(&path);
        remove(&path);
    });
}

/// Calls `f` with the path of the first file of an input, which is called `name`. Inputs that name
/// files outside of the folder are left out.
pub(crate) fn with_files(input: &[u8], name: &str, f: impl FnOnce(&Path)) {
    if leaves_folder(input) {
        return;
    }
    with_folder(|folder| {
        let paths: Vec<PathBuf> = split(input, name)
            .into_iter()
            .map(|(name, content)| {
                let path = folder.join(name);
                write(&path, content);
                path
            })
            .collect();
        f(&paths[0]);
        for path in &paths {
            let asset = ASSETS.iter().find(|(name, _)| path.ends_with(name));
            match asset {
                Some((_, content)) => write(path, content),
                None => remove(path),
            }
        }
    });
}

/// Whether the input names a path upwards or an absolute one.
fn leaves_folder(input: &[u8]) -> bool {
    let contains = |what: &[u8]| input.windows(what.len()).any(|part| part == what);
    let escapes = [
        &b"../"[..],
        b"..\\",
        b"%2",
        b"%5",
        b"&#",
        b"\\u00",
        b"\\/",
        b"file:",
    ];
    // A quote before `/>` ends the last attribute of an XML element.
    let is_absolute =
        |part: &[u8]| matches!(part, [b'"' | b'\'', b'/' | b'\\', next] if *next != b'>');
    escapes.into_iter().any(contains) || input.windows(3).any(is_absolute)
}

/// The files of an input. Of files with the same name, the last one counts.
fn split<'a>(input: &'a [u8], first: &str) -> Vec<(String, &'a [u8])> {
    let mut files = Vec::new();
    let (mut name, mut rest) = (first.to_owned(), input);
    while let Some(place) = rest.windows(SEPARATOR.len()).position(|w| w == SEPARATOR) {
        let (content, after) = (&rest[..=place], &rest[place + SEPARATOR.len()..]);
        let end = after
            .iter()
            .position(|&b| b == b'\n')
            .unwrap_or(after.len());
        files.push((name, content));
        name = file_name(&after[..end], files.len());
        rest = &after[(end + 1).min(after.len())..];
    }
    files.push((name, rest));
    files
}

/// A file name of the allowed characters; another one for other names.
fn file_name(bytes: &[u8], number: usize) -> String {
    /// Longest name.
    const MAX_LENGTH: usize = 32;
    let is_allowed = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'_' | b'-');
    let fits = (1..=MAX_LENGTH).contains(&bytes.len()) && bytes[0] != b'.';
    if fits && bytes.iter().all(is_allowed) {
        String::from_utf8_lossy(bytes).into_owned()
    } else {
        format!("file{number}")
    }
}

fn with_folder(f: impl FnOnce(&Path)) {
    FOLDER.with_borrow_mut(|folder| {
        let folder = folder.get_or_insert_with(|| {
            let folder = tempfile::tempdir().expect("a folder for temporary files can be written");
            for (name, content) in ASSETS {
                write(&folder.path().join(name), content);
            }
            folder
        });
        f(folder.path());
    });
}

fn write(path: &Path, content: &[u8]) {
    fs::write(path, content).expect("the temporary folder can be written");
}

fn remove(path: &Path) {
    // A file that was written twice is gone at the second time.
    let _ = fs::remove_file(path);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_has_several_files() {
        let input = b"one\n#### FILE b.ply\ntwo\n#### FILE ../c\nthree";
        let files = split(input, "a.xml");
        let expected: [(&str, &[u8]); 3] = [
            ("a.xml", b"one\n"),
            ("b.ply", b"two\n"),
            ("file2", b"three"),
        ];
        assert!(
            files
                .iter()
                .map(|(name, content)| (name.as_str(), *content))
                .eq(expected)
        );
    }

    #[test]
    fn files_of_an_input_are_removed_and_assets_restored() {
        let input = b"one\n#### FILE b.ply\ntwo\n#### FILE mesh.ply\nthree";
        let mut folder = None;
        with_files(input, "a.xml", |path| {
            let parent = path.parent().unwrap();
            assert_eq!(fs::read(parent.join("mesh.ply")).unwrap(), b"three");
            assert!(parent.join("b.ply").exists());
            folder = Some(parent.to_owned());
        });
        let folder = folder.unwrap();
        assert_eq!(fs::read(folder.join("mesh.ply")).unwrap(), ASSETS[0].1);
        assert!(!folder.join("a.xml").exists() && !folder.join("b.ply").exists());
    }

    #[test]
    fn inputs_that_leave_the_folder_are_left_out() {
        for input in [
            &br#"<include filename="../x"/>"#[..],
            br#"Include "/etc/passwd""#,
        ] {
            with_files(input, "a.xml", |_| {
                panic!("an input that leaves the folder")
            });
        }
    }

    #[test]
    fn elements_of_xml_are_no_absolute_paths() {
        let mut called = false;
        with_files(br#"<a b="c"/><d e='f'/>"#, "a.xml", |_| called = true);
        assert!(called);
    }
}
