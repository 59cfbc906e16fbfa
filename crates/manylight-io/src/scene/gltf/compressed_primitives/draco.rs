//! Primitives of the extension KHR_draco_mesh_compression: all attributes and the triangles in one
//! stream.

use super::super::accessors::{Accessors, Component, Decoded};
use super::super::json::Json;
use draco_core::draco_types::DataType;
use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute, PointIndex};

/// Most bytes that one primitive may decode to: 32 attributes of four floats for 4 million
/// vertices. A stream of some hundred bytes may declare more than any machine holds.
const MAX_DECODED_BYTES: u64 = 2 << 30;

/// The data of the accessors of a compressed primitive. `None` for damaged data, which is reported.
pub(super) fn decode<'a>(
    primitive: &Json<'a>,
    extension: &Json<'a>,
    accessors: &Accessors<'a, '_>,
) -> Option<Decoded> {
    if let Some(mode) = primitive.unsigned("mode").filter(|mode| *mode != 4) {
        primitive.unexpected("mode", mode, "4 (triangles) in compressed geometry");
        return None;
    }
    let mesh = decode_mesh(extension, accessors)?;
    let mut decoded = Decoded::default();
    if let Some(at) = primitive.get("indices") {
        let (index, component) = accessors.target(&at)?;
        let corners = mesh.faces().iter().flatten();
        let values = corners.map(|corner| f64::from(corner.0));
        decoded.insert(index, bytes_of(values, component), mesh.num_faces() * 3);
    }
    let attributes = primitive.member("attributes")?;
    for (name, id) in extension.member("attributes")?.members() {
        let Some(at) = attributes.get(name) else {
            id.error(format!(
                "the primitive has no attribute `{name}` that would describe the compressed one"
            ));
            return None;
        };
        let number = id.as_unsigned()?;
        let attribute = u32::try_from(number)
            .ok()
            .and_then(|number| mesh.attribute_by_unique_id(number));
        let Some(attribute) = attribute else {
            id.error(format!("the compressed data has no attribute {number}"));
            return None;
        };
        let (index, component) = accessors.target(&at)?;
        let values = values_of(attribute, mesh.num_points());
        decoded.insert(index, bytes_of(values, component), mesh.num_points());
    }
    Some(decoded)
}

fn decode_mesh<'a>(extension: &Json<'a>, accessors: &Accessors<'a, '_>) -> Option<Mesh> {
    extension.check_given("bufferView")?;
    let view = extension.index("bufferView", "bufferViews", accessors.document.views.len())?;
    let data = accessors.buffers.view(view)?;
    let mut limits = DecodeLimits::default();
    limits.max_decoded_bytes = MAX_DECODED_BYTES;
    let mut buffer = DecoderBuffer::new(data.bytes).with_limits(limits);
    let mut mesh = Mesh::new();
    if let Err(error) = MeshDecoder::new().decode(&mut buffer, &mut mesh) {
        extension.error(format!("the Draco data cannot be decoded: {error}"));
        return None;
    }
    Some(mesh)
}

/// The components of all points, one point after another. What damaged data lacks is 0.
fn values_of(attribute: &PointAttribute, points: usize) -> impl Iterator<Item = f64> {
    let components = usize::from(attribute.num_components());
    let kind = attribute.data_type();
    let size = kind.byte_length();
    let stride = attribute.byte_stride() as usize;
    let data = attribute.buffer().data();
    (0..points).flat_map(move |point| {
        let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        (0..components).map(move |c| {
            let start = value.checked_mul(stride).map(|start| start + c * size);
            let bytes = start.and_then(|start| data.get(start..start.checked_add(size)?));
            bytes.map_or(0.0, |bytes| scalar(kind, bytes))
        })
    })
}

/// The value of `bytes`, which has the size of `kind`.
fn scalar(kind: DataType, bytes: &[u8]) -> f64 {
    /// The first `N` bytes.
    fn first<const N: usize>(bytes: &[u8]) -> [u8; N] {
        std::array::from_fn(|i| bytes[i])
    }
    match kind {
        DataType::Int8 => f64::from(bytes[0] as i8),
        DataType::Uint8 | DataType::Bool => f64::from(bytes[0]),
        DataType::Int16 => f64::from(i16::from_le_bytes(first(bytes))),
        DataType::Uint16 => f64::from(u16::from_le_bytes(first(bytes))),
        DataType::Int32 => f64::from(i32::from_le_bytes(first(bytes))),
        DataType::Uint32 => f64::from(u32::from_le_bytes(first(bytes))),
        DataType::Int64 => i64::from_le_bytes(first(bytes)) as f64,
        DataType::Uint64 => u64::from_le_bytes(first(bytes)) as f64,
        DataType::Float32 => f64::from(f32::from_le_bytes(first(bytes))),
        DataType::Float64 => f64::from_le_bytes(first(bytes)),
        _ => 0.0,
    }
}

/// The values as components of an accessor.
fn bytes_of(values: impl Iterator<Item = f64>, component: Component) -> Vec<u8> {
    let mut bytes = Vec::new();
    for value in values {
        component.write(value, &mut bytes);
    }
    bytes
}
