//! Emitter plugins.

use super::super::description::Additions;
use super::super::files::find_file;
use super::super::parameters::{Numbers, Parameters};
use super::super::sink::Problem;
use super::builder::{DescBuilder, IGNORED, Substitute};
use super::colors::ColorUse;
use super::family::PluginFamily;
use super::props::Props;
use super::skies::SkyParts;
use super::transforms::rotation;
use super::values::ObjectId;
use glam::DVec3;
use manylight::color::Rgb;
use manylight::emitters::{Emitter, Environment, ProjectorTexture, SpotFalloff};
use manylight::ids::{EmitterId, TextureId};
use manylight::image::Image;
use manylight::math::{Mat3, Vec2};
use manylight::scene::SceneDesc;
use manylight::sensors::FovAxis;
use manylight::texture::{ColorInput, Texture};
use std::f32::consts::{FRAC_PI_4, PI};

pub(super) const SUPPORTED: &[&str] = &[
    "area",
    "constant",
    "directional",
    "envmap",
    "point",
    "projector",
    "sky",
    "spot",
    "sun",
    "sunsky",
];

const SUBSTITUTES: &[Substitute] = &[
    ("directionalarea", IGNORED),
    ("timed_sunsky", IGNORED),
    ("collimated", IGNORED),
];

/// Parameters of Mitsuba's emitter sampling, which have no effect.
const SAMPLING_PARAMETERS: &[&str] = &["id", "sampling_weight", "samples", "mis_compensation"];

