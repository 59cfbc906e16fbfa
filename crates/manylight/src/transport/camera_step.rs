//! One step of a camera path: the segment's end, the radiance emitted there, and the next vertex that scatters.
//!
//! Every method that walks from the camera takes its steps here. The path tracer advances the paths of a tile in
//! stages and uses [`SegmentEnd`] alone; the others use [`next_scattering_vertex`].

use super::direct::{emitted_with_mis, environment_with_mis};
use super::{Arrival, Vertex, Walk};
use crate::color::Rgb;
use crate::emitters::EnvironmentLobes;
use crate::geometry::SurfacePoint;
use crate::math::Vec3;
use crate::sampling::Sampler;
use crate::scene::{PathLimits, Scene};

/// The end of a segment of a camera path.
#[derive(Clone, Copy, Debug)]
pub enum SegmentEnd {
    /// A surface, and the length of the segment in m.
    Surface(SurfacePoint, f32),
    /// The environment, along this unit direction.
    Environment(Vec3),
    /// The environment, which the camera must not see.
    Hidden,
}

impl SegmentEnd {
    /// The surface point of an arrival.
    #[inline]
    pub fn new(scene: &Scene, arrival: Arrival) -> Self {
        match arrival {
            Arrival::Hit(at, distance) => SegmentEnd::Surface(scene.surface_point(at), distance),
            Arrival::Escaped(wi) => SegmentEnd::Environment(wi),
            Arrival::Hidden => SegmentEnd::Hidden,
        }
    }

    /// Radiance emitted at the end of the segment that `walk` has just followed, times the MIS weight of finding it by
    /// the walk's last event, in W/(m² sr); with `lobes` if next-event estimation there uses them.
    #[inline]
    pub fn emitted(&self, scene: &Scene, walk: &Walk, lobes: Option<&EnvironmentLobes>) -> Rgb {
        match self {
            SegmentEnd::Surface(x, _) => emitted_with_mis(scene, walk.previous(), x, walk.w_prev()),
            SegmentEnd::Environment(wi) => environment_with_mis(scene, walk.previous(), *wi, lobes),
            SegmentEnd::Hidden => Rgb::BLACK,
        }
    }
}

/// A segment of a camera path that was followed to its end.
#[derive(Clone, Debug)]
pub struct CameraStep<'s> {
    /// See [`SegmentEnd::emitted`].
    pub emitted: Rgb,
    /// Unit direction from which that arrives.
    pub wi: Vec3,
    /// The surface at the end; `None` for the environment.
    pub vertex: Option<Vertex<'s>>,
}

/// Follows one segment. `None` if it ends at an environment that the camera must not see.
#[inline]
fn follow_segment<'s>(
    walk: &mut Walk<'s>,
    lobes: Option<&EnvironmentLobes>,
) -> Option<CameraStep<'s>> {
    let scene = walk.scene;
    let end = SegmentEnd::new(scene, walk.arrive());
    let emitted = end.emitted(scene, walk, lobes);
    match end {
        SegmentEnd::Surface(x, distance) => Some(CameraStep {
            emitted,
            wi: -walk.w_prev(),
            vertex: Some(walk.vertex(x, distance)),
        }),
        SegmentEnd::Environment(wi) => Some(CameraStep {
            emitted,
            wi,
            vertex: None,
        }),
        SegmentEnd::Hidden => None,
    }
}

/// Follows a camera path to the next vertex that scatters: through masks, null surfaces and thin glass. `lobes` are those of
/// next-event estimation at the walk's last event, if it uses any.
///
/// `visit` is shown each segment with the walk's throughput towards it, and returns `false` to end the path. `None` if
/// the path ends: by `visit`, in the environment, or because no longer path is within `limits`.
#[inline]
pub fn next_scattering_vertex<'s>(
    limits: PathLimits,
    walk: &mut Walk<'s>,
    lobes: Option<&EnvironmentLobes>,
    sampler: &mut Sampler,
    mut visit: impl FnMut(&CameraStep<'s>, Rgb, &mut Sampler) -> bool,
) -> Option<Vertex<'s>> {
    loop {
        let step = follow_segment(walk, lobes)?;
        if !visit(&step, walk.throughput(), sampler) {
            return None;
        }
        let v = step.vertex?;
        if !limits.allow(v.segments + 1) {
            return None;
        }
        if !walk.pass_through(&v, sampler.next_1d()) {
            return Some(v);
        }
    }
}
