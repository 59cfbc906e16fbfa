//! The directives of the language and the forms of their arguments.

use crate::suggest::did_you_mean;

/// The form of the arguments of a directive.
#[derive(Clone, Copy)]
pub(super) enum Form {
    None,
    Numbers(usize),
    Names { least: usize, most: usize },
    Word,
    Declaration,
    Texture,
    Option,
}

const fn names(least: usize, most: usize) -> Form {
    Form::Names { least, most }
}

/// All directives; those of PBRT v3 last.
const DIRECTIVES: [(&str, Form); 45] = [
    ("Accelerator", Form::Declaration),
    ("ActiveTransform", Form::Word),
    ("AreaLightSource", Form::Declaration),
    ("Attribute", Form::Declaration),
    ("AttributeBegin", Form::None),
    ("AttributeEnd", Form::None),
    ("Camera", Form::Declaration),
    ("ColorSpace", names(1, 1)),
    ("ConcatTransform", Form::Numbers(16)),
    ("CoordSysTransform", names(1, 1)),
    ("CoordinateSystem", names(1, 1)),
    ("Film", Form::Declaration),
    ("Identity", Form::None),
    ("Import", names(1, 1)),
    ("Include", names(1, 1)),
    ("Integrator", Form::Declaration),
    ("LightSource", Form::Declaration),
    ("LookAt", Form::Numbers(9)),
    ("MakeNamedMaterial", Form::Declaration),
    ("MakeNamedMedium", Form::Declaration),
    ("Material", Form::Declaration),
    ("MediumInterface", names(1, 2)),
    ("NamedMaterial", names(1, 1)),
    ("ObjectBegin", names(1, 1)),
    ("ObjectEnd", Form::None),
    ("ObjectInstance", names(1, 1)),
    ("Option", Form::Option),
    ("PixelFilter", Form::Declaration),
    ("ReverseOrientation", Form::None),
    ("Rotate", Form::Numbers(4)),
    ("Sampler", Form::Declaration),
    ("Scale", Form::Numbers(3)),
    ("Shape", Form::Declaration),
    ("Texture", Form::Texture),
    ("Transform", Form::Numbers(16)),
    ("TransformBegin", Form::None),
    ("TransformEnd", Form::None),
    ("TransformTimes", Form::Numbers(2)),
    ("Translate", Form::Numbers(3)),
    ("WorldBegin", Form::None),
    ("WorldEnd", Form::None),
    ("Renderer", Form::Declaration),
    ("SurfaceIntegrator", Form::Declaration),
    ("Volume", Form::Declaration),
    ("VolumeIntegrator", Form::Declaration),
];

/// The form of the arguments of a directive.
pub(super) fn form_of(word: &str) -> Option<Form> {
    let found = DIRECTIVES.iter().find(|(name, _)| *name == word);
    found.map(|(_, form)| *form)
}

/// The question whether a directive similar to `word` is meant.
pub(super) fn similar_directive(word: &str) -> Option<String> {
    did_you_mean(word, DIRECTIVES.iter().map(|(name, _)| *name))
}

/// Whether `word` is a directive.
pub(super) fn is_directive(word: &str) -> bool {
    form_of(word).is_some()
}
