//! Glossy form 1: radiant intensity of a light in an octahedral table, cosine included.
//!
//! The lobes of the paths are evaluated on the grid, each about its own normal. Then the table is
//! scaled per channel so that the integral of its bilinear interpolation, over the domain of
//! emission, is the flux scattered by the paths.

use super::octahedral_grid::Grid;
use super::reflection::{EmissionDomain, Reflection};
use super::table_lookup::bilinear;
use crate::bsdf::{FixedWi, Lobes};
use crate::color::Rgb;
use crate::lanes::{Color, Float, LANES, Lanes3, Mask};
use crate::math::Vec3;
use crate::sampling::rng::Pcg;
use crate::simd::{Isa, Simd, SimdKernel, set_bits};

/// Roughness below which lobes are averaged over each texel; wider lobes are evaluated at the
/// texel's center. At 0.15 and 0.6 (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy
/// Room): pictures differ by at most 0.8 % (RMS).
const CENTER_ROUGHNESS: f32 = 0.3;
/// Value of a block of 2 x 2 texels, relative to the brightest block, from which its texels are
/// evaluated separately; for lobes narrower than [`CENTER_ROUGHNESS`]. Smaller values are slower
/// and keep more of the shape. At 0.025 and 0.1 (2 passes of 128 lights at 72x40, 3 seeds; Kitchen,
/// Glossy Room): pictures differ by at most 0.7 % (RMS).
const NARROW_BRIGHT_SHARE: f32 = 0.05;
/// Value of a block of 2 x 2 texels, relative to the brightest block, from which its texels are
/// evaluated separately; for wider lobes, which vary little within a block. At 0.15 and 0.6 (2
/// passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room): pictures differ by at most 0.1 %
/// (RMS).
const WIDE_BRIGHT_SHARE: f32 = 0.3;
/// Number of directions sampled from each lobe for a table made of samples. At 64 and 256 (2 passes
/// of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room): the same picture.
const SPLAT_SAMPLES: u32 = 128;
/// Largest factor, or inverse factor, that corrects the flux of an evaluated table. A larger one
/// shows that the lobes fall between the texels, and the table is made of sampled directions
/// instead. At √2 and 4 (2 passes of 128 lights at 72x40, 3 seeds; Kitchen, Glossy Room): the same
/// picture.
const MAX_CORRECTION: f32 = 2.0;

/// Those texels of a block of 2 x 2 that have their centers in a domain of emission.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    texels: [usize; 4],
    count: usize,
}

impl Block {
    fn add(&mut self, t: usize) {
        self.texels[self.count] = t;
        self.count += 1;
    }

    fn texels(&self) -> &[usize] {
        &self.texels[..self.count]
    }
}

impl Grid {
    /// The texels of the table of `paths`, in W/sr, and the flux of the table, in W, which is
    /// `target` unless no texel or sample has found the lobes. `roughness` is the smallest of
    /// the lobes.
    pub(super) fn fill(
        &self,
        paths: &[Reflection],
        roughness: f32,
        domain: EmissionDomain,
        target: Rgb,
        rng: &mut Pcg,
    ) -> (Vec<Rgb>, Rgb) {
        let mut texels = vec![Rgb::BLACK; self.side() * self.side()];
        Isa::best().run(Evaluation {
            grid: self,
            paths,
            roughness,
            blocks: self.blocks_inside(domain),
            texels: &mut texels,
        });
        let mut flux = self.integral(&texels, domain.horizon());
        let mut scale = correction(flux, target);
        if scale.is_none() {
            texels.fill(Rgb::BLACK);
            for path in paths {
                self.splat(path, domain, rng, &mut texels);
            }
            flux = self.integral(&texels, domain.horizon());
            scale = correction(flux, target);
        }
        let scale = scale.unwrap_or(Rgb::WHITE);
        texels.iter_mut().for_each(|texel| *texel *= scale);
        (texels, flux * scale)
    }

    /// The blocks of 2 x 2 texels that have texel centers in `domain`, and for each the direction,
    /// unit, to the middle of these centers.
    fn blocks_inside(&self, domain: EmissionDomain) -> (Vec<Block>, Vec<Vec3>) {
        let (mut blocks, mut middles) = (Vec::new(), Vec::new());
        for corner in self.blocks() {
            let mut block = Block::default();
            let mut middle = Vec3::ZERO;
            for t in self.block(corner) {
                if domain.contains(self.center(t)) {
                    block.add(t);
                    middle += self.center(t);
                }
            }
            if middle != Vec3::ZERO {
                blocks.push(block);
                middles.push(middle.normalize());
            }
        }
        (blocks, middles)
    }

