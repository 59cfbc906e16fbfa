//! The connections of the server. Any program on this machine can open some, and may send half a
//! request, or none: their number is bounded, and those that show no picture give way to new ones.
//! The program keeps enough open files for its images.

use axum::{Extension, Router};
use futures_util::future::{Either, select};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;
use tokio::task::AbortHandle;

/// Largest number of connections at the same time: more than a browser opens for
/// [`super::server::MAX_PAGES`] pages, and a small part of the 1024 files that a process may
/// usually have open.
const MAX_CONNECTIONS: usize = 96;

/// Longest time for the head of a request, from the opening of the connection or the end of the
/// last answer.
const REQUEST_TIME: Duration = Duration::from_secs(10);

/// Most bytes of the head of a request. Browsers send less than 2 kB.
const MAX_HEAD_BYTES: usize = 64 << 10;

/// Time between two attempts to accept a connection if the system refuses.
const RETRY_TIME: Duration = Duration::from_millis(100);

/// Whether a connection receives pictures. Each request holds the mark of its connection.
#[derive(Clone, Debug, Default)]
pub(super) struct ShowsPictures(Arc<AtomicBool>);

impl ShowsPictures {
    /// The connection does not give way any more.
    pub(super) fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn get(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Serves `pages` until `stopped`, and until the pages that show pictures have received everything.
pub(super) async fn serve(
    listener: TcpListener,
    pages: Router,
    mut stopped: oneshot::Receiver<()>,
) {
    let mut connections = Connections::default();
    loop {
        match select(pin!(listener.accept()), &mut stopped).await {
            Either::Left((Ok((stream, _)), _)) => connections.open(stream, &pages),
            Either::Left((Err(_), _)) => tokio::time::sleep(RETRY_TIME).await,
            Either::Right(_) => break,
        }
    }
    drop(listener);
    connections.close().await;
}

/// The open connections.
#[derive(Default)]
struct Connections {
    /// In the order of their opening.
    open: Vec<Connection>,
    graceful: GracefulShutdown,
}

struct Connection {
    task: AbortHandle,
    shows_pictures: ShowsPictures,
}

impl Connections {
    /// Serves `pages` to a new connection. The oldest one that shows no picture is closed if there
    /// are too many.
    fn open(&mut self, stream: TcpStream, pages: &Router) {
        self.open
            .retain(|connection| !connection.task.is_finished());
        if self.open.len() >= MAX_CONNECTIONS {
            let waiting = |connection: &Connection| !connection.shows_pictures.get();
            let Some(oldest) = self.open.iter().position(waiting) else {
                return;
            };
            self.open.remove(oldest).task.abort();
        }
        let shows_pictures = ShowsPictures::default();
        let pages = pages.clone().layer(Extension(shows_pictures.clone()));
        let connection = http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(REQUEST_TIME)
            .max_buf_size(MAX_HEAD_BYTES)
            .serve_connection(TokioIo::new(stream), TowerToHyperService::new(pages));
        let connection = self.graceful.watch(connection);
        let task = tokio::spawn(async move {
            // A client that leaves or sends nonsense concerns nobody else.
            let _ = connection.await;
        });
        self.open.push(Connection {
            task: task.abort_handle(),
            shows_pictures,
        });
    }

    /// Closes the connections, those with pictures when they have received the last one.
    async fn close(self) {
        let waiting = self.open.iter().filter(|c| !c.shows_pictures.get());
        waiting.for_each(|connection| connection.task.abort());
        self.graceful.shutdown().await;
    }
}
