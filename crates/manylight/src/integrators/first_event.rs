//! What a camera path meets first, straight-through transmission aside, and the film layers of it:
//! alpha, position and ids.

use crate::color::Rgb;
use crate::film::{IdLayer, Layer, TileSamples};
use crate::geometry::SurfaceRef;
use crate::math::Vec3;
use crate::scene::{PathLimits, Scene};

/// What a camera path meets before its first scattering event.
#[derive(Clone, Copy, Debug)]
pub(super) enum FirstEvent {
    /// Nothing, or an environment that the camera must not see.
    Nothing,
    /// The environment.
    Environment,
    /// A surface.
    Surface {
        at: SurfaceRef,
        /// Position in m.
        p: Vec3,
        /// Fraction of the sample that the surface covers.
        opacity: f32,
    },
}

impl FirstEvent {
    /// A ray that leaves the scene.
    pub(super) fn escape(scene: &Scene, limits: PathLimits) -> Self {
        if scene.emitters.has_environment() && !limits.hide_emitters {
            FirstEvent::Environment
        } else {
            FirstEvent::Nothing
        }
    }
}

/// The part of a camera path in a sample of its pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleShare {
    /// Weight by the reconstruction filter; its mean is 1.
    pub(super) filter_weight: f32,
    /// Inverse of the number of camera paths of the sample.
    pub(super) share: f32,
}

/// Adds `event` to pixel `index` of the tile. Every camera path must be added, those that meet
/// nothing too.
pub(super) fn add_first_event(
    scene: &Scene,
    event: FirstEvent,
    path: SampleShare,
    index: usize,
    out: &mut TileSamples,
) {
    let SampleShare {
        filter_weight,
        share,
    } = path;
    let covered = match event {
        FirstEvent::Nothing => 0.0,
        FirstEvent::Environment => 1.0,
        FirstEvent::Surface { opacity, .. } => opacity,
    };
    let alpha = Rgb::new(filter_weight * covered, covered, filter_weight);
    out.add(index, Layer::Alpha, alpha * share);
    let FirstEvent::Surface { at, p, .. } = event else {
        return;
    };
    let covered = covered * share;
    out.add(index, Layer::Position, Rgb::new(p.x, p.y, p.z) * covered);
    if out.records_ids() && covered > 0.0 {
        let material = scene.geometry.primitives()[at.primitive.index()].material;
        out.add_id(index, IdLayer::Object, scene.names.object(at), covered);
        out.add_id(
            index,
            IdLayer::Material,
            scene.names.material(material),
            covered,
        );
    }
}
