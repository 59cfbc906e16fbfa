//! A page before it becomes Markdown or HTML.

mod table;

pub(crate) use table::{Cell, Table};

use serde::Serialize;

/// A part of a page.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub(crate) enum Block {
    /// With its level, 1 for the title.
    Heading { level: usize, text: String },
    /// For who edits the page.
    Comment { text: String },
    /// Text with `code` and **bold** words.
    Paragraph { text: String },
    /// As many paragraphs with a dot each.
    List { items: Vec<String> },
    /// Figures.
    Table(Table),
    /// Lines; not in Markdown.
    Plot(Plot),
}

/// Lines over two logarithmic axes.
#[derive(Debug, Serialize)]
pub(crate) struct Plot {
    pub(crate) title: String,
    pub(crate) x: String,
    pub(crate) y: String,
    pub(crate) lines: Vec<Line>,
}

/// One of them.
#[derive(Debug, Serialize)]
pub(crate) struct Line {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
}

/// A page.
#[derive(Debug, Default)]
pub(crate) struct Document {
    pub(crate) blocks: Vec<Block>,
}

impl Document {
    pub(crate) fn heading(&mut self, level: usize, text: impl Into<String>) {
        let text = text.into();
        self.blocks.push(Block::Heading { level, text });
    }

    pub(crate) fn comment(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Comment { text: text.into() });
    }

    /// Nothing if the text is empty.
    pub(crate) fn paragraph(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !text.is_empty() {
            self.blocks.push(Block::Paragraph { text });
        }
    }

    /// Nothing without items.
    pub(crate) fn list(&mut self, items: Vec<String>) {
        if !items.is_empty() {
            self.blocks.push(Block::List { items });
        }
    }

    /// Nothing without rows.
    pub(crate) fn table(&mut self, table: Table) {
        if !table.is_empty() {
            self.blocks.push(Block::Table(table));
        }
    }

    /// Nothing without points.
    pub(crate) fn plot(&mut self, plot: Plot) {
        if plot.lines.iter().any(|line| !line.points.is_empty()) {
            self.blocks.push(Block::Plot(plot));
        }
    }

    /// Parts are apart by an empty line; there is no other at the end.
    pub(crate) fn markdown(&self) -> String {
        let parts = self.blocks.iter().filter_map(|block| match block {
            Block::Heading { level, text } => Some(format!("{} {text}\n", "#".repeat(*level))),
            Block::Comment { text } => Some(format!("<!-- {text} -->\n")),
            Block::Paragraph { text } => Some(format!("{text}\n")),
            Block::List { items } => Some(items.iter().map(|item| format!("* {item}\n")).collect()),
            Block::Table(table) => Some(table.markdown()),
            Block::Plot(_) => None,
        });
        parts.collect::<Vec<String>>().join("\n")
    }
}
