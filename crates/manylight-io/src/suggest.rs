//! Suggestions for misspelled names.

/// The name in `known` most similar to `found`, if one is similar enough to suggest. Case is
/// ignored.
pub(crate) fn similar<'a>(
    found: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    /// Least Jaro-Winkler similarity of a suggestion. A lower value suggests unrelated names.
    const MIN_SIMILARITY: f64 = 0.75;
    let lower = found.to_lowercase();
    known
        .into_iter()
        .map(|name| (strsim::jaro_winkler(&lower, &name.to_lowercase()), name))
        .filter(|(score, _)| *score >= MIN_SIMILARITY)
        .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(a.1)))
        .map(|(_, name)| name)
}

/// The question whether a similar name is meant, if there is one.
pub(crate) fn did_you_mean<'a>(
    found: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    similar(found, known).map(|similar| format!("did you mean `{similar}`?"))
}

/// The question whether a similar name is meant, or else all names.
pub(crate) fn one_of<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    did_you_mean(found, known.iter().copied())
        .unwrap_or_else(|| format!("expected one of {}", known.join(", ")))
}

/// The question whether a similar name is meant, if there is one, and `list`, which gives all.
pub(crate) fn with_list<'a>(
    found: &str,
    known: impl IntoIterator<Item = &'a str>,
    list: String,
) -> String {
    match did_you_mean(found, known) {
        Some(question) => format!("{question} {list}"),
        None => list,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_similar_names_are_suggested() {
        let known = ["diffuse", "dielectric", "roughconductor"];
        assert_eq!(similar("difuse", known), Some("diffuse"));
        assert_eq!(similar("Dielektric", known), Some("dielectric"));
        assert_eq!(similar("xyz", known), None);
    }
}
