//! Child processes with a time limit.
//!
//! Each render runs in a separate process, so that its peak memory and times are not affected by
//! other renders.

use std::fs::File;
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time between two checks of the state of a child: 2 % of a run of one second.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Shortest time between the interrupt signal and the kill: a render finishes its pass, and writes
/// its image.
const MIN_GRACE: Duration = Duration::from_secs(5);

/// How a child process ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// It ended by itself with this exit code; `None` if a signal ended it.
    Exited(Option<i32>),
    /// It was stopped at its time limit.
    Stopped,
    /// It was killed because the study was interrupted.
    Interrupted,
}

/// A child process that has ended.
#[derive(Debug)]
pub(super) struct FinishedProcess {
    /// How it ended.
    pub(super) ending: Ending,
    /// Its standard output.
    pub(super) stdout: String,
    /// Its standard error.
    pub(super) stderr: String,
    /// Time from its start to its end in seconds.
    pub(super) seconds: f64,
}

/// Runs `command` to its end. At the time `limit` it receives an interrupt signal; if it does not
/// end within a tenth of the limit and at least [`MIN_GRACE`], it is killed. When `interrupted`
/// becomes true, it is killed at once. Its output is collected in files in `folder`.
///
/// # Errors
/// The process cannot be started, or the files cannot be written or read.
pub(super) fn spawn_and_wait(
    command: &mut Command,
    limit: Option<Duration>,
    interrupted: &AtomicBool,
    folder: &Path,
) -> io::Result<FinishedProcess> {
    // Files, because a full pipe would block the child.
    let (stdout, stderr) = (folder.join("stdout"), folder.join("stderr"));
    let start = Instant::now();
    let mut child = command
        .stdin(Stdio::null())
        .stdout(File::create(&stdout)?)
        .stderr(File::create(&stderr)?)
        .spawn()?;
    let ending = wait(&mut child, limit, interrupted);
    if ending.is_err() {
        // The state of the child is unknown; it must not go on running.
        let _ = child.kill();
    }
    let text = |path| std::fs::read(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    Ok(FinishedProcess {
        ending: ending?,
        seconds: start.elapsed().as_secs_f64(),
        stdout: text(&stdout)?,
        stderr: text(&stderr)?,
    })
}

fn wait(
    child: &mut Child,
    limit: Option<Duration>,
    interrupted: &AtomicBool,
) -> io::Result<Ending> {
    let Some(limit) = limit else {
        let status = wait_until(child, None, interrupted)?;
        return Ok(status.map_or(Ending::Interrupted, exited));
    };
    let deadline = Instant::now() + limit;
    if let Some(status) = wait_until(child, Some(deadline), interrupted)? {
        return Ok(exited(status));
    }
    if interrupted.load(Ordering::Relaxed) {
        return Ok(Ending::Interrupted);
    }
    request_end(child)?;
    let grace = deadline + (limit / 10).max(MIN_GRACE);
    let status = wait_until(child, Some(grace), interrupted)?;
    if interrupted.load(Ordering::Relaxed) {
        return Ok(Ending::Interrupted);
    }
    if status.is_none() {
        child.kill()?;
        child.wait()?;
    }
    // It may have ended by itself before the signal arrived.
    Ok(match status {
        Some(status) if status.success() => exited(status),
        _ => Ending::Stopped,
    })
}

fn exited(status: ExitStatus) -> Ending {
    Ending::Exited(status.code())
}

/// Waits until the child has ended. `None` if `deadline` has passed, or if an interrupt has killed
/// the child.
fn wait_until(
    child: &mut Child,
    deadline: Option<Instant>,
    interrupted: &AtomicBool,
) -> io::Result<Option<ExitStatus>> {
    loop {
        if interrupted.load(Ordering::Relaxed) {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            return Ok(None);
        }
        std::thread::sleep(POLL_INTERVAL);
    }
}

/// Sends the interrupt signal.
#[cfg(unix)]
fn request_end(child: &Child) -> io::Result<()> {
    let id = i32::try_from(child.id())
        .ok()
        .and_then(rustix::process::Pid::from_raw);
    match id {
        Some(id) => Ok(rustix::process::kill_process(
            id,
            rustix::process::Signal::INT,
        )?),
        None => Ok(()),
    }
}

/// Without signals: the caller kills the child after the grace time.
#[cfg(not(unix))]
fn request_end(_child: &Child) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    fn run(script: &str, limit: Option<Duration>, interrupted: bool) -> FinishedProcess {
        let folder = tempfile::tempdir().unwrap();
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        spawn_and_wait(
            &mut command,
            limit,
            &AtomicBool::new(interrupted),
            folder.path(),
        )
        .unwrap()
    }

    #[test]
    fn a_child_ends_by_itself() {
        let ended = run("echo a; echo b >&2; exit 3", None, false);
        assert_eq!(ended.ending, Ending::Exited(Some(3)));
        assert_eq!((ended.stdout.trim(), ended.stderr.trim()), ("a", "b"));
        let limit = Some(Duration::from_secs(60));
        assert_eq!(run("exit 0", limit, false).ending, Ending::Exited(Some(0)));
    }

    #[test]
    fn a_child_beyond_its_limit_is_interrupted() {
        let script = "trap 'echo interrupted; exit 130' INT; while :; do sleep 0.02; done";
        let ended = run(script, Some(Duration::from_millis(300)), false);
        assert_eq!(
            (ended.ending, ended.stdout.trim()),
            (Ending::Stopped, "interrupted")
        );
        assert!(ended.seconds < 5.0, "{}", ended.seconds);
    }

    #[test]
    fn an_interrupt_kills_the_child() {
        let ended = run("sleep 60", None, true);
        assert_eq!(ended.ending, Ending::Interrupted);
        assert!(ended.seconds < 10.0);
    }
}
