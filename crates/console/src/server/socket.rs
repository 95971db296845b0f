//! The WebSocket of a page: one thread reads its messages, another writes the frames that wait for it.

use std::cell::Cell;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::unix::net::UnixStream;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use tungstenite::protocol::frame::coding::{CloseCode, Data, OpCode};
use tungstenite::protocol::frame::{CloseFrame, Frame as WebFrame};
use tungstenite::protocol::{Message, Role, WebSocketConfig};
use tungstenite::{Error, WebSocket};

use super::{Count, PATIENCE, PageId, Shared, ToHub};
use crate::message::{FromPage, PageCommand};

/// Maximum length of a message that is not a show, bytes.
const MESSAGE_MAX: usize = 4096;
/// Maximum number of frames that wait for a page. A page that does not read them in time is disconnected.
const WAITING_MAX: usize = 64;
/// Interval of the server's pings, and the number of pings without an answer after which a page counts as gone.
const PING_EVERY: Duration = Duration::from_secs(1);
const PINGS_MAX: u32 = 8;
/// Time without a complete message after which a page counts as gone.
const SILENT_MAX: Duration = Duration::from_secs(10);
/// Code with which a WebSocket is closed if the token is wrong.
const WRONG_TOKEN: u16 = 4001;

/// The bytes of a WebSocket frame, shared by all pages that get it.
pub(crate) type Frame = Arc<[u8]>;

/// Returns a text as a frame.
pub(crate) fn text(text: String) -> Frame {
    frame(WebFrame::message(text.into_bytes(), OpCode::Data(Data::Text), true))
}

/// Returns bytes as a frame.
pub(crate) fn binary(bytes: Vec<u8>) -> Frame {
    frame(WebFrame::message(bytes, OpCode::Data(Data::Binary), true))
}

/// Returns the text of a frame; `None` for a frame with other content.
pub(crate) fn text_of(frame: &[u8]) -> Option<&[u8]> {
    let [kind, length, ..] = frame else { return None };
    // A length above 125 has two or eight more bytes.
    let head = match length {
        127 => 10,
        126 => 4,
        _ => 2,
    };
    (kind & 0x0F == 1).then(|| frame.get(head..))?
}

fn frame(frame: WebFrame) -> Frame {
    let mut bytes = Vec::with_capacity(frame.len());
    // A vector takes all bytes.
    let _ = frame.format(&mut bytes);
    bytes.into()
}

/// The queue of frames for a page.
#[derive(Debug, Clone)]
pub(crate) struct Outbox {
    frames: SyncSender<Frame>,
    way: Way,
}

/// The connection of an outbox.
#[derive(Debug, Clone)]
pub(crate) enum Way {
    Page(Arc<TcpStream>),
    /// A program that drives.
    Program(Arc<UnixStream>),
}

impl Outbox {
    /// Creates an outbox, and the queue of its frames.
    pub(crate) fn new(way: Way) -> (Self, Receiver<Frame>) {
        let (frames, waiting) = sync_channel(WAITING_MAX);
        (Self { frames, way }, waiting)
    }

    /// Queues a frame. Disconnects the page if the queue is full.
    pub(crate) fn send(&self, frame: &Frame) {
        if let Err(TrySendError::Full(_)) = self.frames.try_send(Arc::clone(frame)) {
            // Shutdown fails only if the connection is already over.
            let _ = match &self.way {
                Way::Page(stream) => stream.shutdown(Shutdown::Both),
                Way::Program(stream) => stream.shutdown(Shutdown::Both),
            };
        }
    }

    /// Closes the page's WebSocket after the frames that wait are written.
    fn close(&self, code: CloseCode, reason: &'static str) {
        self.send(&frame(WebFrame::close(Some(CloseFrame { code, reason: reason.into() }))));
    }
}

/// The reading end of a connection, with a deadline. Frames that the protocol itself sends go to the outbox.
pub(super) struct Reader {
    stream: TcpStream,
    deadline: Rc<Cell<Instant>>,
    out: Option<Outbox>,
}

impl Reader {
    pub(super) fn new(stream: TcpStream, deadline: Instant) -> Self {
        Self { stream, deadline: Rc::new(Cell::new(deadline)), out: None }
    }
}

impl Read for Reader {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let left = self.deadline.get().saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        self.stream.set_read_timeout(Some(left))?;
        self.stream.read(into).map_err(|error| match error.kind() {
            io::ErrorKind::WouldBlock => io::ErrorKind::TimedOut.into(),
            _ => error,
        })
    }
}

