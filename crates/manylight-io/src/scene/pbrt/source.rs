//! Text of scene files.

use super::super::sink::{FileSpan, Problem, Sink, Text};
use crate::gzip::unpacked;
use crate::read::read_regular;
use std::path::Path;
use std::sync::Arc;

/// Most bytes of a file: spans have 32 bits.
const MAX_BYTES: usize = u32::MAX as usize - 1;

/// The text in the content `bytes` of the file `path`, which may be compressed. Bytes that are not
/// UTF-8 are reported at their place; other damage is returned as a message.
pub(super) fn text_of(
    path: &Path,
    bytes: Vec<u8>,
    sink: &Sink,
) -> Result<Option<Arc<str>>, String> {
    let bytes = unpacked(bytes).map_err(|fault| fault.in_file(path).to_string())?;
    if bytes.len() > MAX_BYTES {
        return Err(format!("{} has more than 4 GiB of text", path.display()));
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(Some(text.into())),
        Err(error) => {
            let start = error.utf8_error().valid_up_to() as u32;
            let lossy = String::from_utf8_lossy(error.as_bytes());
            let file = sink.add_file(path, lossy.into());
            let replacement = char::REPLACEMENT_CHARACTER.len_utf8() as u32;
            let span = FileSpan {
                file,
                start,
                end: start + replacement,
            };
            let message = "found a byte that is not UTF-8, expected UTF-8 text";
            sink.error_at("scene::encoding", span, message);
            Ok(None)
        }
    }
}

/// The text of the included file `path`. Errors are reported.
pub(super) fn read_text(path: &Path, name: &Text, sink: &Sink) -> Option<Arc<str>> {
    let bytes = match read_regular(path) {
        Ok(bytes) => bytes,
        Err(error) => {
            let message = format!("cannot read the included file `{}`: {error}", name.value);
            let problem = Problem::new("scene::unreadable", name.span, message);
            sink.error(problem.file_system());
            return None;
        }
    };
    sink.note_read(path);
    match text_of(path, bytes, sink) {
        Ok(text) => text,
        Err(what) => {
            let message = format!("cannot use the included file {what}");
            sink.error_at("scene::broken_file", name.span, message);
            None
        }
    }
}
