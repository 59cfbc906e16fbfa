//! Compressed buffer views: decoded where the program is built with the feature of their decoder,
//! else refused by name.

#[cfg(feature = "meshopt")]
mod meshopt;

use super::json::Json;

/// Names of the extension of compressed buffer views: ratified, and its draft.
const MESHOPT: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// Whether compressed views are decoded. Otherwise the uncompressed content is read where a file
/// has both.
pub(super) const READS_MESHOPT: bool = cfg!(feature = "meshopt");

/// Whether a buffer only holds the place of the decompressed content of others.
pub(super) fn is_fallback(buffer: &Json<'_>) -> bool {
    let extensions = MESHOPT.iter().filter_map(|name| buffer.extension(name));
    extensions
        .into_iter()
        .any(|extension| extension.boolean("fallback"))
        && !buffer.has("uri")
}

/// The extension by which a buffer view is compressed, and its name.
pub(super) fn of_view<'a>(view: &Json<'a>) -> Option<(Json<'a>, &'static str)> {
    let mut names = MESHOPT.iter();
    names.find_map(|name| Some((view.extension(name)?, *name)))
}

/// The content of a view that is compressed by `extension` of this name, of which `bytes` is the
/// compressed data. `None` if it cannot be decoded, which is reported.
pub(super) fn decode_view(extension: &Json<'_>, name: &str, bytes: &[u8]) -> Option<Vec<u8>> {
    #[cfg(feature = "meshopt")]
    {
        let _ = name;
        meshopt::decode(extension, bytes)
    }
    #[cfg(not(feature = "meshopt"))]
    {
        let _ = bytes;
        extension.refuse_compressed(name, "meshopt");
        None
    }
}
