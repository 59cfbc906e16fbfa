//! `manylight maps`: what the placement of virtual lights follows, and where they stand, as pictures.

use super::render::{load, thread_pool};
use crate::args::{DisplayArgs, MapsArgs};
use crate::failure::Failure;
use crate::figure::{Scale, dots, false_colors, gray_layer, rgb_layer};
use crate::interrupt::Interrupt;
use crate::output::print_message;
use crate::preset;
use crate::repeat::Settings;
use crate::request::RenderRequest;
use manylight::integrators::{InterimMaps, MethodKind, PassContext, PlacedLight};
use manylight::math::Vec2;
use manylight::render::Stats;
use manylight::sampling::Pass;
use manylight_io::FileError;
use manylight_io::image::{LayeredImage, check_writable, write_image};
use std::process::ExitCode;

/// What is written, in the order of [`pictures`].
const FILES: [&str; 6] = [
    "maps.exr",
    "importance.png",
    "radiance.png",
    "product.png",
    "placement.png",
    "relaxed.png",
];

/// Writes the interim maps of a many-light method.
pub(crate) fn run(args: &MapsArgs) -> Result<ExitCode, Failure> {
    let request = RenderRequest::for_maps(args, &FILES)?;
    let MethodKind::ManyLight(lights) = request.kind else {
        return Err(Failure::usage(
            format!("the method `{}` has no virtual lights", request.method),
            format!(
                "those with lights: {}",
                preset::names_with("lights").join(", ")
            ),
        ));
    };
    let display = DisplayArgs {
        quiet: args.quiet,
        ..DisplayArgs::default()
    };
    let interrupt = Interrupt::install()?;
    let pool = thread_pool(request.threads)?;
    let stats = Stats::default();
    let (scene, _) = pool.install(|| load(&request, &stats, display))?;
    std::fs::create_dir_all(&args.output).map_err(|e| FileError::unwritable(&args.output, e))?;
    request
        .outputs
        .iter()
        .try_for_each(|path| check_writable(path))?;

    let method = request.method(scene.limits);
    let pass = Pass {
        seed: request.seed,
        index: 0,
    };
    let run = PassContext {
        pass,
        stats: &stats,
        cancel: interrupt.cancel(),
    };
    let Some(maps) = pool.install(|| lights.interim_maps(&scene, method.limits, &run)) else {
        return Ok(ExitCode::from(interrupt.exit_code().unwrap_or_default()));
    };
    let shown = shown(&maps);
    let mut metadata = vec![
        (
            "software".to_string(),
            format!("manylight {}", env!("CARGO_PKG_VERSION")),
        ),
        ("scene".into(), request.scene.display().to_string()),
        ("method".into(), request.method.into()),
    ];
    let settings = Settings {
        request: &request,
        method: &method,
        film: &scene.sensor.desc().film,
        threads: pool.current_num_threads(),
    };
    metadata.extend(settings.metadata());
    let pictures = pictures(&maps, &shown, metadata);
    for (path, picture) in request.outputs.iter().zip(&pictures) {
        let _no_half_file = interrupt.writing();
        write_image(path, picture, request.exposure)?;
    }
    if !args.quiet {
        report(&maps, &shown);
        for path in &request.outputs {
            print_message(format_args!("wrote {}", path.display()));
        }
    }
    Ok(ExitCode::from(interrupt.exit_code().unwrap_or_default()))
}

/// A map by its colors.
struct Shown {
    name: &'static str,
    unit: &'static str,
    /// One per pixel.
    values: Vec<f32>,
    scale: Option<Scale>,
}

impl Shown {
    fn new(name: &'static str, unit: &'static str, values: Vec<f32>) -> Self {
        let scale = Scale::of(&values);
        Shown {
            name,
            unit,
            values,
            scale,
        }
    }

    /// What the colors mean.
    fn legend(&self) -> String {
        match self.scale {
            Some(Scale { low, high }) => format!("{low:.3e} to {high:.3e} {}", self.unit),
            None => "0 everywhere".into(),
        }
    }
}

/// The maps in the order of [`FILES`].
fn shown(maps: &InterimMaps) -> [Shown; 3] {
    let luminance = maps.irradiance.iter().map(|e| e.luminance()).collect();
    [
        Shown::new("importance", "1/m²", maps.importance.clone()),
        Shown::new("radiance", "W/m²", luminance),
        Shown::new("product", "W/m⁴", maps.product.clone()),
    ]
}

/// In the order of [`FILES`].
fn pictures(
    maps: &InterimMaps,
    shown: &[Shown; 3],
    mut metadata: Vec<(String, String)>,
) -> Vec<LayeredImage> {
    metadata.extend(
        shown
            .iter()
            .map(|map| (format!("scale.{}", map.name), map.legend())),
    );
    let gray = shown
        .iter()
        .map(|map| gray_layer(map.name, map.values.clone()));
    let mut layers: Vec<_> = gray.collect();
    // Its luminance is among its channels.
    layers[1]
        .channels
        .extend(rgb_layer("radiance", &maps.irradiance).channels);
    let numbers = LayeredImage {
        width: maps.size.x as usize,
        height: maps.size.y as usize,
        layers,
        metadata,
    };
    let colors = shown
        .iter()
        .map(|map| false_colors(maps.size, &map.values, map.scale));
    let lights =
        [&maps.placed, &maps.relaxed].map(|lights| dots(maps.size, &maps.shading, &seen(lights)));
    std::iter::once(numbers)
        .chain(colors)
        .chain(lights)
        .collect()
}

/// Where on the film the lights are that the camera sees.
fn seen(lights: &[PlacedLight]) -> Vec<Vec2> {
    lights
        .iter()
        .filter_map(|light| light.film_position)
        .collect()
}

fn report(maps: &InterimMaps, shown: &[Shown; 3]) {
    for map in shown {
        print_message(format_args!("{:<11} {}", map.name, map.legend()));
    }
    for (name, lights) in [("placement", &maps.placed), ("relaxed", &maps.relaxed)] {
        print_message(format_args!(
            "{name:<11} the camera sees {} of {} lights",
            seen(lights).len(),
            lights.len()
        ));
    }
}
