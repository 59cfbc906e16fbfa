//! What materials need of the vertices of a mesh.

use super::document::Document;
use super::json::Json;
use super::textures::uv_set;

/// What a material needs of the vertices of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct VertexNeeds {
    /// Sets of texture coordinates; the first is the primary one, along which tangents are defined.
    pub(super) sets: Vec<usize>,
    /// Whether the directions of the tangents matter.
    pub(super) tangents: bool,
}

/// All references to textures within a material.
fn texture_infos<'a>(json: &Json<'a>, found: &mut Vec<Json<'a>>) {
    for (name, member) in json.members() {
        if name.ends_with("Texture") {
            found.push(member);
        } else if name != "extras" {
            texture_infos(&member, found);
        }
    }
}

/// What the material of this index needs of the vertices.
pub(super) fn vertex_needs(document: &Document<'_>, index: Option<usize>) -> VertexNeeds {
    let Some(json) = index.map(|index| &document.materials[index]) else {
        return VertexNeeds::default();
    };
    let mut infos = Vec::new();
    texture_infos(json, &mut infos);
    infos.retain(|info| !info.path().ends_with("/occlusionTexture"));
    let rank = |info: &Json<'_>| match info.path().rsplit('/').next() {
        Some("normalTexture") => 0,
        Some("baseColorTexture" | "diffuseTexture") => 1,
        _ => 2,
    };
    infos.sort_by_key(rank);
    let mut sets = Vec::new();
    for set in infos.iter().map(uv_set) {
        if !sets.contains(&set) {
            sets.push(set);
        }
    }
    let tangents =
        json.has("normalTexture") || json.extension("KHR_materials_anisotropy").is_some();
    VertexNeeds { sets, tangents }
}
