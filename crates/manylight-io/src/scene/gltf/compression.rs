//! Compressed geometry. It is not decoded: files that need it are refused by name.

use super::json::Json;

/// How to write a file without compression.
const ADVICE: &str = "export the scene without mesh compression, or expand the file, for example by `gltf-transform copy IN OUT`";

/// Names of the extension of compressed buffer views: ratified, and its draft.
const MESHOPT: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// Whether a buffer only holds the place of the decompressed content of others.
pub(super) fn is_fallback(buffer: &Json<'_>) -> bool {
    let extensions = MESHOPT.iter().filter_map(|name| buffer.extension(name));
    extensions
        .into_iter()
        .any(|extension| extension.boolean("fallback"))
        && !buffer.has("uri")
}

/// Reports a buffer view that is compressed.
pub(super) fn refuse_meshopt(view: &Json<'_>) -> bool {
    let used = MESHOPT.iter().find(|name| view.extension(name).is_some());
    used.inspect(|name| refuse(view, name)).is_some()
}

/// Reports a primitive that is compressed.
pub(super) fn refuse_draco(primitive: &Json<'_>) -> bool {
    let name = "KHR_draco_mesh_compression";
    let is_compressed = primitive.extension(name).is_some();
    if is_compressed {
        refuse(primitive, name);
    }
    is_compressed
}

fn refuse(json: &Json<'_>, name: &str) {
    let message = format!("geometry compressed by the extension `{name}` is not supported");
    let reporter = json.reporter();
    reporter.error_with_help(json.path(), &message, ADVICE);
}
