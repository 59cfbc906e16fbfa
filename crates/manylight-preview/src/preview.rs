//! The preview of a render: a viewer, and how often it gets a picture.

use crate::browser::BrowserViewer;
use crate::pace::Pace;
use crate::picture::{Picture, RenderInfo};
use crate::target::{PreviewTarget, Warn};
use crate::tev::TevViewer;
use std::fmt;
use std::time::{Duration, Instant};

/// Longest time that the end of the program waits for a viewer to receive the final picture.
const LAST_PICTURE_TIME: Duration = Duration::from_secs(5);

/// Shows the growing picture of one render. Nothing here fails: what goes wrong is a warning.
pub struct Preview {
    viewer: Viewer,
    pace: Pace,
    warn: Warn,
}

enum Viewer {
    Tev(TevViewer),
    Browser(BrowserViewer),
}

impl Preview {
    /// Starts the thread that connects to the viewer or serves the page. `None`, with a warning, if
    /// the system refuses that.
    pub fn start(target: &PreviewTarget, info: RenderInfo, warn: Warn) -> Option<Self> {
        let viewer = match target {
            PreviewTarget::Tev(address) => {
                TevViewer::start(address.clone(), info.name, warn.clone())
                    .map(Viewer::Tev)
                    .map_err(|error| format!("--preview tev: cannot start a thread: {error}"))
            }
            PreviewTarget::Browser { port } => {
                BrowserViewer::start(*port, info, &warn).map(Viewer::Browser)
            }
        };
        match viewer {
            Ok(viewer) => Some(Preview {
                viewer,
                pace: Pace::default(),
                warn,
            }),
            Err(warning) => {
                warn(warning);
                None
            }
        }
    }

    /// The address of the page in the browser; `None` for other viewers.
    pub fn address(&self) -> Option<&str> {
        match &self.viewer {
            Viewer::Tev(_) => None,
            Viewer::Browser(viewer) => Some(viewer.address()),
        }
    }

    /// Shows the picture that `make` makes, if one is due and somebody may look. Never waits for
    /// the viewer.
    pub fn update(&mut self, make: impl FnOnce() -> Picture) {
        let start = Instant::now();
        if self.is_wanted() && self.pace.is_due(start) {
            self.show(make());
            self.pace.note(start, Instant::now());
        }
    }

    /// Shows the final picture. Does not wait until the viewer has received it.
    pub fn finish(&mut self, make: impl FnOnce() -> Picture) {
        if self.is_wanted() {
            self.show(make());
        }
    }

    /// Waits a few seconds at most until the viewer has received the final picture.
    pub fn close(self) {
        let closed = match self.viewer {
            Viewer::Tev(viewer) => viewer.close(LAST_PICTURE_TIME),
            Viewer::Browser(viewer) => viewer.close(LAST_PICTURE_TIME),
        };
        if let Err(warning) = closed {
            (self.warn)(format!("--preview: {warning}"));
        }
    }

    fn is_wanted(&self) -> bool {
        match &self.viewer {
            Viewer::Tev(viewer) => viewer.is_wanted(),
            Viewer::Browser(_) => true,
        }
    }

    fn show(&self, picture: Picture) {
        match &self.viewer {
            Viewer::Tev(viewer) => viewer.show(picture),
            Viewer::Browser(viewer) => viewer.show(picture),
        }
    }
}

impl fmt::Debug for Preview {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match &self.viewer {
            Viewer::Tev(_) => "tev",
            Viewer::Browser(viewer) => viewer.address(),
        };
        f.debug_tuple("Preview").field(&name).finish()
    }
}
