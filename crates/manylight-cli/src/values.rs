//! Numbers and other values that options accept.

use manylight::film::blocks::BLOCK_STEP;
use manylight::integrators::many_light::{ClampRule, GlossyForm};
use manylight::math::UVec2;
use serde::{Serialize, Serializer};
use std::fmt;
use std::num::NonZeroU32;
use std::ops::RangeInclusive;

/// The word for a number of virtual lights by the scene.
pub(crate) const AUTO: &str = "auto";

/// A number of virtual lights: a positive integer, or `None` for `auto`.
pub(crate) fn light_count(text: &str) -> Result<Option<NonZeroU32>, String> {
    match text {
        AUTO => Ok(None),
        _ => (text.parse().map(Some)).map_err(|_| "expected `auto` or a positive integer".into()),
    }
}

/// A positive whole number.
pub(crate) fn count(text: &str) -> Result<NonZeroU32, String> {
    text.parse()
        .map_err(|_| format!("expected a whole number from 1 to {}", u32::MAX))
}

/// Sets a setting to a positive whole number.
pub(crate) fn set_count(setting: &mut u32, text: &str) -> Result<(), String> {
    *setting = count(text)?.get();
    Ok(())
}

/// A seed of random numbers.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| format!("expected a whole number from 0 to {}", u64::MAX))
}

/// Most threads: ten thousands of them, each with its stack, stop the machine.
pub(crate) const MAX_THREADS: u32 = 1024;

/// A number of threads.
pub(crate) fn threads(text: &str) -> Result<NonZeroU32, String> {
    (text.parse().ok())
        .filter(|threads: &NonZeroU32| threads.get() <= MAX_THREADS)
        .ok_or_else(|| format!("expected a number from 1 to {MAX_THREADS}"))
}

/// A number from 0 to 1.
pub(crate) fn fraction(text: &str) -> Result<f32, String> {
    let value: f32 = text
        .parse()
        .map_err(|_| format!("`{text}` is not a number"))?;
    if (0.0..=1.0).contains(&value) {
        Ok(value)
    } else {
        Err("expected a number from 0 to 1".into())
    }
}

/// A clamp as `--clamp` takes it.
pub(crate) fn clamp_name(clamp: ClampRule) -> String {
    match clamp {
        ClampRule::None => "none".into(),
        ClampRule::Auto => "auto".into(),
        ClampRule::Fixed => "fixed".into(),
        ClampRule::Value(value) => value.to_string(),
    }
}

/// A clamp: `none`, `auto`, `fixed` or a bound of the geometry term in 1/m².
pub(crate) fn clamp(text: &str) -> Result<ClampRule, String> {
    match text {
        "none" => Ok(ClampRule::None),
        "auto" => Ok(ClampRule::Auto),
        "fixed" => Ok(ClampRule::Fixed),
        _ => positive(text)
            .map(ClampRule::Value)
            .map_err(|_| "expected `none`, `auto`, `fixed` or a positive number".into()),
    }
}

/// Texels along an edge of an emission table.
pub(crate) const TABLE_SIZES: RangeInclusive<u32> = 8..=128;

/// Texels along an edge of an emission table: even, because tables consist of blocks of 2 x 2.
pub(crate) fn table_size(text: &str) -> Result<u32, String> {
    let (least, most) = (TABLE_SIZES.start(), TABLE_SIZES.end());
    match text.parse::<u32>() {
        Ok(n) if TABLE_SIZES.contains(&n) && n.is_multiple_of(2) => Ok(n),
        _ => Err(format!("expected an even number from {least} to {most}")),
    }
}

/// Edge of a pattern of pixels.
pub(crate) fn interleaving(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(edge @ (1 | 2 | 4)) => Ok(edge),
        _ => Err("expected 1, 2 or 4".into()),
    }
}

/// A number of von Mises-Fisher lobes.
pub(crate) fn lobes(text: &str) -> Result<u32, String> {
    const MAX: u32 = GlossyForm::MAX_LOBES;
    match text.parse() {
        Ok(lobes @ 1..=MAX) => Ok(lobes),
        _ => Err(format!("expected a whole number from 1 to {MAX}")),
    }
}

