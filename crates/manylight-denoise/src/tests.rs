//! Tests with the library. They pass without testing anything where it is not installed.

use crate::symmetries::filter_by_symmetries;
use crate::{
    FeatureImages, FilterError, LIBRARY_NAME, Oidn, SearchPlaces, denoise_film, render_features,
};
use manylight::film::blocks::DEFAULT_BLOCK;
use manylight::film::{ErrorBars, Film, Layer};
use manylight::image::Image;
use manylight::integrators::{ExtraLayers, Method, MethodKind};
use manylight::render::{Budget, RenderJob, render_film};
use manylight::sampling::rng::Pcg;
use manylight::testing::scenes::glossy_box;
use std::sync::atomic::AtomicBool;

static NEVER: AtomicBool = AtomicBool::new(false);

/// A device of the installed library, or a printed note.
fn installed() -> Option<Oidn> {
    let oidn = Oidn::open(&SearchPlaces::from_environment(None), Some(2));
    if let Err(error) = &oidn {
        println!("skipped: {error}");
    }
    oidn.ok()
}

/// Gray 0.5 with uniform noise of this amplitude.
fn noisy(width: usize, height: usize, amplitude: f32) -> Image {
    let mut image = Image::new(width, height, 3);
    let mut rng = Pcg::new(5);
    for v in &mut image.data {
        *v = 0.5 + amplitude * (2.0 * rng.next_f32() - 1.0);
    }
    image
}

fn deviation(image: &Image) -> f32 {
    let sum: f32 = image.data.iter().map(|v| (v - 0.5).powi(2)).sum();
    (sum / image.data.len() as f32).sqrt()
}

#[test]
fn a_missing_file_is_reported_with_its_place() {
    let places = SearchPlaces::from_environment(Some("/nowhere/library.so".into()));
    let error = Oidn::open(&places, None).unwrap_err();
    assert_eq!(error.tried.len(), 1);
    assert!(error.to_string().contains("/nowhere/library.so"), "{error}");
}

#[test]
fn every_place_is_reported() {
    let folder = tempfile::TempDir::new().unwrap();
    std::fs::write(folder.path().join(LIBRARY_NAME), "no library").unwrap();
    let places = SearchPlaces {
        oidn_dir: Some(folder.path().into()),
        ..SearchPlaces::default()
    };
    if let Err(error) = Oidn::open(&places, None) {
        let text = error.to_string();
        for word in ["OIDN_DIR=", "pyoidn: no library", LIBRARY_NAME] {
            assert!(text.contains(word), "{word}: {text}");
        }
    }
}

#[test]
fn noise_is_filtered() {
    let Some(oidn) = installed() else { return };
    assert!(oidn.version().major >= 2);
    let image = noisy(64, 48, 0.3);
    let filtered = oidn.filter(&image, None, &NEVER).unwrap();
    assert!(deviation(&filtered) < 0.2 * deviation(&image));
}

#[test]
fn constants_stay_at_the_borders() {
    let Some(oidn) = installed() else { return };
    for (width, height) in [(64, 48), (50, 37), (9, 8)] {
        let image = noisy(width, height, 0.0);
        let filtered = filter_by_symmetries(&oidn, &image, None, &NEVER).unwrap();
        let largest = |image: &Image| {
            let deviations = image.data.iter().map(|v| (v - 0.5).abs());
            deviations.fold(0.0, f32::max)
        };
        let (bare, kept) = (oidn.filter(&image, None, &NEVER).unwrap(), filtered);
        println!("{width}x{height}: {} {}", largest(&bare), largest(&kept));
        assert!(
            largest(&kept) < 0.02,
            "{width}x{height}: {}",
            largest(&kept)
        );
    }
}

#[test]
fn any_size_is_filtered() {
    let Some(oidn) = installed() else { return };
    for (width, height) in [(1, 1), (1, 7), (5, 1), (33, 2)] {
        let image = noisy(width, height, 0.1);
        let filtered = oidn.filter(&image, None, &NEVER).unwrap();
        assert_eq!((filtered.width, filtered.height), (width, height));
        assert!(filtered.data.iter().all(|v| v.is_finite()));
    }
}

