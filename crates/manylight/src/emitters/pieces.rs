//! Pieces of emitters that may become virtual lights: points of their surfaces and directions of the surroundings, drawn by flux.
//!
//! Parallel light is one piece by itself. Points and spots are no pieces: they shine as [`Emitter::point_intensity`] says.

use super::{Emitter, Emitters, Strength, distant_share};
use crate::color::Rgb;
use crate::geometry::{Geometry, SurfacePoint};
use crate::ids::EmitterId;
use crate::math::{Vec2, Vec3};
use crate::sampling::Sampler;
use crate::texture::Texture;

/// What is infinitely far stands at so many radii of the scene: directions to it are off by the inverse of that.
const FAR: f32 = 1e4;

/// A small piece of an emitter.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Position; far outside the scene if it is infinitely far.
    pub p: Vec3,
    /// Geometric normal on the side that shines, unit.
    pub n: Vec3,
    /// Shading normal on that side, unit.
    pub ns: Vec3,
    /// Radiant intensity along the normal, in W/sr; it falls with the cosine to it.
    pub intensity: Rgb,
    /// Surface that it stands for, in m²; 0 for parallel light.
    pub area: f32,
    /// Distance by which shadow rays start off the surface, in m.
    pub offset: f32,
}

/// Among how many pieces emitters are divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PieceCounts {
    /// Of surfaces.
    pub near: u32,
    /// Of surroundings.
    pub far: u32,
}

impl Emitters {
    /// Divides about `count` pieces among surfaces and surroundings, by flux.
    pub fn piece_counts(&self, count: u32) -> PieceCounts {
        let total = |is_meant: fn(&Emitter) -> bool| -> f32 {
            let meant = self.emitters.iter().zip(&self.powers);
            meant
                .filter(|(emitter, _)| is_meant(emitter))
                .map(|(_, power)| power.strength())
                .sum()
        };
        let near = total(|emitter| matches!(emitter, Emitter::Area { .. }));
        let far = total(|e| matches!(e, Emitter::Constant { .. } | Emitter::Environment(_)));
        let share = distant_share((near > 0.0).then_some(near), (far > 0.0).then_some(far));
        let far_count = (share * count as f32).round() as u32;
        PieceCounts {
            near: if near > 0.0 { count - far_count } else { 0 },
            far: far_count,
        }
    }

    /// The pieces in the scene, and those beyond it, with the first numbers of `sampler`. On average over these, they send what the
    /// emitters send.
    pub fn pieces(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        counts: PieceCounts,
        sampler: &mut Sampler,
    ) -> (Vec<Piece>, Vec<Piece>) {
        let (near, far) = (sampler.next_spread(), sampler.next_spread());
        let on_surfaces = (0..counts.near).filter_map(|i| {
            let (u_part, u) = near.triple(i);
            let part = self.parts.choose_by_area(u_part)?;
            self.piece_of_part(geometry, textures, counts, part, u)
        });
        let around = (0..counts.far).filter_map(|i| {
            let (u_source, u) = far.triple(i);
            self.piece_of_surroundings(counts, u_source, u)
        });
        let parallel = self.distant.parallel();
        let parallel = parallel.map(|(wi, irradiance)| self.far_piece(wi, irradiance, 0.0));
        (on_surfaces.collect(), around.chain(parallel).collect())
    }

    fn piece_of_part(
        &self,
        geometry: &Geometry,
        textures: &[Texture],
        counts: PieceCounts,
        part: usize,
        u: Vec2,
    ) -> Option<Piece> {
        let y = self.parts.part(part).sample_area(geometry, u)?;
        let emitter = self.parts.part(part).emitter;
        let Emitter::Area { radiance } = &self.emitters[emitter.index()] else {
            return None;
        };
        let area = self.area_per_piece_of(part, counts, &y);
        let intensity = radiance.eval(y.uv, textures) * area;
        let shines = !intensity.is_black() && intensity.is_finite();
        shines.then(|| Piece {
            p: y.p,
            n: y.ng * 1.0f32.copysign(y.ng.dot(y.frame.n)),
            ns: y.frame.n,
            intensity,
            area,
            offset: y.offset,
        })
    }

    fn piece_of_surroundings(&self, counts: PieceCounts, u_source: f32, u: Vec2) -> Option<Piece> {
        let wi = self.distant.direction_of_surroundings(u_source, u)?;
        let (radiance, _) = self.distant.look_up(None, wi);
        let solid_angle = self.solid_angle_per_piece(counts, wi);
        let piece = self.far_piece(wi, radiance * solid_angle, solid_angle);
        (!piece.intensity.is_black() && piece.intensity.is_finite()).then_some(piece)
    }

    /// What shines as bright as the given irradiance across `wi` and fills that solid angle.
    fn far_piece(&self, wi: Vec3, irradiance: Rgb, solid_angle: f32) -> Piece {
        let sphere = self.distant.sphere();
        let d = FAR * sphere.radius;
        Piece {
            p: sphere.center + wi * d,
            n: -wi,
            ns: -wi,
            intensity: irradiance * (d * d),
            area: solid_angle * (d * d),
            offset: 0.0,
        }
    }

    /// Surface that a piece at the point `y` of an area emitter would stand for, in m²; as good as infinite where there is none.
    pub fn area_per_piece(&self, counts: PieceCounts, y: &SurfacePoint) -> f32 {
        let part = self.parts.index_at(y.at);
        part.map_or(f32::MAX, |part| self.area_per_piece_of(part, counts, y))
    }

    fn area_per_piece_of(&self, part: usize, counts: PieceCounts, y: &SurfacePoint) -> f32 {
        let density = self.parts.share_by_area(part) * self.parts.part(part).pdf_area(y);
        (density * counts.near as f32).recip().min(f32::MAX)
    }

    /// Solid angle that a piece of the surroundings along the unit vector `wi` would stand for, in sr; as good as infinite where there is none.
    pub fn solid_angle_per_piece(&self, counts: PieceCounts, wi: Vec3) -> f32 {
        let density = self.distant.density_of_surroundings(wi) * counts.far as f32;
        density.recip().min(f32::MAX)
    }

    /// The points and spots, with their positions.
    pub fn points(&self) -> impl Iterator<Item = (EmitterId, Vec3)> + '_ {
        let emitters = self.emitters.iter().enumerate();
        emitters.filter_map(|(i, emitter)| match emitter {
            Emitter::Point { position, .. } | Emitter::Spot { position, .. } => {
                Some((EmitterId::from(i), *position))
            }
            _ => None,
        })
    }
}
