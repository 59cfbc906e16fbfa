//! XML text into a tree whose every name and value knows its span, with `$name` replaced and `<include>` followed.

use super::super::sink::{FileSpan, Problem, Sink};
use super::object::PluginFamily;
use crate::resolve::{resolve, similar};
use roxmltree::{Document, Node, ParsingOptions};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Files including files: more than this is a cycle.
const MAX_INCLUDE_DEPTH: usize = 15;

/// Elements in elements: far beyond any scene, and still safe for recursion.
const MAX_NESTING: usize = 100;

/// Which generation of the format a file is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dialect {
    /// 0.x: camelCase names, other defaults, Y up for the sky.
    V0,
    /// 2 and 3.
    V3,
}

/// A piece of text and where it stands.
#[derive(Clone, Debug)]
pub(super) struct Text {
    pub(super) value: String,
    pub(super) span: FileSpan,
}

/// An attribute with `$name` replaced.
#[derive(Clone, Debug)]
pub(super) struct Attribute {
    pub(super) name: Text,
    pub(super) value: Text,
}

/// An element with included files in span.
#[derive(Clone, Debug)]
pub(super) struct XmlElement {
    pub(super) tag: Text,
    pub(super) attributes: Vec<Attribute>,
    pub(super) children: Vec<XmlElement>,
    pub(super) dialect: Dialect,
    /// Where the files that it names are looked for.
    pub(super) folders: Arc<[PathBuf]>,
}

impl XmlElement {
    /// The attribute called `name`.
    pub(super) fn attribute(&self, name: &str) -> Option<&Text> {
        self.attributes
            .iter()
            .find(|attribute| attribute.name.value == name)
            .map(|attribute| &attribute.value)
    }
}

/// A `$name` parameter.
struct Parameter {
    name: String,
    value: String,
    defined: Definition,
}

/// Where a parameter comes from.
#[derive(PartialEq, Eq)]
enum Definition {
    Caller { used: bool },
    File,
}

/// What is known of the file that is being read.
#[derive(Clone)]
struct File {
    index: u32,
    dialect: Dialect,
    folders: Arc<[PathBuf]>,
    depth: usize,
}

/// Reads a file and all that it includes into one tree. `None` if the text is not XML.
pub(super) fn read_tree(
    path: &Path,
    text: Arc<str>,
    defines: &[(String, String)],
    sink: &Sink,
) -> Option<XmlElement> {
    let parameters = defines
        .iter()
        .map(|(name, value)| Parameter {
            name: name.clone(),
            value: value.clone(),
            defined: Definition::Caller { used: false },
        })
        .collect();
    let mut reader = TreeReader {
        sink,
        parameters,
        nesting: 0,
    };
    let root = reader.file(path, text, 0, &[])?;
    reader.check_defines();
    Some(root)
}

struct TreeReader<'a> {
    sink: &'a Sink,
    parameters: Vec<Parameter>,
    /// Elements that are being read.
    nesting: usize,
}

