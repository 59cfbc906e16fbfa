//! Mitsuba's XML scene format, versions 0.4 to 3.
//!
//! Names, defaults and meanings of plugins are those of Mitsuba 3.9. Loading has four stages:
//!
//! 1. `xml` parses text into a tree of elements with source spans.
//! 2. `tree` turns it into `object`s, plugins with parameters; `values` parses the parameters, and
//!    `upgrade` renames those of old files.
//! 3. One module for each plugin family (`bsdfs`, `shapes`, ...) reads the parameters by `props`,
//!    and fills the [`SceneDesc`] of `builder`.
//! 4. `assets` reads meshes and images in parallel.
//!
//! CONTRIBUTING.md says how to add a plugin. The names of textures and spectra are in the list of
//! `family`.

mod bsdfs;
mod builder;
mod colors;
mod emitters;
mod family;
mod integrators;
mod object;
mod props;
mod sensors;
mod shape_files;
mod shapes;
mod skies;
mod textures;
mod transforms;
mod tree;
mod upgrade;
mod values;
mod xml;

use super::options::LoadOptions;
use super::parameters::Parameters;
use super::plugins::{SupportedFamily, families};
use super::sink::{Problem, Sink};
use builder::DescBuilder;
use family::{PluginFamily, TEXTURES};
use manylight::scene::SceneDesc;
use object::ObjectTree;
use props::Props;
use std::path::Path;
use std::sync::Arc;

/// The supported plugins, by family.
pub(super) static SUPPORTED: [SupportedFamily; 7] = families(
    "mitsuba",
    [
        ("bsdfs", bsdfs::SUPPORTED),
        ("emitters", emitters::SUPPORTED),
        ("shapes", shapes::SUPPORTED),
        ("textures", TEXTURES),
        ("sensors", sensors::SUPPORTED),
        ("filters", sensors::FILTERS),
        ("integrators", integrators::SUPPORTED),
    ],
);

/// The scene in `text`, the content of `path`, without its invalid parts. `None` only if an error
/// has been reported.
pub(super) fn load(
    path: &Path,
    text: Arc<str>,
    options: &LoadOptions,
    sink: &Sink,
) -> Option<SceneDesc> {
    let root = xml::read_tree(path, text, &options.defines, sink)?;
    let tree = tree::read_objects(&root, sink)?;
    let mut builder = DescBuilder::new(&tree, options.fps, sink);
    builder.scene();
    let mut desc = builder.desc;
    builder.assets.load(&mut desc, sink);
    for finish in builder.finish {
        finish(&mut desc);
    }
    Some(desc)
}

impl DescBuilder<'_> {
    /// Adds all objects of the scene.
    fn scene(&mut self) {
        let root = self.props(ObjectTree::ROOT);
        for (id, _) in root.objects(PluginFamily::Bsdf) {
            if !self.is_per_shape(id) {
                self.material(id);
            }
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
            if !self.is_per_shape(id) {
                self.texture(id);
            }
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
        // Settings of acceleration structures have no effect.
        for prefix in ["kd_", "embree_"] {
            root.ignore_prefix(prefix);
        }
        root.ignore(&["allow_thread_reordering", "id"]);
        self.check_whole(&root);
        root.finish();
    }

    /// Reports scenes without a sensor or an emitter.
    fn check_whole(&self, root: &Props<'_>) {
        let no_sensor = root.objects(PluginFamily::Sensor).is_empty();
        if no_sensor || self.desc.sensors.is_empty() && !self.sink.has_errors() {
            let message = if no_sensor {
                "the scene has no sensor"
            } else {
                "the scene has no supported sensor"
            };
            let problem = Problem::new("scene::no_sensor", root.span(), message);
            let help = "add for example <sensor type=\"perspective\"/>";
            self.sink.error(problem.help(help));
        }
        if !self.tree.has(PluginFamily::Emitter) {
            let message = "the scene has no emitter; its image will be black";
            self.sink
                .warn(Problem::new("scene::no_emitter", root.span(), message));
        }
    }
}
