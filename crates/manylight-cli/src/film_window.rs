//! Size and crop window of a film, as the options of the camera change them.

use crate::values::Crop;
use manylight::film::FilmDesc;
use manylight::math::{UVec2, Vec2};

/// Changes the image size and scales the crop window with it.
pub(crate) fn resize(film: &mut FilmDesc, size: UVec2) {
    let scale = size.as_dvec2() / film.size.as_dvec2();
    let scaled = |pixels: UVec2| (pixels.as_dvec2() * scale).round().as_uvec2();
    let first = scaled(film.crop_offset).min(size - UVec2::ONE);
    let end = scaled(film.crop_offset + film.crop_size).clamp(first + UVec2::ONE, size);
    *film = FilmDesc {
        size,
        crop_offset: first,
        crop_size: end - first,
        filter: film.filter,
    };
}

/// Sets the crop window, rounded to whole pixels and at least one.
pub(crate) fn set_crop(film: &mut FilmDesc, crop: Crop) {
    let scaled = |x: f32, y: f32| {
        (Vec2::new(x, y).as_dvec2() * film.size.as_dvec2())
            .round()
            .as_uvec2()
    };
    let first = scaled(crop.x[0], crop.y[0]).min(film.size - UVec2::ONE);
    let end = scaled(crop.x[1], crop.y[1]).clamp(first + UVec2::ONE, film.size);
    film.crop_offset = first;
    film.crop_size = end - first;
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::film::Filter;

    fn film() -> FilmDesc {
        FilmDesc {
            size: UVec2::new(200, 100),
            crop_offset: UVec2::new(50, 20),
            crop_size: UVec2::new(100, 30),
            filter: Filter::Box,
        }
    }

    #[test]
    fn resizing_scales_the_crop() {
        let mut half = film();
        resize(&mut half, UVec2::new(100, 50));
        assert_eq!(
            (half.crop_offset, half.crop_size),
            (UVec2::new(25, 10), UVec2::new(50, 15))
        );
        let mut tiny = film();
        resize(&mut tiny, UVec2::new(1, 1));
        assert_eq!(
            (tiny.crop_offset, tiny.crop_size),
            (UVec2::ZERO, UVec2::ONE)
        );
    }

    #[test]
    fn crops_are_whole_pixels() {
        let mut film = film();
        set_crop(
            &mut film,
            Crop {
                x: [0.25, 0.5],
                y: [0.0, 1.0],
            },
        );
        assert_eq!(
            (film.crop_offset, film.crop_size),
            (UVec2::new(50, 0), UVec2::new(50, 100))
        );
        set_crop(
            &mut film,
            Crop {
                x: [0.999, 1.0],
                y: [0.5, 0.5001],
            },
        );
        assert_eq!(
            (film.crop_offset, film.crop_size),
            (UVec2::new(199, 50), UVec2::ONE)
        );
    }
}
