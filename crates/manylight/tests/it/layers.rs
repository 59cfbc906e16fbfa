//! The layers listed in `lib.rs` hold: imports go strictly downwards. Within the modules of the method and of scattering, no cycle of
//! imports ties the files of one folder together.

use std::collections::{BTreeMap, BTreeSet, HashMap};
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

/// The modules of the method, and scattering.
const METHOD: [&str; 9] = [
    "bsdf",
    "transport",
    "particles",
    "maps",
    "virtual_lights",
    "light_tree",
    "gather",
    "integrators",
    "render",
];

/// The sibling files and folders of `file` that its code imports, by name. `module` is the path of its folder in the crate.
fn imported_siblings(text: &str, module: &str, siblings: &BTreeSet<String>) -> BTreeSet<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let code: Vec<&str> = (code.lines())
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect();
    let code = code.join("\n");
    let prefixes = ["super::".to_string(), format!("crate::{module}::")];
    let first_names = |prefix: &String| -> Vec<String> {
        let after = code.split(prefix.as_str()).skip(1);
        let name = |rest: &str| -> String {
            let is_name = |c: &char| c.is_alphanumeric() || *c == '_';
            rest.chars().take_while(is_name).collect()
        };
        after.map(name).collect()
    };
    let names = prefixes.iter().flat_map(first_names);
    names.filter(|name| siblings.contains(name)).collect()
}

/// Removes files without imports, again and again, and returns the rest: those on cycles, and those that import them.
fn files_on_cycles(mut imports: BTreeMap<String, BTreeSet<String>>) -> BTreeSet<String> {
    loop {
        let free =
            |(name, used): (&String, &BTreeSet<String>)| used.is_empty().then(|| name.clone());
        let free: Vec<String> = imports.iter().filter_map(free).collect();
        if free.is_empty() {
            return imports.into_keys().collect();
        }
        for name in &free {
            imports.remove(name);
            imports.values_mut().for_each(|used| {
                used.remove(name);
            });
        }
    }
}

fn assert_no_cycles(folder: &Path, module: &str) {
    let entries = std::fs::read_dir(folder).unwrap();
    let paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    let name = |path: &Path| path.file_stem().unwrap().to_string_lossy().into_owned();
    let is_test = |path: &Path| name(path).contains("test");
    let files = paths
        .iter()
        .filter(|path| !is_test(path) && name(path) != "mod");
    let siblings: BTreeSet<String> = files.clone().map(|path| name(path)).collect();
    let mut imports = BTreeMap::new();
    for path in files {
        let own = name(path);
        if path.is_dir() {
            assert_no_cycles(path, &format!("{module}::{own}"));
            continue;
        }
        let text = std::fs::read_to_string(path).unwrap();
        let mut used = imported_siblings(&text, module, &siblings);
        used.remove(&own);
        imports.insert(own, used);
    }
    let folders: BTreeSet<String> = siblings
        .into_iter()
        .filter(|name| !imports.contains_key(name))
        .collect();
    for used in imports.values_mut() {
        used.retain(|name| !folders.contains(name));
    }
    let tied = files_on_cycles(imports);
    assert!(
        tied.is_empty(),
        "{module}: cycles of imports among {tied:?}"
    );
}

#[test]
fn no_cycle_ties_the_files_of_the_method() {
    for module in METHOD {
        assert_no_cycles(&source_root().join(module), module);
    }
}
