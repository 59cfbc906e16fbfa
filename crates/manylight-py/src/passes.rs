//! Iteration over the passes of a render.

use crate::errors::{exception, internal, usage};
use crate::image::Image;
use crate::scene::Scene;
use crate::waiting::next;
use manylight::film::Film;
use manylight::render::{Observer, Stats};
use manylight_cli::embed::Picture;
use manylight_cli::{Failure, Interrupt, Session};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Pictures that may wait for the program. With none, one pass is rendered while the program looks
/// at the picture of the pass before.
const WAITING_PICTURES: usize = 0;

/// An iterator over the pictures after each pass. Another thread renders the next pass meanwhile.
#[pyclass(frozen, module = "manylight._native")]
pub(crate) struct Passes {
    /// Pictures of the thread; `None` if no more are wanted.
    pictures: Mutex<Option<Receiver<Picture>>>,
    interrupt: Interrupt,
    /// The thread that renders; `None` when its end is known.
    thread: Mutex<Option<JoinHandle<Result<(), Failure>>>>,
    label: Option<String>,
    /// Whether the words of the render name files that last.
    files_stay: bool,
}

/// An observer that hands over pictures.
struct Pictures<'s> {
    session: &'s Session,
    sender: SyncSender<Picture>,
}

impl Observer for Pictures<'_> {
    fn pass_done(&mut self, film: &Film, _: &Stats, _: Duration) -> ControlFlow<()> {
        match self.sender.send(self.session.picture(film)) {
            Ok(()) => ControlFlow::Continue(()),
            // Nobody waits for another picture.
            Err(_) => ControlFlow::Break(()),
        }
    }
}

/// Starts to render a scene. `words` are options of `manylight render`; `files_stay` as for `render`.
#[pyfunction]
#[pyo3(signature = (scene, words, files_stay=true))]
pub(crate) fn passes(
    py: Python<'_>,
    scene: &Scene,
    words: Vec<String>,
    files_stay: bool,
) -> PyResult<Passes> {
    let held = scene.held();
    let session = py
        .detach(|| held.session(&words))
        .map_err(|failure| exception(py, &failure))?;
    if session.denoises() {
        return Err(usage(
            py,
            "denoise: the picture after each pass is not denoised",
            "denoise the picture of a whole render, by `render`",
        ));
    }
    let (sender, receiver) = sync_channel(WAITING_PICTURES);
    let interrupt = Interrupt::default();
    let stop = interrupt.clone();
    let thread = std::thread::spawn(move || {
        let session = session;
        let mut observer = Pictures {
            session: &session,
            sender,
        };
        session.render(&stop, &mut observer).map(|_| ())
    });
    Ok(Passes {
        pictures: Mutex::new(Some(receiver)),
        interrupt,
        thread: Mutex::new(Some(thread)),
        label: scene.label().map(str::to_owned),
        files_stay,
    })
}

#[pymethods]
impl Passes {
    fn __iter__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Image>> {
        loop {
            match next(py, &self.pictures) {
                Ok(picture) => {
                    let image = Image::new(picture, false, self.label.as_deref());
                    return Ok(Some(match self.files_stay {
                        true => image,
                        false => image.without_command(),
                    }));
                }
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(signal) = py.check_signals() {
                        self.stop();
                        return Err(signal);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => return self.end(py).map(|()| None),
            }
        }
    }

    /// Stops the render. Further pictures are not made.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| self.stop());
        self.end(py)
    }
}

impl Passes {
    /// Ends the thread after its pass.
    fn stop(&self) {
        self.interrupt.stop();
        // A thread that hands over a picture waits for this receiver.
        if let Ok(mut pictures) = self.pictures.lock() {
            *pictures = None;
        }
    }

    /// Waits for the thread, and says why it ended, once.
    fn end(&self, py: Python<'_>) -> PyResult<()> {
        let thread = self.thread.lock().ok().and_then(|mut thread| thread.take());
        let Some(thread) = thread else {
            return Ok(());
        };
        match py.detach(|| thread.join()) {
            Ok(result) => result.map_err(|failure| exception(py, &failure)),
            Err(_) => Err(internal(py)),
        }
    }
}

impl Drop for Passes {
    fn drop(&mut self) {
        self.stop();
    }
}
