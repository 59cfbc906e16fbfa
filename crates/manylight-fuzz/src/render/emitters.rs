//! Emitters.

use super::numbers::Numbers;
use super::textures::{color_input, image};
use manylight::emitters::{Emitter, Environment, ProjectorTexture, SpotFalloff};
use manylight::ids::TextureId;

/// Largest usual radiance.
const BRIGHT: f32 = 10.0;

pub(super) fn emitters(numbers: &mut Numbers, textures: usize) -> Vec<Emitter> {
    (0..numbers.below(4))
        .map(|_| emitter(numbers, textures))
        .collect()
}

/// Index of the first area emitter.
pub(super) fn area(emitters: &[Emitter]) -> Option<usize> {
    emitters
        .iter()
        .position(|emitter| emitter.surface_radiance().is_some())
}

fn emitter(numbers: &mut Numbers, textures: usize) -> Emitter {
    match numbers.below(10) {
        0..=1 => Emitter::Area {
            radiance: color_input(numbers, textures, BRIGHT),
        },
        2 => Emitter::InvisibleArea {
            radiance: color_input(numbers, textures, BRIGHT),
        },
        3 => Emitter::Point {
            position: numbers.vec3(-2.0, 2.0),
            intensity: numbers.color(BRIGHT),
        },
        4 if textures > 0 => Emitter::Goniometric {
            position: numbers.vec3(-2.0, 2.0),
            intensity: numbers.color(BRIGHT),
            emitter_from_world: numbers.mat3(),
            distribution: TextureId::from(numbers.index(textures)),
        },
        5 | 6 => Emitter::Spot {
            position: numbers.vec3(-2.0, 2.0),
            direction: numbers.direction(),
            intensity: numbers.color(BRIGHT),
            cutoff: numbers.float(0.1, 1.5),
            beam_width: numbers.float(0.0, 1.0),
            falloff: numbers.choose(&[
                SpotFalloff::LinearAngle,
                SpotFalloff::SmoothCosine,
                SpotFalloff::FlatIrradiance,
            ]),
            projector: (textures > 0 && numbers.flag()).then(|| ProjectorTexture {
                texture: TextureId::from(numbers.index(textures)),
                axes: [numbers.direction(), numbers.direction()],
                window: numbers.flag().then(|| numbers.vec2(0.1, 1.0)),
            }),
        },
        7 => Emitter::Directional {
            direction: numbers.direction(),
            irradiance: numbers.color(BRIGHT),
        },
        8 => Emitter::Constant {
            radiance: numbers.color(BRIGHT),
        },
        _ => Emitter::Environment(Environment {
            image: image(numbers, 3),
            scale: numbers.float(0.0, BRIGHT),
            world_from_emitter: numbers.mat3(),
        }),
    }
}
