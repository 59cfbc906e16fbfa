//! Waiting for a render on the thread of the interpreter, which alone receives Ctrl-C.

use crate::errors::internal;
use manylight::film::Film;
use manylight::render::{Budget, Observer, Stats};
use manylight_cli::Interrupt;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// Longest time until Ctrl-C is noticed. People notice delays above a tenth of a second.
const TICK: Duration = Duration::from_millis(50);

/// A complete pass.
struct PassDone {
    passes: u32,
    /// Passes of the render; `None` if another limit ends it.
    total: Option<u32>,
    elapsed: Duration,
}

/// An observer that reports passes.
pub(crate) struct Reporter {
    sender: Sender<PassDone>,
    total: Option<u32>,
}

impl Observer for Reporter {
    fn begins(&mut self, budget: &Budget) {
        self.total = budget.passes;
    }

    fn pass_done(&mut self, _: &Film, stats: &Stats, elapsed: Duration) -> ControlFlow<()> {
        let passes = Stats::get(&stats.passes) as u32;
        let done = PassDone {
            passes,
            total: self.total,
            elapsed,
        };
        // The receiver lives as long as the render.
        let _ = self.sender.send(done);
        ControlFlow::Continue(())
    }
}

/// Runs `work` on another thread, without the lock of the interpreter. `progress` is called with
/// (passes, total passes or None, seconds) after each pass. Ctrl-C stops the render, and `work` then
/// returns what it has. The second value says whether this happened.
///
/// # Errors
/// An exception of `progress` or of a signal handler, after `work` has ended; or `work` panicked.
pub(crate) fn wait_for<T: Send>(
    py: Python<'_>,
    interrupt: &Interrupt,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&mut Reporter) -> T + Send,
) -> PyResult<(T, bool)> {
    let (sender, receiver) = channel();
    let receiver = Mutex::new(Some(receiver));
    let mut keyboard = false;
    let mut failure = None;
    let result = std::thread::scope(|scope| {
        let total = None;
        let worker = scope.spawn(move || work(&mut Reporter { sender, total }));
        loop {
            match next(py, &receiver) {
                Ok(pass) => {
                    if failure.is_none()
                        && let Some(progress) = progress
                    {
                        let seconds = pass.elapsed.as_secs_f64();
                        failure = progress.call1((pass.passes, pass.total, seconds)).err();
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            match py.check_signals() {
                Err(error) if error.is_instance_of::<PyKeyboardInterrupt>(py) => {
                    keyboard = true;
                    interrupt.stop();
                }
                Err(error) => failure = Some(error),
                Ok(()) => {}
            }
            if failure.is_some() {
                interrupt.stop();
            }
        }
        py.detach(|| worker.join())
    });
    match (result, failure) {
        (_, Some(error)) => Err(error),
        (Ok(value), None) => Ok((value, keyboard)),
        (Err(_), None) => Err(internal(py)),
    }
}

/// The next item of a receiver that is closed when the render ends; `None` is a closed one.
pub(crate) fn next<T: Send>(
    py: Python<'_>,
    receiver: &Mutex<Option<Receiver<T>>>,
) -> Result<T, RecvTimeoutError> {
    py.detach(|| match receiver.lock().as_deref() {
        Ok(Some(receiver)) => receiver.recv_timeout(TICK),
        _ => Err(RecvTimeoutError::Disconnected),
    })
}
