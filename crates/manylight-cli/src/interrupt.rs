//! Handling of SIGINT and SIGTERM: the first signal ends the render with an image, the second ends the program at once.

use crate::failure::Failure;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The state of received signals.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interrupt {
    cancel: Arc<AtomicBool>,
    signal: Arc<AtomicI32>,
    writing: Arc<Mutex<()>>,
}

impl Interrupt {
    /// Starts to listen for signals.
    pub(crate) fn install() -> Result<Self, Failure> {
        let interrupt = Interrupt::default();
        interrupt
            .listen()
            .map_err(|error| Failure::Internal(format!("cannot listen for signals: {error}")))?;
        Ok(interrupt)
    }

    #[cfg(unix)]
    fn listen(&self) -> std::io::Result<()> {
        let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM])?;
        let interrupt = self.clone();
        std::thread::Builder::new()
            .name("signals".into())
            .spawn(move || {
                for signal in signals.forever() {
                    interrupt.receive(signal);
                }
            })?;
        Ok(())
    }

    #[cfg(not(unix))]
    fn listen(&self) -> std::io::Result<()> {
        for signal in [SIGINT, SIGTERM] {
            signal_hook::flag::register_conditional_shutdown(
                signal,
                128 + signal,
                self.cancel.clone(),
            )?;
            signal_hook::flag::register(signal, self.cancel.clone())?;
        }
        self.signal.store(SIGINT, Ordering::Relaxed);
        Ok(())
    }

    #[cfg(unix)]
    fn receive(&self, signal: i32) {
        if self.cancel.load(Ordering::Relaxed) {
            // Waits for a file that is being written, so that it is complete.
            let _writing = self.writing();
            std::process::exit(128 + signal);
        }
        self.signal.store(signal, Ordering::Relaxed);
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// Becomes true with the first signal.
    pub(crate) fn cancel(&self) -> &AtomicBool {
        &self.cancel
    }

    /// Delays the second signal while the guard lives.
    pub(crate) fn writing(&self) -> MutexGuard<'_, ()> {
        self.writing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The exit code of the first signal, 128 plus its number; `None` without a signal.
    pub(crate) fn exit_code(&self) -> Option<u8> {
        let signal = self.signal.load(Ordering::Relaxed);
        let code = u8::try_from(128 + signal).ok()?;
        self.cancel.load(Ordering::Relaxed).then_some(code)
    }
}
