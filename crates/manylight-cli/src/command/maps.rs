//! `manylight maps`: maps of importance and incident flux, and the positions of virtual lights, as
//! images.

use super::render::open;
use crate::args::{DisplayArgs, MapsArgs};
use crate::failure::{DONE, Failure};
use crate::interim::{check_memory_of_maps, checked_maps};
use crate::interrupt::Interrupt;
use crate::output::print_message;
use crate::preset::no_lights;
use crate::repeat::Settings;
use crate::request::RenderRequest;
use manylight::integrators::{InterimMaps, MethodKind, PlacedLight};
use manylight::math::Vec2;
use manylight_io::image::{LayeredImage, check_writable, write_image};
use manylight_io::{FileError, shown_path};
use manylight_lab::false_color::{ColorScale, dots, false_colors, gray_layer, rgb_layer};

/// File names, in the order of [`pictures`].
const FILES: [&str; 6] = [
    "maps.exr",
    "importance.png",
    "radiance.png",
    "product.png",
    "placement.png",
    "relaxed.png",
];

/// Writes the interim maps of a many-light method.
pub(crate) fn run(args: &MapsArgs) -> Result<u8, Failure> {
    let request = RenderRequest::for_maps(args, &FILES)?;
    if !matches!(request.kind, MethodKind::ManyLight(_)) {
        return Err(no_lights(request.paths.method));
    }
    let display = DisplayArgs {
        quiet: args.quiet,
        ..DisplayArgs::default()
    };
    let interrupt = Interrupt::install()?;
    let session = open((request, None), None, display)?;
    check_memory_of_maps(&session)?;
    std::fs::create_dir_all(&args.output).map_err(|e| FileError::unwritable(&args.output, e))?;
    let request = &session.request;
    request
        .outputs
        .iter()
        .try_for_each(|path| check_writable(path))?;
    let Some(maps) = checked_maps(&session, &interrupt)? else {
        return Ok(interrupt.exit_code().unwrap_or(DONE));
    };
    let color_maps = color_maps(&maps);
    let job = session.job();
    let pictures = pictures(&maps, &color_maps, metadata(&session.settings(&job)));
    for (path, picture) in request.outputs.iter().zip(&pictures) {
        let _complete_file = interrupt.writing();
        write_image(path, picture, request.picture.file.tone.display())?;
    }
    if !args.quiet {
        report(&maps, &color_maps);
        for path in &request.outputs {
            print_message(format_args!("wrote {}", shown_path(path)));
        }
    }
    Ok(interrupt.exit_code().unwrap_or(DONE))
}

/// Metadata of `maps.exr` (name, value).
fn metadata(settings: &Settings) -> Vec<(String, String)> {
    let software = format!("manylight {}", env!("CARGO_PKG_VERSION"));
    let scene = settings.request.scene.display().to_string();
    let mut metadata = vec![
        ("software".to_string(), software),
        ("scene".into(), scene),
        ("method".into(), settings.request.paths.method.name.into()),
    ];
    metadata.extend(settings.metadata());
    metadata
}

/// A map with its color scale.
struct FalseColorMap {
    name: &'static str,
    unit: &'static str,
    /// One value per pixel.
    values: Vec<f32>,
    scale: Option<ColorScale>,
}

impl FalseColorMap {
    fn new(name: &'static str, unit: &'static str, values: Vec<f32>) -> Self {
        let scale = ColorScale::of(&values);
        FalseColorMap {
            name,
            unit,
            values,
            scale,
        }
    }

    /// The range of the color scale with its unit.
    fn legend(&self) -> String {
        match self.scale {
            Some(ColorScale { low, high }) => format!("{low:.3e} to {high:.3e} {}", self.unit),
            None => "0 everywhere".into(),
        }
    }
}

/// The three maps, in the order of [`FILES`].
fn color_maps(maps: &InterimMaps) -> [FalseColorMap; 3] {
    let luminance = maps.irradiance.iter().map(|e| e.luminance()).collect();
    [
        FalseColorMap::new("importance", "1/m²", maps.importance.clone()),
        FalseColorMap::new("radiance", "W/m²", luminance),
        FalseColorMap::new("product", "W/m⁴", maps.product.clone()),
    ]
}

/// The images, in the order of [`FILES`].
fn pictures(
    maps: &InterimMaps,
    color_maps: &[FalseColorMap; 3],
    mut metadata: Vec<(String, String)>,
) -> Vec<LayeredImage> {
    metadata.extend(
        color_maps
            .iter()
            .map(|map| (format!("scale.{}", map.name), map.legend())),
    );
    let gray = color_maps
        .iter()
        .map(|map| gray_layer(map.name, map.values.clone()));
    let mut layers: Vec<_> = gray.collect();
    // The layer of irradiance has its luminance and its colors.
    layers[1]
        .channels
        .extend(rgb_layer("radiance", &maps.irradiance).channels);
    let numbers = LayeredImage {
        width: maps.size.x as usize,
        height: maps.size.y as usize,
        layers,
        metadata,
        ..LayeredImage::default()
    };
    let colors = color_maps
        .iter()
        .map(|map| false_colors(maps.size, &map.values, map.scale));
    let lights = [&maps.placed, &maps.relaxed]
        .map(|lights| dots(maps.size, &maps.shading, &visible_positions(lights)));
    std::iter::once(numbers)
        .chain(colors)
        .chain(lights)
        .collect()
}

/// Positions on the film of the lights that are directly visible to the camera.
fn visible_positions(lights: &[PlacedLight]) -> Vec<Vec2> {
    lights
        .iter()
        .filter_map(|light| light.film_position)
        .collect()
}

fn report(maps: &InterimMaps, color_maps: &[FalseColorMap; 3]) {
    for map in color_maps {
        print_message(format_args!("{:<11} {}", map.name, map.legend()));
    }
    for (name, lights) in [("placement", &maps.placed), ("relaxed", &maps.relaxed)] {
        print_message(format_args!(
            "{name:<11} {} of {} lights are directly visible",
            visible_positions(lights).len(),
            lights.len()
        ));
    }
}
