//! From text to tokens: words, quoted strings, numbers and brackets. `#` starts a comment.

use super::super::sink::{FileSpan, Problem};
use crate::mesh::parse_number;
use std::sync::Arc;

/// The kind of a token.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TokenKind {
    /// A directive, `true` or `false`.
    Word,
    /// A string in double quotes.
    Quoted,
    /// A finite number.
    Number(f64),
    /// `[`.
    Open,
    /// `]`.
    Close,
}

/// A token with its location.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token {
    pub(super) kind: TokenKind,
    pub(super) span: FileSpan,
}

/// Reads the tokens of one file.
pub(super) struct Lexer {
    text: Arc<str>,
    file: u32,
    position: usize,
}

impl Lexer {
    /// Reads `text`, which is the content of file number `file` and shorter than 4 GiB.
    pub(super) fn new(text: Arc<str>, file: u32) -> Self {
        Lexer {
            text,
            file,
            position: 0,
        }
    }

    /// The span of the bytes from `start` to `end`.
    fn span(&self, start: usize, end: usize) -> FileSpan {
        FileSpan {
            file: self.file,
            start: start as u32,
            end: end as u32,
        }
    }

    /// The place where the file ends.
    pub(super) fn end(&self) -> FileSpan {
        self.span(self.text.len(), self.text.len())
    }

    /// The text of a span of this file.
    pub(super) fn text(&self, span: FileSpan) -> &str {
        &self.text[span.start as usize..span.end as usize]
    }

    /// The content of a quoted string, with `\"` and `\\` replaced.
    pub(super) fn unquoted(&self, span: FileSpan) -> String {
        let text = self.text(span);
        let inner = &text[1..text.len() - 1];
        if inner.contains('\\') {
            inner.replace("\\\"", "\"").replace("\\\\", "\\")
        } else {
            inner.to_owned()
        }
    }

    /// The next token; `None` at the end of the file.
    pub(super) fn next(&mut self) -> Result<Option<Token>, Box<Problem>> {
        self.skip_blank();
        let bytes = self.text.as_bytes();
        let start = self.position;
        let Some(&first) = bytes.get(start) else {
            return Ok(None);
        };
        let (kind, end) = match first {
            b'[' => (TokenKind::Open, start + 1),
            b']' => (TokenKind::Close, start + 1),
            b'"' => (TokenKind::Quoted, self.end_of_string(start)?),
            b'0'..=b'9' | b'-' | b'+' | b'.' => self.number(start)?,
            _ => (TokenKind::Word, self.end_of_word(start)),
        };
        self.position = end;
        let span = self.span(start, end);
        Ok(Some(Token { kind, span }))
    }

    /// Skips white space and comments.
    fn skip_blank(&mut self) {
        let bytes = self.text.as_bytes();
        while let Some(byte) = bytes.get(self.position) {
            match byte {
                b'#' => {
                    let rest = &bytes[self.position..];
                    let line = rest.iter().position(|&b| b == b'\n' || b == b'\r');
                    self.position += line.unwrap_or(rest.len());
                }
                b' ' | b'\t' | b'\n' | b'\r' | b'\x0B' | b'\x0C' => self.position += 1,
                // A byte order mark.
                0xEF if self.position == 0 && bytes.starts_with(b"\xEF\xBB\xBF") => {
                    self.position = 3
                }
                _ => return,
            }
        }
    }

    /// The end of the string that starts at `start`. Strings do not span lines.
    fn end_of_string(&self, start: usize) -> Result<usize, Box<Problem>> {
        let bytes = self.text.as_bytes();
        let mut at = start + 1;
        while let Some(byte) = bytes.get(at) {
            match byte {
                b'"' => return Ok(at + 1),
                b'\n' => break,
                b'\\' if matches!(bytes.get(at + 1), Some(b'"' | b'\\')) => at += 2,
                _ => at += 1,
            }
        }
        let found = if at == bytes.len() {
            "the end of the file"
        } else {
            "the end of the line"
        };
        let message = format!("found {found} in a string, expected `\"`");
        let problem = Problem::new("scene::syntax", self.span(start, at), message);
        Err(Box::new(problem.label("the string starts here")))
    }

    fn end_of_word(&self, start: usize) -> usize {
        let rest = &self.text[start..];
        let is_end = |c: char| c.is_whitespace() || matches!(c, '[' | ']' | '"' | '#');
        start + rest.find(is_end).unwrap_or(rest.len())
    }

    #[inline]
    fn number(&self, start: usize) -> Result<(TokenKind, usize), Box<Problem>> {
        let bytes = self.text.as_bytes();
        if let Some((value, length)) = parse_number(&bytes[start..]) {
            let end = start + length;
            let ends = bytes
                .get(end)
                .is_none_or(|&b| b.is_ascii_whitespace() || matches!(b, b'[' | b']' | b'"' | b'#'));
            // Values are stored in single precision.
            if ends && (value as f32).is_finite() {
                return Ok((TokenKind::Number(value), end));
            }
        }
        let end = self.end_of_word(start).max(start + 1);
        let span = self.span(start, end);
        let message = format!("found `{}`, expected a finite number", self.text(span));
        Err(Box::new(Problem::new("scene::syntax", span, message)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(text: &str) -> Vec<TokenKind> {
        let mut lexer = Lexer::new(text.into(), 0);
        std::iter::from_fn(|| lexer.next().unwrap())
            .map(|token| token.kind)
            .collect()
    }

    #[test]
    fn tokens_need_no_space_around_brackets_and_strings() {
        use TokenKind::{Close, Number, Open, Quoted, Word};
        assert_eq!(
            kinds("\u{feff}Shape\"a b\"[1 -.5e1]# [ \"\nEnd"),
            [Word, Quoted, Open, Number(1.0), Number(-5.0), Close, Word]
        );
    }

    #[test]
    fn unfinished_strings_and_bad_numbers_are_errors() {
        for text in ["\"abc", "\"a\nb\"", "1e40", "-", "1.2.3", "+nan", "5x"] {
            assert!(Lexer::new(text.into(), 0).next().is_err(), "{text}");
        }
    }

    #[test]
    fn quotes_and_backslashes_may_be_escaped() {
        let mut lexer = Lexer::new(r#""a\"b\\c\d""#.into(), 0);
        let token = lexer.next().unwrap().unwrap();
        assert_eq!(lexer.unquoted(token.span), r#"a"b\c\d"#);
    }
}
