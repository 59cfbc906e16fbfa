//! A method at work on a scene, pass by pass.

use super::context::PassContext;
use super::many_light::{KeptLights, LightsContext, ManyLight, PreparedGroups, with_fixed_effort};
use super::method::{Method, MethodKind};
use super::{aov, light_tracer, path};
use crate::film::Film;
use crate::scene::{LimitedScene, PathLimits, Scene};

/// A method at work on a scene, with the virtual lights that its passes share.
#[derive(Debug)]
pub struct Renderer<'s> {
    scene: &'s Scene,
    method: Method,
    kept: PreparedGroups<'s>,
}

impl<'s> Renderer<'s> {
    /// `method`, before its first pass. The virtual lights of as many groups of passes as
    /// `kept_groups` are kept.
    ///
    /// # Panics
    /// The settings of a many-light method contradict each other:
    /// [`ManyLight::check`]. Or layers of light groups are asked for that are not those of the
    /// scene.
    pub fn new(scene: &'s Scene, method: Method, kept_groups: usize) -> Self {
        if let Some(Err(contradiction)) = method.lights().map(ManyLight::check) {
            panic!("{contradiction}");
        }
        let (found, groups) = (method.extra.light_groups, &scene.light_groups);
        let is_sound = found == 0 || groups.are_recordable() && found == groups.count();
        assert!(is_sound, "{found} light groups of {}", groups.count());
        Renderer {
            scene,
            method,
            kept: PreparedGroups::new(kept_groups),
        }
    }

    /// The same, whose passes shade with `lights` if they are those of the method.
    pub fn with_lights(self, lights: Option<&'s KeptLights<'s>>) -> Self {
        Renderer {
            kept: self.kept.with_given(lights.map_or(&[], KeptLights::groups)),
            ..self
        }
    }

    /// The virtual lights of the first `passes` passes, made before them. `None` if cancelled, or
    /// if the method has no virtual lights.
    pub fn make_lights(&self, passes: u32, run: &PassContext) -> Option<KeptLights<'s>> {
        let (scene, limits) = (self.scene, self.method.limits);
        let cx = LightsContext {
            method: with_fixed_effort(self.method.lights()?, scene, limits, run),
            scene,
            limits,
            passes,
            light_groups: run.light_groups,
        };
        KeptLights::make(&cx, run)
    }

    /// Adds one pass to `film`; `false` if it was cancelled and dropped. A pass depends only on the
    /// seed and its index.
    pub fn render_pass(&mut self, run: &PassContext, film: &mut Film) -> bool {
        let (scene, limits) = (self.scene, self.method.limits);
        if let Some(lights) = self.method.lights_mut() {
            *lights = with_fixed_effort(lights, scene, limits, run);
        }
        if self.begins_batch(run.pass.index) {
            film.begin_batch();
        }
        film.set_half(self.method.half_of_pass(run.pass.index));
        match &self.method.kind {
            MethodKind::Path => path::render_pass(scene, limits, run, film),
            MethodKind::Direct => {
                let max_depth = Some(limits.max_depth.map_or(2, |max| max.min(2)));
                let limits = PathLimits {
                    max_depth,
                    ..limits
                };
                path::render_pass(scene, limits, run, film)
            }
            MethodKind::LightTracer => light_tracer::render_pass(scene, limits, run, film),
            MethodKind::Aov => aov::render_pass(scene, limits, run, film),
            MethodKind::ManyLight(settings) => settings.render_pass(
                LimitedScene { scene, limits },
                run,
                &mut self.kept,
                film,
                (|_| (), |_| ()),
            ),
            MethodKind::Mixed(settings) => {
                settings.render_pass(LimitedScene { scene, limits }, run, &mut self.kept, film)
            }
            MethodKind::PhotonMap(settings) => settings.render_pass(scene, limits, run, film),
        }
    }

    /// Whether pass `index` shares no virtual lights with those before.
    fn begins_batch(&self, index: u32) -> bool {
        let lights = self.method.lights();
        lights.is_none_or(|lights| lights.pass_group(index).passes.start == index)
    }
}
