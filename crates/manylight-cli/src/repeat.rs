//! The settings of a render as text: for the JSON report, for the metadata of images, and as a
//! command that repeats the render.

use crate::choice;
use crate::light_options;
use crate::names::filter_name;
use crate::request::RenderRequest;
use manylight::film::FilmDesc;
use manylight::integrators::{Choice, Method, MethodKind};
use manylight_denoise::Version;
use manylight_lab::text::quoted;
use serde::Serialize;
use serde_json::{Map, Number, Value, json};

/// All settings of a render, including defaults and settings of the scene.
#[derive(Debug)]
pub(crate) struct Settings<'r> {
    /// The request.
    pub(crate) request: &'r RenderRequest,
    /// The method with the path limits in effect.
    pub(crate) method: &'r Method,
    /// The film in effect: size, crop window and filter.
    pub(crate) film: &'r FilmDesc,
    /// What was chosen, by a method that is chosen.
    pub(crate) choice: Option<&'r Choice>,
    /// Number of threads.
    pub(crate) threads: usize,
    /// Version of Open Image Denoise, if the image is to be denoised.
    pub(crate) oidn: Option<Version>,
}

impl Settings<'_> {
    /// All settings as JSON. Keys are the names of the options, with underscores.
    pub(crate) fn to_json(&self) -> Map<String, Value> {
        let request = self.request;
        let mut map = self.deciding();
        map.extend(written(&request.run));
        map.extend(written(&request.picture.file));
        map.extend(written(&request.denoise));
        map.shift_remove("oidn_lib");
        map.extend(written(&request.kept));
        map.extend(object(json!({
            "passes": request.budget.passes,
            "time": request.budget.time.map(|time| time.as_secs_f64()),
            "target_error": request.budget.relative_error,
            "threads": self.threads,
            "oidn_version": self.oidn.map(|version| version.to_string()),
        })));
        map.extend(
            self.choice
                .map(|choice| ("choice_errors".into(), choice::figures(choice))),
        );
        map
    }

    /// The settings that decide about the bits of the sums over passes: as the scene and the
    /// options have them together.
    fn deciding(&self) -> Map<String, Value> {
        let request = self.request;
        let mut map = Map::new();
        for (name, value) in light_options::settings(&request.kind) {
            map.insert(name.replace('-', "_"), number_or_word(value));
        }
        match &request.kind {
            MethodKind::ManyLight(method) => {
                map.insert("importons".into(), method.importon_paths.into());
            }
            MethodKind::PhotonMap(method) => {
                map.insert("neighbors".into(), method.neighbors.into());
            }
            _ => {}
        }
        map.extend(self.choice.map(choice::deciding).unwrap_or_default());
        map.extend(written(&request.paths));
        map.extend(written(&request.camera));
        map.extend(written(&request.parts));
        map.extend(written(&request.picture));
        map.extend(written(&request.frames));
        map.extend(written(&request.gltf));
        map.shift_remove("crop");
        let (limits, film) = (self.method.limits, self.film);
        map.extend(object(json!({
            "max_depth": limits.max_depth.map_or(-1, i64::from),
            "rr_depth": limits.rr_depth,
            "hide_emitters": limits.hide_emitters,
            "size": film.size.to_array(),
            "crop_offset": film.crop_offset.to_array(),
            "crop_size": film.crop_size.to_array(),
            "filter": filter_name(&film.filter),
            "environment_scale": request.gltf.options().environment_scale,
        })));
        map
    }

    /// What decides about the bits of the image (name, value), with the SHA-256 of the files of the
    /// scene. Parts of one render agree in it.
    /// `lights` is the SHA-256 of the lights of a file, if the render shades by them.
    pub(crate) fn identity(&self, scene_digest: &str, lights: Option<&str>) -> Map<String, Value> {
        let mut map = object(json!({
            "version": env!("CARGO_PKG_VERSION"),
            "instruction_set": manylight::instruction_set(),
            "scene_sha256": scene_digest,
            "method": self.request.paths.method.name,
        }));
        map.extend(lights.map(|digest| ("lights_sha256".into(), digest.into())));
        map.extend(self.deciding());
        let environment = self.request.gltf.without_folders().environment;
        map.insert("environment".into(), json!(environment));
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

/// The options of a group, with the names of its fields.
fn written(group: &impl Serialize) -> Map<String, Value> {
    object(serde_json::to_value(group).expect("invariant: every option can be written"))
}

fn object(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(map) => map,
        other => unreachable!("a group of options is an object: {other}"),
    }
}

