//! The light groups of a render: names of emitters by rules.

use crate::args::PictureArgs;
use crate::failure::Failure;
use crate::values::GroupRule;
use manylight::ids::LightGroup;
use manylight::scene::{LightGroupNames, LightGroups, REST};
use manylight_lab::text::plural;

/// Most names that a message lists.
const LISTED: usize = 8;

/// The names of the sources of a scene by the rules of `picture`: without rules those of the file.
/// Dots become underscores, as in Blender: in files of images they separate layers.
///
/// # Errors
/// A rule matches no source that no other rule before it matches.
pub(crate) fn named(
    picture: &PictureArgs,
    names: &LightGroupNames,
) -> Result<LightGroupNames, Failure> {
    let rules = &picture.light_group;
    let mut matched = vec![false; rules.len()];
    let named = names.0.iter().map(|(source, name)| {
        let rule = rules.iter().position(|rule| matches(&rule.pattern, name));
        let group = match rule {
            Some(rule) => {
                matched[rule] = true;
                rules[rule].name.as_str()
            }
            None if rules.is_empty() => name,
            None => REST,
        };
        (*source, group.replace('.', "_"))
    });
    let named = LightGroupNames(named.collect());
    match matched.iter().position(|matched| !matched) {
        None => Ok(named),
        Some(rule) => Err(without_match(&rules[rule], names)),
    }
}

/// Refuses scenes of which no picture can have a layer for each group.
///
/// # Errors
/// The scene has too many groups, or none.
pub(crate) fn check_groups(groups: &LightGroups) -> Result<(), Failure> {
    let count = groups.count();
    if groups.are_recordable() {
        return Ok(());
    }
    Err(Failure::usage(
        format!(
            "--light-groups: the scene has {count} light group{}, expected 1 to {}",
            plural(count),
            LightGroup::MAX
        ),
        match count {
            0 => "a scene without emitters has none; omit --light-groups",
            _ => {
                "join them by rules, such as --light-group lamps=lamp*; all other emitters are then one group"
            }
        },
    ))
}

fn without_match(rule: &GroupRule, names: &LightGroupNames) -> Failure {
    let mut distinct: Vec<&str> = Vec::new();
    for (_, name) in &names.0 {
        if !distinct.contains(&name.as_str()) && distinct.len() <= LISTED {
            distinct.push(name);
        }
    }
    let more = if distinct.len() > LISTED { ", ..." } else { "" };
    distinct.truncate(LISTED);
    Failure::usage(
        format!(
            "--light-group {}={}: no emitter has a name that matches, besides those of rules before",
            rule.name, rule.pattern
        ),
        format!("the emitters of the scene: {}{more}", distinct.join(", ")),
    )
}

/// Whether `pattern` matches all of `text`: `*` stands for any text, `?` for any letter.
fn matches(pattern: &str, text: &str) -> bool {
    let (pattern, text): (Vec<char>, Vec<char>) =
        (pattern.chars().collect(), text.chars().collect());
    let (mut p, mut t) = (0, 0);
    // Where the last `*` stands, and the first letter after what it has taken.
    let mut star = None;
    while t < text.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, t));
                p += 1;
            }
            Some(&c) if c == '?' || c == text[t] => (p, t) = (p + 1, t + 1),
            _ => match star {
                Some((place, taken)) => {
                    star = Some((place, taken + 1));
                    (p, t) = (place + 1, taken + 1);
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|&c| c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::emitters::EmissionSource;
    use manylight::ids::EmitterId;

    fn names(names: &[&str]) -> LightGroupNames {
        let named = names.iter().enumerate();
        let sources = named.map(|(i, name)| {
            let source = EmissionSource::Emitter(EmitterId::from(i));
            (source, (*name).to_owned())
        });
        LightGroupNames(sources.collect())
    }

    fn by_rules(rules: &[(&str, &str)]) -> PictureArgs {
        let rule = |&(name, pattern): &(&str, &str)| GroupRule {
            name: name.into(),
            pattern: pattern.into(),
        };
        PictureArgs {
            light_group: rules.iter().map(rule).collect(),
            ..PictureArgs::default()
        }
    }

    fn groups(rules: &[(&str, &str)], of: &[&str]) -> Result<Vec<String>, Failure> {
        let named = named(&by_rules(rules), &names(of))?;
        Ok(named.0.into_iter().map(|(_, name)| name).collect())
    }

    #[test]
    fn patterns_match_whole_names() {
        for (pattern, text, expected) in [
            ("lamp", "lamp", true),
            ("lamp", "lamp_2", false),
            ("lamp*", "lamp_2", true),
            ("*_2", "lamp_2_2", true),
            ("l?mp", "lump", true),
            ("*a*b*", "xxaxxbxx", true),
            ("*a*b", "bbba", false),
            ("*", "", true),
            ("?", "", false),
        ] {
            assert_eq!(matches(pattern, text), expected, "{pattern} {text}");
        }
    }

    #[test]
    fn the_first_rule_decides_and_the_others_are_the_rest() {
        let of = ["lamp.1", "lamp.2", "sky"];
        assert_eq!(groups(&[], &of).unwrap(), ["lamp_1", "lamp_2", "sky"]);
        let rules = [("one", "*1"), ("lamps", "lamp*")];
        assert_eq!(groups(&rules, &of).unwrap(), ["one", "lamps", "rest"]);
    }

    #[test]
    fn rules_that_match_nothing_are_refused() {
        let of = ["lamp", "sky"];
        for rules in [
            &[("sun", "sun*")][..],
            // The rule before takes all.
            &[("all", "*"), ("lamp", "lamp")],
        ] {
            let failure = groups(rules, &of).unwrap_err();
            assert_eq!(failure.exit_code(), 2, "{failure}");
        }
    }
}
