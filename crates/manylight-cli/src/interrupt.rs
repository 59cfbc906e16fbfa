//! Handling of SIGINT, SIGTERM, and SIGHUP (the terminal was closed): the first signal ends the
//! render with an image, the second ends the program at once, or when a file that is being written
//! is complete. The third signal does not wait for that file. While the image is denoised, one
//! signal more writes it with its noise.

use crate::failure::Failure;
#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The state of received signals.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    cancel: Arc<AtomicBool>,
    signal: Arc<AtomicI32>,
    writing: Arc<Mutex<()>>,
    /// Whether the image is being denoised.
    denoising: Arc<AtomicBool>,
    /// Ends denoising; the image stays noisy.
    skip_denoising: Arc<AtomicBool>,
    /// Whether the program ends when the file that is being written is complete.
    ending: Arc<AtomicBool>,
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
        let mut signals = signal_hook::iterator::Signals::new(listened())?;
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
            let denoising = self.denoising.load(Ordering::Relaxed);
            if denoising && !self.skip_denoising.swap(true, Ordering::Relaxed) {
                return;
            }
            self.end(128 + signal);
            return;
        }
        self.signal.store(signal, Ordering::Relaxed);
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// Ends the program when a file that is being written is complete; at once when it is called
    /// again.
    #[cfg(unix)]
    fn end(&self, code: i32) {
        if self.ending.swap(true, Ordering::Relaxed) {
            std::process::exit(code);
        }
        let interrupt = self.clone();
        let wait = move || {
            let _complete_file = interrupt.writing();
            std::process::exit(code);
        };
        if std::thread::Builder::new().spawn(wait).is_err() {
            std::process::exit(code);
        }
    }

    /// Does what a signal does, without an end of the program.
    pub fn stop(&self) {
        if self.cancel.swap(true, Ordering::Relaxed) && self.denoising.load(Ordering::Relaxed) {
            self.skip_denoising.store(true, Ordering::Relaxed);
        }
    }

    /// Becomes true with the first signal.
    pub(crate) fn cancel(&self) -> &AtomicBool {
        &self.cancel
    }

    /// Runs `work`, which denoises. A second signal does not end the program meanwhile, but makes
    /// the argument of `work` true.
    pub(crate) fn denoising<T>(&self, work: impl FnOnce(&AtomicBool) -> T) -> T {
        self.denoising.store(true, Ordering::Relaxed);
        let result = work(&self.skip_denoising);
        self.denoising.store(false, Ordering::Relaxed);
        result
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

/// Makes the system report a file that exceeds the limit of the user as an error. By default it
/// kills the program, and a file that is being written would stay.
#[cfg(unix)]
pub(crate) fn survive_file_limit() {
    // Without it, such a file kills the program as before.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
}

/// Other systems have no such limit.
#[cfg(not(unix))]
pub(crate) fn survive_file_limit() {}

/// The signals that save the image. `nohup` ignores SIGHUP, which stays so.
#[cfg(unix)]
fn listened() -> Vec<i32> {
    let mut signals = vec![SIGINT, SIGTERM];
    if ignores_hangup() == Some(false) {
        signals.push(SIGHUP);
    }
    signals
}

/// Whether the process ignores SIGHUP; `None` if the system does not tell.
#[cfg(unix)]
fn ignores_hangup() -> Option<bool> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let mask = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))?;
    let mask = u64::from_str_radix(mask.trim(), 16).ok()?;
    Some((mask >> (SIGHUP - 1)) & 1 == 1)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_second_signal_skips_denoising() {
        let interrupt = Interrupt::default();
        interrupt.receive(SIGINT);
        interrupt.denoising(|skip| {
            assert!(!skip.load(Ordering::Relaxed));
            interrupt.receive(SIGINT);
            assert!(skip.load(Ordering::Relaxed));
        });
        assert_eq!(interrupt.exit_code(), Some(130));
    }
}
