//! Which file of a crate imports from which, read from the text of its sources.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path as FilePath;

/// The path of a module below the root of its crate, or of an item.
pub(crate) type Path = Vec<String>;

/// Most re-exports in a row that are followed to the definition of a name.
const MAX_RE_EXPORTS: u32 = 8;

/// The sources of a crate, without tests.
pub(crate) struct Crate {
    pub(crate) name: String,
    /// The text of `lib.rs`.
    pub(crate) documentation: String,
    modules: BTreeMap<Path, Module>,
}

/// The paths in a file.
struct Module {
    imports: Vec<Import>,
    /// Paths outside imports, such as `crate::color::luminance` and `float::lerp`.
    inline: Vec<Path>,
}

/// A name that an import brings into a module.
struct Import {
    path: Path,
    name: String,
    is_public: bool,
}

/// That one module uses what another one defines.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Edge {
    pub(crate) from: Path,
    pub(crate) to: Path,
    pub(crate) is_re_export: bool,
}

impl Crate {
    /// The crate in `folder`.
    pub(crate) fn read(folder: &FilePath) -> Crate {
        let mut modules = BTreeMap::new();
        read_modules(&folder.join("src"), &Path::new(), &mut modules);
        Crate {
            name: folder.file_name().unwrap().to_string_lossy().into_owned(),
            documentation: std::fs::read_to_string(folder.join("src/lib.rs")).unwrap(),
            modules,
        }
    }

    /// All modules that are files.
    pub(crate) fn modules(&self) -> impl Iterator<Item = &Path> {
        self.modules.keys()
    }

    /// All imports between files, those by paths in the code included.
    pub(crate) fn edges(&self) -> Vec<Edge> {
        let mut edges = BTreeSet::new();
        for (from, module) in &self.modules {
            let imports = module.imports.iter().map(|i| (&i.path, i.is_public));
            let inline = module.inline.iter().map(|path| (path, false));
            for (path, is_re_export) in imports.chain(inline) {
                if let Some(to) = self.definition(from, path, 0)
                    && to != *from
                {
                    edges.insert(Edge {
                        from: from.clone(),
                        to,
                        is_re_export,
                    });
                }
            }
        }
        edges.into_iter().collect()
    }

    /// The module that defines what `path` names in the module `from`. `None` for other crates.
    fn definition(&self, from: &Path, path: &[String], re_exports: u32) -> Option<Path> {
        let path = self.absolute(from, path)?;
        let is_module = |length: &usize| self.modules.contains_key(&path[..*length]);
        let length = (0..=path.len()).take_while(is_module).last()?;
        let (module, item) = path.split_at(length);
        let module = module.to_vec();
        let Some(name) = item.first() else {
            return Some(module);
        };
        let import = self.import(&module, name);
        match import {
            Some(import) if re_exports < MAX_RE_EXPORTS => {
                let path = [import.path.as_slice(), &item[1..]].concat();
                self.definition(&module, &path, re_exports + 1)
            }
            _ => Some(module),
        }
    }

    /// The import that brings `name` into a module.
    fn import(&self, module: &Path, name: &str) -> Option<&Import> {
        let imports = &self.modules.get(module)?.imports;
        imports.iter().find(|import| import.name == name)
    }

    /// `path` from the root of the crate.
    fn absolute(&self, from: &Path, path: &[String]) -> Option<Path> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => Some(rest.to_vec()),
            "self" => Some([from.as_slice(), rest].concat()),
            "super" => {
                let ups = path.iter().take_while(|name| *name == "super").count();
                let parent = &from[..from.len().checked_sub(ups)?];
                Some([parent, &path[ups..]].concat())
            }
            _ if self.is_module(from, first) => Some([from.as_slice(), path].concat()),
            _ => {
                let import = self.import(from, first)?;
                if import.path.first() == Some(first) {
                    return None;
                }
                Some([self.absolute(from, &import.path)?.as_slice(), rest].concat())
            }
        }
    }

    fn is_module(&self, parent: &Path, name: &str) -> bool {
        let path = [parent.as_slice(), &[name.to_string()]].concat();
        self.modules.contains_key(&path)
    }
}

/// Reads the files in a folder and the folders below it, without tests and programs.
fn read_modules(folder: &FilePath, module: &Path, found: &mut BTreeMap<Path, Module>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let is_program = module.is_empty() && (name == "main" || name == "bin");
        if name.contains("test") || is_program {
            continue;
        }
        let child = [module.as_slice(), std::slice::from_ref(&name)].concat();
        if file.is_dir() {
            read_modules(&file, &child, found);
        } else if file.extension().is_some_and(|e| e == "rs") {
            let is_own = name == "mod" || (module.is_empty() && name == "lib");
            let path = if is_own { module.clone() } else { child };
            found.insert(
                path,
                Module::parse(&std::fs::read_to_string(&file).unwrap()),
            );
        }
    }
}

