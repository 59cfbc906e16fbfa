//! The scene files that `MANYLIGHT_BENCH_SCENES` names, separated as in `PATH`, and the instructions
//! that `MANYLIGHT_SIMD` names.

use std::path::Path;

/// Prints a heading for each scene file in `MANYLIGHT_BENCH_SCENES` and calls `bench` with its
/// path. Without the variable, a hint is printed instead. `MANYLIGHT_SIMD` selects the instruction
/// set, as it does for the command.
///
/// # Panics
/// The machine lacks the instructions that `MANYLIGHT_SIMD` names.
pub(crate) fn for_each_scene(mut bench: impl FnMut(&Path)) {
    if let Some(name) = std::env::var_os("MANYLIGHT_SIMD") {
        manylight::select_instruction_set(&name.to_string_lossy())
            .unwrap_or_else(|message| panic!("MANYLIGHT_SIMD: {message}"));
    }
    let Some(scenes) = std::env::var_os("MANYLIGHT_BENCH_SCENES") else {
        println!("nothing to measure: set MANYLIGHT_BENCH_SCENES to scene files (a.xml:b.xml)");
        return;
    };
    for path in std::env::split_paths(&scenes) {
        println!("\n# {}", path.display());
        bench(&path);
    }
}
