//! The parts of a page, in order.

use super::table::DocumentTable;
use serde::Serialize;

/// A part of a page. In text, \`code\` and \*\*bold\*\* are marked as in Markdown.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum DocumentPart {
    /// A heading.
    Heading {
        /// 1 for the title of the page.
        level: usize,
        /// Its words.
        text: String,
    },
    /// A comment for editors of the Markdown file; it is not displayed.
    Comment {
        /// Its words.
        text: String,
    },
    /// A paragraph.
    Paragraph {
        /// Its words.
        text: String,
    },
    /// A list with bullets.
    List {
        /// One text per bullet.
        items: Vec<String>,
    },
    /// A table.
    Table(DocumentTable),
    /// A diagram; Markdown leaves it out.
    Plot(Plot),
}

/// A line diagram with two logarithmic axes.
#[derive(Debug, Serialize)]
pub struct Plot {
    /// Text above the diagram.
    pub title: String,
    /// Name of the horizontal axis.
    pub x: String,
    /// Name of the vertical axis.
    pub y: String,
    /// The lines; points that are not positive are left out.
    pub lines: Vec<PlotLine>,
}

/// One line of a [`Plot`].
#[derive(Debug, Serialize)]
pub struct PlotLine {
    /// Name in the legend.
    pub name: String,
    /// Points (x, y) in drawing order.
    pub points: Vec<(f64, f64)>,
}

/// A page.
#[derive(Debug, Default)]
pub struct Document {
    /// The parts from top to bottom.
    pub parts: Vec<DocumentPart>,
}

impl Document {
    /// Appends a heading of level 1 to 6.
    pub fn heading(&mut self, level: usize, text: impl Into<String>) {
        let text = text.into();
        self.parts.push(DocumentPart::Heading { level, text });
    }

    /// Appends a comment.
    pub fn comment(&mut self, text: impl Into<String>) {
        self.parts.push(DocumentPart::Comment { text: text.into() });
    }

    /// Appends a paragraph, unless the text is empty.
    pub fn paragraph(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !text.is_empty() {
            self.parts.push(DocumentPart::Paragraph { text });
        }
    }

    /// Appends a list, unless it has no items.
    pub fn list(&mut self, items: Vec<String>) {
        if !items.is_empty() {
            self.parts.push(DocumentPart::List { items });
        }
    }

    /// Appends a table, unless it has no rows.
    pub fn table(&mut self, table: DocumentTable) {
        if !table.is_empty() {
            self.parts.push(DocumentPart::Table(table));
        }
    }

    /// Appends a plot, unless it has no points.
    pub fn plot(&mut self, plot: Plot) {
        if plot.lines.iter().any(|line| !line.points.is_empty()) {
            self.parts.push(DocumentPart::Plot(plot));
        }
    }

    /// The page as Markdown. Parts are separated by an empty line; the text ends with one line end.
    pub fn markdown(&self) -> String {
        let parts = self.parts.iter().filter_map(|part| match part {
            DocumentPart::Heading { level, text } => {
                Some(format!("{} {text}\n", "#".repeat(*level)))
            }
            DocumentPart::Comment { text } => Some(format!("<!-- {text} -->\n")),
            DocumentPart::Paragraph { text } => Some(format!("{text}\n")),
            DocumentPart::List { items } => {
                Some(items.iter().map(|item| format!("* {item}\n")).collect())
            }
            DocumentPart::Table(table) => Some(table.markdown()),
            DocumentPart::Plot(_) => None,
        });
        parts.collect::<Vec<String>>().join("\n")
    }
}
