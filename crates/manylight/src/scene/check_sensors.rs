//! Checks of sensors: finite numbers within their domains, a film with pixels.

use super::error::{Checked, check_transform, ensure, with_context};
use crate::film::{FilmDesc, Filter};
use crate::math::UVec2;
use crate::sensors::{SensorDesc, SensorKind};

pub(super) fn check_sensor(sensor: &SensorDesc) -> Checked {
    let name = if sensor.name.is_empty() {
        "the sensor"
    } else {
        &sensor.name
    };
    check_transform(&sensor.world_from_camera)
        .and_then(|()| check_projection(sensor))
        .and_then(|()| check_film(&sensor.film))
        .map_err(|e| with_context(name, &e))
}

fn check_projection(sensor: &SensorDesc) -> Checked {
    match sensor.kind {
        SensorKind::Perspective { fov, .. } => check_fov(fov)?,
        SensorKind::ThinLens {
            fov,
            aperture_radius,
            focus_distance,
            ..
        } => {
            check_fov(fov)?;
            ensure(
                aperture_radius.is_finite() && aperture_radius >= 0.0,
                || format!("the aperture radius {aperture_radius} is negative or not finite"),
            )?;
            ensure(focus_distance.is_finite() && focus_distance > 0.0, || {
                format!("the focus distance {focus_distance} is not positive and finite")
            })?;
        }
        SensorKind::Orthographic => {}
    }
    let offset = sensor.principal_point_offset;
    ensure(offset.is_finite(), || {
        format!("the principal point offset {offset} is not finite")
    })?;
    let (near, far) = (sensor.near_clip, sensor.far_clip);
    ensure(near.is_finite() && near < far, || {
        format!("the clip distances {near} and {far} are not finite or not in order")
    })
}

fn check_fov(fov: f32) -> Checked {
    ensure(fov > 0.0 && fov < 180.0, || {
        format!("the field of view {fov} is not between 0 and 180 degrees")
    })
}

fn check_film(film: &FilmDesc) -> Checked {
    ensure(film.size.min_element() > 0, || {
        format!("the film of {} pixels is empty", pixels(film.size))
    })?;
    ensure(film.crop_size.min_element() > 0, || {
        format!("the crop of {} pixels is empty", pixels(film.crop_size))
    })?;
    let fits = |size: u32, offset: u32, whole: u32| {
        offset.checked_add(size).is_some_and(|end| end <= whole)
    };
    let (size, offset, whole) = (film.crop_size, film.crop_offset, film.size);
    ensure(
        fits(size.x, offset.x, whole.x) && fits(size.y, offset.y, whole.y),
        || {
            format!(
                "the crop of {} at {} leaves the film of {} pixels",
                pixels(size),
                pixels(offset),
                pixels(whole)
            )
        },
    )?;
    check_filter(&film.filter)
}

fn check_filter(filter: &Filter) -> Checked {
    if let Filter::Mitchell { b, c } = *filter {
        ensure(b.is_finite() && c.is_finite(), || {
            format!("the parameters {b} and {c} of the Mitchell filter are not finite")
        })?;
    }
    let radius = filter.radius();
    ensure(radius.is_finite() && radius > 0.0, || {
        format!("the radius {radius} of the filter is not positive and finite")
    })
}

fn pixels(size: UVec2) -> String {
    format!("{} x {}", size.x, size.y)
}
