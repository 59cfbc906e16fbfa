//! The comment at the head of a scene file.

use crate::scene::About;

/// Longest line in bytes, without indentation.
const WIDTH: usize = 118;

/// Title and description as lines.
pub(crate) fn lines(about: &About) -> Vec<String> {
    let mut lines = vec![format!("{}.", about.title)];
    for paragraph in &about.text {
        lines.push(String::new());
        lines.extend(wrapped(paragraph, WIDTH));
    }
    lines
}

/// Breaks a paragraph into lines of at most `width` bytes.
fn wrapped(paragraph: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in paragraph.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= width => *line += &format!(" {word}"),
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_short() {
        let lines = wrapped(&"word ".repeat(60), WIDTH);
        assert!(lines.len() > 2 && lines.iter().all(|line| line.len() <= WIDTH));
    }
}
