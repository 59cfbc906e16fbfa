//! Material variants: the extension KHR_materials_variants.

use super::json::Json;
use super::options::GltfOptions;
use crate::resolve::similar;

/// The index of the variant that the options name; `None` for the materials of the meshes. Unknown names are reported.
pub(super) fn chosen(root: &Json<'_>, options: &GltfOptions) -> Option<usize> {
    let wanted = options.variant.as_deref()?;
    let variants = root
        .extension("KHR_materials_variants")
        .map_or_else(Vec::new, |extension| extension.objects("variants"));
    let names: Vec<&str> = variants
        .iter()
        .map(|variant| variant.string("name").unwrap_or_default())
        .collect();
    let found = names.iter().position(|name| *name == wanted);
    if found.is_none() {
        let known = match names.as_slice() {
            [] => "the file has no variants".to_owned(),
            names => format!("variants of the file: {}", names.join(", ")),
        };
        let help = match similar(wanted, names.iter().copied()) {
            Some(similar) => format!("did you mean `{similar}`? {known}"),
            None => known,
        };
        let message = format!("the file has no material variant `{wanted}`");
        let reporter = root.reporter();
        reporter.error_with_help("/extensions/KHR_materials_variants", &message, help);
    }
    found
}

/// The index of the material of a primitive.
pub(super) fn material(
    primitive: &Json<'_>,
    variant: Option<usize>,
    count: usize,
) -> Option<usize> {
    let mappings = variant
        .and_then(|_| primitive.extension("KHR_materials_variants"))
        .map_or_else(Vec::new, |extension| extension.objects("mappings"));
    let is_chosen = |mapping: &&Json<'_>| {
        let variants = mapping.items("variants");
        let mut indices = variants.iter().filter_map(Json::as_unsigned);
        indices.any(|index| Some(index as usize) == variant)
    };
    match mappings.iter().find(is_chosen) {
        Some(mapping) => mapping.index("material", "materials", count),
        None => primitive.index("material", "materials", count),
    }
}
