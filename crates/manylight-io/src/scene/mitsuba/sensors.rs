//! Sensor plugins with their films and reconstruction filters. Samplers are checked but have no
//! effect.

use super::super::description::film_of_size;
use super::super::motion::frames;
use super::super::parameters::{Numbers, Parameters};
use super::builder::{DescBuilder, IGNORED, Substitute};
use super::family::PluginFamily;
use super::props::Props;
use super::transforms::affine;
use super::values::ObjectId;
use manylight::film::{FilmDesc, Filter};
use manylight::math::{Affine3A, UVec2, Vec2};
use manylight::sensors::{FovAxis, SensorDesc, SensorKind};

pub(super) const SUPPORTED: &[&str] = &["orthographic", "perspective", "thinlens"];

const SUBSTITUTES: &[Substitute] = &[
    ("batch", IGNORED),
    ("distant", IGNORED),
    ("irradiancemeter", IGNORED),
    ("radiancemeter", IGNORED),
    ("fluencemeter", IGNORED),
    ("spherical", IGNORED),
    ("telecentric", IGNORED),
    ("perspective_rdist", IGNORED),
];

pub(super) const FILTERS: &[&str] = &[
    "box",
    "catmullrom",
    "gaussian",
    "lanczos",
    "mitchell",
    "tent",
];

const FILMS: &[&str] = &["hdrfilm", "ldrfilm", "mfilm", "specfilm", "tiledhdrfilm"];

const SAMPLERS: &[&str] = &[
    "halton",
    "hammersley",
    "independent",
    "ldsampler",
    "multijitter",
    "orthogonal",
    "sobol",
    "stratified",
];

/// Parameters of films about output files, which have no effect.
const FILM_PARAMETERS: &[&str] = &[
    "id",
    "banner",
    "compensate",
    "component_format",
    "file_format",
    "pixel_format",
    "sample_border",
];

/// The same for files of version 0.x.
const FILM_PARAMETERS_V0: &[&str] = &[
    "attach_log",
    "burn",
    "digits",
    "exposure",
    "fileformat",
    "gamma",
    "high_quality_edges",
    "key",
    "tonemap_method",
    "variable",
    "alpha",
    "bloom_fov",
];

/// Parameters of samplers, which have no effect.
const SAMPLER_PARAMETERS: &[&str] = &[
    "id",
    "sample_count",
    "seed",
    "jitter",
    "strength",
    "scramble",
    "dimension",
    "max_dimension",
];

