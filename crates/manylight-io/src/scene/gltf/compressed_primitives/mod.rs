//! Compressed primitives: decoded where the program is built with the feature of their decoder,
//! else refused by name.

#[cfg(feature = "draco")]
mod draco;

use super::accessors::Accessors;
use super::json::Json;

/// The extension of compressed primitives.
const DRACO: &str = "KHR_draco_mesh_compression";

/// `accessors` with the decoded data of a primitive in place of the accessors to which it refers,
/// if it is compressed. `Err` if it cannot be decoded, which is reported.
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
        extension.refuse_compressed(DRACO, "draco");
        None
    };
    decoded
        .map(|decoded| Some(accessors.with_decoded(decoded)))
        .ok_or(())
}