impl DescBuilder<'_> {
    /// The area emitter nested in a shape, added at its first use.
    pub(super) fn area_emitter(&mut self, shape: &Props<'_>) -> Option<EmitterId> {
        let id = shape.single(PluginFamily::Emitter)?;
        let key = self.scoped(id);
        if let Some(emitter) = self.made.area_emitters.get(&key) {
            return Some(*emitter);
        }
        let props = self.props(id);
        if props.plugin().value != "area" {
            if SUPPORTED.contains(&props.plugin().value.as_str()) {
                let object = props.describe();
                let message = format!("{object} cannot be nested in a shape; expected `area`");
                self.sink
                    .error_at("scene::unexpected_object", props.span(), message);
            } else {
                self.unsupported(&props, SUPPORTED, SUBSTITUTES);
            }
            return None;
        }
        let radiance = self.color_input(&props, "radiance", 1.0, ColorUse::Emission);
        props.ignore(SAMPLING_PARAMETERS);
        props.finish();
        let emitter = self.desc.add(Emitter::Area { radiance });
        self.made.area_emitters.insert(key, emitter);
        Some(emitter)
    }

    /// Adds an emitter that is nested in the scene.
    pub(super) fn emitter(&mut self, id: ObjectId) {
        let props = self.props(id);
        match props.plugin().value.as_str() {
            "area" => {
                let message = "emitter `area` must be nested in a shape";
                let problem = Problem::new("scene::unexpected_object", props.span(), message);
                let help = "move it into the <shape> that emits light";
                self.sink.error(problem.help(help));
                return;
            }
            "point" => self.point(&props),
            "spot" => self.spot(&props),
            "projector" => self.projector(&props),
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
    fn emission(&mut self, props: &Props<'_>, name: &'static str) -> Rgb {
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
        self.desc.add(Emitter::Point {
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
        self.desc.add(Emitter::Spot {
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
        let Some(texture) = self.nested_texture(&param.value) else {
            props.mismatch(param, &"a texture");
            return None;
        };
        let texture = self.texture(texture)?;
        let axes = [world_from_emitter.x_axis, world_from_emitter.y_axis];
        Some(ProjectorTexture {
            texture,
            axes,
            window: None,
        })
    }

    /// A projector. Its image fills the view of a perspective camera with the same parameters.
    fn projector(&mut self, props: &Props<'_>) {
        let to_world = props.to_world();
        let scale = props.float("scale", 1.0);
        let (fov, fov_axis) = self.field_of_view(props);
        props.require("irradiance");
        if !props.has("irradiance") {
            return;
        }
        let irradiance = self.color_input(props, "irradiance", 1.0, ColorUse::Emission);
        let texture = match irradiance {
            ColorInput::Texture(texture) => texture,
            ColorInput::Constant(color) => self.constant_texture(color),
        };
        let axes = rotation(to_world);
        let emitter = self.desc.add(Emitter::Spot {
            position: to_world.transform_point3(DVec3::ZERO).as_vec3(),
            direction: axes.z_axis,
            // A constant image of value 1 gives the irradiance π at distance 1, as in Mitsuba.
            intensity: Rgb::splat(PI * scale),
            cutoff: FRAC_PI_4,
            beam_width: FRAC_PI_4,
            falloff: SpotFalloff::FlatIrradiance,
            // As seen by a camera, u grows towards -x and v towards -y.
            projector: Some(ProjectorTexture {
                texture,
                axes: [-axes.x_axis, -axes.y_axis],
                window: Some(Vec2::ONE),
            }),
        });
        self.finish.push(Box::new(move |desc: &mut SceneDesc| {
            fit_projector(desc, (emitter, texture), fov, fov_axis);
        }));
    }

    fn directional(&mut self, props: &Props<'_>) {
        let irradiance = self.emission(props, "irradiance");
        self.exclusive(props, "direction", "to_world");
        let forward = props.to_world().transform_vector3(DVec3::Z);
        let direction = props.vector("direction").unwrap_or(forward);
        if direction == DVec3::ZERO {
            props.refuse_named("direction", "nonzero");
            return;
        }
        self.desc.add(Emitter::Directional {
            direction: direction.normalize().as_vec3(),
            irradiance,
        });
    }

    fn constant_environment(&mut self, props: &Props<'_>) {
        props.ignore(&["to_world"]);
        let radiance = self.emission(props, "radiance");
        self.desc.add(Emitter::Constant { radiance });
    }

    fn environment_map(&mut self, props: &Props<'_>) {
        props.ignore(&["cache", "gamma"]);
        let scale = props.float("scale", 1.0);
        let world_from_emitter = rotation(props.to_world());
        let Some(name) = props.required_string("filename") else {
            return;
        };
        let folders = &props.object().folders;
        let Some(path) = find_file(self.sink, folders, name, "environment map") else {
            return;
        };
        let environment = Environment {
            image: Image::default(),
            scale,
            world_from_emitter,
        };
        let emitter = self.desc.add(Emitter::Environment(environment));
        self.assets.add_environment_image(emitter, path, name.span);
    }
}

/// Sets the window of a projector with this field of view in degrees by the size of its image,
/// after that has been read.
fn fit_projector(
    desc: &mut SceneDesc,
    (emitter, texture): (EmitterId, TextureId),
    fov: f32,
    fov_axis: FovAxis,
) {
    let size = match &desc.textures[texture.index()] {
        Texture::Bitmap(bitmap) => Vec2::new(
            bitmap.image.width.max(1) as f32,
            bitmap.image.height.max(1) as f32,
        ),
        _ => Vec2::ONE,
    };
    let (x, y) = (size.x, size.y);
    let along = match fov_axis {
        FovAxis::X => x,
        FovAxis::Y => y,
        FovAxis::Diagonal => size.length(),
        FovAxis::Smaller => x.min(y),
        FovAxis::Larger => x.max(y),
    };
    let half = size * ((0.5 * fov).to_radians().tan() / along);
    if let Emitter::Spot {
        cutoff,
        beam_width,
        projector: Some(projector),
        ..
    } = &mut desc.emitters[emitter.index()]
    {
        projector.window = Some(half);
        *cutoff = half.length().atan();
        *beam_width = *cutoff;
    }
}
