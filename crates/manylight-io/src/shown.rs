//! Text from files in messages, without characters that a terminal obeys: colors, titles, moved
//! cursors, reordered letters.

use std::borrow::Cow;
use std::path::Path;

/// Whether a terminal or a text editor obeys `c` instead of showing it: control characters, and
/// those that change the direction of text.
fn is_obeyed(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// `text` with escapes such as `\u{1b}` in place of characters that a terminal obeys. Lines and
/// tabs stay.
pub fn clean_text(text: &str) -> Cow<'_, str> {
    escaped(text, |c| is_obeyed(c) && !matches!(c, '\n' | '\t'))
}

/// `path` for people, on one line: with escapes in place of characters that a terminal obeys, and
/// `\u{fffd}` in place of bytes that are not UTF-8.
pub fn shown_path(path: &Path) -> String {
    escaped(&path.to_string_lossy(), is_obeyed).into_owned()
}

fn escaped(text: &str, is_hidden: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_hidden) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        match c {
            '\n' if is_hidden(c) => shown.push_str("\\n"),
            c if is_hidden(c) => shown.extend(c.escape_unicode()),
            c => shown.push(c),
        }
    }
    shown.into()
}

/// `text` with the same number of bytes and characters, and a mark in place of each character that
/// a terminal obeys, but line ends and tabs. Places in the text stay valid.
pub(crate) fn masked(text: &str) -> Cow<'_, str> {
    let is_hidden = |c| is_obeyed(c) && !matches!(c, '\n' | '\r' | '\t');
    if !text.contains(is_hidden) {
        return text.into();
    }
    let mark = |c: char| match c {
        c if !is_hidden(c) => c,
        c if c.len_utf8() == 1 => '?',
        c if c.len_utf8() == 2 => '\u{b7}',
        _ => char::REPLACEMENT_CHARACTER,
    };
    text.chars().map(mark).collect::<String>().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a\u{1b}[31m\u{9b}\u{202e}\tb\nc\u{7f}ä";

    #[test]
    fn texts_have_escapes() {
        assert_eq!(
            clean_text(TEXT),
            "a\\u{1b}[31m\\u{9b}\\u{202e}\tb\nc\\u{7f}ä"
        );
        assert_eq!(shown_path(Path::new("a\nb\tä")), "a\\nb\\u{9}ä");
    }

    #[test]
    fn masks_keep_places() {
        let masked = masked(TEXT);
        assert_eq!(masked, "a?[31m\u{b7}\u{fffd}\tb\nc?ä");
        let starts = |text: &str| text.char_indices().map(|(i, _)| i).collect::<Vec<_>>();
        assert_eq!(starts(&masked), starts(TEXT));
    }
}
