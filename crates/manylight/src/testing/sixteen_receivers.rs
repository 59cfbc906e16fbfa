//! Next-event estimation for sixteen receivers at a time, for callers outside of kernels.

use crate::emitters::{DirectSample, DirectSamples, Emitters, EnvironmentLobes, Receivers};
use crate::geometry::{Geometry, SurfacePoint, SurfacePoints};
use crate::lanes::{Color, Float, LANES, LaneMask, Lanes, Lanes3, Mask, Pair, Vector, Width};
use crate::simd::{Isa, Simd, SimdKernel};
use crate::texture::Texture;

/// Sixteen points that receive light; see [`Receivers`].
#[derive(Clone, Copy, Debug)]
pub struct SixteenReceivers {
    /// Positions, in m.
    pub p: Lanes3,
    /// Unit geometric normals; any finite vector where there is none.
    pub n: Lanes3,
    /// The receivers with a normal.
    pub has_normal: LaneMask,
}

/// Samples for sixteen receivers; see [`DirectSample`].
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "the fields are documented at DirectSample")]
pub struct SixteenDirectSamples {
    pub wi: Lanes3,
    pub target: Lanes3,
    pub weight: Lanes3,
    pub pdf: Lanes,
    /// The receivers with a sample.
    pub valid: LaneMask,
}

impl SixteenDirectSamples {
    /// The sample of receiver `i`.
    pub fn get(&self, i: usize) -> Option<DirectSample> {
        (self.valid >> i & 1 != 0).then(|| DirectSample {
            wi: self.wi.vec(i),
            target: self.target.vec(i),
            weight: self.weight.rgb(i),
            pdf: self.pdf[i],
        })
    }
}

impl SixteenReceivers {
    #[inline(always)]
    fn load<S: Width<Each<f32> = Lanes>>(&self, s: S) -> Receivers<S> {
        Receivers {
            p: Vector::load(s, &self.p.0),
            n: Vector::load(s, &self.n.0),
            has_normal: Mask::from_bits(s, self.has_normal.into()),
        }
    }
}

/// [`Emitters::sample`] for the receivers of `lanes`. The numbers `u` by receiver choose the
/// emitter and a point on it, in this order.
pub fn sample_sixteen(
    emitters: &Emitters,
    geometry: &Geometry,
    textures: &[Texture],
    receivers: &SixteenReceivers,
    u: &Lanes3,
    lanes: LaneMask,
) -> SixteenDirectSamples {
    Isa::best().run(SampleKernel {
        emitters,
        scene: (geometry, textures),
        receivers,
        u,
        lobes: [None; LANES],
        lanes,
    })
}

/// [`Emitters::pdf_direct`] for the receivers of `lanes`; 0 for the others.
pub fn pdf_direct_sixteen(
    emitters: &Emitters,
    receivers: &SixteenReceivers,
    y: &[SurfacePoint; LANES],
    lanes: LaneMask,
) -> Lanes {
    Isa::best().run(DensityKernel {
        emitters,
        receivers,
        y,
        lanes,
    })
}

/// [`Emitters::environment`] for sixteen directions `wi`.
pub fn environment_sixteen(
    emitters: &Emitters,
    receivers: &SixteenReceivers,
    wi: &Lanes3,
) -> (Lanes3, Lanes) {
    Isa::best().run(EnvironmentKernel {
        emitters,
        receivers,
        wi,
    })
}

pub(crate) struct SampleKernel<'a> {
    pub(crate) emitters: &'a Emitters,
    pub(crate) scene: (&'a Geometry, &'a [Texture]),
    pub(crate) receivers: &'a SixteenReceivers,
    pub(crate) u: &'a Lanes3,
    pub(crate) lobes: [Option<&'a EnvironmentLobes>; LANES],
    pub(crate) lanes: LaneMask,
}

impl SimdKernel for SampleKernel<'_> {
    type Output = SixteenDirectSamples;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> SixteenDirectSamples {
        let s = s.wide();
        let [u_choice, x, y] = self.u.0.each_ref().map(|u| Float::load(s, u));
        let (geometry, textures) = self.scene;
        let samples: DirectSamples<_> = self.emitters.sample_lanes(
            geometry,
            textures,
            &self.receivers.load(s),
            (u_choice, Pair::new(x, y)),
            Some(&s.each(|i| self.lobes[i])),
            Mask::from_bits(s, self.lanes.into()),
        );
        SixteenDirectSamples {
            wi: Lanes3(samples.wi.store()),
            target: Lanes3(samples.target.store()),
            weight: Lanes3(samples.weight.store()),
            pdf: samples.pdf.store(),
            valid: samples.valid.bits() as LaneMask,
        }
    }
}

pub(crate) struct DensityKernel<'a> {
    pub(crate) emitters: &'a Emitters,
    pub(crate) receivers: &'a SixteenReceivers,
    pub(crate) y: &'a [SurfacePoint; LANES],
    pub(crate) lanes: LaneMask,
}

impl SimdKernel for DensityKernel<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Lanes {
        let s = s.wide();
        let y = SurfacePoints::load(s, &s.each(|i| self.y[i]));
        let lanes = Mask::from_bits(s, self.lanes.into());
        let receivers = self.receivers.load(s);
        (self.emitters)
            .pdf_direct_lanes(&receivers, &y, lanes)
            .store()
    }
}

pub(crate) struct EnvironmentKernel<'a> {
    pub(crate) emitters: &'a Emitters,
    pub(crate) receivers: &'a SixteenReceivers,
    pub(crate) wi: &'a Lanes3,
}

impl SimdKernel for EnvironmentKernel<'_> {
    type Output = (Lanes3, Lanes);

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> (Lanes3, Lanes) {
        let s = s.wide();
        let wi = Vector::load(s, &self.wi.0);
        let (radiance, pdf): (Color<_>, _) =
            (self.emitters).environment_lanes(&self.receivers.load(s), wi, None);
        (Lanes3(radiance.store()), pdf.store())
    }
}
