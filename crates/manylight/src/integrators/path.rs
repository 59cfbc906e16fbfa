//! The reference: a path tracer with next-event estimation and multiple importance sampling.
//!
//! It fills the same layers as the many-light methods, so each of their terms can be checked by itself.

use super::partition::Stage;
use super::{PassContext, first_surface_sampled};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::film::{Film, TileSamples};
use crate::sampling::{Sampler, Stream};
use crate::scene::{PathLimits, Scene};
use crate::stats::Stats;
use crate::transport::direct::{EmitterSample, found_environment, found_radiance};
use crate::transport::{Step, Vertex, Walk, roulette};

/// One sample per pixel. `false` if cancelled.
pub(super) fn render_pass(
    scene: &Scene,
    limits: PathLimits,
    run: &PassContext,
    film: &mut Film,
) -> bool {
    let positions = film.desc().sampler();
    run.shade(film, |samples| {
        let mut shadow_rays = 0;
        for (i, pixel) in samples.tile().pixels().enumerate() {
            let mut sampler = run.pass.sampler(Stream::Pixel, positions.index(pixel));
            let at = positions.sample(pixel, sampler.next_2d());
            let camera = scene.sensor.ray(at.position, sampler.next_2d());
            let walk = Walk::from_sensor(
                scene,
                limits,
                camera.ray,
                Rgb::splat(camera.weight * at.weight),
            );
            let mut path = Path {
                scene,
                limits,
                walk,
                stage: Stage::BeforeX,
                shadow_rays: 0,
            };
            path.trace(&mut sampler, i, samples);
            shadow_rays += path.shadow_rays;
        }
        Stats::count(&run.stats.shadow_rays, shadow_rays);
        Stats::count(
            &run.stats.camera_paths,
            samples.tile().pixels().count() as u64,
        );
    })
}

struct Path<'s> {
    scene: &'s Scene,
    limits: PathLimits,
    walk: Walk<'s>,
    stage: Stage,
    shadow_rays: u64,
}

impl Path<'_> {
    fn trace(&mut self, sampler: &mut Sampler, index: usize, out: &mut TileSamples) {
        loop {
            let v = match self.walk.advance() {
                Step::Hidden => return,
                Step::Escaped(wi) => {
                    let found = found_environment(self.scene, self.walk.previous(), wi);
                    out.add(index, self.stage.layer(), self.walk.throughput() * found);
                    return;
                }
                Step::Hit(v) => v,
            };
            let found = found_radiance(self.scene, self.walk.previous(), &v.x, v.w_prev);
            out.add(index, self.stage.layer(), self.walk.throughput() * found);
            let ends = !self.limits.allow(v.segments + 1);
            if ends && v.segments > 1 {
                return;
            }
            let sample = v.bsdf.sample_wi(v.w_prev, sampler.next_bsdf(), Lobes::ALL);
            if v.segments == 1 {
                first_surface_sampled(&v, sample.as_ref(), index, out);
            }
            if ends {
                return;
            }
            if self.walk.pass_through(&v, sampler.next_1d()) {
                continue;
            }
            self.next_event(&v, sampler, index, out);
            if !self.walk.follow(&v, sample) {
                return;
            }
            self.stage = self.stage.after(self.walk.previous().event);
            if v.segments >= self.limits.rr_depth {
                let survival =
                    roulette::camera_survival(self.walk.throughput(), self.walk.eta_squared());
                if !self.walk.survive(survival, sampler.next_1d()) {
                    return;
                }
            }
        }
    }

    /// Light from an emitter at `v`, by the lobe that reflects it: the classes belong to different layers.
    fn next_event(
        &mut self,
        v: &Vertex,
        sampler: &mut Sampler,
        index: usize,
        out: &mut TileSamples,
    ) {
        if !v.bsdf.lobes().has(Lobes::FINITE) {
            return;
        }
        let Some(light) =
            EmitterSample::draw(self.scene, &v.x, v.bsdf.receiving_normal(v.w_prev), sampler)
        else {
            return;
        };
        let (smooth, narrow) = v.bsdf.f_cos_wi_by_width(light.wi, v.w_prev);
        if smooth.is_black() && narrow.is_black() {
            return;
        }
        self.shadow_rays += 1;
        let crossings = self
            .limits
            .max_depth
            .map_or(u32::MAX, |max| max - (v.segments + 1));
        let arriving = light.weight * light.transmittance(self.scene, crossings);
        if arriving.is_black() {
            return;
        }
        let mis = light.mis_weight(v.bsdf.pdf_wi(light.wi, v.w_prev, Lobes::ALL));
        let scale = self.walk.throughput() * arriving * mis;
        out.add(
            index,
            self.stage.after(Lobes::DIFFUSE).layer(),
            scale * smooth,
        );
        out.add(
            index,
            self.stage.after(Lobes::NEAR_DELTA).layer(),
            scale * narrow,
        );
    }
}
