//! A run is a process of its own: its memory and its times are nobody else's.

use std::fs::File;
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time between two looks at the child.
const TICK: Duration = Duration::from_millis(20);

/// How a child ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// By itself, with this exit code; `None` if a signal ended it.
    Exited(Option<i32>),
    /// It took longer than it may.
    Stopped,
    /// The study was interrupted, and the child with it.
    Interrupted,
}

/// A child that has ended.
#[derive(Debug)]
pub(crate) struct Ended {
    /// How.
    pub(crate) ending: Ending,
    /// What it wrote to standard output.
    pub(crate) stdout: String,
    /// What it wrote to standard error.
    pub(crate) stderr: String,
    /// How long it ran.
    pub(crate) seconds: f64,
}

/// Runs `command` to its end. Beyond `limit` it is asked to end, as by Ctrl-C, and killed if it does not within a tenth of the
/// limit; once `interrupted` is true, it is killed. What it writes goes by way of `folder`.
///
/// # Errors
/// The system refuses the process or the files.
pub(crate) fn spawn_and_wait(
    command: &mut Command,
    limit: Option<Duration>,
    interrupted: &AtomicBool,
    folder: &Path,
) -> io::Result<Ended> {
    // Files take what pipes would hold up while nobody reads.
    let (stdout, stderr) = (folder.join("stdout"), folder.join("stderr"));
    let start = Instant::now();
    let mut child = command
        .stdin(Stdio::null())
        .stdout(File::create(&stdout)?)
        .stderr(File::create(&stderr)?)
        .spawn()?;
    let ending = wait(&mut child, limit, interrupted);
    if ending.is_err() {
        // Nothing is known about the child any more, but it shall not stay.
        let _ = child.kill();
    }
    let text = |path| std::fs::read(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    Ok(Ended {
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
    ask_to_end(child)?;
    let grace = deadline + (limit / 10).max(Duration::from_secs(5));
    let status = wait_until(child, Some(grace), interrupted)?;
    if interrupted.load(Ordering::Relaxed) {
        return Ok(Ending::Interrupted);
    }
    if status.is_none() {
        child.kill()?;
        child.wait()?;
    }
    // It may have ended by itself before it was asked to.
    Ok(match status {
        Some(status) if status.success() => exited(status),
        _ => Ending::Stopped,
    })
}

fn exited(status: ExitStatus) -> Ending {
    Ending::Exited(status.code())
}

/// Waits until the child has ended, `None` if `deadline` has passed. An interrupt kills the child, and is `None` as well.
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
        std::thread::sleep(TICK);
    }
}

#[cfg(unix)]
fn ask_to_end(child: &Child) -> io::Result<()> {
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

/// There is no way to ask; the caller kills it after its time of grace.
#[cfg(not(unix))]
fn ask_to_end(_child: &Child) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    fn run(script: &str, limit: Option<Duration>, interrupted: bool) -> Ended {
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
    fn a_child_beyond_its_limit_is_asked_to_end() {
        let script = "trap 'echo asked; exit 130' INT; while :; do sleep 0.02; done";
        let ended = run(script, Some(Duration::from_millis(300)), false);
        assert_eq!(
            (ended.ending, ended.stdout.trim()),
            (Ending::Stopped, "asked")
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
