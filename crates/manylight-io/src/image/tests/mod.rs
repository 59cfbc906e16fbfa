//! Tests of image files.

mod reading;
mod writing;

use super::*;

/// Distinct values that no 8 bit format can store, in three layers with metadata.
fn layered_image() -> LayeredImage {
    let plane = |c: usize| {
        (0..6)
            .map(|i| (i * 3 + c) as f32 * 0.37 - 0.2)
            .collect::<Vec<f32>>()
    };
    let channel = |name: &str, c: usize| (name.to_owned(), plane(c));
    let layers = vec![
        ImageLayer {
            name: String::new(),
            channels: vec![channel("R", 0), channel("G", 1), channel("B", 2)],
        },
        ImageLayer {
            name: "variance".into(),
            channels: vec![channel("variance.R", 3), channel("variance.G", 4)],
        },
        ImageLayer {
            name: "depth".into(),
            channels: vec![(
                "depth.Z".into(),
                vec![1e30, 0.0, -1.0, 1.0 / 3.0, 1e-30, f32::INFINITY],
            )],
        },
    ];
    let metadata = [
        ("software", "manylight"),
        ("scene", "Küche λ.xml"),
        ("comments", "none"),
        ("empty", ""),
    ];
    LayeredImage {
        width: 3,
        height: 2,
        layers,
        metadata: metadata.map(|(n, v)| (n.to_owned(), v.to_owned())).to_vec(),
        ..LayeredImage::default()
    }
}

fn beauty_image(width: usize, height: usize, value: impl Fn(usize, usize) -> f32) -> LayeredImage {
    let plane = |c: usize| (0..width * height).map(|i| value(i, c)).collect();
    LayeredImage::from_channels(
        width,
        height,
        vec![
            ("R".into(), plane(0)),
            ("G".into(), plane(1)),
            ("B".into(), plane(2)),
        ],
    )
}
