//! The picture of a render while it grows, in a viewer.
//!
//! * [`PreviewTarget`] is the viewer that a user names: tev over TCP, or a page for the browser on
//!   this machine.
//! * [`Preview`] takes a [`Picture`] after a pass, at a bounded rate, and hands it to the thread of
//!   the viewer. A picture that the thread has not begun to send is replaced by the next one.
//!
//! # Layers
//!
//! A module imports only from layers with smaller numbers.
//!
//! ```text
//!  2 preview
//!  1 tev browser
//!  0 picture target pace mailbox
//! ```
//!
//! # Promises
//!
//! * A render never waits for a viewer, and pictures between the first and the last take at most 2
//!   % of its time.
//! * Nothing fails: a missing viewer, and one that goes away, is one warning.
//! * The page is served on the loopback interface alone, under an address with a random token, and
//!   only for requests that name this machine as their host. It loads nothing from elsewhere.

mod browser;
mod mailbox;
mod pace;
mod picture;
mod preview;
mod target;
mod tev;

pub use picture::{Picture, Progress, RenderInfo, RenderState};
pub use preview::Preview;
pub use target::{PreviewTarget, TargetError, TevAddress, Warn};
