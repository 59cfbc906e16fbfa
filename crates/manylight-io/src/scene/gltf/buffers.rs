//! Buffers and buffer views: the binary data of a scene.

use super::document::Document;
use super::json::Json;
use super::{compressed_views, uri};
use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

/// The binary data of a scene, checked against the sizes that the file declares.
pub(super) struct Buffers<'a> {
    buffers: Vec<Option<Cow<'a, [u8]>>>,
    views: Vec<Option<View>>,
}

/// The content of a buffer view.
#[derive(Clone, Debug)]
struct View {
    content: Content,
    stride: Option<usize>,
}

#[derive(Clone, Debug)]
enum Content {
    /// A part of a buffer.
    Part { buffer: usize, range: Range<usize> },
    /// What a compressed view was decoded to.
    Decoded(Vec<u8>),
}

/// The bytes of a buffer view.
#[derive(Clone, Copy, Debug)]
pub(super) struct ViewData<'b> {
    pub(super) bytes: &'b [u8],
    /// Distance between elements in bytes, if the view gives it.
    pub(super) stride: Option<usize>,
}

impl<'a> Buffers<'a> {
    /// Reads all buffers. `data` is the data chunk of a binary file, `folder` that of the scene
    /// file.
    pub(super) fn read(document: &Document<'a>, data: Option<&'a [u8]>, folder: &Path) -> Self {
        let buffers = document.buffers.iter().enumerate();
        let mut read = Buffers {
            buffers: buffers
                .map(|(i, json)| read_buffer(json, data.filter(|_| i == 0), folder))
                .collect(),
            views: Vec::new(),
        };
        for json in &document.views {
            let view = read.read_view(json);
            read.views.push(view);
        }
        read
    }

    /// The data of the view of this index; `None` if it is invalid, which has been reported.
    pub(super) fn view(&self, index: usize) -> Option<ViewData<'_>> {
        let view = self.views.get(index)?.as_ref()?;
        Some(ViewData {
            bytes: self.bytes(view)?,
            stride: view.stride,
        })
    }

    fn bytes<'b>(&'b self, view: &'b View) -> Option<&'b [u8]> {
        match &view.content {
            Content::Part { buffer, range } => {
                Some(&self.buffers[*buffer].as_deref()?[range.clone()])
            }
            Content::Decoded(bytes) => Some(bytes),
        }
    }

    /// Size of all data in bytes.
    pub(super) fn total_bytes(&self) -> usize {
        let buffers = self.buffers.iter().flatten();
        buffers.map(|bytes| bytes.len()).sum()
    }

    fn read_view(&self, json: &Json<'a>) -> Option<View> {
        let Some((extension, name)) = compressed_views::of_view(json) else {
            return self.read_range(json);
        };
        if !compressed_views::READS_MESHOPT && !self.refers_to_placeholder(json) {
            return self.read_range(json);
        }
        let compressed = self.read_range(&extension)?;
        let decoded = compressed_views::decode_view(&extension, name, self.bytes(&compressed)?)?;
        Some(View {
            content: Content::Decoded(decoded),
            stride: stride(json).ok()?,
        })
    }

    /// Whether the buffer of a view has no content.
    fn refers_to_placeholder(&self, view: &Json<'a>) -> bool {
        let buffer = view.index("buffer", "buffers", self.buffers.len());
        buffer.is_some_and(|buffer| self.buffers[buffer].is_none())
    }

    /// The range of a buffer that `json` describes.
    fn read_range(&self, json: &Json<'a>) -> Option<View> {
        json.check_given("buffer")?;
        let buffer = json.index("buffer", "buffers", self.buffers.len())?;
        let offset = json.unsigned("byteOffset").unwrap_or(0);
        let length = json.required_unsigned("byteLength")?;
        let available = self.buffers[buffer].as_ref()?.len();
        let end = offset
            .checked_add(length)
            .filter(|end| *end <= available as u64);
        let Some(end) = end else {
            json.error(format!(
                "the view needs {length} bytes at offset {offset}, but buffer {buffer} has {available}"
            ));
            return None;
        };
        Some(View {
            content: Content::Part {
                buffer,
                range: offset as usize..end as usize,
            },
            stride: stride(json).ok()?,
        })
    }
}

/// The distance between elements that a view gives, in bytes. `Err` if it is not allowed, which is
/// reported.
fn stride(json: &Json<'_>) -> Result<Option<usize>, ()> {
    let stride = json.unsigned("byteStride");
    if let Some(stride) = stride.filter(|stride| !(1..=256).contains(stride)) {
        json.unexpected("byteStride", stride, "a number from 1 to 256");
        return Err(());
    }
    Ok(stride.map(|stride| stride as usize))
}

/// The content of one buffer. `data` is the data chunk, if the buffer may refer to it.
fn read_buffer<'a>(
    json: &Json<'a>,
    data: Option<&'a [u8]>,
    folder: &Path,
) -> Option<Cow<'a, [u8]>> {
    let length = json.required_unsigned("byteLength")?;
    if length == 0 {
        json.unexpected("byteLength", 0, "at least 1");
        return None;
    }
    if compressed_views::is_fallback(json) {
        return None;
    }
    let content: Cow<'a, [u8]> = match (json.string("uri"), data) {
        (Some(text), _) => uri::read(&json.get("uri")?, text, folder, "buffer")?.into(),
        (None, Some(data)) => data.into(),
        (None, None) => {
            json.error("the buffer has neither a `uri` nor the data chunk of a binary file");
            return None;
        }
    };
    if (content.len() as u64) < length {
        json.error(format!(
            "`byteLength` is {length}, but the data has {} bytes",
            content.len()
        ));
        return None;
    }
    Some(content)
}
