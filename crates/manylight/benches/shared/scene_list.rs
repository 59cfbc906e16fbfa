//! The scene files that `MANYLIGHT_BENCH_SCENES` names, separated as in `PATH`.

use std::path::Path;

/// Prints a heading for each scene file in `MANYLIGHT_BENCH_SCENES` and calls `bench` with its
/// path. Without the variable, a hint is printed instead.
pub(crate) fn for_each_scene(mut bench: impl FnMut(&Path)) {
    let Some(scenes) = std::env::var_os("MANYLIGHT_BENCH_SCENES") else {
        println!("nothing to measure: set MANYLIGHT_BENCH_SCENES to scene files (a.xml:b.xml)");
        return;
    };
    for path in std::env::split_paths(&scenes) {
        println!("\n# {}", path.display());
        bench(&path);
    }
}
