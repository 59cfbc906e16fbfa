//! Wrong words of a command line as failures with a message and a suggestion, for programs that
//! give options other than on a terminal.

use crate::args::{Cli, Command, RenderArgs};
use crate::failure::Failure;
use clap::Parser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::error::Error;

/// The options of `manylight render` with these words.
///
/// # Errors
/// An option is unknown, or its value is wrong.
pub(crate) fn render_args<'w>(
    words: impl IntoIterator<Item = &'w str>,
) -> Result<Box<RenderArgs>, Failure> {
    let command = ["manylight", "render"].into_iter();
    let cli = Cli::try_parse_from(command.chain(words)).map_err(|error| usage(&error))?;
    match cli.command {
        Command::Render(args) => Ok(args),
        _ => unreachable!("the subcommand is `render`"),
    }
}

/// The failure of a wrong command line.
fn usage(error: &clap::Error) -> Failure {
    Failure::usage(message(error), suggestion(error))
}

fn message(error: &clap::Error) -> String {
    let option = texts(error, ContextKind::InvalidArg)
        .iter()
        .map(|name| format!("'{}'", without_value(name)))
        .collect::<Vec<_>>()
        .join(", ");
    let value = texts(error, ContextKind::InvalidValue).concat();
    match error.kind() {
        ErrorKind::InvalidValue if value.is_empty() => {
            format!("a value is required for {option} but none was supplied")
        }
        ErrorKind::InvalidValue => format!("invalid value '{value}' for {option}"),
        ErrorKind::ValueValidation => match error.source() {
            Some(expected) => format!("invalid value '{value}' for {option}: {expected}"),
            None => format!("invalid value '{value}' for {option}"),
        },
        ErrorKind::TooManyValues => format!("unexpected value '{value}' for {option}"),
        ErrorKind::UnknownArgument => format!("unexpected argument {option} found"),
        ErrorKind::ArgumentConflict => {
            let other = texts(error, ContextKind::PriorArg).concat();
            match without_value(&other) {
                "" => format!("the argument {option} cannot be used here"),
                other if option == format!("'{other}'") => {
                    format!("the argument {option} cannot be used multiple times")
                }
                other => format!("the argument {option} cannot be used with '{other}'"),
            }
        }
        ErrorKind::MissingRequiredArgument => {
            format!("the following required arguments were not provided: {option}")
        }
        kind => format!("{kind}: {option}"),
    }
}

fn suggestion(error: &clap::Error) -> String {
    let similar = |kind, noun: &str| {
        let texts = texts(error, kind);
        let quoted: Vec<_> = texts.iter().map(|text| format!("'{text}'")).collect();
        match quoted.as_slice() {
            [] => None,
            [one] => Some(format!("a similar {noun} exists: {one}")),
            some => Some(format!("some similar {noun}s exist: {}", some.join(", "))),
        }
    };
    let valid = texts(error, ContextKind::ValidValue);
    let expected = (!valid.is_empty()).then(|| format!("expected one of {}", valid.join(", ")));
    let parts = [
        similar(ContextKind::SuggestedArg, "argument"),
        similar(ContextKind::SuggestedValue, "value"),
        expected,
    ];
    let parts: Vec<_> = parts.into_iter().flatten().collect();
    match parts.as_slice() {
        [] => "see `manylight render --help`".into(),
        parts => parts.join("; "),
    }
}

/// The texts that the error has of a kind.
fn texts(error: &clap::Error, kind: ContextKind) -> Vec<String> {
    match error.get(kind) {
        Some(ContextValue::String(text)) => vec![text.clone()],
        Some(ContextValue::Strings(texts)) => texts.clone(),
        _ => Vec::new(),
    }
}

/// `--size` of `--size <WxH>`.
fn without_value(option: &str) -> &str {
    option.split(' ').next().unwrap_or_default()
}
