//! Command line of the generators.

use manylight_scenes::files;
use manylight_scenes::scenes::{ALL, Detail, Generator, named};
use std::path::PathBuf;
use std::process::ExitCode;

/// What was asked for.
struct Request {
    generator: &'static Generator,
    detail: Detail,
    folder: PathBuf,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let request = match parsed(&arguments) {
        Ok(request) => request,
        Err(complaint) => {
            report(&format!("{complaint}\n{}", usage()));
            return ExitCode::from(2);
        }
    };
    let scene = (request.generator.generate)(request.detail);
    if let Err(error) = files::write(&scene, &request.folder) {
        report(&format!(
            "cannot write {}: {error}",
            request.folder.display()
        ));
        return ExitCode::from(4);
    }
    ExitCode::SUCCESS
}

fn parsed(arguments: &[String]) -> Result<Request, String> {
    let mut rest = arguments.iter();
    let name = rest.next().ok_or("which scene?")?;
    let generator = named(name).ok_or_else(|| format!("there is no scene '{name}'"))?;
    let mut detail = Detail::default();
    let mut folder = None;
    while let Some(option) = rest.next() {
        let value = rest
            .next()
            .ok_or_else(|| format!("{option} wants a value"))?;
        match option.as_str() {
            "-o" => folder = Some(PathBuf::from(value)),
            "--detail" => {
                let level = value.parse().ok().and_then(Detail::new);
                detail = level.ok_or_else(|| {
                    format!(
                        "--detail is a number from 1 to {}, not '{value}'",
                        Detail::MAX
                    )
                })?;
            }
            _ => return Err(format!("unknown option '{option}'")),
        }
    }
    Ok(Request {
        generator,
        detail,
        folder: folder.ok_or("where to? Give -o FOLDER")?,
    })
}

fn usage() -> String {
    let names: Vec<&str> = ALL.iter().map(|generator| generator.name).collect();
    format!(
        "usage: manylight-scenes SCENE -o FOLDER [--detail 1..{}], where SCENE is one of {}",
        Detail::MAX,
        names.join(", ")
    )
}

#[allow(
    clippy::print_stderr,
    reason = "the one place where the command speaks"
)]
fn report(message: &str) {
    eprintln!("error: {message}");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn complaint(words: &str) -> String {
        let arguments: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
        parsed(&arguments).err().unwrap_or_default()
    }

    #[test]
    fn a_whole_request_is_understood() {
        assert_eq!(complaint("garage -o somewhere --detail 3"), "");
    }

    #[test]
    fn complaints_say_what_is_wrong() {
        assert_eq!(complaint(""), "which scene?");
        assert_eq!(complaint("attic -o x"), "there is no scene 'attic'");
        assert_eq!(complaint("garage"), "where to? Give -o FOLDER");
        assert_eq!(complaint("garage -o"), "-o wants a value");
        assert_eq!(complaint("garage -q x"), "unknown option '-q'");
        assert!(complaint("garage --detail 0 -o x").contains("from 1 to 6, not '0'"));
    }
}