impl DescBuilder<'_> {
    /// Adds a sensor.
    pub(super) fn sensor(&mut self, id: ObjectId) {
        let props = self.props(id);
        let plugin = props.plugin().value.as_str();
        if !SUPPORTED.contains(&plugin) {
            self.unsupported(&props, SUPPORTED, SUBSTITUTES);
            return;
        }
        props.ignore(&[
            "id",
            "shutter_open",
            "shutter_close",
            "shutter_open_time",
            "srf",
        ]);
        let world_from_camera = affine(props.first_to_world());
        let motion = self.motion(&props);
        let (near_clip, far_clip) = clipping(&props);
        let (kind, principal_point_offset) = self.projection(&props, far_clip);
        let film = match props.single(PluginFamily::Film) {
            Some(film) => self.film(film),
            None => film_of_size(UVec2::new(DEFAULT_SIZE.0, DEFAULT_SIZE.1), DEFAULT_FILTER),
        };
        if let Some(sampler) = props.single(PluginFamily::Sampler) {
            self.sampler(sampler);
        }
        for (medium, _) in props.objects(PluginFamily::Medium) {
            self.ignore_medium(medium);
        }
        props.finish();
        let name = props.object().id.clone();
        let sensor = SensorDesc {
            name,
            world_from_camera,
            motion,
            kind,
            principal_point_offset,
            near_clip,
            far_clip,
            film,
        };
        self.desc.sensors.push(sensor);
    }

    /// The frames of an animated camera.
    fn motion(&self, props: &Props<'_>) -> Vec<Affine3A> {
        let Some((keys, span)) = props.motion() else {
            return Vec::new();
        };
        frames(keys, self.fps).unwrap_or_else(|fault| {
            let message = format!("this animation cannot be used: {fault}");
            self.sink.error_at("scene::bad_value", span, message);
            Vec::new()
        })
    }

    /// The projection, and the offset of the principal point.
    fn projection(&self, props: &Props<'_>, far_clip: f32) -> (SensorKind, Vec2) {
        let positive = |distance| distance > 0.0;
        let focus_distance = props.float_where("focus_distance", far_clip, positive, "positive");
        if props.plugin().value == "orthographic" {
            return (SensorKind::Orthographic, Vec2::ZERO);
        }
        let (fov, fov_axis) = self.field_of_view(props);
        if props.plugin().value == "perspective" {
            let x = props.float("principal_point_offset_x", 0.0);
            let y = props.float("principal_point_offset_y", 0.0);
            return (SensorKind::Perspective { fov, fov_axis }, Vec2::new(x, y));
        }
        props.require("aperture_radius");
        let at_least_zero = |radius| radius >= 0.0;
        let aperture_radius =
            props.float_where("aperture_radius", 0.1, at_least_zero, "at least 0");
        let kind = SensorKind::ThinLens {
            fov,
            fov_axis,
            aperture_radius,
            focus_distance,
        };
        (kind, Vec2::ZERO)
    }

    /// The field of view in degrees from `fov` or `focal_length`, and the axis along which it is
    /// measured.
    pub(super) fn field_of_view(&self, props: &Props<'_>) -> (f32, FovAxis) {
        let axes = [
            ("x", FovAxis::X),
            ("y", FovAxis::Y),
            ("diagonal", FovAxis::Diagonal),
            ("smaller", FovAxis::Smaller),
            ("larger", FovAxis::Larger),
        ];
        let axis = props.choice("fov_axis", FovAxis::X, &axes);
        if let Some(param) = props.get("fov") {
            if props.has("focal_length") {
                props.refuse(param, "absent if `focal_length` is given");
                props.ignore(&["focal_length"]);
            }
            let inside = |fov| fov > 0.0 && fov < 180.0;
            return (props.float_where("fov", 50.0, inside, "in (0, 180)"), axis);
        }
        let given = props.string("focal_length");
        let text = given.map_or("50mm", |text| text.value.as_str());
        let length = text
            .trim()
            .trim_end_matches("mm")
            .trim_end()
            .parse::<f32>()
            .ok();
        let Some(length) = length.filter(|length| *length > 0.0) else {
            props.refuse_named("focal_length", "a length such as `50mm`");
            return (50.0, axis);
        };
        // A focal length refers to the diagonal of 35 mm film, 36 mm x 24 mm.
        let half_diagonal = 0.5 * 36_f32.hypot(24.0);
        (
            2.0 * (half_diagonal / length).atan().to_degrees(),
            FovAxis::Diagonal,
        )
    }

    fn film(&mut self, id: ObjectId) -> FilmDesc {
        let props = self.props(id);
        let plugin = props.plugin().value.as_str();
        if !FILMS.contains(&plugin) {
            self.unsupported(&props, FILMS, &[]);
        }
        let extent = |name, default: u32| props.integer(name, i64::from(default), 1) as u32;
        let size = UVec2::new(
            extent("width", DEFAULT_SIZE.0),
            extent("height", DEFAULT_SIZE.1),
        );
        let offset = |name| props.integer(name, 0, 0) as u32;
        let mut film = FilmDesc {
            size,
            crop_offset: UVec2::new(offset("crop_offset_x"), offset("crop_offset_y")),
            crop_size: UVec2::new(extent("crop_width", size.x), extent("crop_height", size.y)),
            filter: props
                .single(PluginFamily::Filter)
                .map_or(DEFAULT_FILTER, |filter| self.filter(filter)),
        };
        if (film.crop_offset + film.crop_size).cmpgt(film.size).any() {
            self.report_crop(&props, &film);
            film = film_of_size(size, DEFAULT_FILTER);
        }
        props.ignore(FILM_PARAMETERS);
        if props.is_v0() {
            props.ignore(FILM_PARAMETERS_V0);
            props.ignore_prefix("label[");
            props.ignore_prefix("metadata[");
        }
        if plugin == "specfilm" {
            props.objects(PluginFamily::Spectrum);
        }
        props.finish();
        film
    }

    fn report_crop(&self, props: &Props<'_>, film: &FilmDesc) {
        let message = format!(
            "the crop window {}x{} at ({}, {}) exceeds the film of {}x{}",
            film.crop_size.x,
            film.crop_size.y,
            film.crop_offset.x,
            film.crop_offset.y,
            film.size.x,
            film.size.y
        );
        let names = [
            "crop_width",
            "crop_height",
            "crop_offset_x",
            "crop_offset_y",
        ];
        let span = names
            .iter()
            .find_map(|name| props.get(name))
            .map_or(props.span(), |param| param.span);
        self.sink.error_at("scene::bad_value", span, message);
    }

    fn filter(&mut self, id: ObjectId) -> Filter {
        let props = self.props(id);
        let filter = match props.plugin().value.as_str() {
            "box" => {
                if props.is_v0() {
                    props.ignore(&["radius"]);
                }
                Filter::Box
            }
            "tent" => Filter::Tent {
                radius: props.float_where("radius", 1.0, |radius| radius > 0.0, "positive"),
            },
            "gaussian" => Filter::Gaussian {
                stddev: props.float_where("stddev", 0.5, |stddev| stddev > 0.0, "positive"),
            },
            "mitchell" => Filter::Mitchell {
                b: props.float("B", 1.0 / 3.0),
                c: props.float("C", 1.0 / 3.0),
            },
            "catmullrom" => Filter::CatmullRom,
            "lanczos" => Filter::Lanczos {
                lobes: props.integer("lobes", 3, 1) as f32,
            },
            _ => {
                self.unsupported(&props, FILTERS, &[]);
                return DEFAULT_FILTER;
            }
        };
        props.finish();
        filter
    }

    fn sampler(&self, id: ObjectId) {
        let props = self.props(id);
        if !SAMPLERS.contains(&props.plugin().value.as_str()) {
            self.unsupported(&props, SAMPLERS, &[]);
            return;
        }
        props.integer("sample_count", 4, 1);
        props.ignore(SAMPLER_PARAMETERS);
        props.finish();
    }
}

/// Width and height of a film in pixels.
const DEFAULT_SIZE: (u32, u32) = (768, 576);
const DEFAULT_FILTER: Filter = Filter::Gaussian { stddev: 0.5 };

/// The clip distances `near_clip` and `far_clip`.
fn clipping(props: &Props<'_>) -> (f32, f32) {
    let near = props.float_where("near_clip", 1e-2, |near| near > 0.0, "positive");
    let far = props.float("far_clip", 1e4);
    if near >= far {
        let param = props
            .get("near_clip")
            .or_else(|| props.get("far_clip"))
            .expect("invariant: the default distances are in order");
        let required = "a distance such that `near_clip` is less than `far_clip`";
        props.refuse(param, required);
        return (1e-2, 1e4);
    }
    (near, far)
}
