//! The settings of a render as text: for the JSON report, for the metadata of images, and as a command that repeats the render.

use crate::args::{Denoiser, Units, environment_name};
use crate::names::{AOV_NAMES, AovNames, FILTERS, VIEWS, filter_name, name_of};
use crate::preset;
use crate::request::RenderRequest;
use manylight::film::FilmDesc;
use manylight::film::blocks::DEFAULT_BLOCK;
use manylight::integrators::{Method, MethodKind};
use manylight_denoise::Version;
use manylight_io::image::View;
use manylight_lab::text::quoted;
use serde_json::{Map, Value, json};

/// Keys of settings that do not change the bits of the sums over passes.
const NOT_DECIDING: &[&str] = &[
    "passes",
    "time",
    "target_error",
    "threads",
    "exposure",
    "view",
    "aov_names",
    "denoise",
    "oidn_version",
    "strict",
];

/// All settings of a render, including defaults and settings of the scene.
#[derive(Debug)]
pub(crate) struct Settings<'r> {
    /// The request.
    pub(crate) request: &'r RenderRequest,
    /// The method with the path limits in effect.
    pub(crate) method: &'r Method,
    /// The film in effect: size, crop window and filter.
    pub(crate) film: &'r FilmDesc,
    /// Number of threads.
    pub(crate) threads: usize,
    /// Version of Open Image Denoise, if the image is to be denoised.
    pub(crate) oidn: Option<Version>,
}

impl Settings<'_> {
    /// All settings as JSON. Keys are the names of the options, with underscores.
    pub(crate) fn to_json(&self) -> Map<String, Value> {
        let request = self.request;
        let mut map = Map::new();
        let mut put = |key: &str, value: Value| map.insert(key.replace('-', "_"), value);
        for (name, value) in preset::settings(&request.kind) {
            let number = value.parse::<u64>().map(Value::from);
            put(name, number.unwrap_or(Value::String(value)));
        }
        match &request.kind {
            MethodKind::ManyLight(method) => put("importons", method.importon_paths.into()),
            MethodKind::PhotonMap(method) => put("neighbors", method.neighbors.into()),
            _ => None,
        };
        let limits = self.method.limits;
        put("max-depth", limits.max_depth.map_or(json!(-1), Value::from));
        put("rr-depth", limits.rr_depth.into());
        put("hide-emitters", limits.hide_emitters.into());
        put("passes", json!(request.budget.passes));
        put(
            "time",
            json!(request.budget.time.map(|time| time.as_secs_f64())),
        );
        put("target-error", json!(request.budget.relative_error));
        put("size", json!(self.film.size.to_array()));
        put("crop-offset", json!(self.film.crop_offset.to_array()));
        put("crop-size", json!(self.film.crop_size.to_array()));
        put("filter", filter_name(&self.film.filter).into());
        put("sensor", request.sensor.into());
        put("seed", request.seed.into());
        put("block", request.block.get().into());
        put("threads", self.threads.into());
        let picture = &request.picture;
        put("exposure", picture.file.exposure.into());
        put("view", json!(name_of(VIEWS, &picture.file.view)));
        put("aov", picture.aov_words().into());
        put(
            "aov-names",
            json!(name_of(AOV_NAMES, &picture.file.aov_names)),
        );
        put("denoise", json!(request.denoise.map(denoiser_name)));
        put(
            "oidn-version",
            json!(self.oidn.map(|version| version.to_string())),
        );
        put("strict", request.strict.into());
        let defines = request
            .defines
            .iter()
            .map(|(name, value)| (name.clone(), json!(value)));
        put("defines", Value::Object(defines.collect()));
        let gltf = &request.gltf;
        put("light-units", json!(gltf.light_units.map(Units::name)));
        put(
            "environment",
            json!(gltf.environment.as_ref().map(environment_name)),
        );
        put("environment-scale", json!(gltf.environment_scale));
        put("variant", json!(gltf.variant));
        map
    }

    /// What decides about the bits of the image (name, value), with the SHA-256 of the files of the scene. Parts of one render agree in it.
    pub(crate) fn identity(&self, scene_digest: &str) -> Map<String, Value> {
        let mut map = Map::new();
        map.insert("version".into(), env!("CARGO_PKG_VERSION").into());
        map.insert(
            "instruction_set".into(),
            manylight::instruction_set().into(),
        );
        map.insert("scene_sha256".into(), scene_digest.into());
        map.insert("method".into(), self.request.method.into());
        let deciding = |(key, _): &(String, Value)| !NOT_DECIDING.contains(&key.as_str());
        map.extend(self.to_json().into_iter().filter(deciding));
        map
    }

    /// All settings as metadata of an image (name, value).
    pub(crate) fn metadata(&self) -> impl Iterator<Item = (String, String)> {
        let text = |value: Value| match value {
            Value::String(text) => text,
            other => other.to_string(),
        };
        let settings = self.to_json().into_iter();
        settings.map(move |(key, value)| (format!("settings.{key}"), text(value)))
    }
}

