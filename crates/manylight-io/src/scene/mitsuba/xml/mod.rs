//! Parsing of XML text into a tree of [`XmlElement`]s with source spans. `$name` parameters are
//! replaced by their values, and `<include>` by the content of the included file.

mod element;
mod parameters;

pub(super) use element::{Dialect, XmlElement};

use super::super::files::{find_file, identity};
use super::super::growth::Expansion;
use super::super::sink::{FileSpan, Problem, Sink, Text};
use super::family::PluginFamily;
use crate::read::read_regular;
use crate::resolve::resolve;
use element::Attribute;
use parameters::Parameters;
use roxmltree::{Document, Node, ParsingOptions};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest nesting of included files.
const MAX_INCLUDE_DEPTH: usize = 15;

/// Largest nesting of elements: far above any scene, and few enough stack frames for recursion.
const MAX_NESTING: usize = 100;

/// The file that is being parsed.
struct FileContext {
    /// Index of the file in the [`Sink`].
    index: u32,
    /// Bytes of the byte order mark, which the offsets of the XML parser exclude.
    bom_length: usize,
    dialect: Dialect,
    folders: Arc<[PathBuf]>,
    /// Number of files that include this one.
    depth: usize,
}

impl FileContext {
    /// The location of a range of offsets of the XML parser.
    fn span(&self, range: Range<usize>) -> FileSpan {
        FileSpan {
            file: self.index,
            start: (range.start + self.bom_length) as u32,
            end: (range.end + self.bom_length) as u32,
        }
    }
}

/// Parses `text`, the content of `path`, and all included files. `None` if `text` is not
/// well-formed XML.
pub(super) fn read_tree(
    path: &Path,
    text: Arc<str>,
    defines: &[(String, String)],
    sink: &Sink,
) -> Option<XmlElement> {
    let mut reader = TreeReader {
        sink,
        parameters: Parameters::from_defines(defines),
        nesting: 0,
        expansion: Expansion::default(),
        open_files: vec![identity(path)],
    };
    // The first file is below any bound.
    let _ = reader.expansion.include(&identity(path), text.len());
    // After the folder of the scene, Mitsuba searches the working directory.
    let root = reader.file(path, text, 0, &[PathBuf::new()])?;
    reader.parameters.report_unused(sink);
    Some(root)
}

struct TreeReader<'a> {
    sink: &'a Sink,
    parameters: Parameters,
    /// Number of elements around the current one.
    nesting: usize,
    expansion: Expansion,
    /// Files that are being read, without symbolic links.
    open_files: Vec<PathBuf>,
}

