//! Command line: `manylight-scenes SCENE -o FOLDER [--detail LEVEL] [--format FORMAT]` writes one
//! generated scene.

use manylight_scenes::files::{self, Format};
use manylight_scenes::scenes::{Detail, GENERATORS, SceneGenerator, generator_named};
use std::path::PathBuf;
use std::process::ExitCode;

/// Exit status after a wrong command line, as in `manylight`.
const USAGE_ERROR: u8 = 2;
/// Exit status after a failure to write a file, as in `manylight`.
const FILE_SYSTEM_ERROR: u8 = 4;

/// A parsed command line.
struct Request {
    generator: &'static SceneGenerator,
    detail: Detail,
    formats: Vec<Format>,
    folder: PathBuf,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let request = match parse(&arguments) {
        Ok(request) => request,
        Err(message) => {
            print_error(&format!("{message}\n{}", usage()));
            return ExitCode::from(USAGE_ERROR);
        }
    };
    let scene = (request.generator.generate)(request.detail);
    if let Err(error) = files::write(&scene, &request.formats, &request.folder) {
        print_error(&format!(
            "cannot write {}: {error}",
            request.folder.display()
        ));
        return ExitCode::from(FILE_SYSTEM_ERROR);
    }
    ExitCode::SUCCESS
}

fn parse(arguments: &[String]) -> Result<Request, String> {
    let mut rest = arguments.iter();
    let name = rest.next().ok_or("no scene given")?;
    let generator = generator_named(name).ok_or_else(|| format!("unknown scene '{name}'"))?;
    let mut detail = Detail::default();
    let mut folder = None;
    let mut formats = Vec::new();
    while let Some(option) = rest.next() {
        let value = rest
            .next()
            .ok_or_else(|| format!("{option} needs a value"))?;
        match option.as_str() {
            "-o" => folder = Some(PathBuf::from(value)),
            "--detail" => {
                let level = value.parse().ok().and_then(Detail::new);
                detail = level.ok_or_else(|| {
                    format!("--detail must be from 1 to {}, not '{value}'", Detail::MAX)
                })?;
            }
            "--format" => {
                let format = Format::named(value);
                formats.push(format.ok_or_else(|| {
                    format!("--format must be mitsuba, pbrt or gltf, not '{value}'")
                })?);
            }
            _ => return Err(format!("unknown option '{option}'")),
        }
    }
    if formats.is_empty() {
        formats.extend(Format::COMMITTED);
    }
    Ok(Request {
        generator,
        detail,
        formats,
        folder: folder.ok_or("no output folder given (-o FOLDER)")?,
    })
}

fn usage() -> String {
    let names: Vec<&str> = GENERATORS.iter().map(|generator| generator.name).collect();
    format!(
        "usage: manylight-scenes SCENE -o FOLDER [--detail LEVEL] [--format FORMAT]...\n\
         SCENE is one of {}\n\
         LEVEL is from 1 (the scenes in the repository) to {}\n\
         FORMAT is mitsuba, pbrt or gltf; both mitsuba and pbrt if none is given",
        names.join(", "),
        Detail::MAX
    )
}

#[allow(
    clippy::print_stderr,
    reason = "a command reports its errors on stderr"
)]
fn print_error(message: &str) {
    eprintln!("error: {message}");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(words: &str) -> String {
        let arguments: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
        parse(&arguments).err().unwrap_or_default()
    }

    #[test]
    fn a_complete_command_line_parses() {
        assert_eq!(message("garage -o somewhere --detail 3"), "");
    }

    #[test]
    fn formats_add_up_and_have_a_default() {
        let formats = |words: &str| {
            let arguments: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
            parse(&arguments).map(|request| request.formats)
        };
        assert_eq!(formats("disco -o x"), Ok(Format::COMMITTED.to_vec()));
        let both = [Format::Gltf, Format::Pbrt].to_vec();
        assert_eq!(formats("disco --format gltf -o x --format pbrt"), Ok(both));
    }

    #[test]
    fn messages_name_what_is_wrong() {
        assert_eq!(message(""), "no scene given");
        assert_eq!(message("attic -o x"), "unknown scene 'attic'");
        assert_eq!(message("garage"), "no output folder given (-o FOLDER)");
        assert_eq!(message("garage -o"), "-o needs a value");
        assert_eq!(message("garage -q x"), "unknown option '-q'");
        assert!(message("garage --detail 0 -o x").contains("from 1 to 6, not '0'"));
        assert!(message("garage --format usd -o x").contains("mitsuba, pbrt or gltf, not 'usd'"));
    }
}
