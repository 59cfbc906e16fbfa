//! The viewer tev, over TCP. HDRView reads the same protocol.

mod packets;
mod sender;

pub(crate) use sender::TevViewer;
