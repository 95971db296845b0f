//! The hub's end of the socket.

use std::fs::{self, Permissions};
use std::io::{self, BufRead as _, BufReader, Read, Write as _};
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TryRecvError, sync_channel};
use std::thread;
use std::time::Duration;

use super::{Reply, Request, create_folder, folder};
use crate::server::ToHub;

/// Maximum length of a request, bytes.
const REQUEST_MAX: u64 = 4096;
/// Longest time for a request, and the interval of checks whether a waiting command still runs.
const PATIENCE: Duration = Duration::from_secs(2);
const LOOK: Duration = Duration::from_millis(20);

/// Number of commands so far; the next command has this number.
static COMMANDS: AtomicU64 = AtomicU64::new(0);

/// A socket for other commands. It is removed on drop.
#[derive(Debug)]
pub(crate) struct Door {
    path: PathBuf,
    is_over: Arc<AtomicBool>,
}

impl Door {
    /// Opens the socket of a hub, and serves it in a thread. Replaces a socket that a killed hub has left.
    pub(crate) fn open(name: &str, hub: SyncSender<ToHub>) -> io::Result<Self> {
        let folder = folder();
        create_folder(&folder)?;
        let path = folder.join(format!("{name}.sock"));
        if UnixStream::connect(&path).is_ok() {
            let text = format!("{}: another console uses it", path.display());
            return Err(io::Error::new(io::ErrorKind::AddrInUse, text));
        }
        let _ = fs::remove_file(&path);
        let listener = UnixListener::bind(&path)?;
        fs::set_permissions(&path, Permissions::from_mode(0o600))?;
        let door = Self { path, is_over: Arc::default() };
        if fs::metadata(&door.path)?.uid() != fs::metadata(&folder)?.uid() {
            let text = format!("{}: belongs to another user", folder.display());
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, text));
        }
        let is_over = Arc::clone(&door.is_over);
        let accept = move || {
            for stream in listener.incoming() {
                if is_over.load(Ordering::Relaxed) {
                    break;
                }
                let Ok(stream) = stream else { continue };
                let hub = hub.clone();
                // If a connection fails, nobody waits for the reason.
                let _ = thread::Builder::new().spawn(move || serve(&stream, &hub));
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
    }
}

/// Passes a request to the hub and the answer back. Reports to the hub if the command ends earlier.
fn serve(mut stream: &UnixStream, hub: &SyncSender<ToHub>) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut line = String::new();
    BufReader::new(stream.take(REQUEST_MAX)).read_line(&mut line)?;
    let request: Request = serde_json::from_str(&line).map_err(io::Error::other)?;
    let command = COMMANDS.fetch_add(1, Ordering::Relaxed);
    let (answer, answers) = sync_channel(1);
    let gone = || io::Error::from(io::ErrorKind::BrokenPipe);
    hub.send(ToHub::Asked { command, request, answer }).map_err(|_| gone())?;
    stream.set_read_timeout(Some(LOOK))?;
    let reply: Reply = loop {
        match answers.try_recv() {
            Ok(reply) => break reply,
            Err(TryRecvError::Disconnected) => return Err(gone()),
            Err(TryRecvError::Empty) => {}
        }
        // The command sends nothing more. If the connection is closed, the command has ended.
        let is_there = stream.read(&mut [0]).is_err_and(|e| e.kind() == io::ErrorKind::WouldBlock);
        if !is_there {
            let _ = hub.send(ToHub::Gone { command });
            return Err(gone());
        }
    };
    let mut text = serde_json::to_string(&reply).map_err(io::Error::other)?;
    text.push('\n');
    stream.write_all(text.as_bytes())
}