impl TreeReader<'_> {
    fn file(
        &mut self,
        path: &Path,
        text: Arc<str>,
        depth: usize,
        outer: &[PathBuf],
    ) -> Option<XmlElement> {
        let index = self.sink.add_file(path, Arc::clone(&text));
        // A byte order mark is not part of the document; offsets count from after it.
        let skipped = if text.starts_with('\u{feff}') {
            '\u{feff}'.len_utf8()
        } else {
            0
        };
        let options = ParsingOptions {
            allow_dtd: true,
            ..ParsingOptions::default()
        };
        let document = match Document::parse_with_options(&text[skipped..], options) {
            Ok(document) => document,
            Err(error) => {
                self.malformed(index, &text, &error);
                return None;
            }
        };
        let mut folders = vec![path.parent().map_or_else(PathBuf::new, Path::to_owned)];
        folders.extend(
            outer
                .iter()
                .filter(|folder| **folder != folders[0])
                .cloned()
                .collect::<Vec<_>>(),
        );
        let root = document.root_element();
        let dialect = self.dialect(root, index, skipped);
        let mut file = File {
            index,
            dialect,
            folders: folders.into(),
            depth,
        };
        self.element(root, &mut file, skipped)
    }

    fn malformed(&self, file: u32, text: &str, error: &roxmltree::Error) {
        let position = error.pos();
        let line_start: usize = text
            .split_inclusive('\n')
            .take(position.row as usize - 1)
            .map(str::len)
            .sum();
        let line = text[line_start..].lines().next().unwrap_or("");
        let column = line
            .char_indices()
            .nth(position.col as usize - 1)
            .map_or(line.len(), |(offset, _)| offset);
        let span = FileSpan {
            file,
            start: (line_start + column) as u32,
            end: (line_start + column) as u32,
        };
        let message = error.to_string();
        let message = message.split(" at ").next().unwrap_or(&message).to_owned();
        self.sink.error(
            Problem::new(
                "scene::malformed_xml",
                span,
                format!("malformed XML: {message}"),
            )
            .label("here"),
        );
    }

    fn dialect(&self, root: Node<'_, '_>, file: u32, skipped: usize) -> Dialect {
        let tag = span(file, tag_range(root), skipped);
        let Some(version) = root.attribute_node("version") else {
            self.sink.error(
                Problem::new(
                    "scene::missing_version",
                    tag,
                    format!("<{}> has no `version`", root.tag_name().name()),
                )
                .help("expected for instance `<scene version=\"3.0.0\">`"),
            );
            return Dialect::V3;
        };
        match version
            .value()
            .split('.')
            .next()
            .and_then(|major| major.trim().parse::<u32>().ok())
        {
            Some(0 | 1) => Dialect::V0,
            Some(_) => Dialect::V3,
            None => {
                let at = span(file, version.range_value(), skipped);
                self.sink.error(
                    Problem::new(
                        "scene::bad_version",
                        at,
                        format!("`{}` is not a version", version.value()),
                    )
                    .help("expected for instance `3.0.0`"),
                );
                Dialect::V3
            }
        }
    }

    /// The element, or `None` for those that only matter while reading (`default`, `path`) or that are broken.
    fn element(
        &mut self,
        node: Node<'_, '_>,
        file: &mut File,
        skipped: usize,
    ) -> Option<XmlElement> {
        let mut element = self.start(node, file, skipped);
        match element.tag.value.as_str() {
            "default" => {
                self.default(&element);
                return None;
            }
            "path" => {
                self.search_path(&element, file);
                return None;
            }
            _ => {}
        }
        if self.nesting == MAX_NESTING {
            let message = format!("elements are nested more than {MAX_NESTING} deep");
            self.sink
                .error(Problem::new("scene::too_deep", element.tag.span, message));
            return None;
        }
        self.nesting += 1;
        element.children = self.children(node, file, skipped);
        self.nesting -= 1;
        Some(element)
    }

    /// The element without its children.
    fn start(&mut self, node: Node<'_, '_>, file: &File, skipped: usize) -> XmlElement {
        let tag = Text {
            value: node.tag_name().name().to_owned(),
            span: span(file.index, tag_range(node), skipped),
        };
        let attributes = node
            .attributes()
            .map(|attribute| {
                let value_place = span(file.index, attribute.range_value(), skipped);
                Attribute {
                    name: Text {
                        value: attribute.name().to_owned(),
                        span: span(file.index, attribute.range_qname(), skipped),
                    },
                    value: Text {
                        value: self.substitute(attribute.value(), value_place),
                        span: value_place,
                    },
                }
            })
            .collect();
        XmlElement {
            tag,
            attributes,
            children: Vec::new(),
            dialect: file.dialect,
            folders: Arc::clone(&file.folders),
        }
    }

    fn children(&mut self, node: Node<'_, '_>, file: &mut File, skipped: usize) -> Vec<XmlElement> {
        let mut children = Vec::new();
        for child in node.children() {
            if child.is_element() && child.tag_name().name() == "include" {
                let include = self.element(child, file, skipped);
                children.extend(
                    include
                        .into_iter()
                        .flat_map(|include| self.include(&include, file)),
                );
            } else if child.is_element() {
                children.extend(self.element(child, file, skipped));
            } else if child.is_text() && child.text().is_some_and(|text| !text.trim().is_empty()) {
                self.stray_text(child, file.index, skipped);
            }
        }
        children
    }

    fn stray_text(&self, node: Node<'_, '_>, file: u32, skipped: usize) {
        let text = node.text().unwrap_or("");
        let lead = text.len() - text.trim_start().len();
        let range = node.range();
        let start = range.start + lead;
        let at = span(
            file,
            start..(start + text.trim().len()).min(range.end),
            skipped,
        );
        self.sink.error(
            Problem::new("scene::stray_text", at, "text between elements")
                .help("values belong into attributes; to leave something out, write <!-- ... -->"),
        );
    }

    fn default(&mut self, element: &XmlElement) {
        let (Some(name), Some(value)) = (
            self.required(element, "name"),
            self.required(element, "value"),
        ) else {
            return;
        };
        if !self
            .parameters
            .iter()
            .any(|parameter| parameter.name == name.value)
        {
            let (name, value) = (name.value.clone(), value.value.clone());
            self.parameters.push(Parameter {
                name,
                value,
                defined: Definition::File,
            });
        } else if let Some(parameter) = self
            .parameters
            .iter_mut()
            .find(|parameter| parameter.name == name.value)
            && let Definition::Caller { used } = &mut parameter.defined
        {
            *used = true;
        }
    }

    fn required<'e>(&self, element: &'e XmlElement, name: &str) -> Option<&'e Text> {
        let found = element.attribute(name);
        if found.is_none() {
            let tag = &element.tag.value;
            let message = format!("<{tag}> needs the attribute `{name}`");
            self.sink.error(Problem::new(
                "scene::missing_attribute",
                element.tag.span,
                message,
            ));
        }
        found
    }

    fn search_path(&mut self, element: &XmlElement, file: &mut File) {
        let Some(value) = self.required(element, "value") else {
            return;
        };
        match resolve(&value.value, &file.folders) {
            Some(found) => {
                let folders = std::iter::once(found.path).chain(file.folders.iter().cloned());
                file.folders = folders.collect();
            }
            None => self.sink.error(
                Problem::new(
                    "scene::missing_file",
                    value.span,
                    format!("the folder `{}` does not exist", value.value),
                )
                .label("not found"),
            ),
        }
    }

    fn include(&mut self, element: &XmlElement, file: &File) -> Vec<XmlElement> {
        let Some(name) = self.required(element, "filename") else {
            return Vec::new();
        };
        if file.depth >= MAX_INCLUDE_DEPTH {
            let message = format!("files include each other more than {MAX_INCLUDE_DEPTH} deep");
            self.sink.error(
                Problem::new("scene::include_depth", name.span, message).help("is there a cycle?"),
            );
            return Vec::new();
        }
        let Some(found) = find_file(self.sink, &file.folders, name, "included file") else {
            return Vec::new();
        };
        let text = match std::fs::read_to_string(&found) {
            Ok(text) => text,
            Err(error) => {
                let message = format!("cannot read `{}`: {error}", found.display());
                self.sink
                    .error(Problem::new("scene::unreadable", name.span, message).file_system());
                return Vec::new();
            }
        };
        let Some(root) = self.file(&found, text.into(), file.depth + 1, &file.folders) else {
            return Vec::new();
        };
        if PluginFamily::of_tag(&root.tag.value) == Some(PluginFamily::Scene) {
            root.children
        } else {
            vec![root]
        }
    }

    /// Replaces each `$name`, the longest name that is defined.
    fn substitute(&mut self, text: &str, at: FileSpan) -> String {
        let mut result = String::new();
        let mut rest = text;
        while let Some(dollar) = rest.find('$') {
            result.push_str(&rest[..dollar]);
            rest = &rest[dollar + 1..];
            let best = self
                .parameters
                .iter_mut()
                .filter(|parameter| !parameter.name.is_empty() && rest.starts_with(&parameter.name))
                .max_by_key(|parameter| parameter.name.len());
            match best {
                Some(parameter) => {
                    if let Definition::Caller { used } = &mut parameter.defined {
                        *used = true;
                    }
                    result.push_str(&parameter.value);
                    rest = &rest[parameter.name.len()..];
                }
                None => {
                    let length = rest
                        .find(|c: char| !c.is_alphanumeric() && c != '_')
                        .unwrap_or(rest.len());
                    self.undefined(&rest[..length], at);
                    return text.to_owned();
                }
            }
        }
        result.push_str(rest);
        result
    }

    fn undefined(&self, name: &str, at: FileSpan) {
        let known = self
            .parameters
            .iter()
            .map(|parameter| parameter.name.as_str());
        let suggestion = match similar(name, known) {
            Some(similar) => format!("did you mean `${similar}`?"),
            None => format!(
                "give it a value by `-D {name}=...` or `<default name=\"{name}\" value=\"...\"/>`"
            ),
        };
        self.sink.error(
            Problem::new(
                "scene::undefined_parameter",
                at,
                format!("the parameter `${name}` is not defined"),
            )
            .label("no value for it")
            .help(suggestion),
        );
    }

    fn check_defines(&self) {
        use crate::error::{Diagnostic, LoadErrorKind, Severity};
        let known: Vec<&str> = self
            .parameters
            .iter()
            .filter(|parameter| parameter.defined != Definition::Caller { used: false })
            .map(|parameter| parameter.name.as_str())
            .collect();
        for parameter in &self.parameters {
            if parameter.defined != (Definition::Caller { used: false }) {
                continue;
            }
            let name = &parameter.name;
            let help = match (similar(name, known.iter().copied()), known.is_empty()) {
                (Some(similar), _) => format!("did you mean `{similar}`?"),
                (None, true) => "the scene has no parameters".to_owned(),
                (None, false) => format!("its parameters are {}", known.join(", ")),
            };
            self.sink.report(Diagnostic {
                severity: Severity::Error,
                kind: LoadErrorKind::Scene,
                code: "scene::unknown_parameter",
                message: format!(
                    "`-D {name}={}`: the scene does not use `${name}`",
                    parameter.value
                ),
                location: None,
                help: Some(help),
            });
        }
    }
}

