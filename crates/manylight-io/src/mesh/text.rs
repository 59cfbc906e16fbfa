//! A cursor over the bytes of a text file: lines, numbers, and errors with their location.

use crate::file_error::Fault;

/// A position in a text file, with line and column.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    position: usize,
    line: u32,
    line_start: usize,
}

/// Description of a number in error messages.
const NUMBER_EXPECTED: &str = "a number";

impl<'a> Cursor<'a> {
    /// A cursor at the start of `bytes`, which is line number `line`.
    pub(super) fn new(bytes: &'a [u8], line: u32) -> Self {
        Cursor {
            bytes,
            position: 0,
            line,
            line_start: 0,
        }
    }

    /// Whether the cursor is at the end of the file.
    #[inline]
    pub(super) fn at_end(&self) -> bool {
        self.position >= self.bytes.len()
    }

    /// Line of the cursor, from 1.
    #[inline]
    pub(super) fn line(&self) -> u32 {
        self.line
    }

    /// Column of the cursor in bytes, from 1.
    #[inline]
    pub(super) fn column(&self) -> u32 {
        (self.position - self.line_start) as u32 + 1
    }

    /// The byte at the cursor; a line feed at the end of the file.
    #[inline]
    pub(super) fn peek(&self) -> u8 {
        self.bytes.get(self.position).copied().unwrap_or(b'\n')
    }

    /// Advances by `count` bytes of the same line.
    #[inline]
    pub(super) fn skip(&mut self, count: usize) {
        self.position += count;
    }

    /// Skips white space within the line.
    #[inline]
    pub(super) fn skip_spaces(&mut self) {
        while matches!(self.peek(), b' ' | b'\t' | b'\r') && !self.at_end() {
            self.position += 1;
        }
    }

    /// Skips white space and line ends.
    pub(super) fn skip_white(&mut self) {
        while !self.at_end() {
            match self.bytes[self.position] {
                b'\n' => self.next_line(),
                b' ' | b'\t' | b'\r' => self.position += 1,
                _ => return,
            }
        }
    }

    /// Moves to the start of the next line.
    #[inline]
    pub(super) fn next_line(&mut self) {
        while self.position < self.bytes.len() && self.bytes[self.position] != b'\n' {
            self.position += 1;
        }
        self.position += 1;
        self.line += 1;
        self.line_start = self.position;
    }

    /// Whether the cursor is at the end of the line.
    #[inline]
    pub(super) fn at_line_end(&self) -> bool {
        self.peek() == b'\n'
    }

    /// The bytes from the cursor to the end of the file.
    #[inline]
    pub(super) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.position.min(self.bytes.len())..]
    }

    /// The text from the cursor to the next white space, at most 40 bytes, for messages.
    pub(super) fn word(&self) -> String {
        const MAX_LENGTH: usize = 40;
        let rest = self.rest();
        let length = rest
            .iter()
            .take(MAX_LENGTH)
            .take_while(|b| !b.is_ascii_whitespace())
            .count();
        String::from_utf8_lossy(&rest[..length]).into_owned()
    }

    /// The error "expected ..., found ..." at the cursor.
    #[cold]
    pub(super) fn expected(&self, expected: &str) -> Fault {
        let found = match (self.word(), self.at_end()) {
            (_, true) => "the end of the file".to_owned(),
            (word, _) if word.is_empty() => "the end of the line".to_owned(),
            (word, _) => format!("'{word}'"),
        };
        Fault::at(
            self.line,
            self.column(),
            format!("expected {expected}, found {found}"),
        )
    }

    /// An error at the cursor.
    #[cold]
    pub(super) fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::at(self.line, self.column(), message)
    }

    /// Reads a number on this line, after white space. The number must be followed by white space
    /// or the end of the file.
    #[inline]
    pub(super) fn number(&mut self) -> Result<f64, Fault> {
        self.skip_spaces();
        let (value, length) =
            parse_number(self.rest()).ok_or_else(|| self.expected(NUMBER_EXPECTED))?;
        let end = self
            .bytes
            .get(self.position + length)
            .copied()
            .unwrap_or(b'\n');
        if !end.is_ascii_whitespace() {
            return Err(self.expected(NUMBER_EXPECTED));
        }
        self.position += length;
        Ok(value)
    }

    /// Reads a decimal integer at the cursor, followed by anything. `None` if there is none or it
    /// overflows.
    #[inline]
    pub(super) fn integer(&mut self) -> Option<i64> {
        let negative = self.peek() == b'-';
        let start = self.position + usize::from(negative);
        let mut at = start;
        let mut value: i64 = 0;
        while let Some(digit) = self
            .bytes
            .get(at)
            .map(|b| b.wrapping_sub(b'0'))
            .filter(|&d| d < 10)
        {
            value = value.checked_mul(10)?.checked_add(i64::from(digit))?;
            at += 1;
        }
        if at == start {
            return None;
        }
        self.position = at;
        Some(if negative { -value } else { value })
    }
}

/// The number at the start of `text` and its length in bytes.
///
/// A number with at most 15 digits and no exponent is the correctly rounded quotient of two exact
/// doubles. Other numbers are parsed by the standard library, which is slower.
#[inline]
pub(crate) fn parse_number(text: &[u8]) -> Option<(f64, usize)> {
    const POWERS: [f64; 23] = [
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
        1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
    ];
    /// Decimal digits of a mantissa that is exact in a double: 10^15 < 2^53.
    const EXACT_DIGITS: usize = 15;
    let negative = text.first() == Some(&b'-');
    let mut at = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let digit_at = |i: usize| {
        text.get(i)
            .map(|b| b.wrapping_sub(b'0'))
            .filter(|&d| d < 10)
    };
    let mut mantissa: u64 = 0;
    let whole_start = at;
    while let Some(d) = digit_at(at) {
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(d));
        at += 1;
    }
    let mut digits = at - whole_start;
    let mut exponent = 0_i32;
    if text.get(at) == Some(&b'.') {
        at += 1;
        let fraction_start = at;
        while let Some(d) = digit_at(at) {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(d));
            at += 1;
        }
        digits += at - fraction_start;
        exponent = -((at - fraction_start) as i32);
    }
    if digits == 0 || digits > EXACT_DIGITS || matches!(text.get(at), Some(b'e' | b'E')) {
        return parse_any_number(text);
    }
    let magnitude = mantissa as f64 / POWERS[exponent.unsigned_abs() as usize];
    Some((if negative { -magnitude } else { magnitude }, at))
}

/// Like [`parse_number`], for exponents, more digits, `inf` and `nan`.
#[cold]
fn parse_any_number(text: &[u8]) -> Option<(f64, usize)> {
    let is_part = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'-' | b'+');
    let length = text.iter().take_while(|b| is_part(b)).count();
    let word = std::str::from_utf8(&text[..length]).ok()?;
    Some((word.parse().ok()?, length))
}
