//! The hub's end of the socket.

use std::fs::{self, Permissions};
use std::io::{self, BufRead as _, BufReader, Read, Write as _};
use std::net::Shutdown;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::{Reply, Request, View, private_folder};
use crate::message::{FromPage, PageCommand};
use crate::server::{Outbox, PageId, ToHub, Way, program, text_of};

/// Maximum length of a request, bytes.
const REQUEST_MAX: u64 = 4096;
/// Longest time for a request, and the interval of checks whether a waiting command still runs.
const PATIENCE: Duration = Duration::from_secs(2);
const LOOK: Duration = Duration::from_millis(20);
/// Time for the last answers when the hub ends.
const ANSWERS: Duration = Duration::from_millis(300);

/// Longest silence of a program that drives, and longest show, bytes.
const SILENT_MAX: Duration = Duration::from_secs(10);
const SHOW_MAX: usize = 1 << 22;

/// Maximum number of views that wait for a slow command. If they are exceeded, newer views are dropped.
const VIEWS: usize = 4;

/// Number of the next command. Number 0 belongs to the hub's own request.
static COMMANDS: AtomicU64 = AtomicU64::new(1);

/// A socket for other commands. It is removed on drop.
#[derive(Debug)]
pub(crate) struct Door {
    path: PathBuf,
    is_over: Arc<AtomicBool>,
    /// One copy for the door, and one for each request that is not answered yet.
    asked: Arc<()>,
}

impl Door {
    /// Opens the socket of a hub, and serves it in a thread. Replaces a socket that a killed hub has left.
    pub(crate) fn open(name: &str, hub: SyncSender<ToHub>) -> io::Result<Self> {
        let folder = private_folder()?;
        let path = folder.join(format!("{name}.sock"));
        if UnixStream::connect(&path).is_ok() {
            let text = format!("{}: another console uses it", path.display());
            return Err(io::Error::new(io::ErrorKind::AddrInUse, text));
        }
        // The socket gets its final name only when it accepts connections. Otherwise another command could take it for
        // the socket of an ended program, and remove it.
        let unnamed = folder.join(format!(".{name}.{}", std::process::id()));
        let _ = fs::remove_file(&unnamed);
        let listener = UnixListener::bind(&unnamed)?;
        fs::set_permissions(&unnamed, Permissions::from_mode(0o600))?;
        fs::rename(&unnamed, &path)?;
        let door = Self { path, is_over: Arc::default(), asked: Arc::default() };
        if fs::metadata(&door.path)?.uid() != fs::metadata(&folder)?.uid() {
            let text = format!("{}: belongs to another user", folder.display());
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, text));
        }
        let (is_over, asked) = (Arc::clone(&door.is_over), Arc::downgrade(&door.asked));
        let accept = move || {
            for stream in listener.incoming() {
                if is_over.load(Ordering::Relaxed) {
                    break;
                }
                let Ok(stream) = stream else { continue };
                let Some(asked) = asked.upgrade() else { break };
                let hub = hub.clone();
                // If a connection fails, nobody waits for the reason.
                let _ = thread::Builder::new().spawn(move || serve(&stream, &hub, asked));
            }
        };
        thread::Builder::new().name("commands".to_owned()).spawn(accept)?;
        Ok(door)
    }
}

impl Drop for Door {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        // The connection wakes the thread.
        let _ = UnixStream::connect(&self.path);
        let _ = fs::remove_file(&self.path);
        // A program that ends by a request still answers it.
        let end = Instant::now() + ANSWERS;
        while Arc::strong_count(&self.asked) > 1 && Instant::now() < end {
            thread::sleep(Duration::from_millis(2));
        }
    }
}