    /// Adds directions sampled from the lobes of one path, each as a hat function of its flux.
    fn splat(&self, path: &Reflection, domain: EmissionDomain, rng: &mut Pcg, texels: &mut [Rgb]) {
        path.scatter(SPLAT_SAMPLES, rng, |w, flux, _| {
            if domain.contains(w) {
                for (t, weight) in bilinear(w, self.side()) {
                    texels[t] += flux * (weight / self.hats[t]);
                }
            }
        });
    }
}

/// Adds the intensity of paths to a table: first one value for each block of 2 x 2 texels, then the
/// separate texels of bright blocks.
struct Evaluation<'a, 's> {
    grid: &'a Grid,
    paths: &'a [Reflection<'s>],
    /// The smallest of the lobes.
    roughness: f32,
    /// As of [`Grid::blocks_inside`].
    blocks: (Vec<Block>, Vec<Vec3>),
    texels: &'a mut [Rgb],
}

impl SimdKernel for Evaluation<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Simd>(self, isa: I) {
        let s = isa.wide();
        let all = Mask::splat(s, true);
        let Evaluation {
            grid,
            paths,
            roughness,
            blocks: (blocks, middles),
            texels,
        } = self;
        let is_narrow = roughness < CENTER_ROUGHNESS;
        let bright_share = match is_narrow {
            true => NARROW_BRIGHT_SHARE,
            false => WIDE_BRIGHT_SHARE,
        };
        let middles: Vec<Lanes3> = in_lanes(&middles, |w| *w).collect();
        // Sums over the paths for which a block is dim: its texels share one value of such a path.
        let mut sums = vec![Lanes3::ZERO; middles.len()];
        let (mut values, mut samples) = (sums.clone(), Vec::new());
        for path in paths {
            let outgoing = FixedWi::new(s, &path.bsdf, path.wi, Lobes::GLOSSY);
            let flux = Color::splat(s, path.flux);
            let mut brightest = Float::splat(s, 0.0);
            for (value, w) in values.iter_mut().zip(&middles) {
                let intensity = outgoing.f_cos_wo_each(w.vectors(s), all) * flux;
                brightest = brightest.max(intensity.luminance());
                *value = Lanes3::of_colors(intensity);
            }
            let brightest = brightest.store().iter().fold(0.0, |a: f32, &b| a.max(b));
            samples.clear();
            let blocks = blocks.chunks(LANES);
            for ((value, sum), blocks) in values.iter().zip(&mut sums).zip(blocks) {
                let intensity = value.colors(s);
                let is_dim = intensity.luminance().lt(bright_share * brightest);
                let dim = intensity.within(is_dim);
                *sum = Lanes3::of_colors(sum.colors(s) + dim);
                let used = u32::MAX >> (32 - blocks.len());
                for i in set_bits(!is_dim.bits() & used) {
                    for &t in blocks[i].texels() {
                        match is_narrow {
                            true => samples.extend_from_slice(grid.within_texel(t)),
                            false => samples.push(grid.at_center(t)),
                        }
                    }
                }
            }
            let directions = in_lanes(&samples, |sample| sample.w);
            for (w, samples) in directions.zip(samples.chunks(LANES)) {
                let intensity = outgoing.f_cos_wo_each(w.vectors(s), all) * flux;
                let intensity = Lanes3::of_colors(intensity);
                for (i, sample) in samples.iter().enumerate() {
                    texels[sample.texel] += intensity.rgb(i) * sample.share;
                }
            }
        }
        for (k, block) in blocks.iter().enumerate() {
            for &t in block.texels() {
                texels[t] += sums[k / LANES].rgb(k % LANES);
            }
        }
    }
}

/// The direction of each item in lanes, of which unused ones repeat the last.
#[inline(always)]
fn in_lanes<T>(items: &[T], direction: impl Fn(&T) -> Vec3) -> impl Iterator<Item = Lanes3> {
    items.chunks(LANES).map(move |items| {
        let last = items.len() - 1;
        Lanes3::from_fn(|i| direction(&items[i.min(last)]))
    })
}

/// Factor per channel from the flux of a table to `target`; `None` if the luminances differ by more
/// than [`MAX_CORRECTION`] or a channel is black that should not be.
fn correction(flux: Rgb, target: Rgb) -> Option<Rgb> {
    let ratio = |target: f32, flux: f32| match (target > 0.0, flux > 0.0) {
        (true, true) => target / flux,
        (false, _) => 0.0,
        (true, false) => f32::INFINITY,
    };
    let overall = ratio(target.luminance(), flux.luminance());
    let close = overall == 0.0 || (1.0 / MAX_CORRECTION..=MAX_CORRECTION).contains(&overall);
    let factor = target.zip(flux, ratio);
    (close && factor.is_finite()).then_some(factor)
}
