//! What is made of the declarations of a scene.

use super::super::assets::{Assets, Finish};
use super::super::growth::{Bound, Growth};
use super::super::names::ShapeNames;
use super::super::options::DEFAULT_FPS;
use super::super::plugins::report_unknown;
use super::super::sink::{FileSpan, Problem, Sink, Text};
use super::bindings::{Bindings, NameSpace, Place};
use super::colors::ColorUse;
use super::entities::{Entity, MaterialRef};
use glam::DMat4;
use manylight::geometry::Mesh;
use manylight::ids::{MaterialId, ShapeId, TextureId};
use manylight::math::Affine3A;
use manylight::scene::{PrimitiveDesc, SceneDesc};
use manylight::texture::ColorInput;
use std::cell::{Cell, RefCell};
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// Bytes of tessellated surfaces from the bytes of the files. Paraboloids, the largest for their
/// text, reach a ratio of 8000 if each has its transform; files that are included again and again
/// exceed the bound.
const TESSELLATED: Bound = Bound {
    ratio: 10_000,
    always_allowed: 64 << 20,
};

/// What has been made of declarations, so that it is made once.
#[derive(Default)]
pub(super) struct Made {
    /// In the order of the `Texture` directives.
    pub(super) textures: Vec<ColorInput>,
    /// The last definition of each name, as an index in [`Made::textures`].
    pub(super) float_textures: HashMap<String, usize>,
    pub(super) spectrum_textures: HashMap<String, usize>,
    /// Image textures by file and settings.
    pub(super) bitmaps: HashMap<String, TextureId>,
    /// Roughness textures of PBRT v3 by their source.
    pub(super) mapped_textures: HashMap<TextureId, TextureId>,
    /// Materials with a coat of the mean roughness of a texture.
    pub(super) mean_coats: HashMap<TextureId, Rc<RefCell<Vec<MaterialId>>>>,
    /// In the order of the `MakeNamedMaterial` directives; `None` for invalid ones.
    pub(super) named_materials: Vec<Option<MaterialId>>,
    /// The last definition of each name, as an index in [`Made::named_materials`].
    pub(super) material_names: HashMap<String, usize>,
    /// In the order of the `Material` directives.
    pub(super) materials: Vec<MaterialId>,
    pub(super) default_material: Option<MaterialId>,
    /// Materials that depend on texture coordinates.
    pub(super) textured: HashSet<MaterialId>,
    /// Materials behind opacities of shapes.
    pub(super) masks: HashMap<(MaterialId, String), MaterialId>,
    /// The whole disk.
    pub(super) disk: Option<ShapeId>,
}

/// Curves that become one mesh.
pub(super) struct PendingCurves {
    /// In the frame of `transform`.
    pub(super) mesh: Mesh,
    pub(super) transform: DMat4,
    pub(super) material: MaterialRef,
    pub(super) primitive: PrimitiveDesc,
}

/// Fills a [`SceneDesc`] from the declarations of a scene.
pub(super) struct Builder<'a> {
    pub(super) sink: &'a Sink,
    /// Whether the scene uses names of PBRT v3.
    pub(super) is_v3: bool,
    /// Factor of all emission: the imaging ratio of the film.
    pub(super) film_scale: f32,
    /// Frames per second of moving cameras.
    pub(super) fps: f32,
    pub(super) desc: SceneDesc,
    pub(super) assets: Assets,
    pub(super) made: Made,
    /// The curves that have been collected.
    pub(super) curves: Option<PendingCurves>,
    /// The definitions of names, by the rules of PBRT v3.
    pub(super) bindings: Bindings,
    /// Number of uses of textures so far.
    pub(super) texture_uses: Cell<usize>,
    pub(super) shape_names: ShapeNames,
    /// Meshes of surfaces that the files describe by some numbers.
    pub(super) tessellated: Growth,
    /// Triangles of subdivision surfaces of many levels.
    pub(super) finely_subdivided: usize,
    /// Colors that are read as numbers and should be gray, with what they are.
    pub(super) gray_colors: Vec<(FileSpan, TextureId, String)>,
    /// Environment maps that should be square, with the sizes that are found.
    pub(super) square_maps: Vec<(FileSpan, Rc<Cell<[usize; 2]>>)>,
    pub(super) finish: Vec<Finish>,
}