/// The file called `name`; an error or a remark about its spelling goes to the sink.
pub(super) fn find_file(
    sink: &Sink,
    folders: &[PathBuf],
    name: &Text,
    what: &str,
) -> Option<PathBuf> {
    let found = resolve(&name.value, folders).filter(|found| found.path.is_file());
    match found {
        Some(found) => {
            if let Some(remark) = found.remark {
                let message = format!(
                    "the name `{}` {remark}; using `{}`",
                    name.value,
                    found.path.display()
                );
                sink.warn_once(
                    format!("spelling of {}", name.value),
                    Problem::new("scene::file_name", name.span, message),
                );
            }
            Some(found.path)
        }
        None if name.value.contains('$') => None,
        None => {
            let path = folders[0].join(&name.value);
            let help = match crate::resolve::similar_file(&path) {
                Some(similar) => {
                    format!("looked for `{}`; did you mean `{similar}`?", path.display())
                }
                None => format!("looked for `{}`", path.display()),
            };
            sink.error(
                Problem::new(
                    "scene::missing_file",
                    name.span,
                    format!("the {what} `{}` does not exist", name.value),
                )
                .label("not found")
                .help(help),
            );
            None
        }
    }
}

/// `<name` without the bracket.
fn tag_range(node: Node<'_, '_>) -> Range<usize> {
    let start = node.range().start + 1;
    start..start + node.tag_name().name().len()
}

fn span(file: u32, range: Range<usize>, skipped: usize) -> FileSpan {
    FileSpan {
        file,
        start: (range.start + skipped) as u32,
        end: (range.end + skipped) as u32,
    }
}
