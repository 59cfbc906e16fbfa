//! The scene file of benchmarks that measure one scene.

use std::path::{Path, PathBuf};

/// The file in `MANYLIGHT_BENCH_SCENE`, else `scenes/glossy-room/scene.xml` of the repository.
pub(crate) fn default_scene() -> PathBuf {
    let glossy_room =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/glossy-room/scene.xml");
    std::env::var_os("MANYLIGHT_BENCH_SCENE").map_or(glossy_room, PathBuf::from)
}
