//! The request of a render: all options with their defaults, checked before any file is read.

use crate::args::{
    CameraArgs, DenoiseArgs, FrameArgs, GltfArgs, KeptLightArgs, MapsArgs, PartArgs, PathArgs,
    PictureArgs, RenderArgs, RunArgs,
};
use crate::failure::Failure;
use crate::film_window::{resize, set_crop};
use crate::method::{choice_refusal, method_kind};
use crate::preset::{self, Preset};
use crate::values::GroupRule;
use manylight::integrators::{KeptLights, Method, MethodKind};
use manylight::render::Budget;
use manylight::scene::PathLimits;
use manylight::sensors::SensorDesc;
use manylight_io::image::ImageFormat;
use manylight_io::{LoadOptions, SCENE_EXTENSIONS, is_same_file, shown_path};
use manylight_lab::text::plural;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// A request to render.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RenderRequest {
    /// Path of the scene file as given.
    pub(crate) scene: PathBuf,
    /// Image files, at least one.
    pub(crate) outputs: Vec<PathBuf>,
    /// The method with its parameters.
    pub(crate) kind: MethodKind,
    /// Limits of the render.
    pub(crate) budget: Budget,
    /// Name of the method, and paths.
    pub(crate) paths: PathArgs,
    /// Threads, and whether warnings are errors.
    pub(crate) run: RunArgs,
    /// Largest estimated memory in bytes.
    pub(crate) memory_limit: Option<u64>,
    /// Layers and colors of pictures.
    pub(crate) picture: PictureArgs,
    /// Whether layers go anywhere: into a file, to a preview, or to the denoiser.
    pub(crate) keeps_layers: bool,
    /// The denoiser.
    pub(crate) denoise: DenoiseArgs,
    /// Blocks, shares and checkpoints.
    pub(crate) parts: PartArgs,
    /// Camera and film.
    pub(crate) camera: CameraArgs,
    /// Cameras and frames of a walkthrough.
    pub(crate) frames: FrameArgs,
    /// Files of virtual lights.
    pub(crate) kept: KeptLightArgs,
    /// What a glTF scene does not say.
    pub(crate) gltf: GltfArgs,
}

impl RenderRequest {
    /// A warning of layers that are asked for and that no output keeps.
    pub(crate) fn lost_layers(&self) -> Option<String> {
        if writes_part(&self.parts) || have_layers(&self.outputs) {
            return None;
        }
        let option = if !self.picture.aov.is_empty() {
            "--aov"
        } else if self.picture.has_light_groups() {
            "--light-groups"
        } else {
            return None;
        };
        Some(format!(
            "{option}: only exr files have layers; add -o {}",
            shown_path(&self.outputs.first()?.with_extension("exr"))
        ))
    }

    /// The request of the command `render`.
    ///
    /// # Errors
    /// A combination of options without a meaning, or an output with an unknown format.
    pub(crate) fn new(args: &RenderArgs) -> Result<Self, Failure> {
        let outputs = match args.outputs.as_slice() {
            [] => default_outputs(&args.scene),
            given => given.to_vec(),
        };
        match args.parts.shard {
            None => check_formats(&outputs)?,
            Some(_) => check_part(args)?,
        }
        if let Some(path) = &args.parts.checkpoint {
            check_part_name("--checkpoint", path)?;
        }
        let method = method_of(args);
        let kind = method_kind(method, &args.lights)?;
        check_combinations(args, method, &kind)?;
        Ok(RenderRequest {
            scene: args.scene.clone(),
            kind,
            budget: args.budget.budget(),
            paths: PathArgs {
                method,
                ..args.paths.clone()
            },
            run: args.run.clone(),
            memory_limit: args.memory_limit,
            picture: args.picture.clone(),
            keeps_layers: keeps_layers(args, &outputs),
            denoise: args.denoise.clone(),
            parts: args.parts.clone(),
            camera: args.camera.clone(),
            frames: args.frames.clone(),
            kept: args.kept.clone(),
            gltf: args.gltf.clone(),
            outputs,
        })
    }

    /// The request of the command `maps`: one pass, and outputs with the names `files` in its
    /// folder.
    ///
    /// # Errors
    /// A combination of options without a meaning.
    pub(crate) fn for_maps(args: &MapsArgs, files: &[&str]) -> Result<Self, Failure> {
        Ok(RenderRequest {
            scene: args.scene.clone(),
            outputs: files.iter().map(|file| args.output.join(file)).collect(),
            kind: method_kind(args.paths.method, &args.lights)?,
            budget: Budget::passes(1),
            paths: args.paths.clone(),
            run: args.run.clone(),
            memory_limit: None,
            picture: PictureArgs::default(),
            keeps_layers: true,
            denoise: DenoiseArgs::default(),
            parts: PartArgs::default(),
            camera: args.camera.clone(),
            frames: FrameArgs::default(),
            kept: KeptLightArgs::default(),
            gltf: args.gltf.clone(),
        })
    }

