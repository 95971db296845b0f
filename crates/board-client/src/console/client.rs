//! The asking command's end of the socket.

use std::fs;
use std::io::{self, BufRead as _, BufReader, ErrorKind, Write as _};
use std::os::unix::fs::MetadataExt as _;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use super::{Reply, Request, View, folder};

/// Returns the names of all running hubs of this user, sorted. Removes sockets that killed programs have left.
pub fn consoles() -> Vec<String> {
    let files = fs::read_dir(folder()).into_iter().flatten().flatten();
    let mut names: Vec<String> = files
        .filter_map(|file| {
            let name = file.file_name().to_str()?.strip_suffix(".sock")?.to_owned();
            is_alive(&file.path()).then_some(name)
        })
        .collect();
    names.sort();
    names
}

/// Returns whether a program serves a socket. A refused connection means that the program has ended: then removes the
/// socket.
fn is_alive(path: &Path) -> bool {
    let number = || fs::symlink_metadata(path).map(|found| found.ino()).ok();
    let before = number();
    match UnixStream::connect(path) {
        Ok(_) => true,
        Err(error) if error.kind() == ErrorKind::ConnectionRefused => {
            // A new program may have created a socket of this name since.
            if number() == before {
                let _ = fs::remove_file(path);
            }
            false
        }
        Err(_) => false,
    }
}

/// Sends a request to a hub, and waits for the answer, which arrives after the command is executed.
///
/// # Errors
/// An I/O error if no hub has this name, or it has ended.
pub fn ask(name: &str, request: &Request) -> io::Result<Reply> {
    let mut line = String::new();
    BufReader::new(send(name, request)?).read_line(&mut line)?;
    serde_json::from_str(&line).map_err(io::Error::other)
}

fn send(name: &str, request: &Request) -> io::Result<UnixStream> {
    let mut stream = UnixStream::connect(folder().join(format!("{name}.sock")))?;
    let mut text = serde_json::to_string(request).map_err(io::Error::other)?;
    text.push('\n');
    stream.write_all(text.as_bytes())?;
    Ok(stream)
}

/// Connection to a hub that sends views of its rig.
#[derive(Debug)]
pub struct Watching {
    stream: BufReader<UnixStream>,
    line: Vec<u8>,
}

/// Connects to a hub to receive views of its rig.
///
/// # Errors
/// An I/O error if no hub has this name.
pub fn watch(name: &str) -> io::Result<Watching> {
    Ok(Watching { stream: BufReader::new(send(name, &Request::Watch)?), line: Vec::new() })
}

impl Watching {
    /// Returns the next view, or `None` if no view arrives within `wait`.
    ///
    /// # Errors
    /// An I/O error if the hub has ended.
    pub fn next(&mut self, wait: Duration) -> io::Result<Option<View>> {
        self.stream.get_ref().set_read_timeout(Some(wait))?;
        match self.stream.read_until(b'\n', &mut self.line) {
            Ok(_) if self.line.last() == Some(&b'\n') => {
                let view = serde_json::from_slice(&self.line).map_err(io::Error::other);
                self.line.clear();
                view.map(Some)
            }
            Ok(_) => Err(ErrorKind::UnexpectedEof.into()),
            // The part of the line that has arrived stays in the buffer.
            Err(error)
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) =>
            {
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }
}
