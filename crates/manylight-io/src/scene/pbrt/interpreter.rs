//! Runs the statements of a scene file and its included files, and collects the declarations.

use super::super::files::{find_external_file, identity};
use super::super::growth::Expansion;
use super::super::parameters::unresolved;
use super::super::sink::{FileSpan, Problem, Sink, Text};
use super::bindings::{NameSpace, TextureType};
use super::colors::ColorSpace;
use super::entities::{
    Entities, Entity, InstanceEntity, MaterialRef, Named, ShapeEntity, TextureEntity, WrongBlock,
};
use super::lexer::Lexer;
use super::param_types::Param;
use super::params::Params;
use super::parser::{Arguments, Parser, Statement};
use super::source::read_text;
use super::state::{Block, CoordinateSystems, GraphicsState};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

/// Most nested inclusions, as a bound for files that include themselves.
const MAX_INCLUDES: usize = 40;
/// Most nested blocks.
const MAX_BLOCKS: usize = 10_000;

/// The state of a run.
pub(super) struct Interpreter<'a> {
    sink: &'a Sink,
    /// Folders of the scene file and of the current file, in which files are searched in this
    /// order.
    folders: Rc<[PathBuf]>,
    state: GraphicsState<'a>,
    stack: Vec<(Block, FileSpan, GraphicsState<'a>)>,
    systems: CoordinateSystems,
    in_world: bool,
    /// Index of the object to which shapes belong.
    object: Option<usize>,
    /// Files that are being read, without symbolic links.
    open_files: Vec<PathBuf>,
    pub(super) expansion: Expansion,
    pub(super) entities: Entities<'a>,
}