/// A rule for a light group: a name, and a pattern of names of emitters in which `*` stands for any
/// text and `?` for any letter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct GroupRule {
    pub(crate) name: String,
    pub(crate) pattern: String,
}

impl fmt::Display for GroupRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.name, self.pattern)
    }
}

/// `NAME=PATTERN`.
pub(crate) fn group_rule(text: &str) -> Result<GroupRule, String> {
    match text.split_once('=') {
        Some((name, pattern)) if !name.is_empty() && !pattern.is_empty() => Ok(GroupRule {
            name: name.into(),
            pattern: pattern.into(),
        }),
        _ => Err("expected NAME=PATTERN, such as `key=lamp*`".into()),
    }
}

/// Factors on the light of a group, per channel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GroupWeight {
    pub(crate) name: String,
    pub(crate) factors: [f32; 3],
}

/// `NAME=R,G,B`, or `NAME=X` for three equal factors.
pub(crate) fn group_weight(text: &str) -> Result<GroupWeight, String> {
    const EXPECTED: &str = "expected NAME=R,G,B or NAME=X with numbers of at least 0";
    let (name, numbers) = text.rsplit_once('=').ok_or(EXPECTED)?;
    let number = |text: &str| {
        let value = text.trim().parse::<f32>().ok();
        value.filter(|value| value.is_finite() && *value >= 0.0)
    };
    let numbers: Option<Vec<f32>> = numbers.split(',').map(number).collect();
    let factors = match numbers.ok_or(EXPECTED)?[..] {
        [all] => [all; 3],
        [r, g, b] => [r, g, b],
        _ => return Err(EXPECTED.into()),
    };
    Ok(GroupWeight {
        name: name.into(),
        factors,
    })
}

/// A finite number > 0.
pub(crate) fn positive(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("expected a positive number".into()),
    }
}

/// A relative error: `0.02` or `2%`. A whole or more without a sign is rather meant in percent.
///
/// # Errors
/// What is expected instead.
pub fn relative_error(text: &str) -> Result<f32, String> {
    let percent = text
        .strip_suffix('%')
        .map(|number| positive(number.trim_end()));
    let value = percent
        .map_or_else(|| positive(text), |value| Ok(value? / 100.0))
        .map_err(|_| "expected a positive number such as 0.02, or 2%")?;
    if value >= 1.0 && !text.ends_with('%') {
        return Err(format!(
            "this is {} %; write {text}% for {text} %",
            100.0 * value
        ));
    }
    Ok(value)
}

/// A finite number.
pub(crate) fn finite(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("expected a number".into()),
    }
}

/// Largest width and height of an image in pixels. Larger values are rather typing errors.
const MAX_EDGE: u32 = 65_536;

/// An image size such as `640x360`, or `640,360`.
pub(crate) fn size(text: &str) -> Result<UVec2, String> {
    let edge = |word: &str| {
        word.parse::<u32>()
            .ok()
            .filter(|n| (1..=MAX_EDGE).contains(n))
    };
    text.split_once(['x', 'X', ','])
        .and_then(|(width, height)| Some(UVec2::new(edge(width)?, edge(height)?)))
        .ok_or_else(|| format!("expected WIDTHxHEIGHT such as 640x360, each from 1 to {MAX_EDGE}"))
}

/// A part of the image in fractions of its width and height, from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crop {
    /// Left and right edge, in [0, 1].
    pub(crate) x: [f32; 2],
    /// Upper and lower edge, in [0, 1].
    pub(crate) y: [f32; 2],
}

impl Serialize for Crop {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let ([x0, x1], [y0, y1]) = (self.x, self.y);
        to.collect_str(&format_args!("{x0},{x1},{y0},{y1}"))
    }
}

/// A crop window `x0,x1,y0,y1`.
pub(crate) fn crop(text: &str) -> Result<Crop, String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x0, x1, y0, y1])
            if 0.0 <= x0 && x0 < x1 && x1 <= 1.0 && 0.0 <= y0 && y0 < y1 && y1 <= 1.0 =>
        {
            Ok(Crop {
                x: [x0, x1],
                y: [y0, y1],
            })
        }
        _ => Err("expected x0,x1,y0,y1 with 0 <= x0 < x1 <= 1 and 0 <= y0 < y1 <= 1".into()),
    }
}

