//! Film, reconstruction filter and path limits.

use super::super::description::film_of_size;
use super::super::parameters::{Numbers, Parameters};
use super::super::sink::Problem;
use super::builder::Builder;
use super::entities::Entity;
use manylight::film::{FilmDesc, Filter};
use manylight::math::UVec2;
use manylight::scene::PathLimits;

pub(super) const FILMS: &[&str] = &["gbuffer", "rgb", "spectral"];

pub(super) const FILTERS: &[&str] = &["box", "gaussian", "mitchell", "sinc", "triangle"];

/// Integrators of PBRT v4; only their path length is used.
pub(super) const INTEGRATORS: &[&str] = &[
    "ambientocclusion",
    "bdpt",
    "function",
    "lightpath",
    "mlt",
    "path",
    "randomwalk",
    "simplepath",
    "simplevolpath",
    "sppm",
    "volpath",
];

/// Integrators of PBRT v3.
const INTEGRATORS_V3: [&str; 6] = [
    "ao",
    "directlighting",
    "igi",
    "photonmap",
    "whitted",
    "exphotonmap",
];

/// Default width and height in pixels.
const DEFAULT_SIZE: [i32; 2] = [1280, 720];
/// Most pixels along an edge.
const MAX_SIZE: i32 = 1 << 16;

/// Parameters of films that are read elsewhere or without effect on the image.
const FILM_PARAMETERS: &[&str] = &[
    "filename",
    "savefp16",
    "diagonal",
    "iso",
    "scale",
    "display",
    "coordinatesystem",
    "nbuckets",
    "lambdamin",
    "lambdamax",
    "nwavelengths",
    "premultiplyalpha",
    "writefrequency",
    "gamma",
    "colorspace",
    "fnumber",
    "c",
];