fn denoiser_name(denoiser: Denoiser) -> &'static str {
    match denoiser {
        Denoiser::Oidn => "oidn",
    }
}

/// The command that repeats a render of `passes` passes with identical bits, independent of what ended it.
pub(crate) fn command_line(request: &RenderRequest, passes: u32) -> String {
    let mut words = vec![
        "manylight".to_string(),
        "render".into(),
        request.scene.display().to_string(),
    ];
    let mut option = |name: &str, value: String| words.extend([format!("--{name}"), value]);
    option("method", request.method.into());
    for (name, value) in preset::settings(&request.kind) {
        option(name, value);
    }
    option("passes", passes.to_string());
    option("seed", request.seed.to_string());
    if request.block != DEFAULT_BLOCK {
        option("block", request.block.to_string());
    }
    option("sensor", request.sensor.to_string());
    if let Some(depth) = request.max_depth {
        option("max-depth", depth.0.map_or("-1".into(), |n| n.to_string()));
    }
    if let Some(size) = request.size {
        option("size", format!("{}x{}", size.x, size.y));
    }
    if let Some(crop) = request.crop {
        option(
            "crop",
            format!("{},{},{},{}", crop.x[0], crop.x[1], crop.y[0], crop.y[1]),
        );
    }
    if let Some(filter) = request
        .filter
        .as_ref()
        .and_then(|filter| name_of(FILTERS, filter))
    {
        option("filter", filter.into());
    }
    for path in &request.outputs {
        option("output", path.display().to_string());
    }
    if let Some(denoiser) = request.denoise {
        option("denoise", denoiser_name(denoiser).into());
    }
    if let Some(file) = &request.oidn_lib {
        option("oidn-lib", file.display().to_string());
    }
    let picture = &request.picture;
    option("exposure", picture.file.exposure.to_string());
    if picture.file.view != View::default() {
        let name = name_of(VIEWS, &picture.file.view);
        option("view", name.unwrap_or_default().into());
    }
    if !picture.aov.is_empty() {
        option("aov", picture.aov_words());
    }
    if picture.file.aov_names != AovNames::default() {
        let name = name_of(AOV_NAMES, &picture.file.aov_names);
        option("aov-names", name.unwrap_or_default().into());
    }
    let gltf = &request.gltf;
    if let Some(units) = gltf.light_units {
        option("light-units", Units::name(units).into());
    }
    if let Some(source) = &gltf.environment {
        option("environment", environment_name(source));
        option("environment-scale", gltf.environment_scale.to_string());
    }
    if let Some(variant) = &gltf.variant {
        option("variant", variant.clone());
    }
    if request.hide_emitters {
        words.push("--hide-emitters".into());
    }
    for (name, value) in &request.defines {
        words.extend(["-D".into(), format!("{name}={value}")]);
    }
    words
        .iter()
        .map(|word| quoted(word))
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use clap::Parser;

    fn request(words: &[&str]) -> RenderRequest {
        match Cli::try_parse_from(words).unwrap().command {
            Command::Render(args) => RenderRequest::new(&args).unwrap(),
            _ => unreachable!(),
        }
    }

    #[test]
    fn the_command_line_asks_for_the_same_render() {
        for options in [
            "-n 5000 --clamp 2.5 --kernel point --table-size 8 --size 32x16 --max-depth -1",
            "-m vpl --photons 77 --crop 0.25,1,0,0.5 --filter tent --seed 9 -D a=1 -D b=2",
            "-m photon-map --photons 99 --max-depth 3 --denoise oidn",
            "-m direct --denoise oidn --oidn-lib some/library.so",
            "-m path --light-units raw --environment sky.hdr --environment-scale 2 --variant red",
            "-m direct --view agx --aov object,position --aov-names blender",
            "-m path --block 32",
            "-m path --hide-emitters --sensor 2 --exposure -1.5 --max-depth 4 -o a.hdr -o b.pfm",
        ] {
            let start = ["manylight", "render", "a/scene.xml"].into_iter();
            let asked = request(&start.chain(options.split_whitespace()).collect::<Vec<_>>());
            let line = command_line(&asked, 16);
            let again = request(&line.split_whitespace().collect::<Vec<_>>());
            assert_eq!(asked, again, "{line}");
        }
    }
}