/// Passes a request to the hub, and the answer back to the command. Tells the hub if the command ends earlier.
fn serve(stream: &UnixStream, hub: &SyncSender<ToHub>, asked: Arc<()>) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut line = String::new();
    BufReader::new(stream.take(REQUEST_MAX)).read_line(&mut line)?;
    let request: Request = serde_json::from_str(&line).map_err(io::Error::other)?;
    if request == Request::Watch {
        drop(asked);
        return show(stream, hub);
    }
    let drives = request == Request::Drive;
    let command = COMMANDS.fetch_add(1, Ordering::Relaxed);
    let (answer, answers) = sync_channel(1);
    hub.send(ToHub::Asked { command, request, answer }).map_err(|_| gone())?;
    stream.set_read_timeout(Some(LOOK))?;
    let reply: Reply = loop {
        match answers.try_recv() {
            Ok(reply) => break reply,
            Err(TryRecvError::Disconnected) => return Err(gone()),
            Err(TryRecvError::Empty) => {}
        }
        if !is_there(stream) {
            let _ = hub.send(ToHub::Gone { command });
            return Err(gone());
        }
    };
    write(stream, &reply)?;
    drop(asked);
    if drives && reply.ok { drive(stream, hub, program(command)) } else { Ok(()) }
}

/// Passes views of the rig to a command until the command ends.
fn show(stream: &UnixStream, hub: &SyncSender<ToHub>) -> io::Result<()> {
    let (views, waiting) = sync_channel::<View>(VIEWS);
    hub.send(ToHub::Watches { views }).map_err(|_| gone())?;
    stream.set_read_timeout(Some(LOOK))?;
    loop {
        match waiting.recv_timeout(PATIENCE) {
            Ok(view) => write(stream, &view)?,
            Err(RecvTimeoutError::Timeout) if is_there(stream) => {}
            Err(_) => return Err(gone()),
        }
    }
}

/// Lets a program drive like a page: passes messages in both directions, until the program ends or sends something
/// invalid.
fn drive(stream: &UnixStream, hub: &SyncSender<ToHub>, page: PageId) -> io::Result<()> {
    let (out, waiting) = Outbox::new(Way::Program(Arc::new(stream.try_clone()?)));
    let mut writing = stream.try_clone()?;
    let write_all = move || {
        // A page's pictures are left out: a program asks for the state.
        for frame in waiting {
            let text =
                text_of(&frame).map_or(Ok(()), |text| writing.write_all(&[text, b"\n"].concat()));
            if text.is_err() {
                break;
            }
        }
        let _ = writing.shutdown(Shutdown::Both);
    };
    thread::Builder::new().name("program".to_owned()).spawn(write_all)?;
    hub.send(ToHub::Joined { page, out, may_drive: true }).map_err(|_| gone())?;
    let listened = listen(stream, hub, page);
    // Without a hub there is nothing to report.
    let _ = hub.send(ToHub::Left { page });
    listened
}

/// Passes messages of a program to the hub.
fn listen(stream: &UnixStream, hub: &SyncSender<ToHub>, page: PageId) -> io::Result<()> {
    stream.set_read_timeout(Some(SILENT_MAX))?;
    let mut reader = BufReader::new(stream);
    loop {
        let mut line = String::new();
        reader.by_ref().take(REQUEST_MAX).read_line(&mut line)?;
        let message: FromPage = serde_json::from_str(&line).map_err(io::Error::other)?;
        let content = match message.command {
            PageCommand::Upload { bytes, .. } if bytes > SHOW_MAX => {
                return Err(io::ErrorKind::InvalidData.into());
            }
            PageCommand::Upload { bytes, .. } => Some(bytes),
            _ => None,
        };
        hub.send(ToHub::Said { page, message }).map_err(|_| gone())?;
        if let Some(count) = content {
            let mut bytes = vec![0; count];
            reader.read_exact(&mut bytes)?;
            hub.send(ToHub::Content { page, bytes }).map_err(|_| gone())?;
        }
    }
}

/// Returns whether the command still waits. It sends nothing more, so a read fails only while the socket is open.
fn is_there(mut stream: &UnixStream) -> bool {
    stream.read(&mut [0]).is_err_and(|error| error.kind() == io::ErrorKind::WouldBlock)
}

fn write(mut stream: &UnixStream, message: &impl Serialize) -> io::Result<()> {
    let mut text = serde_json::to_string(message).map_err(io::Error::other)?;
    text.push('\n');
    stream.write_all(text.as_bytes())
}

fn gone() -> io::Error {
    io::ErrorKind::BrokenPipe.into()
}