impl Module {
    fn parse(text: &str) -> Module {
        let code: Vec<&str> = text.lines().map(without_comment).collect();
        let code = without_visibilities(&without_tests(&code.join("\n")));
        let mut imports = Vec::new();
        let mut inline = Vec::new();
        let mut rest = code.as_str();
        while let Some((before, is_public, after)) = split_at_import(rest) {
            inline.extend(paths(before));
            let (tree, after) = after.split_once(';').unwrap_or((after, ""));
            let names = names_of_tree(&Path::new(), tree).into_iter();
            imports.extend(names.map(|(path, name)| Import {
                path,
                name,
                is_public,
            }));
            rest = after;
        }
        inline.extend(paths(rest));
        Module { imports, inline }
    }
}

/// The code before the first import, whether that is public, and what follows the word `use`.
fn split_at_import(code: &str) -> Option<(&str, bool, &str)> {
    let is_import = |&(at, _): &(usize, &str)| {
        let line = code[..at].rsplit('\n').next().unwrap_or_default().trim();
        line.is_empty() || line.starts_with("pub")
    };
    let (at, word) = code.match_indices("use ").find(is_import)?;
    let is_public = code[..at].trim_end_matches(' ').ends_with(['b', ')']);
    Some((&code[..at], is_public, &code[at + word.len()..]))
}

/// The path and the name of everything that the tree of an import brings.
fn names_of_tree(prefix: &Path, tree: &str) -> Vec<(Path, String)> {
    let join = |text: &str| -> Path {
        let names = text.split("::").map(str::trim).filter(|n| !n.is_empty());
        prefix
            .iter()
            .cloned()
            .chain(names.map(str::to_string))
            .collect()
    };
    let tree = tree.trim();
    if let Some((head, group)) = tree.split_once('{') {
        let prefix = join(head);
        let branches = split_at_commas(group.strip_suffix('}').unwrap_or(group));
        let names = branches.iter().map(|branch| names_of_tree(&prefix, branch));
        return names.flatten().collect();
    }
    let (tree, alias) = match tree.split_once(" as ") {
        Some((tree, alias)) => (tree, Some(alias.trim())),
        None => (tree, None),
    };
    let mut path = join(tree);
    if path.len() > 1 {
        path.pop_if(|last| last == "self");
    }
    let last = path.last().cloned();
    match (tree.is_empty(), last) {
        (false, Some(last)) => vec![(path, alias.map_or(last, str::to_string))],
        _ => Vec::new(),
    }
}

/// The branches of a group in an import.
fn split_at_commas(group: &str) -> Vec<&str> {
    let mut depth = 0;
    let is_end = |c: char| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    };
    group.split(is_end).collect()
}

/// The paths of two and more names in code without imports.
fn paths(code: &str) -> impl Iterator<Item = Path> {
    let words = code.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
    words.filter(|word| word.contains("::")).filter_map(|word| {
        let names = word.split("::").map(str::to_string);
        let path: Path = names.take_while(|name| !name.is_empty()).collect();
        (path.len() > 1).then_some(path)
    })
}

fn without_comment(line: &str) -> &str {
    line.split_once("//").map_or(line, |(code, _)| code)
}

/// The code without the items that are compiled for tests alone.
fn without_tests(code: &str) -> String {
    let mut kept = String::new();
    let mut rest = code;
    while let Some(at) = rest.find("#[cfg(") {
        let (before, attribute) = rest.split_at(at);
        kept.push_str(before);
        let end = attribute.find(")]").map_or(attribute.len(), |end| end + 2);
        let (condition, item) = attribute.split_at(end);
        let is_for_tests = condition.contains("test") && !condition.contains("not(test");
        rest = if is_for_tests { after_item(item) } else { item };
    }
    kept + rest
}

/// The code without the paths of visibilities such as `pub(in crate::geometry)`.
fn without_visibilities(code: &str) -> String {
    let (first, rest) = code.split_once("pub(in ").unwrap_or((code, ""));
    let others = rest
        .split("pub(in ")
        .filter_map(|part| part.split_once(')'));
    let others = others.map(|(_, code)| format!("pub{code}"));
    std::iter::once(first.to_string()).chain(others).collect()
}

/// What follows the first item in `code`: a semicolon or a block ends it.
fn after_item(code: &str) -> &str {
    let mut depth = 0;
    for (at, c) in code.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if depth == 0 && (c == ';' || c == '}') {
            return &code[at + 1..];
        }
    }
    ""
}
