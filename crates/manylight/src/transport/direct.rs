//! Next-event estimation, and the MIS weights of emitters that walks run into, in lanes: for one
//! vertex or for sixteen.

use crate::emitters::{DirectSamples, LobesOfLanes, Receivers};
use crate::geometry::SurfacePoints;
use crate::lanes::{Color, Float, Mask, Pair, Vector, Width, Word, power};
use crate::scene::Scene;
use crate::simd::outlined;

/// Directions from points to emitters, visibility not yet tested.
#[derive(Clone, Copy, Debug)]
pub struct EmitterSamples<S: Width> {
    /// Unit direction to the emitter.
    pub wi: Vector<S>,
    /// Radiance over pdf, in W/m²: times `f |cos|` this is reflected radiance.
    pub weight: Color<S>,
    /// Density per solid angle, in 1/sr; 0 for emitters that only next-event estimation finds.
    pub pdf: Float<S>,
    /// Start of the shadow segment, moved off the surface.
    pub from: Vector<S>,
    /// End of the shadow segment, moved off the surface.
    pub to: Vector<S>,
    /// As in [`DirectSamples`].
    pub source: Word<S>,
    /// The lanes with a sample. Elsewhere the fields are unspecified.
    pub valid: Mask<S>,
}

outlined! {
    fn sample_emitters<S: Width>(
        scene: &Scene, receivers: &Receivers<S>, numbers: (Float<S>, Pair<S>),
        lobes: LobesOfLanes<'_, S>, lanes: Mask<S>,
    ) -> DirectSamples<S> {
        lanes.width() => {
            let (geometry, textures) = (&scene.geometry, &scene.textures);
            scene.emitters.sample_lanes(geometry, textures, receivers, numbers, lobes, lanes)
        }
    }
}

impl<S: Width> EmitterSamples<S> {
    /// Directions from the points `x` in the lanes of `lanes`, with the random numbers of the
    /// choice of an emitter and of a point on it. `normals` are vectors and the lanes that have
    /// one, as in [`Bsdf::receiving_normal`](crate::bsdf::Bsdf::receiving_normal).
    #[inline(always)]
    pub fn new<'a>(
        scene: &'a Scene,
        x: &SurfacePoints<S>,
        normals: (Vector<S>, Mask<S>),
        numbers: (Float<S>, Pair<S>),
        lobes: LobesOfLanes<'a, S>,
        lanes: Mask<S>,
    ) -> Self {
        let (n, has_normal) = normals;
        let receivers = Receivers {
            p: x.p,
            n,
            has_normal,
        };
        let samples = sample_emitters(scene, &receivers, numbers, lobes, lanes);
        EmitterSamples {
            wi: samples.wi,
            weight: samples.weight,
            pdf: samples.pdf,
            from: x.offset_towards(samples.wi),
            to: samples.target,
            source: samples.source,
            valid: samples.valid,
        }
    }

    /// MIS weight (power heuristic) against a walk that samples the same directions with density
    /// `pdf_walk`, in 1/sr.
    #[inline(always)]
    pub fn mis_weight(&self, pdf_walk: Float<S>) -> Float<S> {
        self.pdf.gt(0.0).select(power(self.pdf, pdf_walk), 1.0)
    }
}

/// The last scattering events of walks; see [`Previous`](super::walk::Previous).
#[derive(Clone, Copy, Debug)]
pub struct PreviousEvents<S: Width> {
    /// Positions, and normals by which next-event estimation chooses emitters there.
    pub receivers: Receivers<S>,
    /// Density of the sampled direction per solid angle.
    pub pdf: Float<S>,
    /// The lanes where next-event estimation can sample the same direction: events other than delta
    /// events, and not the camera.
    pub has_next_event: Mask<S>,
}

impl<S: Width> PreviousEvents<S> {
    /// MIS weight of a walk. Next-event estimation cannot sample directions after delta events and
    /// from the camera.
    #[inline(always)]
    fn walk_weight(&self, pdf_direct: Float<S>) -> Float<S> {
        (self.has_next_event).select(power(self.pdf, pdf_direct), 1.0)
    }
}

/// Radiance that the surface points `y` emit along `wo` to the ends of walks, times its MIS weight
/// against next-event estimation at the last events, in W/(m² sr); in the lanes of `lanes`,
/// elsewhere black.
#[inline(always)]
pub fn emitted_with_mis<S: Width>(
    scene: &Scene,
    previous: &PreviousEvents<S>,
    y: &SurfacePoints<S>,
    wo: Vector<S>,
    lanes: Mask<S>,
) -> Color<S> {
    let (geometry, textures) = (&scene.geometry, &scene.textures);
    let emitters = &scene.emitters;
    let radiance = emitters.radiance_lanes(geometry, textures, y, wo, lanes);
    let weighted = lanes & previous.has_next_event & !radiance.is_black();
    if weighted.none() {
        return radiance;
    }
    let pdf = emitters.pdf_direct_lanes(&previous.receivers, y, weighted);
    radiance * previous.walk_weight(pdf)
}

/// Radiance of the environment along `wi`, times its MIS weight as in [`emitted_with_mis`], in the
/// lanes of `lanes`, elsewhere black. `lobes` are those of next-event estimation at the last
/// events, if it uses any.
#[inline(always)]
pub fn environment_with_mis<S: Width>(
    scene: &Scene,
    previous: &PreviousEvents<S>,
    wi: Vector<S>,
    lobes: LobesOfLanes<S>,
    lanes: Mask<S>,
) -> Color<S> {
    let (radiance, pdf) = (scene.emitters).environment_lanes(&previous.receivers, wi, lobes);
    (radiance * previous.walk_weight(pdf)).within(lanes)
}
