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

impl<'p> TilePaths<'p, '_, '_, '_> {
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
        // Photons that come from an emitter by specular events count for all non-specular lobes.
        let mut by_lobes = [(Lobes::NON_SPECULAR, Vec::new()), (gathering, Vec::new())];
        let visit = |photon: &'p Photon, kernel: f32| {
            let cos = photon.wi.dot(v.x.ng).abs();
            if cos > 0.0 && pass.limits.allow(v.segments + u32::from(photon.depth)) {
                let from_emitter =
                    photon.event.has(Lobes::SPECULAR) && photon.origin == Lobes::NONE;
                let (_, photons) = &mut by_lobes[usize::from(!from_emitter)];
                photons.push((photon, kernel / cos));
            }
        };
        let radius = density_estimate(&pass.photons, receiver, bandwidth, &mut self.found, visit);
        let mut f_cos = Vec::new();
        for (lobes, photons) in &by_lobes {
            let directions: Vec<Vec3> = photons.iter().map(|(photon, _)| photon.wi).collect();
            v.bsdf
                .f_cos_each_wi(&directions, v.w_prev, *lobes, &mut f_cos);
            for (&(photon, kernel), &f_cos) in photons.iter().zip(&f_cos) {
                let term = match photon.event.has(Lobes::SPECULAR) {
                    true => 2,
                    false => usize::from(photon.event != Lobes::NONE),
                };
                terms[term].1 += photon.flux * f_cos * kernel;
            }
        }
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
