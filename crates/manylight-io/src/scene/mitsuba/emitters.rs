//! Emitter plugins.

use super::super::files::find_file;
use super::super::sink::Problem;
use super::colors::ColorUse;
use super::object::{ObjectId, PluginFamily};
use super::props::Props;
use super::skies::SkyParts;
use super::values::Value;
use super::{DescBuilder, IGNORED, Substitute};
use glam::{DMat4, DVec3};
use manylight::emitters::{Emitter, Environment, ProjectorTexture, SpotFalloff};
use manylight::ids::EmitterId;
use manylight::image::Image;
use manylight::math::Mat3;
use std::path::PathBuf;

pub(super) const SUPPORTED: &[&str] = &[
    "area",
    "constant",
    "directional",
    "envmap",
    "point",
    "sky",
    "spot",
    "sun",
    "sunsky",
];

const SUBSTITUTES: &[Substitute] = &[
    ("directionalarea", IGNORED),
    ("projector", IGNORED),
    ("timed_sunsky", IGNORED),
    ("collimated", IGNORED),
];

/// Parameters of Mitsuba's emitter sampling, which have no effect.
const SAMPLING_PARAMETERS: &[&str] = &["id", "sampling_weight", "samples", "mis_compensation"];

impl DescBuilder<'_> {
    pub(super) fn add_emitter(&mut self, emitter: Emitter) -> EmitterId {
        self.desc.emitters.push(emitter);
        EmitterId::from(self.desc.emitters.len() - 1)
    }

    /// The area emitter nested in a shape, added at its first use.
    pub(super) fn area_emitter(&mut self, shape: &Props<'_>) -> Option<EmitterId> {
        let id = shape.single(PluginFamily::Emitter)?;
        if let Some(emitter) = self.area_emitters.get(&id) {
            return Some(*emitter);
        }
        let props = self.props(id);
        if props.plugin().value != "area" {
            if SUPPORTED.contains(&props.plugin().value.as_str()) {
                let message = format!(
                    "{} cannot be nested in a shape; expected `area`",
                    props.describe()
                );
                self.sink.error(Problem::new(
                    "scene::unexpected_object",
                    props.span(),
                    message,
                ));
            } else {
                self.unsupported(&props, SUPPORTED, SUBSTITUTES);
            }
            return None;
        }
        let radiance = self.color_input(&props, "radiance", 1.0, ColorUse::Emission);
        props.ignore(SAMPLING_PARAMETERS);
        props.finish();
        let emitter = self.add_emitter(Emitter::Area { radiance });
        self.area_emitters.insert(id, emitter);
        Some(emitter)
    }

    /// Adds an emitter that is nested in the scene.
    pub(super) fn emitter(&mut self, id: ObjectId) {
        let props = self.props(id);
        match props.plugin().value.as_str() {
            "area" => {
                let message = "emitter `area` must be nested in a shape";
                self.sink.error(
                    Problem::new("scene::unexpected_object", props.span(), message)
                        .help("move it into the <shape> that emits light"),
                );
                return;
            }
            "point" => self.point(&props),
            "spot" => self.spot(&props),
            "directional" => self.directional(&props),
            "constant" => self.constant_environment(&props),
            "envmap" => self.environment_map(&props),
            "sunsky" => self.sun_and_sky(&props, SkyParts::Both),
            "sky" | "sun" => {
                self.require_v0(&props, "use `sunsky`");
                let parts = if props.plugin().value == "sky" {
                    SkyParts::Sky
                } else {
                    SkyParts::Sun
                };
                self.sun_and_sky(&props, parts);
            }
            _ => {
                self.unsupported(&props, SUPPORTED, SUBSTITUTES);
                return;
            }
        }
        props.ignore(SAMPLING_PARAMETERS);
        props.finish();
    }

    /// The parameter `name` as an emission; 1 by default.
    fn emission(&mut self, props: &Props<'_>, name: &'static str) -> manylight::color::Rgb {
        self.color(props, name, 1.0, ColorUse::Emission)
    }

    /// Reports the parameter `name` if `other` is given as well.
    fn exclusive(&self, props: &Props<'_>, name: &'static str, other: &'static str) {
        if let (Some(first), true) = (props.get(name), props.has(other)) {
            props.refuse(first, &format!("absent if `{other}` is given"));
        }
    }

    fn point(&mut self, props: &Props<'_>) {
        let intensity = self.emission(props, "intensity");
        self.exclusive(props, "position", "to_world");
        let origin = props.to_world().transform_point3(DVec3::ZERO);
        let position = props.vector("position").unwrap_or(origin).as_vec3();
        self.add_emitter(Emitter::Point {
            position,
            intensity,
        });
    }

    fn spot(&mut self, props: &Props<'_>) {
        let intensity = self.emission(props, "intensity");
        let to_world = props.to_world();
        let slide = self.projector_texture(props, rotation(to_world));
        let cutoff = props.float_where(
            "cutoff_angle",
            20.0,
            |angle| angle > 0.0 && angle <= 180.0,
            "in (0, 180]",
        );
        let beam_width = props.float_where(
            "beam_width",
            cutoff * 0.75,
            |angle| angle >= 0.0,
            "at least 0",
        );
        self.add_emitter(Emitter::Spot {
            position: to_world.transform_point3(DVec3::ZERO).as_vec3(),
            direction: to_world.transform_vector3(DVec3::Z).normalize().as_vec3(),
            intensity,
            cutoff: cutoff.to_radians(),
            beam_width: beam_width.min(cutoff).to_radians(),
            falloff: SpotFalloff::LinearAngle,
            projector: slide,
        });
    }

    /// The texture that a spot light projects.
    fn projector_texture(
        &mut self,
        props: &Props<'_>,
        world_from_emitter: Mat3,
    ) -> Option<ProjectorTexture> {
        let param = props.get("texture")?;
        let texture = match param.value {
            Value::Object(id) if self.tree.get(id).family == PluginFamily::Texture => {
                self.texture(id)?
            }
            _ => {
                props.mismatch(param, "a texture");
                return None;
            }
        };
        let axes = [world_from_emitter.x_axis, world_from_emitter.y_axis];
        Some(ProjectorTexture { texture, axes })
    }

    fn directional(&mut self, props: &Props<'_>) {
        let irradiance = self.emission(props, "irradiance");
        self.exclusive(props, "direction", "to_world");
        let forward = props.to_world().transform_vector3(DVec3::Z);
        let direction = props.vector("direction").unwrap_or(forward);
        if direction == DVec3::ZERO {
            props.refuse(
                props
                    .get("direction")
                    .expect("invariant: the default direction is not zero"),
                "nonzero",
            );
            return;
        }
        self.add_emitter(Emitter::Directional {
            direction: direction.normalize().as_vec3(),
            irradiance,
        });
    }

    fn constant_environment(&mut self, props: &Props<'_>) {
        props.ignore(&["to_world"]);
        let radiance = self.emission(props, "radiance");
        self.add_emitter(Emitter::Constant { radiance });
    }

    fn environment_map(&mut self, props: &Props<'_>) {
        props.ignore(&["cache", "gamma"]);
        let scale = props.float("scale", 1.0);
        let world_from_emitter = rotation(props.to_world());
        let Some(name) = props.required_string("filename") else {
            return;
        };
        let path: Option<PathBuf> =
            find_file(self.sink, &props.object().folders, &name, "environment map");
        let Some(path) = path else { return };
        let environment = Environment {
            image: Image::default(),
            scale,
            world_from_emitter,
        };
        let emitter = self.add_emitter(Emitter::Environment(environment));
        self.assets.add_environment_image(emitter, path, name.span);
    }
}

/// The normalized axes of a transform.
pub(super) fn rotation(to_world: DMat4) -> Mat3 {
    let matrix = to_world.as_mat4();
    let column = |index: usize| matrix.col(index).truncate().normalize_or_zero();
    Mat3::from_cols(column(0), column(1), column(2))
}
