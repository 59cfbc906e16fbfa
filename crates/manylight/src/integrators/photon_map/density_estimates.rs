//! Density estimates at the vertices of camera paths.

use super::camera_paths::{PathState, TilePaths};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::integrators::light_groups::RadianceByGroup;
use crate::maps::density::Bandwidth;
use crate::maps::{ArrivingPhotons, COVERAGE_PROBES, PhotonReceiver};
use crate::math::Vec3;
use crate::particles::Photon;
use crate::transport::Vertex;

impl TilePaths<'_, '_, '_, '_> {
    /// Density estimate at `v`, for `gathering` lobes and for photons that come from emitters by
    /// specular events. The path comes with its throughput.
    pub(super) fn gather(&mut self, path: (&PathState, Rgb), v: &Vertex, gathering: Lobes) {
        let n = v.x.normal_towards(v.w_prev);
        self.gather_from(path, v, gathering, n);
        if v.bsdf.transmits() {
            self.gather_from(path, v, gathering, -n);
        }
    }

    /// The estimate of [`TilePaths::gather`] over photons on the side of the unit normal `n`, in
    /// the layers of the photons' last events.
    fn gather_from(
        &mut self,
        (path, throughput): (&PathState, Rgb),
        v: &Vertex,
        gathering: Lobes,
        n: Vec3,
    ) {
        let pass = self.pass;
        let at = PhotonReceiver {
            x: &v.x,
            bsdf: &v.bsdf,
            wo: v.w_prev,
            segments: v.segments,
            limits: pass.limits,
        };
        let bandwidth = Bandwidth {
            largest: f32::INFINITY,
            radius_scale: pass.radius_scale,
        };
        let mut by_group = [0; 3].map(|_| RadianceByGroup::black(self.out.light_groups()));
        let here = path.stage.after(Lobes::NON_SPECULAR);
        // Of photons straight from emitters, from non-specular events, and from specular ones.
        let mut terms = [
            (here.layer(), Rgb::BLACK),
            (here.after(Lobes::NON_SPECULAR).layer(), Rgb::BLACK),
            (here.after(Lobes::SPECULAR).layer(), Rgb::BLACK),
        ];
        let mut add = |photon: &Photon, f_cos: Rgb, kernel: f32| {
            let term = match photon.event.has(Lobes::SPECULAR) {
                true => 2,
                false => usize::from(photon.event != Lobes::NONE),
            };
            let value = photon.flux * f_cos * kernel;
            terms[term].1 += value;
            by_group[term].add(photon.group, value);
        };
        let arriving = ArrivingPhotons::around(&pass.photons, at, n, bandwidth, &mut self.found);
        // Photons that come from an emitter by specular events count for all non-specular lobes.
        let is_from_emitter =
            |photon: &Photon| photon.event.has(Lobes::SPECULAR) && photon.origin == Lobes::NONE;
        let [from_emitters, others] = arriving.partition(is_from_emitter);
        from_emitters.each(Lobes::NON_SPECULAR, &mut add);
        others.each(gathering, &mut add);
        if terms.iter().all(|(_, sum)| sum.is_black()) {
            return;
        }
        let covered = others.covered(&pass.scene.geometry, COVERAGE_PROBES);
        let scale = 1.0 / (covered * pass.camera_paths as f32);
        let pixel = path.first.pixel as usize;
        for ((layer, sum), by_group) in terms.into_iter().zip(&by_group) {
            if !by_group.is_told_apart() {
                self.out.add(pixel, layer, throughput * sum * scale);
            }
            for (group, sum) in by_group.lit() {
                let value = throughput * sum * scale;
                self.out.add_light(pixel, layer, group, value);
            }
        }
    }
}
