//! The thread that sends pictures to tev.
//!
//! The render puts pictures into a mailbox and goes on. A picture that the thread has not begun to
//! send is replaced by the next one. Pictures are wanted only while a viewer is connected: without
//! one they are not even made.

use super::packets::{channel_names, create_image, tiles, update_image};
use crate::mailbox::{Mailbox, Taken};
use crate::picture::{Picture, RenderState};
use crate::target::TevAddress;
use crate::target::Warn;
use std::io::{self, ErrorKind, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

/// Longest time to connect to one address of the host.
const CONNECT_TIME: Duration = Duration::from_secs(2);

/// Longest time in which a viewer may read nothing.
const WRITE_TIME: Duration = Duration::from_secs(5);

/// Time between two attempts to connect.
const RETRY_TIME: Duration = Duration::from_secs(3);

/// Longest time that the end of the program waits for the first attempt to connect.
const LATE_CONNECT_TIME: Duration = Duration::from_millis(500);

/// Whether a viewer is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
enum Presence {
    /// The first attempt to connect has no result yet.
    Unknown,
    Connected,
    Absent,
}

/// What the thread and the render share.
#[derive(Debug)]
struct Shared {
    mailbox: Mailbox<Picture>,
    presence: AtomicU8,
}

impl Shared {
    fn presence(&self) -> Presence {
        match self.presence.load(Ordering::Acquire) {
            x if x == Presence::Unknown as u8 => Presence::Unknown,
            x if x == Presence::Connected as u8 => Presence::Connected,
            _ => Presence::Absent,
        }
    }

    fn set(&self, presence: Presence) {
        self.presence.store(presence as u8, Ordering::Release);
    }
}

/// The sending side of a connection to tev.
#[derive(Debug)]
pub(crate) struct TevViewer {
    shared: Arc<Shared>,
    /// Is disconnected when the thread ends.
    ended: Receiver<()>,
    address: TevAddress,
}

impl TevViewer {
    /// Starts a thread that connects. `name` is the name of the image in tev.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub(crate) fn start(address: TevAddress, name: String, warn: Warn) -> io::Result<Self> {
        let shared = Arc::new(Shared {
            mailbox: Mailbox::new(),
            presence: AtomicU8::new(Presence::Unknown as u8),
        });
        let (alive, ended) = channel();
        let sender = Sender {
            shared: shared.clone(),
            address: address.clone(),
            name,
            warn,
            warned: false,
        };
        thread::Builder::new().name("tev".into()).spawn(move || {
            let _alive = alive;
            sender.run();
        })?;
        Ok(TevViewer {
            shared,
            ended,
            address,
        })
    }

    /// Whether a viewer is connected, or may be connected soon.
    pub(crate) fn is_wanted(&self) -> bool {
        self.shared.presence() != Presence::Absent
    }

    /// Hands over a picture. Never waits.
    pub(crate) fn show(&self, picture: Picture) {
        self.shared.mailbox.put(picture);
    }

    /// Waits until the last picture is sent, up to `time`. The error is a warning.
    pub(crate) fn close(self, time: Duration) -> Result<(), String> {
        self.shared.mailbox.close();
        if self.shared.presence() == Presence::Unknown {
            let _ = self.ended.recv_timeout(LATE_CONNECT_TIME.min(time));
        }
        match self.shared.presence() {
            Presence::Absent => Ok(()),
            Presence::Unknown => Err(format!("tev at {} does not answer", self.address)),
            Presence::Connected => match self.ended.recv_timeout(time) {
                Err(std::sync::mpsc::RecvTimeoutError::Timeout) => Err(format!(
                    "tev at {} reads slowly; it did not receive the whole last picture",
                    self.address
                )),
                _ => Ok(()),
            },
        }
    }
}

/// The state of the thread.
struct Sender {
    shared: Arc<Shared>,
    address: TevAddress,
    name: String,
    warn: Warn,
    /// Whether the user knows that there is no viewer.
    warned: bool,
}

/// An open connection, and the image created over it.
struct Connection {
    stream: TcpStream,
    /// Size and channels of the image in tev.
    created: Option<(usize, usize, Vec<String>)>,
}

impl Sender {
    fn run(mut self) {
        let mut connection = self.connect();
        loop {
            match self.shared.mailbox.take(RETRY_TIME) {
                Taken::Closed => break,
                Taken::Nothing if connection.is_none() => connection = self.connect(),
                Taken::Nothing => {}
                Taken::Item(picture) => {
                    let Some(open) = &mut connection else {
                        continue;
                    };
                    let Err(error) = self.send(open, &picture) else {
                        continue;
                    };
                    connection = None;
                    self.shared.set(Presence::Absent);
                    if is_timeout(&error) {
                        // A new connection would block in the same way, as soon as the buffers of
                        // the system are full.
                        self.warn_once(format_args!(
                            "reads nothing for {} s; it gets no more pictures",
                            WRITE_TIME.as_secs()
                        ));
                        return;
                    }
                    self.warn_once(format_args!("has gone away ({error})"));
                }
            }
        }
        if let Some(open) = connection {
            // The system delivers what is written, also after the end of the program.
            let _ = open.stream.shutdown(Shutdown::Write);
        }
    }

    /// A connection; `None`, with one warning per run, if nothing listens.
    fn connect(&mut self) -> Option<Connection> {
        match connect(&self.address) {
            Ok(stream) => {
                self.shared.set(Presence::Connected);
                Some(Connection {
                    stream,
                    created: None,
                })
            }
            Err(error) => {
                self.shared.set(Presence::Absent);
                self.warn_once(format_args!(
                    "does not answer ({error}); the picture appears there when it does"
                ));
                None
            }
        }
    }

    fn send(&self, connection: &mut Connection, picture: &Picture) -> io::Result<()> {
        let Connection { stream, created } = connection;
        let shape = (picture.width, picture.height, channel_names(picture));
        if created.as_ref() != Some(&shape) {
            stream.write_all(&create_image(&self.name, picture))?;
            *created = Some(shape);
        }
        for tile in tiles(picture.width, picture.height) {
            let is_final = picture.progress.state != RenderState::Rendering;
            if !is_final && self.shared.mailbox.is_closed() {
                // The program waits for the final picture.
                break;
            }
            stream.write_all(&update_image(&self.name, picture, tile))?;
        }
        Ok(())
    }

    fn warn_once(&mut self, what: std::fmt::Arguments) {
        if !std::mem::replace(&mut self.warned, true) {
            (self.warn)(format!("--preview: tev at {} {what}", self.address));
        }
    }
}

fn connect(address: &TevAddress) -> io::Result<TcpStream> {
    let mut last = io::Error::new(ErrorKind::NotFound, "the host has no address");
    for socket in (address.host.as_str(), address.port).to_socket_addrs()? {
        match TcpStream::connect_timeout(&socket, CONNECT_TIME) {
            Ok(stream) => {
                stream.set_write_timeout(Some(WRITE_TIME))?;
                stream.set_nodelay(true)?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Whether a write ended because of its time limit; the kind depends on the system.
fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)
}