/// A scene parameter `name=value`.
pub(crate) fn define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.into(), value.into())),
        _ => Err("expected name=value".into()),
    }
}

/// Longest path, counted as in Mitsuba; `None` for no limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MaxDepth(pub(crate) Option<u32>);

impl Serialize for MaxDepth {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_i64(self.0.map_or(-1, i64::from))
    }
}

/// A longest path; -1 is no limit.
pub(crate) fn max_depth(text: &str) -> Result<MaxDepth, String> {
    match text.parse::<i64>() {
        Ok(-1) => Ok(MaxDepth(None)),
        Ok(n) if n >= 1 => u32::try_from(n)
            .map(|n| MaxDepth(Some(n)))
            .map_err(|_| "too large".into()),
        _ => Err(
            "expected -1 for no limit, or at least 1 (1 = emitters only, 2 = direct light)".into(),
        ),
    }
}

/// A share of the blocks of a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    /// Which share, from 1 to `count`.
    pub(crate) index: u32,
    /// Number of shares.
    pub(crate) count: NonZeroU32,
}

impl Shard {
    /// The blocks of this share, out of `blocks`: consecutive ones, and as many in each share, up
    /// to one.
    pub(crate) fn range(self, blocks: u32) -> std::ops::Range<u32> {
        let start = |share: u32| {
            (u64::from(blocks) * u64::from(share) / u64::from(self.count.get())) as u32
        };
        start(self.index - 1)..start(self.index)
    }
}

/// A share `I/N`, with I from 1 to N.
pub(crate) fn shard(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/').and_then(|(index, count)| {
        Some(Shard {
            index: index.parse().ok()?,
            count: count.parse().ok()?,
        })
    });
    numbers
        .filter(|shard| (1..=shard.count.get()).contains(&shard.index))
        .ok_or_else(|| "expected I/N such as 3/8, with I from 1 to N".into())
}

/// Frames of a walkthrough, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FrameRange {
    /// The first one, at least 1.
    pub(crate) first: u32,
    /// The last one, not before the first; `None`: that of the walkthrough.
    pub(crate) last: Option<u32>,
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..", self.first)?;
        self.last.map_or(Ok(()), |last| write!(f, "{last}"))
    }
}

/// Frames `A..B`, both included, `A..` to the end, or `A`.
pub(crate) fn frames(text: &str) -> Result<FrameRange, String> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    let number = |text: &str| text.parse::<NonZeroU32>().ok().map(NonZeroU32::get);
    let last = match last {
        "" => Some(None),
        _ => number(last).map(Some),
    };
    let range = number(first).zip(last);
    range
        .filter(|(first, last)| last.is_none_or(|last| *first <= last))
        .map(|(first, last)| FrameRange { first, last })
        .ok_or_else(|| "expected A..B such as 1..48, with 1 the first frame".into())
}

/// Passes of a block: a multiple of the most passes that share a set of virtual lights.
pub(crate) fn block(text: &str) -> Result<NonZeroU32, String> {
    let number = text.parse::<NonZeroU32>().ok();
    number
        .filter(|n| n.get().is_multiple_of(BLOCK_STEP))
        .ok_or_else(|| format!("expected a multiple of {BLOCK_STEP}"))
}