    /// Options for loading the scene file.
    pub(crate) fn load_options(&self) -> LoadOptions {
        self.gltf.load_options(&self.paths.defines)
    }

    /// The method with its path limits; `scene_limits` are those of the scene.
    pub(crate) fn method(&self, scene_limits: PathLimits) -> Method {
        let limits = PathLimits {
            max_depth: (self.paths.max_depth).map_or(scene_limits.max_depth, |depth| depth.0),
            hide_emitters: self.paths.hide_emitters || scene_limits.hide_emitters,
            ..scene_limits
        };
        Method {
            kind: self.kind.clone(),
            limits,
            extra: self.picture.extra_layers(&self.kind),
        }
    }

    /// The frames that are asked for, counted from 1, out of `count`.
    ///
    /// # Errors
    /// There are fewer.
    pub(crate) fn frames_of(&self, count: u32) -> Result<RangeInclusive<u32>, Failure> {
        let Some(range) = self.frames.frames else {
            return Ok(1..=count);
        };
        let last = range.last.unwrap_or(count);
        if range.first.max(last) > count {
            return Err(Failure::usage(
                format!(
                    "--frames {range}: found {count} camera{}",
                    plural(count as usize)
                ),
                "frames are counted from 1",
            ));
        }
        Ok(range.first..=last)
    }

    /// The selected one of the cameras of a scene, with the options of the film.
    ///
    /// # Errors
    /// The scene has no camera with this index.
    pub(crate) fn camera(&self, sensors: &[SensorDesc]) -> Result<SensorDesc, Failure> {
        let count = sensors.len();
        let options = &self.camera;
        let Some(mut sensor) = sensors.get(options.sensor).cloned() else {
            return Err(Failure::usage(
                format!(
                    "--sensor {}: the scene has {count} camera{}",
                    options.sensor,
                    plural(count)
                ),
                "cameras are counted from 0; `manylight info` lists them",
            ));
        };
        if let Some(size) = options.size {
            resize(&mut sensor.film, size);
        }
        if let Some(crop) = options.crop {
            set_crop(&mut sensor.film, crop);
        }
        sensor.film.filter = options.filter.unwrap_or(sensor.film.filter);
        Ok(sensor)
    }
}

/// Refuses to keep lights of a method that has none, or has trees over them.
fn check_kept(args: &RenderArgs, kind: &MethodKind) -> Result<(), Failure> {
    if args.kept.lights_out.is_none() {
        return Ok(());
    }
    let MethodKind::ManyLight(lights) = kind else {
        return Err(Failure::usage(
            format!(
                "--lights-out: the method {} has no virtual lights",
                args.paths.method.name
            ),
            "choose another --method, such as rich-vpl",
        ));
    };
    KeptLights::check(lights).map_err(|error| {
        let message = format!("--lights-out: {error}");
        Failure::usage(
            message,
            "choose a method that sums all lights, such as rich-vpl",
        )
    })
}

/// The method of a render.
fn method_of(args: &RenderArgs) -> &'static Preset {
    let has_lights_first = args.frames.is_walkthrough() || args.kept.is_given();
    match args.paths.method {
        method if method.is_chosen() && has_lights_first => preset::of_kept_lights(),
        method => method,
    }
}

/// Default outputs: the name of the folder of the scene with `.exr` and `.png`, in the current
/// folder.
fn default_outputs(scene: &Path) -> Vec<PathBuf> {
    let absolute = std::path::absolute(scene).unwrap_or_else(|_| scene.into());
    let folder = absolute.parent().and_then(Path::file_name);
    let name = folder.unwrap_or_else(|| std::ffi::OsStr::new("render"));
    ["exr", "png"]
        .map(|extension| {
            let mut file = name.to_os_string();
            file.push(".");
            file.push(extension);
            PathBuf::from(file)
        })
        .into()
}

/// Refuses a share without one part file, or with an end that only a whole image has.
fn check_part(args: &RenderArgs) -> Result<(), Failure> {
    let [part] = args.outputs.as_slice() else {
        return Err(Failure::usage(
            format!(
                "--shard: found {} outputs, expected one part file",
                args.outputs.len()
            ),
            "name it by -o, such as -o image-1.part",
        ));
    };
    check_part_name("--shard", part)?;
    if args.budget.time.is_some() || args.budget.target_error.is_some() {
        return Err(Failure::usage(
            "--shard: --time and --target-error depend on all shares",
            "give --passes, the number of passes of the whole render",
        ));
    }
    Ok(())
}

