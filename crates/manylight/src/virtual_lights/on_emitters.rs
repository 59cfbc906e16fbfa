//! Emitters as lights among the others: pieces of their surfaces and of the surroundings, each a diffuse light, and points and spots as they
//! are.

use super::moments::POINTS;
use super::{Emission, LightField, VirtualLight};
use crate::bsdf::Exit;
use crate::color::Rgb;
use crate::emitters::{Piece, PieceCounts};
use crate::math::Vec3;
use crate::sampling::Sampler;
use crate::scene::Scene;
use std::f32::consts::PI;

impl<'s> LightField<'s> {
    /// Adds lights that together send what the emitters send, on average over the numbers of `sampler`.
    pub fn add_emitters(&mut self, scene: &'s Scene, counts: PieceCounts, sampler: &mut Sampler) {
        let (emitters, textures) = (&scene.emitters, scene.textures.as_slice());
        let pieces = emitters.pieces(&scene.geometry, textures, counts, sampler);
        let points = emitters.points().map(|(id, p)| VirtualLight {
            flux: emitters.power(id),
            emission: Emission::Point {
                emitter: &emitters.descriptions()[id.index()],
                textures,
            },
            one_sided: false,
            ..bare_light(p)
        });
        let (near, far) = pieces;
        self.extend(
            near.iter().map(light_on).chain(points),
            far.iter().map(light_on),
        );
    }
}

/// The light on a piece of an emitter.
fn light_on<'s>(piece: &Piece) -> VirtualLight<'s> {
    let flux = piece.intensity * PI;
    VirtualLight {
        n: piece.n,
        ns: piece.ns,
        area: piece.area,
        offset: piece.offset,
        flux,
        emission: Emission::Rich {
            diffuse: flux,
            exit: Exit::Lambert,
            glossy: None,
        },
        ..bare_light(piece.p)
    }
}

/// Nothing but a place.
fn bare_light<'s>(p: Vec3) -> VirtualLight<'s> {
    VirtualLight {
        p,
        points: [p; POINTS],
        n: Vec3::Z,
        ns: Vec3::Z,
        radius: 0.0,
        area: 0.0,
        offset: 0.0,
        flux: Rgb::BLACK,
        one_sided: true,
        emission: Emission::Rich {
            diffuse: Rgb::BLACK,
            exit: Exit::Lambert,
            glossy: None,
        },
    }
}
