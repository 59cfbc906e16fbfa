//! The layers listed in the `lib.rs` of a crate hold: imports go strictly downwards. In every
//! crate, no circle of imports ties the files and folders of one folder together.

use crate::source::{Crate, Edge, Path};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// The crates of the workspace that have a library.
fn crates() -> Vec<Crate> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folders = std::fs::read_dir(root.join("crates")).unwrap();
    let mut folders: Vec<PathBuf> = folders.map(|entry| entry.unwrap().path()).collect();
    folders.push(root.join("fuzz"));
    folders.retain(|folder| folder.join("src/lib.rs").exists());
    folders.sort();
    folders.iter().map(|folder| Crate::read(folder)).collect()
}

/// Module → layer, from the list under the heading "Layers" in the documentation of a crate: in
/// each line the number of the layer, its modules, and after two spaces what they are. `None`
/// without such a list.
fn layers(documentation: &str) -> Option<BTreeMap<String, u32>> {
    let section = documentation.split("//! # Layers").nth(1)?;
    let list = section.split("```text").nth(1)?.split("```").next()?;
    let lines = list
        .lines()
        .map(|line| line.trim_start_matches("//!").trim());
    let mut layers = BTreeMap::new();
    for line in lines.filter(|line| !line.is_empty()) {
        let (number, modules) = line.split_once(' ').expect("a number and modules");
        let number = number.parse().expect("a number begins each line");
        let modules = modules.split("  ").next().unwrap_or_default();
        layers.extend(
            modules
                .split(' ')
                .map(|module| (module.to_string(), number)),
        );
    }
    Some(layers)
}

#[test]
fn imports_go_strictly_downwards() {
    let mut checked = 0;
    for one in crates() {
        let Some(layers) = layers(&one.documentation) else {
            continue;
        };
        let layer = |path: &Path| {
            let module = path.first().map_or("lib", String::as_str);
            let layer = layers.get(module);
            *layer.unwrap_or_else(|| panic!("{}: `{module}` is in no layer of lib.rs", one.name))
        };
        for Edge { from, to, .. } in one.edges() {
            // `lib.rs` re-exports from all layers, and has nothing to import.
            if from.is_empty() || from.first() == to.first() {
                continue;
            }
            let (own, imported) = (layer(&from), layer(&to));
            let [from, to] = [from, to].map(|path| path.join("::"));
            checked += 1;
            assert!(
                imported < own,
                "{}: `{from}` (layer {own}) imports `{to}` (layer {imported})",
                one.name
            );
        }
    }
    assert!(
        checked > 500,
        "only {checked} imports found: the reader of imports is broken"
    );
}

/// The imports among the entries of one folder: entry → imported entry → an example, as two
/// modules.
type Imports = BTreeMap<String, BTreeMap<String, String>>;

/// The imports among the files and folders in `folder`; its own file is called `mod`. Re-exports by
/// that file are no imports.
fn imports_among_entries(folder: &Path, edges: &[Edge]) -> Imports {
    let entry = |module: &Path| -> Option<String> {
        let inner = module.strip_prefix(folder.as_slice())?;
        Some(inner.first().map_or("mod", String::as_str).to_string())
    };
    let mut imports = Imports::new();
    for edge in edges {
        let (Some(from), Some(to)) = (entry(&edge.from), entry(&edge.to)) else {
            continue;
        };
        if from != to && !(from == "mod" && edge.is_re_export) {
            let example = format!("{} -> {}", edge.from.join("::"), edge.to.join("::"));
            imports.entry(from).or_default().insert(to, example);
        }
    }
    imports
}

/// Removes entries that import none or that none imports, again and again: what is left are circles
/// and what connects them.
fn circles(mut imports: Imports) -> Imports {
    loop {
        let before: usize = imports.values().map(BTreeMap::len).sum();
        let importing: BTreeSet<String> = imports.keys().cloned().collect();
        for used in imports.values_mut() {
            used.retain(|name, _| importing.contains(name));
        }
        let imported: BTreeSet<String> = imports.values().flat_map(|u| u.keys().cloned()).collect();
        imports.retain(|name, used| !used.is_empty() && imported.contains(name));
        if before == imports.values().map(BTreeMap::len).sum() {
            return imports;
        }
    }
}

#[test]
fn no_circle_of_imports_ties_files() {
    let mut found = Vec::new();
    for one in crates() {
        let edges = one.edges();
        let folders: BTreeSet<&[String]> = one
            .modules()
            .filter_map(|module| Some(module.split_last()?.1))
            .collect();
        for folder in folders {
            let tied = circles(imports_among_entries(&folder.to_vec(), &edges));
            let examples = tied.values().flat_map(BTreeMap::values);
            let examples: String = examples.map(|e| format!("\n    {e}")).collect();
            if !tied.is_empty() {
                found.push(format!("{} {}:{examples}", one.name, folder.join("::")));
            }
        }
    }
    assert!(
        found.is_empty(),
        "circles of imports among the entries of folders:\n{}",
        found.join("\n")
    );
}