/// Refuses combinations of options without a meaning.
fn check_combinations(
    args: &RenderArgs,
    method: &Preset,
    kind: &MethodKind,
) -> Result<(), Failure> {
    check_kept(args, kind)?;
    check_rules(&args.picture.light_group)?;
    if args.frames.skip_existing && !args.frames.is_walkthrough() {
        return Err(Failure::usage(
            "--skip-existing: a single picture is asked for",
            "give --frames or --cameras, or omit --skip-existing",
        ));
    }
    if args.picture.has_light_groups() && *kind == MethodKind::Aov {
        return Err(Failure::usage(
            "--light-groups: the method aov renders no light",
            "choose another --method, or omit --light-groups",
        ));
    }
    if args.denoise.denoise.is_some() && *kind == MethodKind::Aov {
        return Err(Failure::usage(
            "--denoise: the method aov renders no light to denoise",
            "choose another --method, or omit --denoise",
        ));
    }
    if !args.picture.aov.is_empty() && *kind == MethodKind::LightTracer {
        return Err(Failure::usage(
            "--aov: the method light-trace has no camera paths, which find these layers",
            "choose another --method, or omit --aov",
        ));
    }
    if method.is_chosen()
        && let MethodKind::ManyLight(lights) = kind
        && let Some(refusal) = choice_refusal(lights)
    {
        return Err(refusal);
    }
    Ok(())
}

/// Refuses names of images and scenes for a part file, which replaces what is there.
fn check_part_name(option: &str, path: &Path) -> Result<(), Failure> {
    let extension = path.extension().map(|e| e.to_ascii_lowercase());
    let is_scene = extension.is_some_and(|e| SCENE_EXTENSIONS.iter().any(|&scene| e == scene));
    let kind = match ImageFormat::from_path(path) {
        _ if is_scene => "scene",
        Ok(_) => "image",
        Err(_) => return Ok(()),
    };
    Err(Failure::usage(
        format!(
            "{option}: found the {kind} file {}, expected a part file",
            path.display()
        ),
        "use an extension such as .part",
    ))
}

/// Refuses two rules for one group.
fn check_rules(rules: &[GroupRule]) -> Result<(), Failure> {
    for (i, rule) in rules.iter().enumerate() {
        if rules[..i].iter().any(|other| other.name == rule.name) {
            return Err(Failure::usage(
                format!("--light-group: the group `{}` is given twice", rule.name),
                "one pattern makes a group; `*` and `?` match several names",
            ));
        }
    }
    Ok(())
}

/// Whether layers of a render go anywhere. A resumed film has those of its checkpoint.
fn keeps_layers(args: &RenderArgs, outputs: &[PathBuf]) -> bool {
    have_layers(outputs)
        || writes_part(&args.parts)
        || args.parts.resume.is_some()
        || args.denoise.denoise.is_some()
        || args.preview.is_some()
}

/// Whether a render writes a part or a checkpoint.
fn writes_part(parts: &PartArgs) -> bool {
    parts.shard.is_some() || parts.checkpoint.is_some()
}

/// Whether a file of `outputs` has layers.
pub(crate) fn have_layers(outputs: &[PathBuf]) -> bool {
    let is_exr = |path: &PathBuf| matches!(ImageFormat::from_path(path), Ok(ImageFormat::Exr));
    outputs.iter().any(is_exr)
}

/// Refuses outputs with an unknown format, and repeated outputs.
pub(crate) fn check_formats(outputs: &[PathBuf]) -> Result<(), Failure> {
    for (i, path) in outputs.iter().enumerate() {
        if let Err(error) = ImageFormat::from_path(path) {
            return Err(Failure::usage(
                format!("--output {}: {}", path.display(), error.message),
                "the extension selects the format; -o may be given several times",
            ));
        }
        if outputs[..i].contains(path) {
            return Err(Failure::usage(
                format!("--output {} is given twice", path.display()),
                "give each file once",
            ));
        }
    }
    Ok(())
}