impl<'a> Interpreter<'a> {
    /// Runs the scene file `path` with content `text`.
    pub(super) fn run(path: &Path, text: Arc<str>, sink: &'a Sink) -> Interpreter<'a> {
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
        let mut interpreter = Interpreter {
            sink,
            folders: Rc::new([folder]),
            state: GraphicsState::default(),
            stack: Vec::new(),
            systems: CoordinateSystems::new(),
            in_world: false,
            object: None,
            open_files: Vec::new(),
            expansion: Expansion::default(),
            entities: Entities::default(),
        };
        let file = sink.add_file(path, Arc::clone(&text));
        interpreter.entities.start = Some(FileSpan {
            file,
            start: 0,
            end: 0,
        });
        let identity = identity(path);
        // The first file is below any bound.
        let _ = interpreter.expansion.include(&identity, text.len());
        interpreter.file(identity, Lexer::new(text, file), 0);
        interpreter.end_blocks(0);
        interpreter
    }

    /// Runs one file. The outer `depth` blocks cannot end in it.
    fn file(&mut self, identity: PathBuf, lexer: Lexer, depth: usize) {
        self.open_files.push(identity);
        let mut parser = Parser::new(lexer);
        while let Some(statement) = parser.next(self.sink) {
            self.statement(statement, depth);
        }
        self.open_files.pop();
    }

    /// Ends all but the outer `depth` blocks, which is reported.
    fn end_blocks(&mut self, depth: usize) {
        while self.stack.len() > depth {
            let Some((block, span, state)) = self.stack.pop() else {
                break;
            };
            self.restore(block, state);
            let [begin, end] = block.names();
            let message = format!("`{begin}` has no `{end}` before the end of the file");
            let problem = Problem::new("scene::unbalanced", span, message).label("opened here");
            self.wrong_block(problem, false);
        }
    }

    /// Notes the wrong end of a block. Whether it is an error depends on the version.
    fn wrong_block(&mut self, problem: Problem, is_valid_in_v3: bool) {
        self.entities.wrong_blocks.push(WrongBlock {
            problem,
            is_valid_in_v3,
        });
    }

    /// Restores the state before a block that ends.
    fn restore(&mut self, block: Block, state: GraphicsState<'a>) {
        match block {
            // `TransformEnd` restores the transform alone.
            Block::Transform => self.state.transforms = state.transforms,
            Block::Attribute | Block::Object => {
                self.entities.bindings.end_block();
                self.state = state;
            }
        }
    }

    fn statement(&mut self, statement: Statement, depth: usize) {
        let Statement {
            directive,
            arguments,
        } = statement;
        match arguments {
            Arguments::None => self.plain(&directive, depth),
            Arguments::Numbers(numbers) if directive.value != "TransformTimes" => {
                self.state.transform(&directive, &numbers, self.sink)
            }
            Arguments::Numbers(times) => {
                self.entities.motion_times = times.first_chunk().copied();
            }
            Arguments::Word(which) => self.state.activate(&which, self.sink),
            Arguments::Names(names) => self.named(&directive, names, depth),
            Arguments::Declaration(name, list) => self.declaration(&directive, name, list),
            Arguments::Texture(names, list) => self.texture(names, list),
            Arguments::Option(param) => self.option(&param),
        }
    }

    fn plain(&mut self, directive: &Text, depth: usize) {
        match directive.value.as_str() {
            "WorldBegin" => self.begin_world(directive),
            "WorldEnd" => self.entities.has_world_end = true,
            "Identity" => self.state.transform(directive, &[], self.sink),
            "ReverseOrientation" => {
                self.state.reverse_orientation = !self.state.reverse_orientation
            }
            "AttributeBegin" => self.open(Block::Attribute, directive),
            "TransformBegin" => self.open(Block::Transform, directive),
            "AttributeEnd" => self.close(Block::Attribute, directive, depth),
            "TransformEnd" => self.close(Block::Transform, directive, depth),
            _ => self.close(Block::Object, directive, depth),
        }
    }

    fn begin_world(&mut self, directive: &Text) {
        if self.in_world {
            let message = "`WorldBegin` is given twice";
            self.sink.error_at("scene::syntax", directive.span, message);
        }
        self.in_world = true;
        self.state.begin_world();
        self.systems
            .insert("world".to_owned(), self.state.transforms);
    }

    fn open(&mut self, block: Block, directive: &Text) {
        if self.stack.len() >= MAX_BLOCKS {
            let message = format!("blocks are nested more than {MAX_BLOCKS} deep");
            self.sink
                .error_at("scene::nesting", directive.span, message);
            return;
        }
        if block != Block::Transform {
            self.entities.bindings.begin_block();
        }
        self.stack.push((block, directive.span, self.state.clone()));
    }

    /// Ends a block. PBRT v3 counts blocks: it ends the innermost one that saves the state, be it
    /// of attributes or of an object.
    fn close(&mut self, block: Block, directive: &Text, depth: usize) {
        let [begin, end] = block.names();
        let opened = self.stack.last().filter(|_| self.stack.len() > depth);
        let is_missing = opened.is_none_or(|(found, ..)| {
            block == Block::Object && *found != block && self.object.is_none()
        });
        if block == Block::Object {
            self.object = None;
        }
        let Some((found, span, _)) = opened.filter(|_| !is_missing) else {
            let message = format!("`{end}` without `{begin}`");
            let problem = Problem::new("scene::unbalanced", directive.span, message);
            self.wrong_block(problem, false);
            return;
        };
        let (found, span) = (*found, *span);
        if found != block {
            let [begin, expected] = found.names();
            let message = format!("found `{end}`, expected `{expected}`");
            let problem = Problem::new("scene::unbalanced", directive.span, message);
            let both_save = found != Block::Transform && block != Block::Transform;
            self.wrong_block(
                problem.second(span, format!("`{begin}` is here")),
                both_save,
            );
            if !both_save {
                return;
            }
        }
        if let Some((_, _, state)) = self.stack.pop() {
            self.restore(found, state);
        }
    }

    fn named(&mut self, directive: &Text, mut names: Vec<Text>, depth: usize) {
        let name = names.swap_remove(0);
        match directive.value.as_str() {
            "Include" | "Import" => self.include(directive, &name, depth),
            "NamedMaterial" => {
                let place = self.entities.bindings.here();
                self.state.material = MaterialRef::Named(name, place);
            }
            "CoordinateSystem" => {
                self.systems.insert(name.value, self.state.transforms);
            }
            "CoordSysTransform" => self.use_system(&name),
            "ColorSpace" => {
                if let Some(space) = ColorSpace::named(&name, self.sink) {
                    self.state.color_space = space;
                }
            }
            "ObjectBegin" => self.begin_object(directive, name),
            "ObjectInstance" => self.instance(directive, name),
            _ => self.ignore_medium(directive),
        }
    }

    fn use_system(&mut self, name: &Text) {
        if let Some(transforms) = self.systems.get(&name.value) {
            self.state.transforms = *transforms;
            return;
        }
        let message = format!("no coordinate system has the name `{}`", name.value);
        let known = self.systems.keys().map(String::as_str);
        self.sink.error(unresolved(name, message, known));
    }

    /// Runs another file. The text of an included file may end blocks around it, that of an
    /// imported one may not.
    fn include(&mut self, directive: &Text, name: &Text, depth: usize) {
        // Further errors would not be listed.
        if self.sink.is_full() {
            return;
        }
        let Some(path) = find_external_file(self.sink, &self.folders, name, "included file") else {
            return;
        };
        let wanted = identity(&path);
        let is_open = self.open_files.contains(&wanted);
        if is_open || self.open_files.len() > MAX_INCLUDES {
            let message = if is_open {
                format!("the file `{}` includes itself", name.value)
            } else {
                format!("included files are nested more than {MAX_INCLUDES} deep")
            };
            self.sink
                .error_at("scene::circular_reference", name.span, message);
            return;
        }
        let Some(text) = read_text(&path, name, self.sink) else {
            return;
        };
        if let Err(exceeded) = self.expansion.include(&wanted, text.len()) {
            exceeded.report(self.sink, "scene::too_many_includes", name.span);
            return;
        }
        let file = self.sink.add_file(&path, Arc::clone(&text));
        let folders = Rc::clone(&self.folders);
        let main = folders[0].clone();
        let own = path.parent().map(Path::to_owned).filter(|own| *own != main);
        self.folders = std::iter::once(main).chain(own).collect();
        let lexer = Lexer::new(text, file);
        if directive.value == "Import" {
            let depth = self.stack.len();
            self.file(wanted, lexer, depth);
            self.end_blocks(depth);
        } else {
            self.file(wanted, lexer, depth);
        }
        self.folders = folders;
    }

    fn begin_object(&mut self, directive: &Text, name: Text) {
        if self.is_in_object() {
            let message = "`ObjectBegin` inside of another object";
            self.sink
                .error_at("scene::nested_group", directive.span, message);
        }
        self.open(Block::Object, directive);
        self.object = Some(self.entities.objects.len());
        let objects = &mut self.entities.objects;
        self.entities
            .object_ids
            .insert(name.value.clone(), objects.len());
        objects.push(Named {
            name,
            value: Vec::new(),
        });
    }

    fn is_in_object(&self) -> bool {
        self.object.is_some()
    }

    fn instance(&mut self, directive: &Text, object: Text) {
        if self.is_in_object() {
            let message = "`ObjectInstance` inside of an object is not possible";
            self.sink
                .error_at("scene::nested_group", directive.span, message);
            return;
        }
        let transform = self.state.start(&object, self.sink);
        self.entities
            .instances
            .push(InstanceEntity { object, transform });
    }

    /// Warns once about participating media.
    fn ignore_medium(&self, at: &Text) {
        let message = "participating media are not supported; they are ignored";
        self.sink
            .unsupported("participating media", at.span, message);
    }

    fn option(&self, param: &Param) {
        let message = format!(
            "the option `{}` has no effect here and is ignored",
            param.name.value
        );
        self.sink.unsupported(
            format!("option {}", param.name.value),
            param.name.span,
            message,
        );
    }

    fn texture(&mut self, names: [Text; 3], list: Vec<Param>) {
        let [name, ty, class] = names;
        let ty = match ty.value.as_str() {
            "float" => TextureType::Float,
            "spectrum" | "color" => TextureType::Spectrum,
            other => {
                let message =
                    format!("unknown type `{other}` of a texture, expected `float` or `spectrum`");
                self.sink.error_at("scene::bad_value", ty.span, message);
                return;
            }
        };
        let inherited = Rc::clone(&self.state.inherited.texture);
        let params = Params::new("texture", class, list, inherited, self.sink);
        let bindings = &mut self.entities.bindings;
        let entity = self.state.entity(params, &self.folders, bindings.here());
        let space = NameSpace::Texture(ty);
        bindings.define(space, &name.value, self.entities.textures.len());
        self.entities.textures.push(Named {
            name,
            value: TextureEntity { ty, entity },
        });
    }

    fn declaration(&mut self, directive: &Text, name: Text, list: Vec<Param>) {
        let inherited = &self.state.inherited;
        let (family, inherited) = match directive.value.as_str() {
            "Attribute" => return self.state.inherit(&name, list, self.sink),
            "MakeNamedMedium" | "Volume" => return self.ignore_medium(directive),
            "Camera" => ("camera", Rc::default()),
            "Film" => ("film", Rc::default()),
            "PixelFilter" => ("filter", Rc::default()),
            "Integrator" | "SurfaceIntegrator" => ("integrator", Rc::default()),
            "Sampler" => ("sampler", Rc::default()),
            "Material" | "MakeNamedMaterial" => ("material", Rc::clone(&inherited.material)),
            "LightSource" => ("light", Rc::clone(&inherited.light)),
            "AreaLightSource" => ("area light", Rc::clone(&inherited.light)),
            "Shape" => ("shape", Rc::clone(&inherited.shape)),
            // Accelerators and the renderers of older versions have no effect.
            _ => return,
        };
        let params = Params::new(family, name, list, inherited, self.sink);
        let place = self.entities.bindings.here();
        let entity = match directive.value.as_str() {
            "Camera" => self.state.moving_entity(params, &self.folders, place),
            _ => self.state.entity(params, &self.folders, place),
        };
        let entities = &mut self.entities;
        match directive.value.as_str() {
            "Camera" => {
                entities.camera_at_end = self.state.at_end();
                let camera = self.state.transforms.map(|transform| transform.inverse());
                self.systems.insert("camera".to_owned(), camera);
                entities.camera = Some(entity);
            }
            "Film" => entities.film = Some(entity),
            "PixelFilter" => entities.filter = Some(entity),
            "Integrator" | "SurfaceIntegrator" => entities.integrator = Some(entity),
            "Sampler" => entities.sampler = Some(entity),
            "LightSource" => entities.lights.push(entity),
            "AreaLightSource" => self.state.area_light = Some(Rc::new(entity)),
            "Material" => {
                self.state.material = MaterialRef::Index(entities.materials.len());
                entities.materials.push(entity);
            }
            "MakeNamedMaterial" => {
                let name = entity.params.plugin.clone();
                let index = entities.named_materials.len();
                entities
                    .bindings
                    .define(NameSpace::Material, &name.value, index);
                entities.named_materials.push(Named {
                    name,
                    value: entity,
                });
            }
            _ => self.shape(entity),
        }
    }

    fn shape(&mut self, entity: Entity<'a>) {
        let shape = ShapeEntity {
            entity,
            material: self.state.material.clone(),
            area_light: self.state.area_light.clone(),
            reverse_orientation: self.state.reverse_orientation,
        };
        match self.object {
            Some(object) => self.entities.objects[object].value.push(shape),
            None => self.entities.shapes.push(shape),
        }
    }
}
