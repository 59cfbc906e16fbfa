//! The place of a value in JSON text.

use serde::de::IgnoredAny;
use serde_json::Deserializer;
use std::ops::Range;

/// The bytes of the value at the JSON pointer `path` (RFC 6901, without escapes) in `text`, which
/// is valid JSON. If there is no such value, those of the innermost value on the path. Only the
/// first byte of objects and arrays is given, so that excerpts stay short.
pub(super) fn locate(text: &str, path: &str) -> Range<usize> {
    let mut scanner = Scanner {
        bytes: text.as_bytes(),
        at: 0,
    };
    scanner.skip_space();
    for name in path.split('/').skip(1) {
        let start = scanner.at;
        if !scanner.enter(name) {
            scanner.at = start;
            break;
        }
    }
    let start = scanner.at;
    match scanner.peek() {
        b'{' | b'[' => start..start + 1,
        _ => {
            scanner.skip_value();
            start..scanner.at
        }
    }
}

struct Scanner<'t> {
    bytes: &'t [u8],
    at: usize,
}

impl Scanner<'_> {
    /// The next byte; 0 at the end.
    fn peek(&self) -> u8 {
        self.bytes.get(self.at).copied().unwrap_or(0)
    }

    /// Skips white space and separators.
    fn skip_space(&mut self) {
        while matches!(
            self.peek(),
            b' ' | b'\n' | b'\r' | b'\t' | b',' | b':' | 0xEF | 0xBB | 0xBF
        ) {
            self.at += 1;
        }
    }

    /// Moves to the member or element `name` of the value here.
    fn enter(&mut self, name: &str) -> bool {
        match self.peek() {
            b'{' => self.enter_member(name),
            b'[' => name.parse().is_ok_and(|index| self.enter_element(index)),
            _ => false,
        }
    }

    fn enter_member(&mut self, name: &str) -> bool {
        self.at += 1;
        loop {
            self.skip_space();
            if self.peek() != b'"' {
                return false;
            }
            let start = self.at + 1;
            self.skip_value();
            let is_wanted = &self.bytes[start..self.at - 1] == name.as_bytes();
            self.skip_space();
            if is_wanted {
                return true;
            }
            self.skip_value();
        }
    }

    fn enter_element(&mut self, index: usize) -> bool {
        self.at += 1;
        for _ in 0..index {
            self.skip_space();
            if matches!(self.peek(), b']' | 0) {
                return false;
            }
            self.skip_value();
        }
        self.skip_space();
        self.peek() != b']'
    }

    /// Skips the value here, or the name of a member.
    fn skip_value(&mut self) {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let mut values = Deserializer::from_slice(rest).into_iter::<IgnoredAny>();
        values.next();
        self.at += values.byte_offset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_by_their_path() {
        let text = r#"{ "a": [1, {"b\"": "x,y", "c": -2.5e3}, true], "d": {} , "e":"end" }"#;
        let found = |path: &str| &text[locate(text, path)];
        assert_eq!(found("/a/0"), "1");
        assert_eq!(found("/a/1/c"), "-2.5e3");
        assert_eq!(found("/a/2"), "true");
        assert_eq!(found("/e"), "\"end\"");
        assert_eq!(
            locate(text, "/d"),
            text.find("{} ").map(|i| i..i + 1).unwrap()
        );
        // The innermost value that exists.
        assert_eq!(found("/a/7"), "[");
        assert_eq!(found("/a/0/x"), "1");
        assert_eq!(found("/z"), "{");
        assert_eq!(found(""), "{");
    }
}
