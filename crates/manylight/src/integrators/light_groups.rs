//! The light groups to which light belongs.

use crate::color::Rgb;
use crate::emitters::EmissionSource;
use crate::ids::LightGroup;
use crate::math::Vec3;
use crate::scene::Scene;

/// Calls `visit` with the light group of `source` and a factor of one. Without a source, light
/// comes from the environment along the unit direction `wi`, and may belong to several groups, of
/// which the factors are the shares.
pub(super) fn each_group(
    scene: &Scene,
    source: Option<EmissionSource>,
    wi: Vec3,
    mut visit: impl FnMut(LightGroup, Rgb),
) {
    let groups = &scene.light_groups;
    if let Some(source) = source {
        return visit(groups.of(source), Rgb::WHITE);
    }
    if let Some(group) = groups.of_environment() {
        return visit(group, Rgb::WHITE);
    }
    let terms = || scene.emitters.environment_terms(wi);
    let total = terms().fold(Rgb::BLACK, |sum, (_, radiance)| sum + radiance);
    let share = |part: f32, all: f32| if all > 0.0 { part / all } else { 0.0 };
    for (emitter, radiance) in terms() {
        let group = groups.of(EmissionSource::Emitter(emitter));
        visit(group, radiance.zip(total, share));
    }
}

/// Radiance by light group. Empty if groups are not told apart.
#[derive(Clone, Debug, Default)]
pub(super) struct RadianceByGroup(Vec<Rgb>);

impl RadianceByGroup {
    /// Black in each of `groups` groups.
    pub(super) fn black(groups: usize) -> Self {
        RadianceByGroup(vec![Rgb::BLACK; groups])
    }

    /// Whether groups are told apart.
    #[inline(always)]
    pub(super) fn is_told_apart(&self) -> bool {
        !self.0.is_empty()
    }

    /// Makes all groups black.
    pub(super) fn clear(&mut self) {
        self.0.fill(Rgb::BLACK);
    }

    /// Adds `value` to a group.
    #[inline(always)]
    pub(super) fn add(&mut self, group: LightGroup, value: Rgb) {
        if let Some(sum) = self.0.get_mut(group.index()) {
            *sum += value;
        }
    }

    /// Multiplies all groups by `factor`.
    pub(super) fn scale(&mut self, factor: f32) {
        self.0.iter_mut().for_each(|value| *value *= factor);
    }

    /// The groups that are not black.
    pub(super) fn lit(&self) -> impl Iterator<Item = (LightGroup, Rgb)> + '_ {
        let groups = self.0.iter().enumerate();
        let lit = groups.filter(|(_, value)| !value.is_black());
        lit.map(|(group, &value)| (LightGroup(group as u8), value))
    }
}
