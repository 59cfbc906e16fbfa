//! The server of the page. It runs in a separate thread.
//!
//! | path | content |
//! |---|---|
//! | `/TOKEN/` | the page |
//! | `/TOKEN/page.css`, `/TOKEN/shared.js`, `/TOKEN/live.js` | its parts |
//! | `/TOKEN/events/LAYER` | server-sent events with the layer named `LAYER`, see [`super::events`] |
//! | `/TOKEN/events/LAYER?lights` | these and the light groups |
//!
//! Every other path is unknown (404), and requests under a foreign name or from a foreign page are
//! refused (403).

use super::access::{check_sender, token};
use super::connections::{ShowsPictures, serve};
use super::events::{Latest, Shown, events};
use super::page::{LIVE_SCRIPT, LIVE_STYLE, html};
use crate::picture::{Picture, RenderInfo};
use crate::target::Warn;
use axum::extract::{Path, RawQuery, Request, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn};
use axum::response::sse::{KeepAlive, Sse};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;
use axum::{Extension, Router};
use manylight_lab::viewer::{SHARED_SCRIPT, STYLE};
use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;
use tokio::sync::{oneshot, watch};

/// Largest number of pages that are open at the same time.
pub(super) const MAX_PAGES: usize = 32;

/// Longest time that the end of the program waits for connections without events to be closed.
const IDLE_TIME: Duration = Duration::from_millis(300);

/// The page loads nothing from other places, and no other page may show it or learn its address.
const HEADERS: [(HeaderName, &str); 5] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::CACHE_CONTROL, "no-store"),
    (
        HeaderName::from_static("cross-origin-resource-policy"),
        "same-origin",
    ),
];

/// The server of the page.
#[derive(Debug)]
pub(crate) struct BrowserViewer {
    address: String,
    latest: watch::Sender<Latest>,
    stop: oneshot::Sender<()>,
    /// Is disconnected when the thread ends.
    ended: Receiver<()>,
}

impl BrowserViewer {
    /// Starts to serve the page at `port` of 127.0.0.1; 0 is any free port. If the port is not
    /// available, `warn` is told and a free one is taken.
    ///
    /// # Errors
    /// The system refuses a port, random numbers or a thread. The error is a warning.
    pub(crate) fn start(port: u16, info: RenderInfo, warn: &Warn) -> Result<Self, String> {
        let failed = |what: &str, error: &dyn std::fmt::Display| {
            format!("--preview browser: cannot {what}: {error}")
        };
        let listener = listen(port, warn).map_err(|e| failed("listen at 127.0.0.1", &e))?;
        let port = listener
            .local_addr()
            .map_err(|e| failed("listen at 127.0.0.1", &e))?
            .port();
        let token = token().map_err(|e| failed("make a random token", &e))?;
        let address = format!("http://127.0.0.1:{port}/{token}/");
        let latest = watch::Sender::new(None);
        let pages = router(&token, &info, latest.clone());
        let (stop, stopped) = oneshot::channel();
        let (alive, ended) = channel();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|e| failed("start the server", &e))?;
        let serving = async move {
            let listener = tokio::net::TcpListener::from_std(listener)?;
            // A dropped sender stops the server too.
            serve(listener, pages, stopped).await;
            Ok::<(), io::Error>(())
        };
        let warn = warn.clone();
        let run = move || {
            let _alive = alive;
            if let Err(error) = runtime.block_on(serving) {
                warn(format!("--preview browser: the server failed: {error}"));
            }
        };
        (thread::Builder::new().name("browser".into()).spawn(run))
            .map_err(|e| failed("start a thread", &e))?;
        Ok(BrowserViewer {
            address,
            latest,
            stop,
            ended,
        })
    }

    /// The address of the page.
    pub(crate) fn address(&self) -> &str {
        &self.address
    }

    /// Hands over a picture. Never waits.
    pub(crate) fn show(&self, picture: Picture) {
        self.latest.send_replace(Some(Arc::new(picture)));
    }

    /// Waits until the open pages have received the last picture, up to `time`. The error is a
    /// warning.
    pub(crate) fn close(self, time: Duration) -> Result<(), String> {
        let has_pages = self.latest.receiver_count() > 0;
        let time = if has_pages { time } else { IDLE_TIME };
        let _ = self.stop.send(());
        match self.ended.recv_timeout(time) {
            Err(RecvTimeoutError::Timeout) if has_pages => {
                Err("a page in the browser did not receive the whole last picture".into())
            }
            _ => Ok(()),
        }
    }
}

/// Listens at `port` of the loopback interface, else, with a warning, at a free one.
fn listen(port: u16, warn: &Warn) -> io::Result<TcpListener> {
    let bind = |port| TcpListener::bind((Ipv4Addr::LOCALHOST, port));
    let listener = match bind(port) {
        Err(error) if port != 0 => {
            let listener = bind(0)?;
            let free = listener.local_addr()?.port();
            warn(format!(
                "--preview browser:{port}: the port is not available ({error}); port {free} is used instead"
            ));
            listener
        }
        result => result?,
    };
    listener.set_nonblocking(true)?;
    Ok(listener)
}

fn router(token: &str, info: &RenderInfo, latest: watch::Sender<Latest>) -> Router {
    let path = |name: &str| format!("/{token}/{name}");
    let file = |kind: &'static str, text: String| {
        let content = ([(header::CONTENT_TYPE, kind)], text);
        get(move || async move { content })
    };
    let root = path("");
    Router::new()
        .route(
            &format!("/{token}"),
            get(|| async move { Redirect::permanent(&root) }),
        )
        .route(&path(""), file("text/html; charset=utf-8", html(info)))
        .route(
            &path("page.css"),
            file("text/css", format!("{STYLE}{LIVE_STYLE}")),
        )
        .route(
            &path("shared.js"),
            file("text/javascript", SHARED_SCRIPT.into()),
        )
        .route(
            &path("live.js"),
            file("text/javascript", LIVE_SCRIPT.into()),
        )
        .route(&path("events/{layer}"), get(send_events))
        .with_state(latest)
        .fallback(|| async { StatusCode::NOT_FOUND })
        .layer(from_fn(check_sender))
        .layer(from_fn(add_headers))
}

async fn send_events(
    State(latest): State<watch::Sender<Latest>>,
    Path(layer): Path<String>,
    RawQuery(query): RawQuery,
    Extension(connection): Extension<ShowsPictures>,
) -> Response {
    if latest.receiver_count() >= MAX_PAGES {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many open pages\n").into_response();
    }
    connection.set();
    let lights = query.as_deref() == Some("lights");
    Sse::new(events(latest.subscribe(), Shown { layer, lights }))
        .keep_alive(KeepAlive::default())
        .into_response()
}

async fn add_headers(request: Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    for (name, value) in HEADERS {
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
    }
    response
}