impl<'a> Builder<'a> {
    pub(super) fn new(sink: &'a Sink, is_v3: bool, text_bytes: usize) -> Self {
        Builder {
            sink,
            is_v3,
            film_scale: 1.0,
            fps: DEFAULT_FPS,
            desc: SceneDesc::default(),
            assets: Assets::default(),
            made: Made::default(),
            curves: None,
            texture_uses: Cell::new(0),
            shape_names: ShapeNames::default(),
            tessellated: Growth::new(text_bytes, TESSELLATED),
            finely_subdivided: 0,
            bindings: Bindings::default(),
            gray_colors: Vec::new(),
            square_maps: Vec::new(),
            finish: Vec::new(),
        }
    }

    /// Defers a change of the description until all files have been read.
    pub(super) fn after_loading(&mut self, finish: impl FnOnce(&mut SceneDesc) + 'static) {
        self.finish.push(Box::new(finish));
    }

    /// The index of the definition that `name` has at `place`, where `last` is the last one of the
    /// file. Names that PBRT v3 would not find there have the last definition, a warning.
    pub(super) fn definition(
        &self,
        space: NameSpace,
        name: &Text,
        place: Place,
        last: &HashMap<String, usize>,
    ) -> Option<usize> {
        let bound = self.bindings.at(space, &name.value, place);
        let last = last.get(&name.value).copied();
        if !self.is_v3 {
            return last;
        }
        if bound.is_none() && last.is_some() {
            let message = format!(
                "PBRT v3 does not find `{}` here: it is defined later or in another block",
                name.value
            );
            let problem = Problem::new("scene::suspicious", name.span, message);
            self.sink
                .warn_once(format!("unbound {}", name.value), problem);
        }
        bound.or(last)
    }

    /// Reports the second definition of a name, which is an error in PBRT v4.
    pub(super) fn defined_twice(&self, what: &str, name: &Text) {
        let message = format!("the {what} `{}` is defined twice", name.value);
        self.sink
            .error_at("scene::duplicate_id", name.span, message);
    }

    /// Notes that the declaration that is being read uses a texture.
    pub(super) fn note_texture(&self) {
        self.texture_uses.set(self.texture_uses.get() + 1);
    }

    /// How the color of a light is meant.
    pub(super) fn emission_use(&self) -> ColorUse {
        if self.is_v3 {
            ColorUse::EmissionV3
        } else {
            ColorUse::Emission
        }
    }

    /// The transform of an entity. Singular transforms are reported and replaced by the identity.
    pub(super) fn world_from(&self, entity: &Entity<'_>) -> Affine3A {
        self.placement(entity.transform, entity.params.plugin.span)
            .unwrap_or(Affine3A::IDENTITY)
    }

    /// A transform in single precision. `None` if it is singular, which is reported at `span`.
    pub(super) fn placement(&self, transform: DMat4, span: FileSpan) -> Option<Affine3A> {
        let affine = Affine3A::from_mat4(transform.as_mat4());
        let inverse = glam::Mat3::from(affine.matrix3).as_dmat3().inverse();
        if affine.is_finite() && inverse.is_finite() {
            return Some(affine);
        }
        let message = "the current transform is singular or too large";
        self.sink.error_at("scene::bad_value", span, message);
        None
    }

    /// Reports that no plugin of the family has this name.
    pub(super) fn unknown_plugin<'n>(
        &self,
        entity: &Entity<'_>,
        known: impl IntoIterator<Item = &'n str>,
    ) {
        let params = &entity.params;
        self.unknown_name(params.family, &params.plugin, known);
    }

    pub(super) fn unknown_name<'n>(
        &self,
        family: &str,
        name: &Text,
        known: impl IntoIterator<Item = &'n str>,
    ) {
        let mut known: Vec<&str> = known.into_iter().collect();
        known.sort_unstable();
        let label = format!("no {family} has this type");
        let list = format!("known types: {}", known.join(", "));
        report_unknown(self.sink, (family, name), known, (label, list));
    }
}
