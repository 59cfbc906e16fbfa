//! Figures that the docs quote are those of the code. A comment behind a figure names what it is,
//! which no reader of the page sees:
//!
//! | mark | value |
//! |---|---|
//! | `8<!-- = MAX_GROUP_PASSES -->` | a constant of the sources, in any file; one of them, where several have its name |
//! | `0.02<!-- = lightcuts --max-error -->` | the setting of a preset, as `manylight list methods` shows it |
//! | `16<!-- = --block -->` | the default of an option of `manylight render` |

use super::support::Folder;
use std::collections::BTreeMap;
use std::fs::read_to_string;
use std::path::{Path, PathBuf};

/// Where every option of the method is said, with its default.
const AXES: &str = "docs/many_light.md";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The files with this extension in a folder and below it.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found
}

/// The values of the constants of the sources, by name.
fn constants() -> BTreeMap<String, Vec<String>> {
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for path in files(&root().join("crates"), "rs") {
        let text = read_to_string(&path).unwrap();
        // A value may stand on the line after the name.
        let statements = text.split("const ").skip(1);
        for statement in statements.filter_map(|rest| rest.split(';').next()) {
            if let Some((declared, value)) = statement.split_once('=')
                && let Some((name, _)) = declared.split_once(':')
            {
                let values = found.entry(name.trim().to_owned()).or_default();
                values.push(value.trim().to_owned());
            }
        }
    }
    found
}

/// The number of an expression such as `48`, `16_384`, `1 << 18` or `NonZeroU32::new(16).unwrap()`.
fn evaluate(expression: &str) -> Option<f64> {
    let number = |text: &str| -> Option<f64> {
        let is_part = |c: char| c.is_ascii_digit() || c == '_' || c == '.';
        let names_left_out = text.rsplit("::new(").next()?.trim_matches('(');
        let digits: String = names_left_out
            .trim()
            .chars()
            .take_while(|&c| is_part(c))
            .collect();
        digits.trim_end_matches('.').replace('_', "").parse().ok()
    };
    if let Some((left, right)) = expression.split_once("<<") {
        return Some(number(left)? * number(right)?.exp2());
    }
    if let Some((left, right)) = expression.split_once('/') {
        return Some(number(left)? / number(right)?);
    }
    number(expression)
}

/// The settings of each preset, from `manylight list methods`: a line with its name, and one with
/// its options.
fn presets() -> BTreeMap<String, BTreeMap<String, String>> {
    let listed = Folder::new("")
        .run("list methods")
        .code(0)
        .stdout()
        .to_owned();
    let mut presets = BTreeMap::new();
    let mut name = String::new();
    for line in listed.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if line.starts_with(' ') {
            let pairs = words.chunks_exact(2);
            let settings = pairs.map(|pair| (pair[0].to_owned(), pair[1].to_owned()));
            presets.insert(name.clone(), settings.collect());
        } else if let Some(first) = words.first() {
            name = (*first).to_owned();
        }
    }
    presets
}

/// The default of an option of `render`, from its help.
fn option_default(help: &str, option: &str) -> Option<String> {
    let words: Vec<&str> = help.split_whitespace().collect();
    let help = words.join(" ");
    let (_, entry) = help.split_once(&format!("{option} <"))?;
    // The entry of the next option begins with its value.
    let entry = entry.split(" <").next()?;
    let value = entry.split("[default: ").nth(1)?;
    Some(value.split(']').next()?.to_owned())
}

/// What stands before a mark: the last word, or a number with its groups of digits; without the
/// signs of Markdown.
fn quoted(before: &str) -> String {
    let text = before.trim_end_matches(['*', '`', ')']);
    let text = text.trim_end();
    let mut words = text.rsplit(|c: char| c.is_whitespace() || "(*`|,".contains(c));
    let mut value = words.next().unwrap_or_default().to_owned();
    let is_group = |word: &str| word.len() <= 3 && word.chars().all(|c| c.is_ascii_digit());
    while value.len() >= 3 && value.chars().all(|c| c.is_ascii_digit()) {
        match words.next() {
            Some(word) if !word.is_empty() && is_group(word) => value = format!("{word}{value}"),
            _ => break,
        }
    }
    value
}

