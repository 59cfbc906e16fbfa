//! The layers listed in `lib.rs` hold: imports go strictly downwards.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

fn source_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Module → layer, from the list in the crate's documentation.
fn layers() -> HashMap<String, u32> {
    let lib = std::fs::read_to_string(source_root().join("lib.rs")).unwrap();
    let list = lib
        .split("```text")
        .nth(1)
        .and_then(|rest| rest.split("```").next())
        .expect("lib.rs lists the layers");
    let mut layers = HashMap::new();
    for line in list.lines() {
        let mut words = line.trim_start_matches("//!").split_whitespace();
        if let Some(number) = words.next() {
            let number = number
                .parse()
                .expect("each line begins with the number of the layer");
            layers.extend(words.map(|module| (module.to_string(), number)));
        }
    }
    layers
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The modules named after every `crate::` in code (comments and test modules left out).
fn imported_modules(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    code.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .flat_map(|line| line.split("crate::").skip(1))
        .map(|rest| {
            rest.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect()
        })
        .collect()
}

#[test]
fn imports_go_strictly_downwards() {
    let layers = layers();
    let root = source_root();
    let mut files = Vec::new();
    rust_files(&root, &mut files);
    let mut checked = 0;
    for file in files {
        let relative = file
            .strip_prefix(&root)
            .unwrap()
            .to_string_lossy()
            .into_owned();
        let module = relative.split(['/', '.']).next().unwrap().to_string();
        let is_test = relative.contains("tests") || relative.contains("testing");
        if module == "lib" || is_test {
            continue;
        }
        let own = *layers
            .get(&module)
            .unwrap_or_else(|| panic!("{relative}: module `{module}` is in no layer of lib.rs"));
        for imported in imported_modules(&std::fs::read_to_string(&file).unwrap()) {
            let Some(&layer) = layers.get(&imported) else {
                panic!("{relative} imports `{imported}`, which is in no layer of lib.rs");
            };
            checked += 1;
            assert!(
                imported == module || layer < own,
                "{relative} (layer {own}) imports `{imported}` (layer {layer})"
            );
        }
    }
    assert!(
        checked > 50,
        "only {checked} imports found: the reader of imports is broken"
    );
}
