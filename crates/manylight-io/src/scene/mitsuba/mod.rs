//! Mitsuba's XML scene format, versions 0.4 to 3.
//!
//! Stages: `xml` (text to a tree with places) → `object` (tree to plugins with parameters; `values`, `upgrade`) → the
//! modules of the families, which read the parameters (`props`) and fill the description → `assets` (meshes and images,
//! read in parallel). Names, defaults and meanings are those of Mitsuba 3.9; a plugin is an arm of its family's `match`
//! and a name in [`SUPPORTED`].

mod assets;
mod bsdfs;
mod colors;
mod emitters;
mod integrators;
mod object;
mod props;
mod sensors;
mod shapes;
mod skies;
mod textures;
mod upgrade;
mod values;
mod xml;

use super::sink::{Problem, Sink};
use super::{LoadOptions, SupportedFamily};
use crate::resolve::similar;
use assets::Assets;
use manylight::ids::{EmitterId, MaterialId, ShapeId, TextureId};
use manylight::scene::SceneDesc;
use object::{ObjectId, ObjectTree, PluginFamily};
use props::Props;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// The plugins that have an effect here, by family, sorted.
pub(super) const SUPPORTED: &[SupportedFamily] = &[
    SupportedFamily {
        name: "bsdfs",
        plugins: bsdfs::SUPPORTED,
    },
    SupportedFamily {
        name: "emitters",
        plugins: emitters::SUPPORTED,
    },
    SupportedFamily {
        name: "shapes",
        plugins: shapes::SUPPORTED,
    },
    SupportedFamily {
        name: "textures",
        plugins: textures::SUPPORTED,
    },
    SupportedFamily {
        name: "sensors",
        plugins: sensors::SUPPORTED,
    },
    SupportedFamily {
        name: "filters",
        plugins: sensors::FILTERS,
    },
    SupportedFamily {
        name: "integrators",
        plugins: integrators::SUPPORTED,
    },
];

/// The scene, as far as it can be understood.
pub(super) fn load(
    path: &Path,
    text: Arc<str>,
    options: &LoadOptions,
    sink: &Sink,
) -> Option<SceneDesc> {
    let root = xml::read_tree(path, text, &options.defines, sink)?;
    let tree = ObjectTree::new(&root, sink)?;
    let mut builder = DescBuilder {
        tree: &tree,
        sink,
        desc: SceneDesc::default(),
        materials: HashMap::new(),
        plain_materials: HashMap::new(),
        textures: HashMap::new(),
        bitmaps: HashMap::new(),
        area_emitters: HashMap::new(),
        groups: HashMap::new(),
        builtin_shapes: HashMap::new(),
        assets: Assets::default(),
    };
    builder.scene();
    let DescBuilder {
        mut desc, assets, ..
    } = builder;
    assets.load(&mut desc, sink);
    Some(desc)
}

/// A known plugin that is not supported, and what happens to objects that use it.
type Substitute = (&'static str, &'static str);

/// Fills a description from a tree of objects. Objects that are used several times are made once.
struct DescBuilder<'a> {
    tree: &'a ObjectTree,
    sink: &'a Sink,
    desc: SceneDesc,
    materials: HashMap<ObjectId, MaterialId>,
    plain_materials: HashMap<bsdfs::PlainMaterial, MaterialId>,
    textures: HashMap<ObjectId, TextureId>,
    bitmaps: HashMap<textures::BitmapKey, TextureId>,
    area_emitters: HashMap<ObjectId, EmitterId>,
    groups: HashMap<ObjectId, usize>,
    builtin_shapes: HashMap<&'static str, ShapeId>,
    assets: Assets,
}

