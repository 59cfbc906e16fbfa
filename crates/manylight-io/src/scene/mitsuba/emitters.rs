//! Emitter plugins.

use super::super::description::Additions;
use super::super::files::find_file;
use super::super::names::name_light_group;
use super::super::parameters::{Numbers, Parameters};
use super::super::sink::Problem;
use super::builder::{DescBuilder, IGNORED, Substitute};
use super::colors::ColorUse;
use super::family::PluginFamily;
use super::props::Props;
use super::skies::SkyParts;
use super::transforms::{rotation, similarity_scale};
use super::values::ObjectId;
use glam::{DMat3, DMat4, DVec3};
use manylight::color::Rgb;
use manylight::emitters::{DeformedCone, Emitter, Environment, ProjectorTexture, SpotFalloff};
use manylight::ids::{EmitterId, TextureId};
use manylight::image::Image;
use manylight::math::{Mat3, Vec2};
use manylight::scene::SceneDesc;
use manylight::sensors::FovAxis;
use manylight::texture::{ColorInput, Texture};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

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
        name_light_group(&mut self.desc, emitter.index(), Some(&props.object().id));
        self.made.area_emitters.insert(key, emitter);
        Some(emitter)
    }

    /// Adds an emitter that is nested in the scene.
    pub(super) fn emitter(&mut self, id: ObjectId) {
        let (props, first) = (self.props(id), self.desc.emitters.len());
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
        name_light_group(&mut self.desc, first, Some(&props.object().id));
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
        let (cutoff, beam_width) = (cutoff.to_radians(), beam_width.min(cutoff).to_radians());
        let mut spot = Spot {
            cutoff,
            beam_width,
            falloff: SpotFalloff::LinearAngle,
        };
        if similarity_scale(to_world).is_none() {
            spot = self.deformed_spot(props, to_world, spot);
        }
        self.desc.add(Emitter::Spot {
            position: to_world.transform_point3(DVec3::ZERO).as_vec3(),
            direction: to_world.transform_vector3(DVec3::Z).normalize().as_vec3(),
            intensity,
            cutoff: spot.cutoff,
            beam_width: spot.beam_width,
            falloff: spot.falloff,
            projector: slide,
        });
    }

    /// The cone of a spot under a transform that changes angles. A texture is not deformed.
    fn deformed_spot(&self, props: &Props<'_>, to_world: DMat4, spot: Spot) -> Spot {
        if props.has("texture") {
            let message = format!(
                "`to_world` of {} changes angles, which is ignored with a texture",
                props.describe()
            );
            props.unsupported("deformed spot", message);
            return spot;
        }
        let linear = DMat3::from_mat4(to_world);
        let (sin, cos) = f64::from(spot.cutoff).sin_cos();
        let axis = linear.z_axis;
        let rim = (0..RIM_POINTS).map(|i| {
            let turn = f64::from(i) / f64::from(RIM_POINTS) * std::f64::consts::TAU;
            let w = DVec3::new(sin * turn.cos(), sin * turn.sin(), cos);
            axis.angle_between(linear * w)
        });
        let widest = rim.fold(0.0, f64::max) * (1.0 + RIM_MARGIN);
        // Cones beyond the plane across their axis are rare; all directions contain them.
        let is_narrow = spot.cutoff < FRAC_PI_2 && widest < std::f64::consts::FRAC_PI_2;
        let cutoff = if is_narrow { widest as f32 } else { PI };
        let scale = linear.z_axis.length();
        Spot {
            cutoff,
            beam_width: cutoff,
            falloff: SpotFalloff::Deformed(DeformedCone {
                cone_from_world: (linear.inverse() * scale).as_mat3(),
                cutoff: spot.cutoff,
                beam_width: spot.beam_width,
            }),
        }
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
        // As in Mitsuba, the irradiance grows with the scale along the axis, and the image with
        // that across it.
        let [x, y, z] = [to_world.x_axis, to_world.y_axis, to_world.z_axis]
            .map(|axis| axis.truncate().length() as f32);
        let stretch = Vec2::new(x, y) / z;
        if !has_orthogonal_axes(to_world) {
            let message = format!(
                "`to_world` of {} shears, which is ignored",
                props.describe()
            );
            props.unsupported("sheared projector", message);
        }
        let emitter = self.desc.add(Emitter::Spot {
            position: to_world.transform_point3(DVec3::ZERO).as_vec3(),
            direction: axes.z_axis,
            // A constant image of value 1 gives the irradiance π at distance 1, as in Mitsuba.
            intensity: Rgb::splat(PI * scale * z),
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
            fit_projector(desc, (emitter, texture), (fov, fov_axis), stretch);
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
        // As in Mitsuba, the irradiance grows with the scale of `to_world` along the direction.
        let scale = match props.has("direction") {
            true => 1.0,
            false => forward.length() as f32,
        };
        self.desc.add(Emitter::Directional {
            direction: direction.normalize().as_vec3(),
            irradiance: irradiance * scale,
        });
    }

    fn constant_environment(&mut self, props: &Props<'_>) {
        props.ignore(&["to_world"]);
        let radiance = self.emission(props, "radiance");
        self.desc.add(Emitter::Constant { radiance });
    }

    /// Warns about a scale in the transform of an environment.
    pub(super) fn check_unscaled(&self, props: &Props<'_>, to_world: DMat4) {
        if similarity_scale(to_world).is_none_or(|scale| (scale.abs() - 1.0).abs() > UNSCALED) {
            let object = props.describe();
            let message = format!(
                "a scale in `to_world` of {object} has no effect here; in Mitsuba it distorts the map"
            );
            props.unsupported(format!("scale of {object}"), message);
        }
    }

    fn environment_map(&mut self, props: &Props<'_>) {
        props.ignore(&["cache", "gamma"]);
        let scale = props.float("scale", 1.0);
        let to_world = props.to_world();
        let world_from_emitter = rotation(to_world);
        self.check_unscaled(props, to_world);
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
        self.finish.push(Box::new(move |desc: &mut SceneDesc| {
            if let Emitter::Environment(environment) = &mut desc.emitters[emitter.index()] {
                enlarge(&mut environment.image);
            }
        }));
    }
}

/// The cone of a spot.
struct Spot {
    cutoff: f32,
    beam_width: f32,
    falloff: SpotFalloff,
}

/// Points of the rim of a cone among which the widest is searched.
const RIM_POINTS: i32 = 360;
/// Relative margin of the widest angle, for the directions between the points.
const RIM_MARGIN: f64 = 1e-3;
/// Largest difference of a scale from 1, and of the cosine between axes from 0, that counts as
/// rounding.
const UNSCALED: f64 = 1e-4;

/// Whether the axes of a transform are perpendicular to each other.
fn has_orthogonal_axes(matrix: DMat4) -> bool {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis]
        .map(|axis| axis.truncate().normalize_or_zero());
    [x.dot(y), y.dot(z), z.dot(x)]
        .iter()
        .all(|cos| cos.abs() < UNSCALED)
}

/// Enlarges a map to at least 2 x 3 texels, each with the value of the nearest one, as Mitsuba
/// does. Of two rows, the lower one becomes two.
fn enlarge(image: &mut Image) {
    if image.width == 1 {
        let texels = image.data.chunks_exact(image.channels.max(1));
        image.data = texels.flat_map(|texel| texel.repeat(2)).collect();
        image.width = 2;
    }
    match image.height {
        1 => image.data = image.data.repeat(3),
        2 => image
            .data
            .extend_from_within(image.width * image.channels..),
        _ => return,
    }
    image.height = 3;
}

/// Sets the window of a projector with this field of view in degrees by the size of its image,
/// after that has been read. Both axes are stretched.
fn fit_projector(
    desc: &mut SceneDesc,
    (emitter, texture): (EmitterId, TextureId),
    (fov, fov_axis): (f32, FovAxis),
    stretch: Vec2,
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
    let half = size * stretch * ((0.5 * fov).to_radians().tan() / along);
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
