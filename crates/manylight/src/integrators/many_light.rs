//! The method: light from virtual lights.

/// Where lights stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// Photons kept with probability proportional to flux.
    Uniform,
    /// Proportional to importance x flux.
    Importance,
}

/// How much flux each light carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FluxRule {
    /// Its own photon's over the probability of having been kept.
    Density,
    /// That of all photons nearer to it than to any other light.
    Partition,
}

/// What each light shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionKind {
    /// The reflection of one photon.
    Single,
    /// The reflection of all its photons: diffuse part exact, glossy part in an octahedral table of this side.
    Table {
        /// Texels along an edge.
        side: u32,
    },
}

/// How one light is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// As a point.
    Point,
    /// As a disc with the second moments of its photons.
    Disc,
}

/// What is done about the singularity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clamp {
    /// Nothing.
    None,
    /// Scale-free: the form factor of the light's own area for discs, `G <= 1 / area per light` for points.
    Auto,
    /// `G <= value`, in 1/m².
    Value(f32),
}

/// Indirect light from virtual lights. Each pass has its own lights and its own jitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManyLight {
    /// Virtual lights per pass.
    pub light_count: u32,
    /// Emitted photon paths per pass.
    pub photon_paths: u32,
    /// Importon paths per pass.
    pub importon_paths: u32,
    /// Where lights stand.
    pub placement: Placement,
    /// How much flux each carries.
    pub flux: FluxRule,
    /// What each shines.
    pub emission: EmissionKind,
    /// How one is evaluated.
    pub kernel: Kernel,
    /// What is done about the singularity.
    pub clamp: Clamp,
}

impl ManyLight {
    /// The default: importance placement, partition, 32 x 32 tables, discs.
    pub fn rich_vpl() -> Self {
        ManyLight {
            light_count: 1024,
            photon_paths: 262_144,
            importon_paths: 32_768,
            placement: Placement::Importance,
            flux: FluxRule::Partition,
            emission: EmissionKind::Table { side: 32 },
            kernel: Kernel::Disc,
            clamp: Clamp::Auto,
        }
    }

    /// Classic VPLs: photons thinned at random.
    pub fn vpl() -> Self {
        ManyLight {
            placement: Placement::Uniform,
            flux: FluxRule::Density,
            emission: EmissionKind::Single,
            kernel: Kernel::Point,
            ..ManyLight::rich_vpl()
        }
    }

    /// VPLs placed by importance.
    pub fn vpl_importance() -> Self {
        ManyLight { placement: Placement::Importance, ..ManyLight::vpl() }
    }
}

impl ManyLight {
    pub(super) fn render_pass(&self, _scene: &crate::scene::Scene, _limits: crate::scene::PathLimits, _run: &super::PassContext, _film: &mut crate::film::Film) -> bool {
        todo!()
    }
}