impl Write for Reader {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // The protocol writes whole frames.
        if let Some(out) = &self.out {
            out.send(&bytes.into());
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Serves a page until it leaves, is silent for too long or breaks a rule.
pub(super) fn serve(
    stream: TcpStream,
    mut reader: Reader,
    rest: Vec<u8>,
    (page, may_drive): (PageId, bool),
    stranger: Count,
    shared: &Shared,
) -> io::Result<()> {
    let (out, waiting) = Outbox::new(Way::Page(Arc::new(stream.try_clone()?)));
    let deadline = Rc::clone(&reader.deadline);
    deadline.set(Instant::now() + PATIENCE);
    reader.out = Some(out.clone());
    let pings = Arc::new(AtomicU32::new(0));
    let of_writer = Arc::clone(&pings);
    let writer = thread::Builder::new().name("page writer".to_owned());
    let writer = writer.spawn(move || write_all(stream, &waiting, &of_writer))?;
    let config = WebSocketConfig::default()
        .read_buffer_size(MESSAGE_MAX)
        .write_buffer_size(0)
        .max_message_size(Some(MESSAGE_MAX))
        .max_frame_size(Some(MESSAGE_MAX));
    let mut socket = WebSocket::from_partially_read(reader, rest, Role::Server, Some(config));
    if says_hello(&mut socket, shared) {
        drop(stranger);
        let joined = ToHub::Joined { page, out: out.clone(), may_drive };
        if shared.hub.send(joined).is_ok() {
            let ended = listen(&mut socket, page, shared, (&deadline, &pings));
            if let Err(Error::Capacity(_)) = ended {
                out.close(CloseCode::Size, "the message is too long");
            }
            // Without a hub there is nothing to report.
            let _ = shared.hub.send(ToHub::Left { page });
        }
    } else {
        out.close(CloseCode::from(WRONG_TOKEN), "the token is not this console's");
    }
    drop((socket, out));
    let _ = writer.join();
    Ok(())
}

/// Reads the first message. Returns whether it is a hello with the token.
fn says_hello(socket: &mut WebSocket<Reader>, shared: &Shared) -> bool {
    let Ok(Message::Text(text)) = socket.read() else { return false };
    let Ok(message) = serde_json::from_str::<FromPage>(&text) else { return false };
    matches!(message.command, PageCommand::Hello { token } if shared.token.is(&token))
}

/// Passes messages of a page to the hub until the page leaves or sends something invalid.
fn listen(
    socket: &mut WebSocket<Reader>,
    page: PageId,
    shared: &Shared,
    (deadline, pings): (&Cell<Instant>, &AtomicU32),
) -> Result<(), Error> {
    loop {
        deadline.set(Instant::now() + SILENT_MAX);
        let said = match socket.read()? {
            Message::Text(text) => {
                // A page of this console sends nothing else.
                let message: FromPage =
                    serde_json::from_str(&text).map_err(|_| Error::ConnectionClosed)?;
                if matches!(message.command, PageCommand::Upload { .. }) {
                    limit(socket, shared.show_bytes.load(Ordering::Relaxed).max(MESSAGE_MAX));
                }
                ToHub::Said { page, message }
            }
            Message::Binary(bytes) => {
                limit(socket, MESSAGE_MAX);
                ToHub::Content { page, bytes: bytes.into() }
            }
            Message::Pong(_) => {
                pings.store(0, Ordering::Relaxed);
                continue;
            }
            Message::Close(_) => return Ok(()),
            _ => continue,
        };
        // It waits while the hub is busy: a page cannot fill the hub's memory.
        if shared.hub.send(said).is_err() {
            return Ok(());
        }
    }
}

fn limit(socket: &mut WebSocket<Reader>, bytes: usize) {
    socket.set_config(|config| {
        (config.max_message_size, config.max_frame_size) = (Some(bytes), Some(bytes));
    });
}

/// Writes frames and pings until the page does not answer, or its reading thread ends.
fn write_all(mut stream: TcpStream, waiting: &Receiver<Frame>, pings: &AtomicU32) {
    let ping = frame(WebFrame::ping(Vec::new()));
    let mut due = Instant::now() + PING_EVERY;
    loop {
        let written = match waiting.recv_timeout(due.saturating_duration_since(Instant::now())) {
            Ok(frame) => stream.write_all(&frame),
            Err(RecvTimeoutError::Timeout) => Ok(()),
            Err(RecvTimeoutError::Disconnected) => break,
        };
        let is_due = Instant::now() >= due;
        if is_due {
            due = Instant::now() + PING_EVERY;
        }
        let is_deaf = is_due && pings.fetch_add(1, Ordering::Relaxed) >= PINGS_MAX;
        if written.is_err() || is_deaf || is_due && stream.write_all(&ping).is_err() {
            break;
        }
    }
    // The reader ends, too.
    let _ = stream.shutdown(Shutdown::Both);
}
