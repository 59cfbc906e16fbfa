//! `--lights-out`, `--lights-in`: virtual lights in files.

use crate::args::{GltfArgs, RenderArgs};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::light_options;
use crate::memory::check_memory_of_lights;
use crate::method::method_kind;
use crate::request::RenderRequest;
use crate::session::Session;
use crate::usage::render_args;
use manylight::integrators::{KeptLights, LightsContext, MethodKind};
use manylight::render::{Stats, make_lights};
use manylight_io::part::{LightsFile, LightsHeader, write_lights};
use manylight_io::{FileError, check_replaceable, shown_path};
use serde_json::{Map, Value, json};
use std::path::Path;

/// The request of `args`, and the file of lights that it names, which decides about the method and
/// the number of passes.
///
/// # Errors
/// A combination of options without a meaning, or the file cannot be used.
pub(crate) fn request_with_lights(
    args: &RenderArgs,
) -> Result<(RenderRequest, Option<LightsFile>), Failure> {
    let request = RenderRequest::new(args)?;
    let Some(path) = &args.kept.lights_in else {
        return Ok((request, None));
    };
    let file = LightsFile::open(path)?;
    let header = file.header();
    let made = request_of_header(path, header)?;
    let (asked, found) = (args.paths.method, made.paths.method);
    if !asked.is_chosen() && asked != found {
        return Err(Failure::usage(
            format!(
                "--method {}: the lights of {} are of the method {}",
                asked.name,
                shown_path(path),
                found.name
            ),
            "omit --method",
        ));
    }
    check_same_options(args, path, &made)?;
    let mut budget = request.budget;
    let given = args.budget.passes.map(|passes| passes.get());
    if let Some(more) = given.filter(|&passes| passes > header.passes) {
        return Err(Failure::usage(
            format!(
                "--passes {more}: {} has lights for {} passes",
                shown_path(path),
                header.passes
            ),
            "ask for fewer passes, or keep lights for as many by --lights-out",
        ));
    }
    budget.passes = Some(given.unwrap_or(header.passes));
    let mut paths = request.paths.clone();
    paths.method = found;
    let request = RenderRequest {
        kind: made.kind,
        budget,
        paths,
        ..request
    };
    Ok((request, Some(file)))
}

/// Refuses options of virtual lights other than those by which the lights of a file were `made`.
fn check_same_options(args: &RenderArgs, path: &Path, made: &RenderRequest) -> Result<(), Failure> {
    let asked = light_options::settings(&method_kind(made.paths.method, &args.lights)?);
    let found = light_options::settings(&made.kind);
    for name in args.lights.names() {
        let value = |settings: &[(&'static str, String)]| {
            let setting = settings.iter().find(|(other, _)| *other == name);
            setting.map_or_else(|| "none".to_owned(), |(_, value)| value.clone())
        };
        let (asked, found) = (value(&asked), value(&found));
        if asked != found {
            return Err(Failure::usage(
                format!(
                    "--{name} {asked}: the lights of {} were made with --{name} {found}",
                    shown_path(path)
                ),
                format!(
                    "omit --{name}; `--lights-out` keeps lights that are made by other options"
                ),
            ));
        }
    }
    Ok(())
}

/// The request with the options in the header of a file.
fn request_of_header(path: &Path, header: &LightsHeader) -> Result<RenderRequest, Failure> {
    let damaged = |failure: Failure| {
        Failure::from(FileError::malformed(
            path,
            format!("the header names options that this version does not know: {failure}"),
        ))
    };
    let words = header.options.iter().map(String::as_str);
    // Neither a scene nor a file of lights is read.
    let args = render_args(["scene.xml", "--passes=1"].into_iter().chain(words));
    let args = args.map_err(damaged)?;
    let request = RenderRequest::new(&args).map_err(damaged)?;
    match &request.kind {
        MethodKind::ManyLight(lights) if !request.paths.method.is_chosen() => {
            KeptLights::check(lights).map_err(|error| {
                FileError::malformed(path, format!("the header is damaged: {error}"))
            })?;
            Ok(request)
        }
        _ => {
            let message = "the header is damaged: it names no method of virtual lights";
            Err(FileError::malformed(path, message).into())
        }
    }
}

/// The lights that a render shades by.
pub(crate) enum ShadingLights<'s> {
    /// They are made pass by pass.
    OfPasses,
    /// They were made before.
    Kept(Box<KeptLights<'s>>),
    /// An interrupt came before all were made.
    Interrupted,
}

impl<'s> ShadingLights<'s> {
    /// Those that `session` asks for: it may name a file of lights, or one in which those that are
    /// made here are kept.
    ///
    /// # Errors
    /// The lights are of another scene, the memory limit is too small, or the file cannot be read or
    /// written.
    pub(crate) fn of(session: &'s Session, interrupt: &Interrupt) -> Result<Self, Failure> {
        let kept = &session.request.kept;
        match (&kept.lights_in, &kept.lights_out) {
            (Some(path), _) => {
                let lights = (session.stats).time("lights_in", || read(session, path))?;
                Ok(ShadingLights::Kept(Box::new(lights)))
            }
            (None, Some(path)) => make(session, path, interrupt),
            (None, None) => Ok(ShadingLights::OfPasses),
        }
    }

    /// Those that were made before.
    pub(crate) fn kept(&self) -> Option<&KeptLights<'s>> {
        match self {
            ShadingLights::Kept(lights) => Some(lights),
            ShadingLights::OfPasses | ShadingLights::Interrupted => None,
        }
    }

    /// Whether an interrupt came before all were made.
    pub(crate) fn are_interrupted(&self) -> bool {
        matches!(self, ShadingLights::Interrupted)
    }
}

