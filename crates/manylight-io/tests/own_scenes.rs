//! Rendering of the project's scenes with known answers. Every file in `scenes/furnace` and
//! `scenes/analytic` states its expected values (format: `scenes/README.md`); the path tracer and
//! Rich-VPLs must reproduce them.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use manylight::film::{Film, Layer};
use manylight::integrators::{ManyLight, MethodKind};
use manylight::render::{Budget, render_film};
use manylight::scene::Scene;
use manylight_io::{LoadOptions, load_scene};
use std::path::{Path, PathBuf};

/// An `expect:` line of a scene file.
#[derive(Clone, Copy, Debug)]
struct Expectation {
    pixels: Pixels,
    rgb: [f64; 3],
    tolerance: f64,
}

/// The pixels of an expectation.
#[derive(Clone, Copy, Debug)]
enum Pixels {
    /// Each pixel, and the mean.
    All,
    Mean,
    Pixel(usize, usize),
}

fn numbers(text: &str) -> Vec<f64> {
    let inner = text
        .split('(')
        .nth(1)
        .and_then(|rest| rest.split(')').next())
        .expect("numbers in parentheses");
    inner
        .split(',')
        .map(|n| n.trim().parse().expect("a number"))
        .collect()
}

fn parse(line: &str) -> Expectation {
    let (pixels, rest) = line
        .trim()
        .split_once(" rgb=")
        .expect("`rgb=` in an expectation");
    let (rgb, tolerance) = rest
        .split_once(" tolerance=")
        .expect("`tolerance=` in an expectation");
    let pixels = match pixels {
        "all" => Pixels::All,
        "mean" => Pixels::Mean,
        pixel => {
            let xy = numbers(pixel);
            Pixels::Pixel(xy[0] as usize, xy[1] as usize)
        }
    };
    let rgb = numbers(rgb);
    Expectation {
        pixels,
        rgb: [rgb[0], rgb[1], rgb[2]],
        tolerance: tolerance.trim().parse().expect("a tolerance"),
    }
}

fn expectations(text: &str) -> Vec<Expectation> {
    text.lines()
        .filter_map(|line| line.trim().strip_prefix("expect:"))
        .map(parse)
        .collect()
}

/// Values and standard errors of the pixels of an expectation.
fn measure(film: &Film, selection: Pixels) -> Vec<([f64; 3], [f64; 3])> {
    let (image, variance) = (film.image(Layer::Beauty).unwrap(), film.variance());
    let at = |x: usize, y: usize| {
        let value = std::array::from_fn(|c| f64::from(image.pixel(x, y)[c]));
        (
            value,
            std::array::from_fn(|c| f64::from(variance.pixel(x, y)[c]).sqrt()),
        )
    };
    let all = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    let pixels: Vec<_> = all.map(|(x, y)| at(x, y)).collect();
    let (value, error) = mean(&pixels);
    // A few passes estimate the error of a pixel poorly, and a pixel that missed a rare event has
    // none. Therefore the error is at least the root mean square relative error of the image.
    let relative: [f64; 3] = std::array::from_fn(|c| {
        let squares = pixels
            .iter()
            .filter(|(v, _)| v[c] > 0.0)
            .map(|(v, e)| (e[c] / v[c]).powi(2));
        (squares.sum::<f64>() / pixels.len() as f64).sqrt()
    });
    let widened =
        |(v, e): ([f64; 3], [f64; 3])| (v, std::array::from_fn(|c| e[c].max(relative[c] * v[c])));
    match selection {
        Pixels::Pixel(x, y) => vec![widened(at(x, y))],
        Pixels::All => pixels
            .iter()
            .copied()
            .map(widened)
            .chain([(value, error)])
            .collect(),
        Pixels::Mean => vec![(value, error)],
    }
}

/// Mean over pixels and its standard error.
fn mean(pixels: &[([f64; 3], [f64; 3])]) -> ([f64; 3], [f64; 3]) {
    let n = pixels.len() as f64;
    let (mut value, mut squares) = ([0.0; 3], [0.0; 3]);
    for (v, e) in pixels {
        for c in 0..3 {
            value[c] += v[c] / n;
            squares[c] += (e[c] / n).powi(2);
        }
    }
    (value, squares.map(f64::sqrt))
}

/// Tolerance in standard errors, because some thousand values are compared.
const SIGMAS: f64 = 5.0;

/// A method to test.
struct Check {
    kind: MethodKind,
    passes: u32,
    /// Relative systematic error of the method, in addition to the tolerance of the file.
    bias: f64,
}

impl Check {
    /// Descriptions of at most three failed expectations of a scene.
    fn failures(&self, path: &Path) -> Vec<String> {
        let text = std::fs::read_to_string(path).unwrap();
        let expected = expectations(&text);
        assert!(
            !expected.is_empty(),
            "{}: found no line `expect:`",
            path.display()
        );
        let loaded = load_scene(path, &LoadOptions::default())
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let scene = Scene::build(loaded.desc, 0).unwrap();
        let film = render_film(&scene, self.kind.clone(), Budget::passes(self.passes), 1);
        let mut failures = Vec::new();
        for e in expected {
            for (value, error) in measure(&film, e.pixels) {
                for c in 0..3 {
                    let scale = if e.rgb[c] == 0.0 { 1.0 } else { e.rgb[c] };
                    let allowed = (e.tolerance + self.bias) * scale + SIGMAS * error[c] + 1e-6;
                    if (value[c] - e.rgb[c]).abs() > allowed {
                        let name = path.file_name().unwrap_or_default().to_string_lossy();
                        failures.push(format!(
                            "{name} {:?}: {value:?} +- {error:?}, expected {:?}",
                            e.pixels, e.rgb
                        ));
                    }
                }
            }
        }
        failures.truncate(3);
        failures
    }

    fn run(&self, folder: &str) {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../scenes")
            .join(folder);
        let mut files: Vec<PathBuf> = std::fs::read_dir(root)
            .unwrap()
            .map(|e| e.unwrap().path())
            .collect();
        files.retain(|f| f.extension().is_some_and(|e| e == "xml"));
        files.sort();
        assert!(files.len() > 10, "expected more than 10 scenes");
        let failures: Vec<String> = files.iter().flat_map(|f| self.failures(f)).collect();
        assert!(
            failures.is_empty(),
            "{:?}:\n{}",
            self.kind,
            failures.join("\n")
        );
    }
}

fn path() -> Check {
    Check {
        kind: MethodKind::Path,
        passes: 1024,
        bias: 0.0,
    }
}

fn rich_vpl() -> Check {
    let settings = ManyLight {
        photon_paths: 12_000,
        importon_paths: 2000,
        light_count: 400,
        ..ManyLight::rich_vpl()
    };
    Check {
        kind: MethodKind::ManyLight(settings),
        passes: 12,
        bias: 0.01,
    }
}

#[test]
fn path_tracer_analytic() {
    path().run("analytic");
}

#[test]
fn path_tracer_furnace() {
    path().run("furnace");
}

#[test]
fn rich_vpl_analytic() {
    rich_vpl().run("analytic");
}

#[test]
fn rich_vpl_furnace() {
    rich_vpl().run("furnace");
}
