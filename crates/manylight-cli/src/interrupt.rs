//! SIGINT and SIGTERM: the first asks the render to end with an image, the second ends the program at once.

use crate::failure::Failure;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a signal asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interrupt {
    cancel: Arc<AtomicBool>,
    signal: Arc<AtomicI32>,
    writing: Arc<Mutex<()>>,
}

impl Interrupt {
    /// Listens for signals from now on.
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
            // A file that is being written is finished first: it takes a moment, and leaves no half file.
            let _writing = self.writing();
            std::process::exit(128 + signal);
        }
        self.signal.store(signal, Ordering::Relaxed);
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// Turns true with the first signal.
    pub(crate) fn cancel(&self) -> &AtomicBool {
        &self.cancel
    }

    /// While the guard lives, a second signal waits.
    pub(crate) fn writing(&self) -> MutexGuard<'_, ()> {
        self.writing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The exit code that the first signal asks for.
    pub(crate) fn exit_code(&self) -> Option<u8> {
        let signal = self.signal.load(Ordering::Relaxed);
        let code = u8::try_from(128 + signal).ok()?;
        self.cancel.load(Ordering::Relaxed).then_some(code)
    }
}
