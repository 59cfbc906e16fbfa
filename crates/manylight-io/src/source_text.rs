//! Texts of scene files: lines and columns, and excerpts for messages.

use crate::shown::{masked, shown_path};
use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};
use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// Most bytes that an excerpt shows of a line on each side of a place. Longer lines are written by
/// programs.
const MARGIN: usize = 200;
/// Most bytes that a label marks.
const LONGEST_LABEL: usize = 200;

/// The text of a file, with its name in messages.
pub(crate) struct SourceText {
    name: String,
    text: Arc<str>,
    /// The text for a terminal, with marks in place of some characters, if it differs.
    masked: OnceLock<Option<String>>,
    /// Offsets of the first bytes of the lines. Computed once, because a file may have many
    /// problems.
    line_starts: OnceLock<Vec<usize>>,
}

impl SourceText {
    pub(crate) fn new(path: &Path, text: Arc<str>) -> Self {
        SourceText {
            name: shown_path(path),
            text,
            masked: OnceLock::new(),
            line_starts: OnceLock::new(),
        }
    }

    fn line_starts(&self) -> &[usize] {
        self.line_starts.get_or_init(|| {
            let ends = self.text.bytes().enumerate().filter(|(_, b)| *b == b'\n');
            std::iter::once(0).chain(ends.map(|(i, _)| i + 1)).collect()
        })
    }

    /// The text as a terminal may show it, with the same places.
    fn shown(&self) -> &str {
        let masked = self.masked.get_or_init(|| match masked(&self.text) {
            Cow::Borrowed(_) => None,
            Cow::Owned(text) => Some(text),
        });
        masked.as_deref().unwrap_or(&self.text)
    }

    /// Index of the line of a byte, from 0.
    fn line_index(&self, offset: usize) -> usize {
        self.line_starts().partition_point(|start| *start <= offset) - 1
    }

    /// The offset of the first byte of a line; the length of the text after the last line.
    fn line_start(&self, index: usize) -> usize {
        let starts = self.line_starts();
        starts.get(index).copied().unwrap_or(self.text.len())
    }

    /// Line and column of a byte, both from 1. Columns are characters; a byte order mark has none.
    pub(crate) fn line_and_column(&self, offset: usize) -> (u32, u32) {
        let offset = self.text.floor_char_boundary(offset);
        let line = self.line_index(offset);
        let before = &self.text[self.line_start(line)..offset];
        let visible = before.trim_start_matches('\u{feff}');
        (line as u32 + 1, visible.chars().count() as u32 + 1)
    }

    /// `span` within the text and between characters, and not longer than an excerpt.
    pub(crate) fn label_span(&self, span: Range<usize>) -> Range<usize> {
        let start = self.text.floor_char_boundary(span.start);
        let end = span.end.min(start + LONGEST_LABEL);
        start..self.text.floor_char_boundary(end).max(start)
    }
}

impl SourceCode for SourceText {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let (start, end) = (span.offset(), span.offset() + span.len());
        if end > self.text.len() {
            return Err(MietteError::OutOfBounds);
        }
        let first = self.line_index(start).saturating_sub(lines_before);
        let last = self.line_index(end).saturating_add(lines_after);
        // Without lines before it, an excerpt begins at the place: messages name its column.
        let from = match lines_before {
            0 => start,
            _ => self.line_start(first).max(start.saturating_sub(MARGIN)),
        };
        let to = self
            .line_start(last.saturating_add(1))
            .min(end.saturating_add(MARGIN));
        let from = self.text.floor_char_boundary(from);
        let to = self.text.ceil_char_boundary(to);
        let (line, column) = self.line_and_column(from);
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            &self.shown().as_bytes()[from..to],
            (from, to - from).into(),
            line as usize - 1,
            column as usize - 1,
            self.line_index(to) + 2 - line as usize,
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(text: &str) -> SourceText {
        SourceText::new("f".as_ref(), text.into())
    }

    #[test]
    fn columns_are_characters_and_lines_end_with_line_feeds() {
        let source = source("\u{feff}aä\nb\n");
        let places = [3, 4, 6, 7, 8, 9, 100].map(|offset| source.line_and_column(offset));
        assert_eq!(
            places,
            [(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (3, 1), (3, 1)]
        );
    }

    #[test]
    fn excerpts_of_long_lines_are_short() {
        let source = source(&format!(
            "a\n{}x{}\nb\n",
            "ä".repeat(5000),
            "ö".repeat(5000)
        ));
        let contents = source.read_span(&(10_002, 1).into(), 1, 1).unwrap();
        let text = std::str::from_utf8(contents.data()).unwrap();
        assert_eq!(text, format!("{}x{}", "ä".repeat(100), "ö".repeat(100)));
        assert_eq!((contents.line(), contents.column()), (1, 4900));
        assert!(source.read_span(&(30_000, 1).into(), 1, 1).is_err());
        assert_eq!(source.label_span(3..9000), 2..202);
    }

    #[test]
    fn excerpts_hide_what_a_terminal_obeys() {
        let source = source("<a b=\"\u{1b}[31m\u{9b}\"/>");
        let contents = source.read_span(&(3, 1).into(), 1, 0).unwrap();
        assert_eq!(contents.data(), "<a b=\"?[31m\u{b7}\"/>".as_bytes());
    }

    #[test]
    fn an_excerpt_without_lines_before_begins_at_its_place() {
        let source = source("\u{feff}aä\nbcd\n");
        for (offset, line, column) in [(3, 0, 0), (4, 0, 1), (9, 1, 2)] {
            let contents = source.read_span(&(offset, 1).into(), 0, 0).unwrap();
            assert_eq!((contents.line(), contents.column()), (line, column));
        }
    }

    #[test]
    fn excerpts_of_short_lines_are_whole() {
        let source = source("a\nb\nccc\nd\ne");
        let contents = source.read_span(&(5, 1).into(), 1, 1).unwrap();
        assert_eq!(contents.data(), b"b\nccc\nd\n");
        assert_eq!((contents.line(), contents.column()), (1, 0));
    }
}
