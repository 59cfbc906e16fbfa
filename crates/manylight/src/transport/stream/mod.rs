//! Streams: the walks of a tile in arrays, advanced in stages.
//!
//! ```text
//!   rays --trace--> hits --sort by material--> packets of sixteen --shade--> rays, connections
//! ```
//!
//! All walks follow their rays (`arrivals`), attenuated inside of bodies (`absorption`). Hits are
//! sorted by material, so that the vertices of a packet share one: its model, its wrappers and its
//! textures (`vertices`). A packet is shaded in lanes, with one generator of random numbers per
//! lane (`generators`). The walks that go on are appended to the stream of the next segment
//! (`walks`), the next round (`rounds`). Walks without a hit see the environment (`escapes`).

mod absorption;
mod arrivals;
mod escapes;
mod generators;
mod photons;
mod rounds;
mod vertices;
mod walks;

pub(crate) use arrivals::Arrivals;
pub(crate) use escapes::see_environment;
pub(crate) use generators::Generators;
pub(crate) use photons::follow_photons;
pub(crate) use rounds::{
    PacketShader, VertexShader, WalkStream, follow_all, follow_and_shade, shade_packets,
};
pub(crate) use vertices::{Bits, SegmentEnd, Vertices, by_lane, lanes_where, used};
pub(crate) use walks::{WalkRow, WalkState, Walks};
