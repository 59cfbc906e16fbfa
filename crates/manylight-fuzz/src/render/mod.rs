//! Renders of random scenes.

mod emitters;
pub(crate) mod kept;
mod materials;
mod methods;
mod numbers;
mod scene;
mod shapes;
mod textures;

use arbitrary::Unstructured;
use manylight::film::{Film, Layer};
use manylight::prelude::*;
use manylight::render::render_film;
use numbers::Numbers;
use std::io::Write;

/// Environment variable with which the description of a scene is printed before it is rendered.
const PRINT: &str = "MANYLIGHT_FUZZ_PRINT";

/// Makes a scene of the bytes, builds it, and renders it with one of the methods. The numbers in it
/// may be zero, negative, huge, tiny, infinite or not a number. What is built is rendered, and
/// every value of the film is finite.
pub(crate) fn check(input: &[u8]) {
    let mut numbers = Numbers::new(Unstructured::new(input));
    let mut kind = methods::method(&mut numbers);
    let passes = numbers.below(2) as u32 + 1;
    let desc = scene::scene(&mut numbers);
    methods::size_tables(&mut kind, &mut numbers);
    if std::env::var_os(PRINT).is_some() {
        let _ = writeln!(std::io::stderr(), "{kind:#?}\n{desc:#?}");
    }
    match Scene::build(desc, 0) {
        Ok(scene) => {
            let budget = Budget {
                passes: Some(passes),
                ..Budget::default()
            };
            check_film(&render_film(&scene, kind, budget, 1), passes);
        }
        Err(error) => assert!(
            !error.message.trim().is_empty(),
            "an error without a message"
        ),
    }
}

fn check_film(film: &Film, passes: u32) {
    assert_eq!(film.passes(), passes);
    for layer in Layer::ALL {
        if let Some(image) = film.image(layer) {
            let finite = image.data.iter().all(|v| v.is_finite());
            assert!(finite, "layer {layer:?} is not finite: {:?}", image.data);
        }
    }
}
