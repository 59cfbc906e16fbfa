//! Links of the pages, and paths of pages that sources name, lead to files and headings that exist.
//! Every page of `docs` is in the table of contents of the site.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Folders without pages and sources of the project.
const LEFT_OUT: [&str; 5] = ["target", "corpus", "node_modules", "__pycache__", "book"];
/// Extensions of source files. Their comments and messages may name pages.
const SOURCES: [&str; 8] = ["rs", "py", "sh", "yaml", "yml", "toml", "md", "json"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn extension(path: &Path) -> &str {
    path.extension().and_then(|e| e.to_str()).unwrap_or("")
}

/// The files below a folder, except hidden ones and those of folders that are left out.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if name.starts_with('.') || LEFT_OUT.contains(&name.as_str()) {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(path);
            }
        }
    }
    found
}

fn pages() -> Vec<PathBuf> {
    let mut pages = files(&root());
    pages.retain(|path| extension(path) == "md" && !path.ends_with("golden.md"));
    pages
}

/// The text of a page without code: fenced blocks, and what stands between backquotes.
fn without_code(text: &str) -> String {
    let mut kept = String::new();
    let mut in_block = false;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            in_block = !in_block;
        } else if !in_block {
            let parts = line.split('`').step_by(2);
            kept.extend(parts.flat_map(|part| [part, "\u{1}"]));
        }
        kept.push('\n');
    }
    kept
}

/// The identifier that forges and mdBook give a heading: small letters, digits, `-` and `_`.
fn identifier(heading: &str) -> String {
    let mut shown = String::new();
    let mut rest = heading;
    // A link is shown by its text.
    while let Some((before, text, after)) = link(rest) {
        shown.push_str(before);
        shown.push_str(text);
        rest = after;
    }
    shown.push_str(rest);
    let characters = shown.trim().chars().flat_map(char::to_lowercase);
    let kept = characters.filter_map(|c| match c {
        ' ' => Some('-'),
        '-' | '_' => Some(c),
        _ => c.is_alphanumeric().then_some(c),
    });
    kept.collect()
}

/// The first link `[text](target)`: what stands before it, its text, and what follows.
fn link(text: &str) -> Option<(&str, &str, &str)> {
    let (start, middle) = (text.find('[')?, text.find("](")?);
    let end = middle + text[middle..].find(')')?;
    let shown = text.get(start + 1..middle)?;
    Some((&text[..start], shown, &text[end + 1..]))
}

/// The identifiers of the headings of a page.
fn headings(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut in_block = false;
    for line in text.lines() {
        in_block ^= line.starts_with("```");
        let title = line.trim_start_matches('#');
        if !in_block && title.len() < line.len() && title.starts_with(' ') {
            let identifier = identifier(title);
            if !found.insert(identifier.clone()) {
                let mut numbered = (1..).map(|n| format!("{identifier}-{n}"));
                let free = numbered.find(|name| !found.contains(name));
                found.extend(free);
            }
        }
    }
    found
}

/// The targets of the links and images of a page.
fn targets(text: &str) -> Vec<String> {
    let text = without_code(text);
    let between = |start: &str, end: char| -> Vec<String> {
        let parts = text.split(start).skip(1);
        parts
            .filter_map(|part| part.split_once(end))
            .map(|(target, _)| target.to_owned())
            .collect()
    };
    let mut found = between("](", ')');
    found.extend(between("src=\"", '"'));
    found.extend(between("href=\"", '"'));
    found.retain(|target| !target.contains("://") && !target.starts_with("mailto:"));
    found
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut headings_of = BTreeMap::new();
    let mut wrong = Vec::new();
    let mut count = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        for target in targets(&text) {
            count += 1;
            let (file, heading) = target.split_once('#').unwrap_or((&target, ""));
            let path = if file.is_empty() {
                page.clone()
            } else {
                page.parent().unwrap().join(file)
            };
            let mut is_right = path.exists();
            if is_right && !heading.is_empty() && extension(&path) == "md" {
                let known = headings_of.entry(path.clone()).or_insert_with(|| {
                    let text = std::fs::read_to_string(&path).unwrap();
                    headings(&text)
                });
                is_right = known.contains(heading);
            }
            if !is_right {
                wrong.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count > 100, "{count} links");
}

#[test]
fn paths_of_docs_in_sources_exist() {
    let mut wrong = Vec::new();
    let workflow = root().join(".github/workflows/ci.yml");
    let run = root().join(".ci/run");
    let mut sources = files(&root());
    sources.retain(|path| SOURCES.contains(&extension(path)));
    // The changelog names files of earlier versions, and this file names none.
    sources.retain(|path| !path.ends_with("CHANGELOG.md") && !path.ends_with("links.rs"));
    sources.extend([workflow, run]);
    for source in sources {
        let text = std::fs::read_to_string(&source).unwrap();
        for (start, _) in text.match_indices("docs/") {
            let is_inside =
                text[..start].ends_with(|c: char| c.is_alphanumeric() || "./_".contains(c));
            let is_of_path = |c: char| c.is_alphanumeric() || "/._-".contains(c);
            let rest = &text[start..];
            let path = rest.split(|c| !is_of_path(c)).next().unwrap();
            let path = path.trim_end_matches(['.', '/']);
            let names_file = ["md", "py", "json", "sh"].contains(&extension(Path::new(path)));
            if !is_inside && names_file && !root().join(path).exists() {
                wrong.push(format!("{}: {path}", source.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn pages_are_in_the_table_of_contents() {
    let docs = root().join("docs");
    let contents = std::fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let listed: BTreeSet<String> = targets(&contents).into_iter().collect();
    let missing: Vec<String> = (files(&docs).into_iter())
        .filter(|path| extension(path) == "md" && !path.ends_with("SUMMARY.md"))
        .map(|path| {
            let page = path.strip_prefix(&docs).unwrap();
            page.to_str().unwrap().replace('\\', "/")
        })
        .filter(|page| !listed.contains(page))
        .collect();
    assert!(missing.is_empty(), "not in docs/SUMMARY.md: {missing:?}");
}

#[test]
fn headings_and_links_are_read() {
    assert_eq!(
        identifier(" Peaks, `--x` & [text](a.md)"),
        "peaks---x--text"
    );
    let found = headings("# A b\n```\n# no\n```\n## A b\n");
    assert_eq!(found.into_iter().collect::<Vec<_>>(), ["a-b", "a-b-1"]);
    let found = targets("[a](b.md#c) `[x](y)` ![i](i.jpg) <img src=\"k\"> [w](https://w)");
    assert_eq!(found, ["b.md#c", "i.jpg", "k"]);
}
