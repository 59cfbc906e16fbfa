//! The methods. Start reading at [`many_light`], the method of the paper.

mod aov;
mod camera_round;
mod camera_starts;
pub mod choice;
mod connections;
pub mod context;
mod direct_light;
pub mod emission_guiding;
mod first_event;
mod guiding;
mod light_groups;
mod light_tracer;
pub mod many_light;
pub mod memory;
pub mod method;
pub mod mixed;
pub mod partition;
mod path;
pub mod photon_map;
pub mod renderer;

pub use choice::{Choice, ChoiceErrors, ChoicePrePass};
pub use context::PassContext;
pub use emission_guiding::GuidedEmission;
pub use many_light::{
    InterimMaps, KeptLights, LightsContext, ManyLight, PlacedLight, PreparedPasses,
};
pub use memory::{LightSets, Stage, StageMemory, estimated_memory};
pub use method::{ExtraLayers, Method, MethodKind};
pub use mixed::{Mixed, PathWeights};
pub use photon_map::PhotonMap;
pub use renderer::Renderer;
