//! Text for people and shells, shared by pages and messages.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The plural ending: an empty text for one, "s" otherwise.
pub fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// `word` quoted for a POSIX shell, where it needs quotes.
///
/// ```
/// assert_eq!(manylight_lab::text::quoted("a b"), "'a b'");
/// ```
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.into();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// Universal time as `YYYY-MM-DDThh:mm:ssZ`. A clock that is wrong by centuries gives the nearest
/// date of the years 1970 to 9999.
pub fn date(time: SystemTime) -> String {
    /// The last second of the year 9999, in seconds since 1970.
    const LAST: Duration = Duration::from_secs(253_402_300_799);
    let since = time.duration_since(UNIX_EPOCH).unwrap_or_default();
    humantime::format_rfc3339_seconds(UNIX_EPOCH + since.min(LAST)).to_string()
}

/// Reads a positive duration such as `60s`, `1.5m`, `2h` or `500ms`. A number without a unit is in
/// seconds.
///
/// # Errors
/// The text is no positive duration, or too long for [`Duration`].
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    let expected = || "expected a length of time such as 60s, 10m, 1.5h or 500ms".to_string();
    let split = text
        .find(|c: char| c.is_ascii_alphabetic())
        .unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let seconds_per_unit = match unit {
        "ms" => 1e-3,
        "" | "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(expected()),
    };
    let value = number.trim().parse::<f64>().map_err(|_| expected())?;
    if value <= 0.0 {
        return Err(expected());
    }
    Duration::try_from_secs_f64(value * seconds_per_unit).map_err(|_| expected())
}

/// `value` with three significant digits; in scientific notation below 0.001 and from a million on.
pub(crate) fn three_digits(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    // The exponent after rounding: 9.996 becomes 10.0.
    let exponent = format!("{size:.2e}")
        .rsplit('e')
        .next()
        .and_then(|exponent| exponent.parse::<i32>().ok())
        .unwrap_or(0);
    let digits = usize::try_from(2 - exponent).unwrap_or(0);
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations() {
        assert_eq!(parse_duration("60s"), Ok(Duration::from_secs(60)));
        assert_eq!(parse_duration("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(parse_duration("1h"), Ok(Duration::from_secs(3600)));
        assert_eq!(parse_duration("500ms"), Ok(Duration::from_millis(500)));
        assert_eq!(parse_duration("7"), Ok(Duration::from_secs(7)));
        for bad in ["", "s", "-1s", "0s", "5 days", "1e300h", "nan"] {
            assert!(parse_duration(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn words_with_spaces_are_quoted() {
        assert_eq!(quoted("a b"), "'a b'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted("a/b.xml"), "a/b.xml");
        assert_eq!(quoted(""), "''");
    }

    #[test]
    fn three_digits_are_significant() {
        for (value, text) in [
            (0.0, "0"),
            (0.012345, "0.0123"),
            (0.9996, "1.00"),
            (9.996, "10.0"),
            (61.23, "61.2"),
            (612.3, "612"),
            (61234.0, "61234"),
            (1.2345e-5, "1.23e-5"),
            (-0.4567, "-0.457"),
            (1.5e7, "1.50e7"),
        ] {
            assert_eq!(three_digits(value), text);
        }
    }
}
