//! References to files, and data within the JSON text.

use super::json::Json;
use crate::read::read_regular;
use crate::resolve::{looked_for, resolve};
use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use std::path::{Path, PathBuf};

/// Base64 with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// What a URI refers to.
pub(super) enum Target {
    /// Bytes of a data URI.
    Data(Vec<u8>),
    /// A file that exists.
    File(PathBuf),
}

/// The target of the URI `text`, the value `json`. `what` describes it in messages.
pub(super) fn target(json: &Json<'_>, text: &str, folder: &Path, what: &str) -> Option<Target> {
    if let Some(data) = text.strip_prefix("data:") {
        return data_uri(json, data).map(Target::Data);
    }
    let scheme = text.split_once(':').map(|(scheme, _)| scheme);
    if let Some(scheme) = scheme.filter(|s| s.len() > 1 && s.chars().all(char::is_alphanumeric)) {
        json.error(format!(
            "found a `{scheme}:` address, expected a file name relative to the scene, or a `data:` address"
        ));
        return None;
    }
    let name = percent_decoded(text);
    match resolve(&name, &[folder.to_owned()]).filter(|found| !found.path.is_dir()) {
        Some(found) => {
            if let Some(remark) = found.remark {
                let used = found.path.display();
                json.warn_once(
                    &format!("spelling of {name}"),
                    format!("the name `{name}` {remark}; using `{used}`"),
                );
            }
            Some(Target::File(found.path))
        }
        None => {
            let message = format!("the {what} `{name}` does not exist");
            let help = Some(looked_for(&folder.join(&name)));
            json.reporter().file_error(json.path(), &message, help);
            None
        }
    }
}

/// The bytes that the URI `text` refers to.
pub(super) fn read(json: &Json<'_>, text: &str, folder: &Path, what: &str) -> Option<Vec<u8>> {
    match target(json, text, folder, what)? {
        Target::Data(bytes) => Some(bytes),
        Target::File(path) => match read_regular(&path) {
            Ok(bytes) => {
                json.reporter().note_read(&path);
                Some(bytes)
            }
            Err(error) => {
                let message = format!("the {what} `{}` cannot be read: {error}", path.display());
                json.reporter().file_error(json.path(), &message, None);
                None
            }
        },
    }
}

/// The bytes of a data URI without its scheme.
fn data_uri(json: &Json<'_>, rest: &str) -> Option<Vec<u8>> {
    let Some((_, encoded)) = rest.split_once(";base64,") else {
        json.error("found a `data:` address that is not encoded as base64");
        return None;
    };
    match BASE64.decode(encoded.trim()) {
        Ok(bytes) => Some(bytes),
        Err(error) => {
            json.error(format!("the base64 data cannot be decoded: {error}"));
            None
        }
    }
}

/// A URI without its percent encoding. Sequences that are not valid stay as they are.
fn percent_decoded(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let hex = text.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                decoded.push(byte);
                at += 3;
            }
            None => {
                decoded.push(bytes[at]);
                at += 1;
            }
        }
    }
    String::from_utf8(decoded).unwrap_or_else(|_| text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_encoding_is_removed() {
        assert_eq!(percent_decoded("a%20b%C3%A4.png"), "a bä.png");
        assert_eq!(percent_decoded("50%.png"), "50%.png");
        assert_eq!(percent_decoded("%zz%"), "%zz%");
    }
}
