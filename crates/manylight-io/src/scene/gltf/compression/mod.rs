//! Compressed geometry: decoded where the program is built with the feature of its decoder, else refused by name.

#[cfg(feature = "draco")]
mod draco;
#[cfg(feature = "meshopt")]
mod meshopt;

use super::accessors::Accessors;
use super::json::Json;

/// The extension of compressed primitives.
const DRACO: &str = "KHR_draco_mesh_compression";
/// Names of the extension of compressed buffer views: ratified, and its draft.
const MESHOPT: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// Whether compressed views are decoded. Otherwise the uncompressed content is read where a file has both.
pub(super) const READS_MESHOPT: bool = cfg!(feature = "meshopt");

/// Whether a buffer only holds the place of the decompressed content of others.
pub(super) fn is_fallback(buffer: &Json<'_>) -> bool {
    let extensions = MESHOPT.iter().filter_map(|name| buffer.extension(name));
    extensions
        .into_iter()
        .any(|extension| extension.boolean("fallback"))
        && !buffer.has("uri")
}

/// The extension by which a buffer view is compressed.
pub(super) fn of_view<'a>(view: &Json<'a>) -> Option<Json<'a>> {
    MESHOPT.iter().find_map(|name| view.extension(name))
}

/// The content of a view that is compressed by `extension`, of which `bytes` is the compressed data.
/// `None` if it cannot be decoded, which is reported.
pub(super) fn decode_view(extension: &Json<'_>, bytes: &[u8]) -> Option<Vec<u8>> {
    #[cfg(feature = "meshopt")]
    return meshopt::decode(extension, bytes);
    #[cfg(not(feature = "meshopt"))]
    {
        let _ = bytes;
        refuse(extension, "EXT_meshopt_compression", "meshopt");
        None
    }
}

/// `accessors` with the decoded data of a primitive in place of the accessors to which it refers, if it is compressed.
/// `Err` if it cannot be decoded, which is reported.
pub(super) fn of_primitive<'a, 'b>(
    primitive: &Json<'a>,
    accessors: &Accessors<'a, 'b>,
) -> Result<Option<Accessors<'a, 'b>>, ()> {
    let Some(extension) = primitive.extension(DRACO) else {
        return Ok(None);
    };
    #[cfg(feature = "draco")]
    let decoded = draco::decode(primitive, &extension, accessors);
    #[cfg(not(feature = "draco"))]
    let decoded = {
        let position = primitive
            .member("attributes")
            .and_then(|a| a.get("POSITION"));
        if position.is_some_and(|at| accessors.has_view(&at)) {
            return Ok(None);
        }
        refuse(&extension, DRACO, "draco");
        None
    };
    decoded
        .map(|decoded| Some(accessors.with_decoded(decoded)))
        .ok_or(())
}

#[cfg(not(all(feature = "draco", feature = "meshopt")))]
fn refuse(at: &Json<'_>, extension: &str, feature: &str) {
    let message =
        format!("geometry compressed by the extension `{extension}` is not read by this build");
    let help = format!(
        "build with `--features {feature}`, export the scene without mesh compression, or expand the file, for example by `gltf-transform copy IN OUT`"
    );
    at.reporter().error_with_help(at.path(), &message, &help);
}