/// A number of bytes: `8G`, `512M`, `1.5GB`, in powers of 1000.
pub(crate) fn bytes(word: &str) -> Result<u64, String> {
    const UNITS: [(char, f64); 4] = [('K', 1e3), ('M', 1e6), ('G', 1e9), ('T', 1e12)];
    let word = word.to_ascii_uppercase();
    let word = word.strip_suffix('B').unwrap_or(&word);
    let with_unit = |&(name, unit)| Some((word.strip_suffix(name)?, unit));
    let (number, unit) = UNITS.iter().find_map(with_unit).unwrap_or((word, 1.0));
    match number.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok((x * unit) as u64),
        _ => Err("expected a size such as 8G or 512M".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_errors_are_numbers_or_percent() {
        for text in ["0.02", "2%", "2 %"] {
            assert_eq!(relative_error(text), Ok(0.02), "{text}");
        }
        for text in ["", "%", "-1%", "0", "nan%", "2%%"] {
            assert!(relative_error(text).unwrap_err().contains("2%"), "{text}");
        }
        assert_eq!(relative_error("150%"), Ok(1.5));
        assert_eq!(
            relative_error("2"),
            Err("this is 200 %; write 2% for 2 %".into())
        );
    }

    #[test]
    fn wrong_numbers_are_told_the_right_ones() {
        let all = "expected a whole number from 1 to 4294967295";
        for bad in ["0", "-5", "1e6", "4294967296", "many", ""] {
            assert_eq!(count(bad), Err(all.into()), "{bad}");
        }
        assert_eq!(count("7").map(NonZeroU32::get), Ok(7));
        assert_eq!(seed("18446744073709551615"), Ok(u64::MAX));
        for bad in ["-1", "18446744073709551616", "x"] {
            assert!(
                seed(bad).unwrap_err().contains("18446744073709551615"),
                "{bad}"
            );
        }
    }

    #[test]
    fn sizes_in_bytes() {
        assert_eq!(bytes("8G"), Ok(8_000_000_000));
        assert_eq!(bytes("1.5gb"), Ok(1_500_000_000));
        assert_eq!(bytes("512M"), Ok(512_000_000));
        assert_eq!(bytes("4096"), Ok(4096));
        for bad in ["", "G", "-1G", "0", "8X", "inf", "1 000"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn shares_divide_all_blocks() {
        for (blocks, count) in [(1, 1), (8, 3), (3, 8), (64, 64), (7, 2)] {
            let mut end = 0;
            for index in 1..=count {
                let share = shard(&format!("{index}/{count}")).unwrap().range(blocks);
                assert_eq!(share.start, end);
                assert!(share.len() as u32 <= blocks.div_ceil(count));
                end = share.end;
            }
            assert_eq!(end, blocks);
        }
        for bad in ["0/2", "3/2", "1", "1/0", "a/b", "-1/2"] {
            assert!(shard(bad).is_err(), "{bad}");
        }
        assert_eq!(block("24").map(NonZeroU32::get), Ok(24));
        for bad in ["0", "12", "-8", "x"] {
            assert!(block(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_and_crops() {
        assert_eq!(size("640x360"), Ok(UVec2::new(640, 360)));
        for bad in ["640", "0x3", "3x-1", "70000x2", "axb", "1x2x3"] {
            assert!(size(bad).is_err(), "{bad}");
        }
        assert_eq!(
            crop("0,0.5,0.25,1"),
            Ok(Crop {
                x: [0.0, 0.5],
                y: [0.25, 1.0]
            })
        );
        for bad in [
            "0,1,0",
            "0.5,0.5,0,1",
            "0,1.1,0,1",
            "-0.1,1,0,1",
            "a,b,c,d",
            "0,nan,0,1",
        ] {
            assert!(crop(bad).is_err(), "{bad}");
        }
        assert_eq!([table_size("8"), table_size("128")], [Ok(8), Ok(128)]);
        for bad in ["6", "33", "130", "-8", "x"] {
            assert!(table_size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn depths_clamps_and_defines() {
        assert_eq!(max_depth("-1"), Ok(MaxDepth(None)));
        assert_eq!(max_depth("2"), Ok(MaxDepth(Some(2))));
        assert!(max_depth("0").is_err() && max_depth("-2").is_err());
        assert_eq!(clamp("auto"), Ok(ClampRule::Auto));
        assert_eq!(clamp("2.5"), Ok(ClampRule::Value(2.5)));
        assert!(clamp("-1").is_err() && clamp("inf").is_err());
        assert_eq!(define("a=b=c"), Ok(("a".into(), "b=c".into())));
        assert!(define("=b").is_err() && define("a").is_err());
    }

    #[test]
    fn every_clamp_reads_back() {
        for clamp_value in [
            ClampRule::None,
            ClampRule::Auto,
            ClampRule::Fixed,
            ClampRule::Value(0.1),
        ] {
            assert_eq!(clamp(&clamp_name(clamp_value)), Ok(clamp_value));
        }
    }
}
