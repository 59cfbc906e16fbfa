//! The unsafe code of the workspace is listed in `docs/robustness.md`, with a test for each file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What begins unsafe code. Types of functions are not counted.
const BEGINNINGS: [&str; 5] = [
    "unsafe {",
    "unsafe fn",
    "unsafe impl",
    "unsafe extern \"C\" {",
    "unsafe extern \"C\" fn ",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Rust files below `folder` that contain unsafe code, with the number of its beginnings.
fn unsafe_code(folder: &Path, found: &mut BTreeMap<String, usize>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.ends_with("target") {
            unsafe_code(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            let lines = text.lines().filter_map(|line| line.split("//").next());
            let of_line = |line: &str| -> usize {
                let found = BEGINNINGS.iter().map(|word| line.matches(word).count());
                found.sum()
            };
            let count = lines.map(of_line).sum();
            if count > 0 {
                let name = path.strip_prefix(root()).unwrap();
                found.insert(name.to_str().unwrap().replace('\\', "/"), count);
            }
        }
    }
}

/// The cells of the table of unsafe code: file, number, reason, test as `file::function`.
fn table() -> Vec<[String; 4]> {
    let page = std::fs::read_to_string(root().join("docs/robustness.md")).unwrap();
    let section = page.split("## Unsafe code").nth(1).unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| {
        let cells = row.trim_matches('|').split(" | ");
        let cells: Vec<String> = cells.map(|cell| cell.trim().replace('`', "")).collect();
        cells.try_into().expect("four cells")
    })
    .collect()
}

#[test]
fn unsafe_code_is_listed() {
    let mut found = BTreeMap::new();
    unsafe_code(&root().join("crates"), &mut found);
    unsafe_code(&root().join("fuzz"), &mut found);
    // The strings above are none.
    found.remove("crates/manylight/tests/it/unsafe_code.rs");
    let listed = table().into_iter();
    let listed = listed.map(|[file, count, ..]| (file, count.parse().unwrap()));
    assert_eq!(found, listed.collect());
}

#[test]
fn tests_of_unsafe_code_exist() {
    for [file, .., test] in table() {
        let (of_test, function) = test.split_once("::").unwrap();
        let text = std::fs::read_to_string(root().join(of_test)).unwrap();
        let is_there = ["fn", "def"].map(|word| text.contains(&format!("{word} {function}(")));
        assert!(is_there.contains(&true), "{file}: {test}");
    }
}
