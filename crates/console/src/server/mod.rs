//! The server of the page: files over HTTP, and a WebSocket for each page, in a few threads.
//!
//! Everything that arrives from outside has a limit: the number of connections, the length and time of a request's
//! head, the length of a message, the time until the token, and the output that waits for a slow reader.

mod head;
mod socket;
mod token;

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::SyncSender;
use std::thread;
use std::time::{Duration, Instant};

use crate::local::{Reply, Request, View};
use crate::message::FromPage;
use crate::sounds::Sounds;

pub(crate) use socket::{Outbox, Way, binary, text, text_of};
pub(crate) use token::Token;

/// Maximum number of connections, and maximum number of connections that have not shown the token.
const OPEN_MAX: usize = 32;
const STRANGERS_MAX: usize = 16;
/// Longest time for the head of a request, and then again for the token.
const PATIENCE: Duration = Duration::from_secs(5);
/// Pause after an error of a listener, such as too many open files.
const PAUSE: Duration = Duration::from_millis(50);

/// Number of a page, or of a program that drives; it is not used again.
pub(crate) type PageId = u64;

/// The bit that tells programs from pages in their numbers.
const OF_PROGRAMS: PageId = 1 << 63;

/// Returns the number of a program, from that of its connection.
pub(crate) fn program(connection: u64) -> PageId {
    OF_PROGRAMS | connection
}

/// Returns whether a number is that of a program of this user.
pub(crate) fn is_program(page: PageId) -> bool {
    page & OF_PROGRAMS != 0
}

/// A message of a connection's thread to the hub.
#[derive(Debug)]
pub(crate) enum ToHub {
    /// A page has shown the token.
    Joined { page: PageId, out: Outbox, may_drive: bool },
    /// A page sends a text message.
    Said { page: PageId, message: FromPage },
    /// A page sends the bytes of the show that it has announced.
    Content { page: PageId, bytes: Vec<u8> },
    /// A page is gone.
    Left { page: PageId },
    /// A command of this user sends a request, and waits for the answer.
    Asked { command: u64, request: Request, answer: SyncSender<Reply> },
    /// Another command of this user starts to watch the rig.
    Watches { views: SyncSender<View> },
    /// A command has ended before it got its answer.
    Gone { command: u64 },
}

/// Data that all threads of a server share.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) token: Token,
    pub(crate) hub: SyncSender<ToHub>,
    /// Whether pages of other machines may drive.
    pub(crate) allow_drive: bool,
    /// Maximum length of a show, bytes.
    pub(crate) show_bytes: AtomicUsize,
    pub(crate) is_over: AtomicBool,
    pub(crate) sounds: Sounds,
    pages: AtomicU64,
    open: AtomicUsize,
    strangers: AtomicUsize,
}

impl Shared {
    /// Creates the data of a server without connections.
    pub(crate) fn new(token: Token, hub: SyncSender<ToHub>, allow_drive: bool) -> Self {
        Self {
            token,
            hub,
            allow_drive,
            show_bytes: AtomicUsize::new(0),
            is_over: AtomicBool::new(false),
            sounds: Sounds::default(),
            pages: AtomicU64::new(1),
            open: AtomicUsize::new(0),
            strangers: AtomicUsize::new(0),
        }
    }
}

/// Opens the listeners: one at the loopback address, and one at the other address if it is given and does not contain
/// the loopback. A port of 0 stands for any free port. The first listener is for browsers of this machine.
pub(crate) fn listen(other: Option<SocketAddr>) -> io::Result<Vec<TcpListener>> {
    let loopback = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let Some(other) = other else {
        return Ok(vec![TcpListener::bind((loopback, 0))?]);
    };
    let wide = TcpListener::bind(other)?;
    if other.ip().is_unspecified() || other.ip().is_loopback() {
        return Ok(vec![wide]);
    }
    let port = wide.local_addr()?.port();
    Ok(vec![TcpListener::bind((loopback, port))?, wide])
}

/// Accepts connections until the server ends.
pub(crate) fn accept(listener: &TcpListener, shared: &Arc<Shared>) {
    while !shared.is_over.load(Ordering::Relaxed) {
        let Ok((stream, peer)) = listener.accept() else {
            thread::sleep(PAUSE);
            continue;
        };
        // A connection beyond the limit is closed without an answer.
        let open = Count::of(shared, |shared| &shared.open, OPEN_MAX);
        let stranger = Count::of(shared, |shared| &shared.strangers, STRANGERS_MAX);
        if let (Some(open), Some(stranger)) = (open, stranger) {
            let shared = Arc::clone(shared);
            let serve = move || {
                let _open = open;
                // A connection that fails is closed; nobody waits for its reason.
                let _ = serve(stream, peer, stranger, &shared);
            };
            let _ = thread::Builder::new().name("page".to_owned()).spawn(serve);
        }
    }
}

/// Serves a connection: sends one file, or serves a page until it leaves.
fn serve(stream: TcpStream, peer: SocketAddr, stranger: Count, shared: &Shared) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut reader = socket::Reader::new(stream.try_clone()?, Instant::now() + PATIENCE);
    let (answer, host, rest) = head::answer(&mut reader, stream.local_addr()?, &shared.sounds)?;
    head::write(&mut &stream, &answer, &host)?;
    if matches!(answer, head::Answer::Upgrade(_)) {
        let may_drive = shared.allow_drive || peer.ip().to_canonical().is_loopback();
        let page = shared.pages.fetch_add(1, Ordering::Relaxed);
        socket::serve(stream, reader, rest, (page, may_drive), stranger, shared)?;
    }
    Ok(())
}

/// A place among a limited number of connections. It is free again on drop.
pub(crate) struct Count {
    shared: Arc<Shared>,
    of: fn(&Shared) -> &AtomicUsize,
}

impl Count {
    fn of(shared: &Arc<Shared>, of: fn(&Shared) -> &AtomicUsize, most: usize) -> Option<Self> {
        let more = |count: usize| (count < most).then_some(count + 1);
        of(shared).fetch_update(Ordering::Relaxed, Ordering::Relaxed, more).ok()?;
        Some(Self { shared: Arc::clone(shared), of })
    }
}

impl Drop for Count {
    fn drop(&mut self) {
        (self.of)(&self.shared).fetch_sub(1, Ordering::Relaxed);
    }
}