fn read<'s>(session: &'s Session, path: &Path) -> Result<KeptLights<'s>, Failure> {
    let Some(file) = &session.lights else {
        unreachable!("the file was opened with the request");
    };
    let header = file.header();
    check_scene(path, &header.scene, &scene_of(session))?;
    let groups = light_group_names(session);
    if header.light_groups != groups {
        let named = |names: &[String]| match names {
            [] => "no light groups".to_owned(),
            names => format!("the light groups {}", names.join(", ")),
        };
        return Err(Failure::usage(
            format!(
                "{} has {}, the render {}",
                shown_path(path),
                named(&header.light_groups),
                named(&groups)
            ),
            "give the same --light-groups and --light-group as with --lights-out",
        ));
    }
    let method = session.request.method(session.scene.limits);
    let Some(lights) = method.lights() else {
        unreachable!("the header was checked to have virtual lights");
    };
    let cx = LightsContext {
        method: lights.of_frames(Some(header.passes)),
        scene: &session.scene,
        limits: method.limits,
        passes: header.passes,
        light_groups: groups.len(),
    };
    let lights = session.pool.install(|| file.lights(&cx))?;
    Stats::count(&session.stats.lights, lights.light_count() as u64);
    Stats::count(&session.stats.light_bytes, lights.light_bytes() as u64);
    Ok(lights)
}

fn make<'s>(
    session: &'s Session,
    path: &Path,
    interrupt: &Interrupt,
) -> Result<ShadingLights<'s>, Failure> {
    check_replaceable(path)?;
    let job = session.job();
    let (pool, stats) = (&session.pool, &session.stats);
    pool.install(|| check_memory_of_lights(session.request.memory_limit, &job))?;
    let Some(lights) = pool.install(|| make_lights(&job, stats, interrupt.cancel())) else {
        return Ok(ShadingLights::Interrupted);
    };
    let header = LightsHeader::new(
        scene_of(session),
        method_words(&session.request),
        job.budget.passes.unwrap_or_default(),
        light_group_names(session),
    );
    let _complete_file = interrupt.writing();
    stats.time("lights_out", || write_lights(path, &header, &lights))?;
    Ok(ShadingLights::Kept(Box::new(lights)))
}

/// The words of the method and of its settings.
fn method_words(request: &RenderRequest) -> Vec<String> {
    let settings = light_options::settings(&request.kind).into_iter();
    let method = [("method", request.paths.method.name.to_owned())];
    let words = method.into_iter().chain(settings);
    words
        .map(|(name, value)| format!("--{name}={value}"))
        .collect()
}

/// Names of the light groups; none if they are not told apart.
fn light_group_names(session: &Session) -> Vec<String> {
    match session.request.picture.has_light_groups() {
        true => session.scene.light_groups.names().to_vec(),
        false => Vec::new(),
    }
}

/// What lights and the render that uses them must have in common.
fn scene_of(session: &Session) -> Map<String, Value> {
    let limits = session.request.method(session.scene.limits).limits;
    // Frames are of cameras.
    let gltf = GltfArgs {
        fps: None,
        ..session.request.gltf.without_folders()
    };
    let rules = session.request.picture.light_group.iter();
    let light_group: Vec<String> = rules.map(ToString::to_string).collect();
    let scene = json!({
        "scene_sha256": session.scene_digest,
        "defines": session.request.paths.defines,
        "gltf": gltf,
        "max_depth": limits.max_depth.map_or(-1, i64::from),
        "light_group": light_group,
    });
    match scene {
        Value::Object(map) => map,
        other => unreachable!("an object was made: {other}"),
    }
}

/// Refuses lights of another scene.
fn check_scene(
    path: &Path,
    found: &Map<String, Value>,
    expected: &Map<String, Value>,
) -> Result<(), Failure> {
    let mut keys = expected.keys().chain(found.keys());
    let Some(key) = keys.find(|key| found.get(*key) != expected.get(*key)) else {
        return Ok(());
    };
    let text = |map: &Map<String, Value>| map.get(key).map_or("nothing".into(), Value::to_string);
    Err(Failure::usage(
        format!(
            "{} holds lights of another scene: its {key} is {}, that of the render {}",
            shown_path(path),
            text(found),
            text(expected)
        ),
        "lights serve any camera of the scene for which they were made, with the same options that load it",
    ))
}
