//! Density estimates at the vertices of camera paths.

use super::camera_paths::{PathState, TilePaths};
use crate::bsdf::Lobes;
use crate::color::Rgb;
use crate::maps::density::{Bandwidth, DensityReceiver, density_estimate};
use crate::maps::{COVERAGE_PROBES, covered_fraction};
use crate::math::Vec3;
use crate::particles::Photon;
use crate::sampling::rng;
use crate::transport::Vertex;

impl TilePaths<'_, '_, '_, '_> {
    /// Density estimate at `v`, for `gathering` lobes and for photons that come from emitters by specular events. The path comes with its
    /// throughput.
    pub(super) fn gather(&mut self, path: (&PathState, Rgb), v: &Vertex, gathering: Lobes) {
        let n = v.x.normal_towards(v.w_prev);
        self.gather_from(path, v, gathering, n);
        if v.bsdf.transmits() {
            self.gather_from(path, v, gathering, -n);
        }
    }

    /// The estimate of [`TilePaths::gather`] over photons on the side of the unit normal `n`: `Σ_j k_j f Φ_j`, divided by the
    /// covered fraction of the kernel, in the layers of the photons' last events.
    fn gather_from(
        &mut self,
        (path, throughput): (&PathState, Rgb),
        v: &Vertex,
        gathering: Lobes,
        n: Vec3,
    ) {
        let pass = self.pass;
        let receiver = DensityReceiver { p: v.x.p, n };
        let bandwidth = Bandwidth {
            largest: f32::INFINITY,
            share: pass.radius_scale,
        };
        let here = path.stage.after(Lobes::NON_SPECULAR);
        // Of photons straight from emitters, from non-specular events, and from specular ones.
        let mut terms = [
            (here.layer(), Rgb::BLACK),
            (here.after(Lobes::NON_SPECULAR).layer(), Rgb::BLACK),
            (here.after(Lobes::SPECULAR).layer(), Rgb::BLACK),
        ];
        let visit = |photon: &Photon, kernel| {
            if !pass.limits.allow(v.segments + u32::from(photon.depth)) {
                return;
            }
            let is_specular = photon.event.has(Lobes::SPECULAR);
            let lobes = if is_specular && photon.origin == Lobes::NONE {
                Lobes::NON_SPECULAR
            } else {
                gathering
            };
            let term = if is_specular {
                2
            } else {
                usize::from(photon.event != Lobes::NONE)
            };
            terms[term].1 += photon.flux * v.bsdf.f(photon.wi, v.w_prev, lobes) * kernel;
        };
        let radius = density_estimate(&pass.photons, receiver, bandwidth, &mut self.found, visit);
        if terms.iter().all(|(_, sum)| sum.is_black()) {
            return;
        }
        // The turn of the probe pattern is a hash of `wo`, which differs from pass to pass and does not depend on the unit of length.
        let turn = rng::unit(rng::key(v.w_prev.to_array()));
        let covered = covered_fraction(
            &pass.scene.geometry,
            receiver,
            radius,
            COVERAGE_PROBES,
            turn,
        );
        let scale = 1.0 / (covered * pass.camera_paths as f32);
        for (layer, sum) in terms {
            let value = throughput * sum * scale;
            self.out.add(path.pixel as usize, layer, value);
        }
    }
}
