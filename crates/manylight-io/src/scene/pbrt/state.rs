//! The graphics state: what directives change, and what shapes and lights inherit.

use super::super::parameters::Parameters;
use super::super::sink::{Problem, Sink, Text};
use super::bindings::Place;
use super::colors::ColorSpace;
use super::entities::{Entity, MaterialRef};
use super::param_types::Param;
use super::params::Params;
use super::transforms;
use glam::{DMat4, DVec3};
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

/// The transforms at the start and the end of the shutter interval.
type TransformPair = [DMat4; 2];

/// Parameters of `Attribute` directives, by target.
#[derive(Clone, Debug, Default)]
pub(super) struct Inherited {
    pub(super) shape: Rc<Vec<Param>>,
    pub(super) light: Rc<Vec<Param>>,
    pub(super) material: Rc<Vec<Param>>,
    pub(super) texture: Rc<Vec<Param>>,
}

/// What `AttributeBegin` saves.
#[derive(Clone)]
pub(super) struct GraphicsState<'a> {
    pub(super) transforms: TransformPair,
    /// Which of the transforms the directives change.
    active: [bool; 2],
    pub(super) reverse_orientation: bool,
    pub(super) material: MaterialRef,
    pub(super) area_light: Option<Rc<Entity<'a>>>,
    pub(super) color_space: ColorSpace,
    pub(super) inherited: Inherited,
}

impl Default for GraphicsState<'_> {
    fn default() -> Self {
        GraphicsState {
            transforms: [DMat4::IDENTITY; 2],
            active: [true; 2],
            reverse_orientation: false,
            material: MaterialRef::Default,
            area_light: None,
            color_space: ColorSpace::default(),
            inherited: Inherited::default(),
        }
    }
}

impl<'a> GraphicsState<'a> {
    /// Resets the state for the description of the world, in which inherited parameters and the
    /// color space remain.
    pub(super) fn begin_world(&mut self) {
        self.transforms = [DMat4::IDENTITY; 2];
        self.active = [true; 2];
        self.reverse_orientation = false;
    }

    fn change(&mut self, change: impl Fn(DMat4) -> DMat4) {
        for (transform, active) in self.transforms.iter_mut().zip(self.active) {
            if active {
                *transform = change(*transform);
            }
        }
    }

    /// Applies a directive with `numbers`.
    pub(super) fn transform(&mut self, directive: &Text, numbers: &[f64], sink: &Sink) {
        match directive.value.as_str() {
            "Identity" => self.change(|_| DMat4::IDENTITY),
            "Transform" => self.change(|_| transforms::matrix(numbers)),
            "ConcatTransform" => self.change(|m| m * transforms::matrix(numbers)),
            "Translate" => self.change(|m| m * DMat4::from_translation(DVec3::from_slice(numbers))),
            "Scale" => {
                let scale = DVec3::from_slice(numbers);
                if scale.min_element() * scale.max_element() == 0.0
                    || scale.x * scale.y * scale.z == 0.0
                {
                    let message = "a factor of a scale is 0, expected nonzero factors";
                    sink.error_at("scene::bad_value", directive.span, message);
                } else {
                    self.change(|m| m * DMat4::from_scale(scale));
                }
            }
            "Rotate" => self.change(|m| m * transforms::rotation(numbers)),
            "LookAt" => match transforms::look_at(numbers) {
                Some(look_at) => self.change(|m| m * look_at),
                None => {
                    let message =
                        "the point of view, the target and the up vector do not span a frame";
                    let problem = Problem::new("scene::bad_value", directive.span, message);
                    sink.error(problem.help("expected three different directions"));
                }
            },
            _ => {}
        }
    }

    /// Applies `ActiveTransform`.
    pub(super) fn activate(&mut self, which: &Text, sink: &Sink) {
        self.active = match which.value.as_str() {
            "All" => [true, true],
            "StartTime" => [true, false],
            "EndTime" => [false, true],
            other => {
                let message = format!("found `{other}`, expected `All`, `StartTime` or `EndTime`");
                sink.error_at("scene::syntax", which.span, message);
                [true, true]
            }
        };
    }

    /// Adds the parameters of `Attribute "target"`; later ones come first.
    pub(super) fn inherit(&mut self, target: &Text, params: Vec<Param>, sink: &Sink) {
        let inherited = &mut self.inherited;
        let list = match target.value.as_str() {
            "shape" => &mut inherited.shape,
            "light" => &mut inherited.light,
            "material" => &mut inherited.material,
            "texture" => &mut inherited.texture,
            "medium" => return,
            other => {
                let message = format!("unknown target `{other}` of attributes");
                let help = "expected shape, light, material, medium or texture";
                sink.error(Problem::new("scene::bad_value", target.span, message).help(help));
                return;
            }
        };
        let older = list.iter().cloned();
        *list = Rc::new(params.into_iter().chain(older).collect());
    }

    /// The transform at the start. Warns once if the other one differs.
    pub(super) fn start(&self, at: &Text, sink: &Sink) -> DMat4 {
        if self.transforms[0] != self.transforms[1] {
            let message = "only cameras move; the transform at the start is used";
            sink.unsupported("motion", at.span, message);
        }
        self.transforms[0]
    }

    /// The transform of what may move at the end of its motion; `None` if it stands still.
    pub(super) fn at_end(&self) -> Option<DMat4> {
        let [start, end] = self.transforms;
        (start != end).then_some(end)
    }

    /// A declaration in this state, at `place`. It stands still, as all but cameras do.
    pub(super) fn entity(
        &self,
        params: Params<'a>,
        folders: &Rc<[PathBuf]>,
        place: Place,
    ) -> Entity<'a> {
        self.start(&params.plugin, params.sink());
        self.moving_entity(params, folders, place)
    }

    /// A declaration in this state, at `place`, of what may move.
    pub(super) fn moving_entity(
        &self,
        params: Params<'a>,
        folders: &Rc<[PathBuf]>,
        place: Place,
    ) -> Entity<'a> {
        Entity {
            place,
            folders: Rc::clone(folders),
            transform: self.transforms[0],
            params,
            color_space: self.color_space,
        }
    }
}

/// What a `...Begin` directive opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Block {
    Attribute,
    Transform,
    Object,
}

impl Block {
    /// The directives that open and close the block.
    pub(super) fn names(self) -> [&'static str; 2] {
        match self {
            Block::Attribute => ["AttributeBegin", "AttributeEnd"],
            Block::Transform => ["TransformBegin", "TransformEnd"],
            Block::Object => ["ObjectBegin", "ObjectEnd"],
        }
    }
}

/// Named coordinate systems.
pub(super) type CoordinateSystems = HashMap<String, TransformPair>;