impl TreeReader<'_> {
    /// The root element of a file. `outer` is the search path of the including file, and `depth`
    /// the nesting of includes.
    fn file(
        &mut self,
        path: &Path,
        text: Arc<str>,
        depth: usize,
        outer: &[PathBuf],
    ) -> Option<XmlElement> {
        let index = self.sink.add_file(path, Arc::clone(&text));
        let bom_length = if text.starts_with('\u{feff}') {
            '\u{feff}'.len_utf8()
        } else {
            0
        };
        let options = ParsingOptions {
            allow_dtd: true,
            ..ParsingOptions::default()
        };
        let document = match Document::parse_with_options(&text[bom_length..], options) {
            Ok(document) => document,
            Err(error) => {
                self.malformed(index, &text, &error);
                return None;
            }
        };
        let mut folders = vec![path.parent().map_or_else(PathBuf::new, Path::to_owned)];
        let own = folders[0].clone();
        folders.extend(outer.iter().filter(|folder| **folder != own).cloned());
        let root = document.root_element();
        let mut file = FileContext {
            index,
            bom_length,
            dialect: Dialect::V3,
            folders: folders.into(),
            depth,
        };
        file.dialect = self.dialect(root, &file);
        self.element(root, &mut file)
    }

    /// Reports that `text` is not well-formed.
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
        let message = format!("malformed XML: {message}");
        let problem = Problem::new("scene::malformed_xml", span, message);
        self.sink.error(problem.label("here"));
    }

    fn dialect(&self, root: Node<'_, '_>, file: &FileContext) -> Dialect {
        let tag = file.span(tag_range(root));
        let Some(version) = root.attribute_node("version") else {
            let name = root.tag_name().name();
            let message = format!("<{name}> needs the attribute `version`");
            let problem = Problem::new("scene::missing_version", tag, message);
            let help = "expected for example `<scene version=\"3.0.0\">`";
            self.sink.error(problem.help(help));
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
                let at = file.span(version.range_value());
                let found = version.value();
                let message = format!("found the version `{found}`, expected a number");
                let problem = Problem::new("scene::bad_version", at, message);
                self.sink
                    .error(problem.help("expected for example `3.0.0`"));
                Dialect::V3
            }
        }
    }

    /// The element with its children. `None` for `<default>` and `<path>`, which only affect
    /// parsing, and for invalid elements.
    fn element(&mut self, node: Node<'_, '_>, file: &mut FileContext) -> Option<XmlElement> {
        let mut element = self.start(node, file);
        match element.tag.value.as_str() {
            "default" => {
                self.add_default(&element);
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
                .error_at("scene::too_deep", element.tag.span, message);
            return None;
        }
        self.nesting += 1;
        element.children = self.children(node, file);
        self.nesting -= 1;
        Some(element)
    }

    /// The element without its children.
    fn start(&mut self, node: Node<'_, '_>, file: &FileContext) -> XmlElement {
        let tag = Text {
            value: node.tag_name().name().to_owned(),
            span: file.span(tag_range(node)),
        };
        let attributes = node
            .attributes()
            .map(|attribute| {
                let span = file.span(attribute.range_value());
                Attribute {
                    name: Text {
                        value: attribute.name().to_owned(),
                        span: file.span(attribute.range_qname()),
                    },
                    value: Text {
                        value: self.substituted(attribute.value(), span),
                        span,
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

    /// An attribute with the values of its parameters.
    fn substituted(&mut self, text: &str, span: FileSpan) -> String {
        if !text.contains('$') {
            return text.to_owned();
        }
        let value = self.parameters.substitute(text, span, self.sink);
        match self.expansion.substitute(value.len()) {
            Ok(()) => value,
            Err(exceeded) => {
                exceeded.report(self.sink, "scene::too_many_includes", span);
                text.to_owned()
            }
        }
    }

    fn children(&mut self, node: Node<'_, '_>, file: &mut FileContext) -> Vec<XmlElement> {
        let mut children = Vec::new();
        for child in node.children() {
            if child.is_element() && child.tag_name().name() == "include" {
                let include = self.element(child, file);
                children.extend(
                    include
                        .into_iter()
                        .flat_map(|include| self.include(&include, file)),
                );
            } else if child.is_element() {
                children.extend(self.element(child, file));
            } else if child.is_text() && child.text().is_some_and(|text| !text.trim().is_empty()) {
                self.report_text(child, file);
            }
        }
        children
    }

    fn report_text(&self, node: Node<'_, '_>, file: &FileContext) {
        let text = node.text().unwrap_or("");
        let lead = text.len() - text.trim_start().len();
        let range = node.range();
        let start = range.start + lead;
        let at = file.span(start..(start + text.trim().len()).min(range.end));
        let problem = Problem::new("scene::stray_text", at, "unexpected text between elements");
        let help = "expected values in attributes, and comments in <!-- ... -->";
        self.sink.error(problem.help(help));
    }

    /// `<default>`: defines a parameter.
    fn add_default(&mut self, element: &XmlElement) {
        let name = element.required(self.sink, "name");
        let value = element.required(self.sink, "value");
        if let (Some(name), Some(value)) = (name, value) {
            self.parameters.add_default(&name.value, &value.value);
        }
    }

    /// `<path>`: adds a folder to the search path of the file.
    fn search_path(&mut self, element: &XmlElement, file: &mut FileContext) {
        let Some(value) = element.required(self.sink, "value") else {
            return;
        };
        match resolve(&value.value, &file.folders) {
            Some(found) => {
                let folders = std::iter::once(found.path).chain(file.folders.iter().cloned());
                file.folders = folders.collect();
            }
            None => {
                let message = format!("the folder `{}` does not exist", value.value);
                let problem = Problem::new("scene::missing_file", value.span, message);
                self.sink.error(problem.label("not found"));
            }
        }
    }

    /// The content of the file that an `<include>` names: the children of a scene, else the root
    /// element.
    fn include(&mut self, element: &XmlElement, file: &FileContext) -> Vec<XmlElement> {
        // Further errors would not be listed.
        if self.sink.is_full() {
            return Vec::new();
        }
        let Some(name) = element.required(self.sink, "filename") else {
            return Vec::new();
        };
        if file.depth >= MAX_INCLUDE_DEPTH {
            let message = format!("included files are nested more than {MAX_INCLUDE_DEPTH} deep");
            self.sink
                .error_at("scene::include_depth", name.span, message);
            return Vec::new();
        }
        let Some(found) = find_file(self.sink, &file.folders, name, "included file") else {
            return Vec::new();
        };
        let identity = identity(&found);
        if self.open_files.contains(&identity) {
            let message = format!("the file `{}` includes itself", name.value);
            self.sink
                .error_at("scene::circular_reference", name.span, message);
            return Vec::new();
        }
        let text = match read_text(&found) {
            Ok(text) => {
                self.sink.note_read(&found);
                text
            }
            Err(error) => {
                let message = format!("cannot read `{}`: {error}", found.display());
                self.sink
                    .error(Problem::new("scene::unreadable", name.span, message).file_system());
                return Vec::new();
            }
        };
        if let Err(exceeded) = self.expansion.include(&identity, text.len()) {
            exceeded.report(self.sink, "scene::too_many_includes", name.span);
            return Vec::new();
        }
        self.open_files.push(identity);
        let root = self.file(&found, text.into(), file.depth + 1, &file.folders);
        self.open_files.pop();
        let Some(root) = root else {
            return Vec::new();
        };
        if PluginFamily::of_tag(&root.tag.value) == Some(PluginFamily::Scene) {
            root.children
        } else {
            vec![root]
        }
    }
}

/// The content of an included file.
fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read_regular(path)?)
        .map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error.utf8_error()))
}

/// The range of the name of the start tag.
fn tag_range(node: Node<'_, '_>) -> Range<usize> {
    let start = node.range().start + 1;
    start..start + node.tag_name().name().len()
}