/// Refuses to replace one of `inputs`, which is `what`, by an output.
pub(crate) fn check_keeps(
    inputs: &[PathBuf],
    outputs: &[PathBuf],
    what: &str,
) -> Result<(), Failure> {
    let is_input = |output: &&PathBuf| inputs.iter().any(|input| is_same_file(output, input));
    match outputs.iter().find(is_input) {
        None => Ok(()),
        Some(output) => Err(Failure::usage(
            format!("{} is {what} would replace", shown_path(output)),
            "write to a file of another name",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command, Denoiser};
    use clap::Parser;
    use manylight::integrators::ManyLight;
    use std::time::Duration;

    fn request(words: &str) -> Result<RenderRequest, Failure> {
        let all = ["manylight", "render"]
            .into_iter()
            .chain(words.split_whitespace());
        match Cli::try_parse_from(all).unwrap().command {
            Command::Render(args) => RenderRequest::new(&args),
            _ => unreachable!(),
        }
    }

    #[test]
    fn defaults() {
        let request = request("some/room/scene.xml").unwrap();
        assert_eq!(
            request.outputs,
            [PathBuf::from("room.exr"), PathBuf::from("room.png")]
        );
        assert_eq!(
            request.kind,
            MethodKind::ManyLight(ManyLight::rich_vpl_by_scene())
        );
        let budget = Budget {
            passes: Some(16),
            time: None,
            relative_error: None,
        };
        assert_eq!(request.budget, budget);
        let limits = PathLimits {
            max_depth: Some(7),
            ..PathLimits::default()
        };
        assert_eq!(request.method(limits).limits, limits);
    }

    #[test]
    fn limits_replace_the_default_number_of_passes() {
        let timed = request("s.xml --time 60s").unwrap().budget;
        assert_eq!(
            (timed.passes, timed.time),
            (None, Some(Duration::from_secs(60)))
        );
        assert_eq!(
            request("s.xml --time 60s --spp 4").unwrap().budget.passes,
            Some(4)
        );
        assert_eq!(
            request("s.xml --target-error 0.01").unwrap().budget.passes,
            None
        );
    }

    #[test]
    fn path_lengths() {
        let limits = PathLimits {
            max_depth: Some(7),
            rr_depth: 3,
            hide_emitters: false,
        };
        let of = |words| request(words).unwrap().method(limits).limits;
        assert_eq!(of("s.xml --max-depth -1").max_depth, None);
        assert_eq!(of("s.xml --max-depth 2").max_depth, Some(2));
        assert_eq!(
            of("s.xml --hide-emitters"),
            PathLimits {
                hide_emitters: true,
                ..limits
            }
        );
    }

    #[test]
    fn outputs_that_cannot_be_written_are_usage_errors() {
        for words in [
            "s.xml -o image.tif",
            "s.xml -o image",
            "s.xml -o a.png -o a.png",
        ] {
            let failure = request(words).unwrap_err();
            assert_eq!(failure.exit_code(), 2, "{words}");
        }
    }

    #[test]
    fn a_share_has_one_part_file_and_a_number_of_passes() {
        let whole = request("s.xml --passes 64 --shard 2/4 -o b.part").unwrap();
        let share = whole.parts.shard.unwrap();
        assert_eq!(
            (share.index, share.count.get(), whole.parts.block.get()),
            (2, 4, 16)
        );
        for words in [
            "s.xml --shard 1/2",
            "s.xml --shard 1/2 -o a.exr",
            "s.xml --shard 1/2 -o s.xml",
            "s.xml --shard 1/2 -o a.part -o b.part",
            "s.xml --shard 1/2 -o a.part --time 5s",
            "s.xml --shard 1/2 -o a.part --target-error 0.1",
        ] {
            assert_eq!(request(words).unwrap_err().exit_code(), 2, "{words}");
        }
    }

    #[test]
    fn a_checkpoint_replaces_neither_scene_nor_image() {
        assert!(request("s.xml --checkpoint s.part").is_ok());
        for words in [
            "s.xml --checkpoint s.xml",
            "s.glb --checkpoint s.GLB",
            "s.xml -o a.exr --checkpoint a.exr",
        ] {
            assert_eq!(request(words).unwrap_err().exit_code(), 2, "{words}");
        }
    }

    #[test]
    fn albedo_and_normals_are_not_denoised() {
        assert_eq!(request("s.xml").unwrap().denoise.denoise, None);
        let denoised = request("s.xml -m path --denoise oidn").unwrap();
        assert_eq!(denoised.denoise.denoise, Some(Denoiser::Oidn));
        let failure = request("s.xml -m aov --denoise oidn").unwrap_err();
        assert_eq!(failure.exit_code(), 2);
    }

    #[test]
    fn light_groups_are_named_once_and_need_light() {
        let rules = "s.xml --light-group key=lamp* --light-group fill=sky";
        let picture = request(rules).unwrap().picture;
        assert!(picture.has_light_groups() && picture.light_group.len() == 2);
        assert!(!request("s.xml").unwrap().picture.has_light_groups());
        for words in [
            "s.xml --light-group a=lamp --light-group a=sky",
            "s.xml --light-group a=lamp,a=sky",
            "s.xml -m aov --light-groups",
        ] {
            assert_eq!(request(words).unwrap_err().exit_code(), 2, "{words}");
        }
    }
}
