//! `manylight check`.

use crate::args::CheckArgs;
use crate::failure::{DONE, FILE_SYSTEM, Failure, SCENE, STRICT};
use crate::output::{print_diagnostic, print_message};
use manylight_io::{LoadErrorKind, Severity, check_scene, shown_path};
use manylight_lab::text::plural;

/// Prints every error and warning of a scene.
pub(crate) fn run(args: &CheckArgs) -> Result<u8, Failure> {
    let options = args.gltf.load_options(&args.defines);
    let found = check_scene(&args.scene, &options);
    for diagnostic in &found {
        print_diagnostic(diagnostic);
    }
    let count = |severity| found.iter().filter(|d| d.severity == severity).count();
    let (errors, warnings) = (count(Severity::Error), count(Severity::Warning));
    print_message(format_args!(
        "{}: {errors} error{}, {warnings} warning{}",
        shown_path(&args.scene),
        plural(errors),
        plural(warnings)
    ));
    let mut failed = found.iter().filter(|d| d.severity == Severity::Error);
    Ok(match (errors, warnings) {
        (0, 1..) if args.strict => STRICT,
        (0, _) => DONE,
        _ if failed.all(|d| d.kind == LoadErrorKind::FileSystem) => FILE_SYSTEM,
        _ => SCENE,
    })
}
