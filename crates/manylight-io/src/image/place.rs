//! Where a rendered image lies: on the full film, and in the world.

/// The part of a full picture that an image shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageWindow {
    /// Width and height of the full picture in pixels.
    pub full_size: [usize; 2],
    /// Column and row of the upper left pixel of the image in the full picture.
    pub offset: [usize; 2],
}

/// The camera of an image, by the definitions of OpenEXR's standard attributes. Matrices are in column-major order for column
/// vectors, which is OpenEXR's row-major order for row vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageCamera {
    /// From world space to camera space, in the world's unit: x to the right, y up, z in the direction of view.
    pub camera_from_world: [f32; 16],
    /// From world space to the full picture: (0, 0) is its upper left corner, (1, 1) its lower right. Homogeneous; z has no meaning.
    pub ndc_from_world: [f32; 16],
    /// Center of the full picture on the plane z = 1 of camera space; 0 for cameras with parallel rays.
    pub screen_center: [f32; 2],
    /// Width of the full picture on that plane; 1 for cameras with parallel rays.
    pub screen_width: f32,
}
