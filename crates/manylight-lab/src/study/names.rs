//! Rules for names in a plan.

/// Help text: the characters of a name.
pub(super) const NAMES: &str = "letters, digits, - and _ can";

/// Whether a name has only the characters of [`NAMES`] and is not empty.
pub(super) fn is_file_name_part(name: &str) -> bool {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    !name.is_empty() && name.chars().all(fits)
}

/// Help text with the known names, the most similar to `name` first.
pub(super) fn expected<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> String {
    let mut known: Vec<&str> = known.collect();
    let nearness = |other: &str| strsim::jaro_winkler(name, other);
    known.sort_by(|a, b| nearness(b).total_cmp(&nearness(a)));
    format!("expected one of {}", known.join(", "))
}
