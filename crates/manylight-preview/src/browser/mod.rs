//! The page for a browser on this machine.

mod access;
mod connections;
mod events;
mod page;
mod server;

pub(crate) use server::BrowserViewer;