impl Builder<'_> {
    /// The film with its filter.
    pub(super) fn film(
        &mut self,
        film: Option<&Entity<'_>>,
        filter: Option<&Entity<'_>>,
    ) -> FilmDesc {
        let filter = match filter {
            Some(entity) => self.filter(entity),
            None if self.is_v3 => Filter::Box,
            None => DEFAULT_FILTER,
        };
        let Some(entity) = film else {
            let size = UVec2::from_array(DEFAULT_SIZE.map(|edge| edge as u32));
            return film_of_size(size, filter);
        };
        let params = &entity.params;
        let plugin = params.plugin.value.as_str();
        if plugin == "image" {
            let message = "film `image` of PBRT v3 is read as `rgb`";
            let problem = Problem::new("scene::old_name", params.plugin.span, message);
            self.sink.warn_once("v3 film", problem);
        } else if !FILMS.contains(&plugin) {
            self.unknown_plugin(entity, FILMS.iter().copied());
            params.ignore_all();
        }
        let edge = |name, default| {
            let edge = params.integer(name, default, 1);
            if edge > MAX_SIZE
                && let Some(param) = params.get(name)
            {
                params.refuse(param, &format!("at most {MAX_SIZE}"));
                return default as u32;
            }
            edge as u32
        };
        let size = UVec2::new(
            edge("xresolution", DEFAULT_SIZE[0]),
            edge("yresolution", DEFAULT_SIZE[1]),
        );
        let [low, high] = self.crop(entity, size);
        params.ignore(FILM_PARAMETERS);
        self.warn_sensor(entity);
        entity.params.finish(self.is_v3);
        FilmDesc {
            size,
            crop_offset: low,
            crop_size: high - low,
            filter,
        }
    }

    /// Corners of the crop window, from `pixelbounds` or `cropwindow`.
    fn crop(&self, entity: &Entity<'_>, size: UVec2) -> [UVec2; 2] {
        let params = &entity.params;
        let whole = [UVec2::ZERO, size];
        let (name, required, corners) = if let Some(window) = params.floats("cropwindow") {
            params.ignore(&["pixelbounds"]);
            let at = |t: f32, n: u32| (t.clamp(0.0, 1.0) * n as f32).ceil() as u32;
            let corners = <[f32; 4]>::try_from(window).map(|[x0, x1, y0, y1]| {
                let low = UVec2::new(at(x0.min(x1), size.x), at(y0.min(y1), size.y));
                [
                    low,
                    UVec2::new(at(x0.max(x1), size.x), at(y0.max(y1), size.y)),
                ]
            });
            let required = "four numbers x0, x1, y0, y1 in [0, 1] around some pixels";
            ("cropwindow", required, corners)
        } else if let Some(bounds) = params.integers("pixelbounds") {
            let at = |v: i32, n: u32| v.clamp(0, n as i32) as u32;
            let corners = <[i32; 4]>::try_from(bounds).map(|[x0, x1, y0, y1]| {
                let low = UVec2::new(at(x0, size.x), at(y0, size.y));
                [low, UVec2::new(at(x1, size.x), at(y1, size.y))]
            });
            let required = "four integers x0 < x1, y0 < y1 on the film";
            ("pixelbounds", required, corners)
        } else {
            return whole;
        };
        match corners {
            Ok([low, high]) if low.cmplt(high).all() => [low, high],
            _ => {
                params.refuse_named(name, required);
                whole
            }
        }
    }

    /// Warns about sensors that change the colors.
    fn warn_sensor(&self, entity: &Entity<'_>) {
        let params = &entity.params;
        if let Some(sensor) = params.string("sensor")
            && sensor.value != "cie1931"
        {
            let name = &sensor.value;
            let message =
                format!("the sensor `{name}` is not supported; it is replaced by `cie1931`");
            self.sink.unsupported("sensor", sensor.span, message);
        }
        for name in ["whitebalance", "maxcomponentvalue", "maxsampleluminance"] {
            if let Some(param) = params.get(name)
                && params.float(name, 0.0) > 0.0
            {
                let message = format!("`{name}` of the film is not supported; it is ignored");
                self.sink.unsupported(name, param.name.span, message);
            }
        }
    }

    /// The radius of a filter along x. Another one along y is reported.
    fn filter_radius(&self, entity: &Entity<'_>, default: f32) -> f32 {
        let params = &entity.params;
        let radius = |name: &'static str, old: &'static str| {
            let positive = |radius| radius > 0.0;
            let name = if params.has(old) { old } else { name };
            params.float_where(name, default, positive, "positive")
        };
        let [x, y] = [radius("xradius", "xwidth"), radius("yradius", "ywidth")];
        if x != y {
            let message = "the filter has one radius along both axes here, that along x";
            params.unsupported("filter radii", message);
        }
        x
    }

    /// Reports a given radius that is not `fixed`, the only one that the filter has here.
    fn warn_radius(&self, entity: &Entity<'_>, fixed: f32) {
        let params = &entity.params;
        let radius = self.filter_radius(entity, fixed);
        if radius != fixed {
            let object = params.describe();
            let message = format!("{object} has the radius {fixed} here, not {radius}");
            params.unsupported("filter radius", message);
        }
    }

    fn filter(&mut self, entity: &Entity<'_>) -> Filter {
        let params = &entity.params;
        let radius = |default| self.filter_radius(entity, default);
        let filter = match params.plugin.value.as_str() {
            "box" => match radius(0.5) {
                0.5 => Filter::Box,
                // A box of another width: the tent with the same variance.
                half_width => Filter::Tent {
                    radius: half_width * std::f32::consts::SQRT_2,
                },
            },
            "triangle" => Filter::Tent {
                radius: radius(2.0),
            },
            "gaussian" => {
                radius(1.5);
                let stddev = match params.maybe_float("alpha") {
                    // PBRT v3: exp(-α x²).
                    Some(alpha) if alpha > 0.0 => (0.5 / alpha).sqrt(),
                    _ if self.is_v3 => 0.5,
                    _ => params.float_where("sigma", 0.5, |sigma| sigma > 0.0, "positive"),
                };
                Filter::Gaussian { stddev }
            }
            "mitchell" => {
                self.warn_radius(entity, 2.0);
                Filter::Mitchell {
                    b: params.float("B", 1.0 / 3.0),
                    c: params.float("C", 1.0 / 3.0),
                }
            }
            "sinc" => {
                let lobes = params.float("tau", 3.0).round().max(1.0);
                self.warn_radius(entity, lobes);
                Filter::Lanczos { lobes }
            }
            _ => {
                self.unknown_plugin(entity, FILTERS.iter().copied());
                params.ignore_all();
                DEFAULT_FILTER
            }
        };
        entity.params.finish(self.is_v3);
        filter
    }

    /// The path limits of an integrator. PBRT counts scattering events, here segments are counted.
    pub(super) fn limits(&mut self, integrator: Option<&Entity<'_>>) -> PathLimits {
        /// PBRT's default number of scattering events.
        const MAX_EVENTS: i32 = 5;
        let mut limits = PathLimits {
            max_depth: Some(MAX_EVENTS as u32 + 1),
            ..PathLimits::default()
        };
        let Some(entity) = integrator else {
            return limits;
        };
        let params = &entity.params;
        let plugin = params.plugin.value.as_str();
        if !INTEGRATORS.contains(&plugin) && !INTEGRATORS_V3.contains(&plugin) {
            let message = format!("unknown integrator `{plugin}`; only its `maxdepth` is used");
            params.unsupported(format!("integrator {plugin}"), message);
        }
        let events = params.integer("maxdepth", MAX_EVENTS, 0);
        limits.max_depth = Some(events as u32 + 1);
        params.ignore_all();
        limits
    }
}

/// The factor of all pixels.
pub(super) fn film_scale(film: Option<&Entity<'_>>) -> f32 {
    let at_least_zero = |scale| scale >= 0.0;
    film.map_or(1.0, |film| {
        film.params
            .float_where("scale", 1.0, at_least_zero, "at least 0")
    })
}

const DEFAULT_FILTER: Filter = Filter::Gaussian { stddev: 0.5 };