#[test]
fn tiny_films_stay_as_they_are() {
    let Some(oidn) = installed() else { return };
    let scene = glossy_box(4).build();
    let film = render_film(&scene, MethodKind::Path, Budget::passes(1), 1);
    let denoised = denoise_film(&oidn, &film, None, &NEVER).unwrap();
    assert_eq!(denoised.image, film.image(Layer::Beauty).unwrap());
    assert_eq!(denoised.bars, ErrorBars::of_film(&film));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let Some(one) = Oidn::open(&SearchPlaces::from_environment(None), Some(1)).ok() else {
        return;
    };
    let Some(two) = installed() else { return };
    let image = noisy(100, 70, 0.3);
    assert_eq!(
        one.filter(&image, None, &NEVER),
        two.filter(&image, None, &NEVER)
    );
}

#[test]
fn threads_share_a_device() {
    let Some(oidn) = installed() else { return };
    let images = [noisy(100, 70, 0.3), noisy(64, 90, 0.1)];
    let filter = |image: &Image| oidn.filter(image, None, &NEVER);
    let alone = images.each_ref().map(filter);
    std::thread::scope(|scope| {
        let threads = images.each_ref().map(|image| scope.spawn(|| filter(image)));
        assert_eq!(threads.map(|thread| thread.join().unwrap()), alone);
    });
}

#[test]
fn a_cancelled_filter_has_no_result() {
    let Some(oidn) = installed() else { return };
    let cancel = AtomicBool::new(true);
    assert_eq!(
        oidn.filter(&noisy(64, 64, 0.3), None, &cancel),
        Err(FilterError::Cancelled)
    );
    assert!(oidn.filter(&noisy(64, 64, 0.3), None, &NEVER).is_ok());
}

/// Mean squared difference.
fn error(a: &Image, b: &Image) -> f32 {
    let sum: f32 = a
        .data
        .iter()
        .zip(&b.data)
        .map(|(a, b)| (a - b).powi(2))
        .sum();
    sum / a.data.len() as f32
}

#[test]
fn a_film_is_denoised_with_its_features() {
    let Some(oidn) = installed() else { return };
    let scene = glossy_box(32).build();
    let path = |passes, seed| render_film(&scene, MethodKind::Path, Budget::passes(passes), seed);
    let (film, reference) = (path(8, 1), path(256, 2));
    let job = RenderJob {
        scene: &scene,
        method: Method {
            kind: MethodKind::Path,
            limits: scene.limits,
            extra: ExtraLayers::default(),
        },
        budget: Budget::passes(8),
        seed: 1,
        frame: None,
        lights: None,
        block: DEFAULT_BLOCK,
        guide: None,
    };
    let features = render_features(&job, 56, &NEVER);
    let features = FeatureImages::from_films(&[&film, &features]);
    let denoised = denoise_film(&oidn, &film, features.as_ref(), &NEVER).unwrap();
    let reference = reference.image(Layer::Beauty).unwrap();
    let noisy = film.image(Layer::Beauty).unwrap();
    assert!(error(&denoised.image, &reference) < 0.5 * error(&noisy, &reference));
}

#[test]
fn features_of_films_are_weighted_by_their_passes() {
    let scene = glossy_box(8).build();
    let aov = |passes, seed| render_film(&scene, MethodKind::Aov, Budget::passes(passes), seed);
    let (one, three) = (aov(1, 1), aov(3, 2));
    let mean = FeatureImages::from_films(&[&one, &three]).unwrap();
    let normal = |film: &Film| film.image(Layer::Normal).unwrap().data;
    let (a, b) = (normal(&one), normal(&three));
    for (i, value) in mean.features().normal.data.iter().enumerate() {
        assert!((value - (a[i] + 3.0 * b[i]) / 4.0).abs() < 1e-5);
    }
    let black = render_film(&scene, MethodKind::LightTracer, Budget::passes(1), 1);
    assert_eq!(FeatureImages::from_films(&[&black]), None);
}
