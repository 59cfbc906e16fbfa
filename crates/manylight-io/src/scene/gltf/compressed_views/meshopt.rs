//! Buffer views of the extension EXT_meshopt_compression.

use super::super::json::Json;
use meshopt::{
    decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat,
    decode_index_buffer, decode_index_sequence, decode_vertex_buffer,
};

/// Largest ratio of decoded to compressed bytes: a constant byte takes 2 bits of a block of 256
/// vertices.
const MAX_RATIO: u64 = 1024;

/// The content of a compressed view. `None` for damaged data, which is reported.
pub(in super::super) fn decode(json: &Json<'_>, bytes: &[u8]) -> Option<Vec<u8>> {
    let count = json.required_unsigned("count")?;
    let stride = json.required_unsigned("byteStride")?;
    let limit = (bytes.len() as u64).saturating_mul(MAX_RATIO);
    if count.checked_mul(stride).is_none_or(|size| size > limit) {
        json.error_at(
            "count",
            format!(
                "found {count} elements of {stride} bytes, more than {} compressed bytes can hold",
                bytes.len()
            ),
        );
        return None;
    }
    let (count, stride) = (count as usize, stride as usize);
    let Some(mode) = json.string("mode") else {
        json.error("the property `mode` is missing");
        return None;
    };
    let wrong_stride = |expected: &str| {
        let message = format!("found {stride}, expected {expected} in the mode {mode}");
        json.error_at("byteStride", message);
        None
    };
    let decoded = match (mode, stride) {
        ("ATTRIBUTES", _) if stride.is_multiple_of(4) && (4..=256).contains(&stride) => {
            attributes(bytes, count, stride)
        }
        ("ATTRIBUTES", _) => return wrong_stride("a multiple of 4 up to 256"),
        ("TRIANGLES", 2) if count.is_multiple_of(3) => indices16(decode_index_buffer(bytes, count)),
        ("TRIANGLES", 4) if count.is_multiple_of(3) => indices32(decode_index_buffer(bytes, count)),
        ("TRIANGLES", 2 | 4) => {
            json.unexpected("count", count, "a multiple of 3");
            return None;
        }
        ("INDICES", 2) => indices16(decode_index_sequence(bytes, count)),
        ("INDICES", 4) => indices32(decode_index_sequence(bytes, count)),
        ("TRIANGLES" | "INDICES", _) => return wrong_stride("2 or 4"),
        _ => {
            let message = format!("found `{mode}`, expected ATTRIBUTES, TRIANGLES or INDICES");
            json.error_at("mode", message);
            return None;
        }
    };
    let Some(mut decoded) = decoded else {
        json.error("the compressed data cannot be decoded");
        return None;
    };
    let filter = json.string("filter").unwrap_or("NONE");
    if mode == "ATTRIBUTES" && !undo_filter(filter, stride, &mut decoded) {
        json.error_at(
            "filter",
            format!("found `{filter}` with a stride of {stride} bytes"),
        );
        return None;
    }
    Some(decoded)
}

/// Bytes of indices.
fn indices16(indices: meshopt::Result<Vec<u16>>) -> Option<Vec<u8>> {
    Some(
        indices
            .ok()?
            .into_iter()
            .flat_map(u16::to_le_bytes)
            .collect(),
    )
}

/// Bytes of indices.
fn indices32(indices: meshopt::Result<Vec<u32>>) -> Option<Vec<u8>> {
    Some(
        indices
            .ok()?
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .collect(),
    )
}

/// A vertex of `N` bytes.
#[derive(Clone, Copy)]
#[repr(transparent)]
struct Vertex<const N: usize>([u8; N]);

impl<const N: usize> Default for Vertex<N> {
    fn default() -> Self {
        Vertex([0; N])
    }
}

/// Bytes of vertices of `stride` bytes. The decoder takes the stride as the size of a type.
fn attributes(bytes: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    macro_rules! by_stride {
        ($($words:literal)*) => {
            match stride / 4 {
                $($words => decode_vertex_buffer::<Vertex<{ 4 * $words }>>(bytes, count)
                    .ok()
                    .map(|vertices| vertices.into_iter().flat_map(|v| v.0).collect()),)*
                _ => None,
            }
        };
    }
    by_stride!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}

/// Undoes the filter that was applied before compression. `false` for a filter that does not exist
/// for this stride.
fn undo_filter(filter: &str, stride: usize, data: &mut [u8]) -> bool {
    match (filter, stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4) => in_place(data, i8::from_le_bytes, i8::to_le_bytes, decode_filter_oct),
        ("OCTAHEDRAL", 8) => in_place(
            data,
            i16::from_le_bytes,
            i16::to_le_bytes,
            decode_filter_oct,
        ),
        ("QUATERNION", 8) => in_place(
            data,
            i16::from_le_bytes,
            i16::to_le_bytes,
            decode_filter_quat,
        ),
        ("EXPONENTIAL", _) => {
            in_place::<_, 4, 1>(
                data,
                u32::from_le_bytes,
                u32::to_le_bytes,
                decode_filter_exp,
            );
        }
        ("COLOR", 4) => in_place(
            data,
            u8::from_le_bytes,
            u8::to_le_bytes,
            decode_filter_color,
        ),
        ("COLOR", 8) => in_place(
            data,
            u16::from_le_bytes,
            u16::to_le_bytes,
            decode_filter_color,
        ),
        _ => return false,
    }
    true
}

/// Applies `filter` to the vectors of `N` components of `SIZE` bytes each that `data` holds.
fn in_place<C: Copy, const SIZE: usize, const N: usize>(
    data: &mut [u8],
    read: fn([u8; SIZE]) -> C,
    write: fn(C) -> [u8; SIZE],
    filter: fn(&mut [[C; N]]),
) {
    let components: Vec<C> = data
        .as_chunks::<SIZE>()
        .0
        .iter()
        .map(|b| read(*b))
        .collect();
    let mut vectors: Vec<[C; N]> = components.as_chunks::<N>().0.to_vec();
    filter(&mut vectors);
    for (bytes, value) in data
        .as_chunks_mut::<SIZE>()
        .0
        .iter_mut()
        .zip(vectors.into_flattened())
    {
        *bytes = write(value);
    }
}