/// The command that repeats a render of `passes` passes with identical bits, independent of what
/// ended it, and of the pre-pass of a choice where a single method was chosen.
pub(crate) fn command_line(
    request: &RenderRequest,
    choice: Option<&Choice>,
    passes: u32,
) -> String {
    let mut words = first_words(request);
    let mut add = |name: &str, value: Value| words.extend(option_words(name, value));
    let method = choice.map_or(request.paths.method.name, choice::repeating_method);
    // Lights that are kept have a method and settings of their own.
    let has_lights = request.kept.lights_in.is_some();
    if !has_lights {
        add("method", method.into());
    }
    if !has_lights && !choice.is_some_and(choice::is_path) {
        for (name, value) in light_options::settings(&request.kind) {
            add(name, value.into());
        }
    }
    add("passes", passes.into());
    for group in [
        written(&request.paths),
        written(&choice::parts(&request.parts, choice)),
        written(&request.camera),
        written(&request.denoise),
        written(&request.picture.file),
        written(&request.picture),
        written(&request.frames),
        written(&request.kept),
        written(&request.gltf),
    ] {
        group
            .into_iter()
            .for_each(|(name, value)| add(&name, value));
    }
    for path in &request.outputs {
        add("output", path.display().to_string().into());
    }
    in_a_line(&words)
}

/// The command that renders the same picture by path tracing to `reference.exr`.
pub(crate) fn reference_command(request: &RenderRequest) -> String {
    let mut words = first_words(request);
    words.extend(["-m", "path", "--spp", "256"].map(str::to_owned));
    let groups = [
        written(&request.paths),
        written(&request.camera),
        written(&request.gltf),
    ];
    for (name, value) in groups.into_iter().flatten() {
        // Another seed is no other picture, and 0 is the default of the camera.
        if name != "seed" && value != 0 {
            words.extend(option_words(&name, value));
        }
    }
    words.extend(["-o", "reference.exr"].map(str::to_owned));
    in_a_line(&words)
}

/// The words of a command that renders the scene of `request`, without its options.
fn first_words(request: &RenderRequest) -> Vec<String> {
    let scene = request.scene.display().to_string();
    vec!["manylight".into(), "render".into(), scene]
}

/// A command as a shell takes it.
fn in_a_line(words: &[String]) -> String {
    let words: Vec<_> = words.iter().map(|word| quoted(word)).collect();
    words.join(" ")
}

/// The words of an option with the name of its field; none where it is not given.
fn option_words(name: &str, value: Value) -> Vec<String> {
    let option = format!("--{}", name.replace('_', "-"));
    let text = match value {
        Value::Null | Value::Bool(false) => return Vec::new(),
        Value::Bool(true) => return vec![option],
        Value::Object(defines) => {
            let define = |(name, value): (&String, &Value)| {
                [
                    "-D".into(),
                    format!("{name}={}", value.as_str().unwrap_or_default()),
                ]
            };
            return defines.iter().flat_map(define).collect();
        }
        Value::String(text) if text.is_empty() => return Vec::new(),
        Value::String(text) => text,
        // The digits of a number of 32 bits that became one of 64.
        Value::Number(number) if number.is_f64() => {
            (number.as_f64().unwrap_or_default() as f32).to_string()
        }
        other => other.to_string(),
    };
    vec![option, text]
}

/// A setting as JSON: a number where it is one.
fn number_or_word(value: String) -> Value {
    let whole = value.parse::<u64>().ok().map(Value::from);
    let number = || value.parse::<f64>().ok().and_then(Number::from_f64);
    whole
        .or_else(|| number().map(Value::Number))
        .unwrap_or(Value::String(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_numbers_or_words() {
        let json = |value: &str| number_or_word(value.to_owned());
        assert_eq!(json("512"), Value::from(512));
        assert_eq!(json("0.02"), Value::from(0.02));
        assert_eq!(json("none"), Value::from("none"));
        assert_eq!(json("inf"), Value::from("inf"));
    }
    use crate::args::{Cli, Command};
    use clap::Parser;

    fn request(words: &[&str]) -> RenderRequest {
        match Cli::try_parse_from(words).unwrap().command {
            Command::Render(args) => RenderRequest::new(&args).unwrap(),
            _ => unreachable!(),
        }
    }

    #[test]
    fn a_reference_shows_the_same_picture() {
        let words = "manylight render a/scene.xml --crop 0,0.5,0,1 --max-depth -1 --seed 9 -D a=0 -n 50 -o b.exr";
        assert_eq!(
            reference_command(&request(&words.split(' ').collect::<Vec<_>>())),
            "manylight render a/scene.xml -m path --spp 256 --max-depth -1 -D a=0 --crop 0,0.5,0,1 -o reference.exr"
        );
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
            "-m path --light-groups",
            "--cameras walk.json --frames 3..7",
            "-m vpl --frames 4",
            "--frames 4..",
            "--lights-out some/file.lights",
            "-m path --light-group key=lamp --light-group fill=sky",
            "-m path --hide-emitters --sensor 2 --exposure -1.5 --max-depth 4 -o a.hdr -o b.pfm",
        ] {
            let start = ["manylight", "render", "a/scene.xml"].into_iter();
            let asked = request(&start.chain(options.split_whitespace()).collect::<Vec<_>>());
            let line = command_line(&asked, None, 16);
            let again = request(&line.split_whitespace().collect::<Vec<_>>());
            assert_eq!(asked, again, "{line}");
        }
    }
}
