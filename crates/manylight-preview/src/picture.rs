//! A picture at one moment of a render.

use manylight_io::image::ImageLayer;

/// The layers of a growing picture, with the state of the render.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Layers with `width * height` values in each channel; the first one is the image.
    pub layers: Vec<ImageLayer>,
    /// How far the render is.
    pub progress: Progress,
}

/// How far a render is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Number of complete passes.
    pub passes: u32,
    /// Time since the render began, in seconds.
    pub seconds: f64,
    /// Upper bound of the relative error of the image as rendered; `None` if it is not known yet.
    pub error: Option<f32>,
    /// Whether the render goes on.
    pub state: RenderState,
}

/// The state of a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RenderState {
    /// Further passes follow.
    Rendering,
    /// The picture is final.
    Done,
    /// The picture is final, because the render was interrupted.
    Interrupted,
}

/// What a render is and when it ends. Does not change while it runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderInfo {
    /// Name of the picture, the same for repeated renders: tev replaces a picture with this name.
    pub name: String,
    /// Title of the page in the browser.
    pub title: String,
    /// Number of passes after which the render ends.
    pub passes: Option<u32>,
    /// Time after which the render ends, in seconds.
    pub seconds: Option<f64>,
    /// Relative error at which the render ends.
    pub error: Option<f32>,
}

#[cfg(test)]
pub(crate) mod testing {
    use super::*;

    /// A picture with the image, one radiance layer and depth. Value `v` of a channel is `1000 *
    /// channel + pixel`, plus `passes / 8`.
    pub(crate) fn picture(width: usize, height: usize, passes: u32) -> Picture {
        let mut count = 0;
        let mut channel = |name: &str| {
            let values = (0..width * height)
                .map(|i| (1000 * count + i) as f32 + passes as f32 / 8.0)
                .collect();
            count += 1;
            (name.to_owned(), values)
        };
        let mut layer = |name: &str, channels: &[&str]| ImageLayer {
            name: name.into(),
            channels: channels.iter().map(|name| channel(name)).collect(),
        };
        Picture {
            width,
            height,
            layers: vec![
                layer("", &["R", "G", "B"]),
                layer("direct", &["direct.R", "direct.G", "direct.B"]),
                layer("depth", &["depth.Z"]),
            ],
            progress: Progress {
                passes,
                seconds: 1.5,
                error: Some(0.25),
                state: RenderState::Rendering,
            },
        }
    }
}