impl<'a> DescBuilder<'a> {
    fn props(&self, id: ObjectId) -> Props<'a> {
        Props::new(self.tree, id, self.sink)
    }

    /// Everything that stands directly in <scene>, in order.
    fn scene(&mut self) {
        let root = self.props(ObjectTree::ROOT);
        for (id, _) in root.objects(PluginFamily::Bsdf) {
            self.material(id);
        }
        for (id, _) in root.objects(PluginFamily::Shape) {
            self.shape(id);
        }
        for (id, _) in root.objects(PluginFamily::Emitter) {
            self.emitter(id);
        }
        for (id, _) in root.objects(PluginFamily::Sensor) {
            self.sensor(id);
        }
        for (id, _) in root.objects(PluginFamily::Texture) {
            self.texture(id);
        }
        if let Some(id) = root.single(PluginFamily::Integrator) {
            self.desc.limits = integrators::limits(&self.props(id), self);
        }
        for family in [
            PluginFamily::Medium,
            PluginFamily::Phase,
            PluginFamily::Volume,
            PluginFamily::Subsurface,
        ] {
            for (id, _) in root.objects(family) {
                self.ignore_medium(id);
            }
        }
        root.objects(PluginFamily::Spectrum);
        // Settings of acceleration structures.
        for prefix in ["kd_", "embree_"] {
            root.ignore_prefix(prefix);
        }
        root.ignore(&["allow_thread_reordering", "id"]);
        self.check_whole(&root);
        root.finish();
    }

    fn check_whole(&self, root: &Props<'_>) {
        let no_sensor = root.objects(PluginFamily::Sensor).is_empty();
        if no_sensor || self.desc.sensors.is_empty() && !self.sink.has_errors() {
            let message = if no_sensor {
                "the scene has no sensor"
            } else {
                "the scene has no sensor that is supported"
            };
            let report = Problem::new("scene::no_sensor", root.span(), message);
            self.sink
                .error(report.help("add for instance <sensor type=\"perspective\"/>"));
        }
        if !self.tree.has(PluginFamily::Emitter) {
            let message = "the scene has no emitter: its image will be black";
            self.sink
                .warn(Problem::new("scene::no_emitter", root.span(), message));
        }
    }

    /// One warning for all media, whatever their kind.
    fn ignore_medium(&self, id: ObjectId) {
        let props = self.props(id);
        let message = format!(
            "{}: participating media are not supported and are ignored",
            props.describe()
        );
        self.sink.warn_once(
            "participating media",
            Problem::new("scene::unsupported", props.span(), message),
        );
    }

    /// The plugin is none that we have: a warning if Mitsuba knows it, an error otherwise.
    fn unsupported(
        &self,
        props: &Props<'_>,
        supported: &[&'static str],
        substitutes: &[Substitute],
    ) {
        let plugin = props.plugin();
        let tag = props.object().family.tag();
        if let Some((_, substitute)) = substitutes.iter().find(|(name, _)| *name == plugin.value) {
            let message = format!("{} is not supported; {substitute}", props.describe());
            let report =
                Problem::new("scene::unsupported", plugin.span, message).label("not supported");
            self.sink.warn_once(props.describe(), report);
        } else if !plugin.value.is_empty() && !plugin.value.contains('$') {
            let known = supported
                .iter()
                .chain(substitutes.iter().map(|(name, _)| name))
                .copied();
            let list = format!("known are {}", supported.join(", "));
            let help = match similar(&plugin.value, known) {
                Some(similar) => format!("did you mean `{similar}`? {list}"),
                None => list,
            };
            let message = format!("unknown {tag} type `{}`", plugin.value);
            let report = Problem::new("scene::unknown_plugin", plugin.span, message);
            self.sink.error(
                report
                    .label(format!("no {tag} plugin has this name"))
                    .help(help),
            );
        }
    }

    /// The plugin is none of version 3.
    fn require_v0(&self, props: &Props<'_>, advice: &str) {
        if !props.is_v0() {
            let message = format!("{} exists only in files of version 0.x", props.describe());
            let help = format!("{advice}, or write `version=\"0.6.0\"` in <scene>");
            self.sink
                .error(Problem::new("scene::unknown_plugin", props.span(), message).help(help));
        }
    }

    /// A feature of a supported plugin that is left out.
    fn warn_feature(&self, props: &Props<'_>, name: &'static str, what: &str) {
        if let Some(param) = props.get(name) {
            let subject = format!("{} {name}", props.describe());
            let message = format!("`{name}` of {} {what}", props.describe());
            self.sink.warn_once(
                subject,
                Problem::new("scene::unsupported", param.name.span, message),
            );
        }
    }
}
