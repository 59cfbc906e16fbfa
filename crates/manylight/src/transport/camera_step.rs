//! One step of a camera path: the segment's end, the radiance emitted there, and the next vertex that scatters.
//!
//! The many-light methods and the photon map take their steps here; the path tracer advances streams (`stream`).

use super::direct::{emitted_with_mis, environment_with_mis};
use super::{Arrival, Vertex, Walk};
use crate::color::Rgb;
use crate::emitters::EnvironmentLobes;
use crate::math::Vec3;
use crate::sampling::Sampler;
use crate::scene::PathLimits;

/// A segment of a camera path that was followed to its end.
#[derive(Clone, Debug)]
pub struct CameraStep<'s> {
    /// Radiance emitted at its end, times the MIS weight of finding it by the walk's last event, in W/(m² sr).
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
    let (emitted, vertex) = match walk.arrive() {
        Arrival::Hit(at, distance) => {
            let x = scene.surface_point(at);
            let emitted = emitted_with_mis(scene, walk.previous(), &x, walk.w_prev());
            (emitted, Some(walk.vertex(x, distance)))
        }
        Arrival::Escaped(wi) => (
            environment_with_mis(scene, walk.previous(), wi, lobes),
            None,
        ),
        Arrival::Hidden => return None,
    };
    Some(CameraStep {
        emitted,
        wi: -walk.w_prev(),
        vertex,
    })
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