/// The number of a word.
fn in_digits(word: &str) -> &str {
    const WORDS: &[(&str, &str)] = &[
        ("two", "2"),
        ("four", "4"),
        ("five", "5"),
        ("eight", "8"),
        ("sixteen", "16"),
        ("Sixteen", "16"),
        ("twentieth", "0.05"),
        ("sixteenth", "0.0625"),
    ];
    let found = WORDS.iter().find(|(name, _)| *name == word);
    found.map_or(word, |(_, digits)| digits)
}

fn are_equal(quoted: &str, actual: &str) -> bool {
    match (in_digits(quoted).parse::<f64>(), evaluate(actual)) {
        (Ok(quoted), Some(actual)) => (quoted - actual).abs() <= 1e-6 * actual.abs(),
        _ => quoted == actual,
    }
}

/// A figure with its mark.
#[derive(Debug)]
struct Mark {
    page: String,
    quoted: String,
    name: String,
}

fn marks() -> Vec<Mark> {
    let mut pages = files(&root().join("docs"), "md");
    pages.push(root().join("README.md"));
    let mut marks = Vec::new();
    for path in pages {
        let text = read_to_string(&path).unwrap();
        let page = path.strip_prefix(root()).unwrap().display().to_string();
        for (start, _) in text.match_indices("<!-- = ") {
            let name = text[start + "<!-- = ".len()..]
                .split(" -->")
                .next()
                .unwrap();
            marks.push(Mark {
                page: page.clone(),
                quoted: quoted(&text[..start]),
                name: name.to_owned(),
            });
        }
    }
    marks
}

/// The values that a mark may stand for; none if nothing has its name.
fn actual(
    name: &str,
    constants: &BTreeMap<String, Vec<String>>,
    presets: &BTreeMap<String, BTreeMap<String, String>>,
    help: &str,
) -> Vec<String> {
    if let Some((preset, option)) = name.split_once(" --") {
        let settings = presets.get(preset);
        let value = settings.and_then(|settings| settings.get(&format!("--{option}")));
        value.into_iter().cloned().collect()
    } else if name.starts_with("--") {
        option_default(help, name).into_iter().collect()
    } else {
        constants.get(name).cloned().unwrap_or_default()
    }
}

#[test]
fn figures_of_the_docs_are_those_of_the_code() {
    let (constants, presets) = (constants(), presets());
    let help = Folder::new("")
        .run("render --help")
        .code(0)
        .stdout()
        .to_owned();
    let marks = marks();
    let wrong: Vec<String> = marks
        .iter()
        .filter_map(|mark| {
            let values = actual(&mark.name, &constants, &presets, &help);
            let is_right = values.iter().any(|value| are_equal(&mark.quoted, value));
            (!is_right).then(|| format!("{mark:?}: the code has {values:?}"))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // Every setting of the default is quoted where the axes are described.
    for option in presets["rich-vpl"].keys() {
        let name = format!("rich-vpl {option}");
        let is_quoted = marks
            .iter()
            .any(|mark| mark.page == AXES && mark.name == name);
        assert!(is_quoted, "{AXES} quotes no default of {option}");
    }
}

#[test]
fn marks_are_read() {
    assert_eq!(quoted("a map of 48"), "48");
    assert_eq!(quoted("at most 32 768"), "32768");
    assert_eq!(quoted("| **`shared`**"), "shared");
    assert_eq!(quoted("`--lobes` 1 to 8 (5"), "5");
    assert_eq!(quoted("(`-n`, 262 144"), "262144");
    assert!(are_equal("sixteen", "16.0") && are_equal("262144", "1 << 18"));
    assert!(are_equal("16", "NonZeroU32::new(16).unwrap()") && !are_equal("4", "8.0"));
    assert!(are_equal("disc", "disc") && !are_equal("point", "disc"));
}
