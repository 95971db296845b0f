//! The asking command's end of the socket.

use std::fs;
use std::io::{self, BufRead as _, BufReader, ErrorKind, Write as _};
use std::os::unix::fs::MetadataExt as _;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::thread;
use std::time::{Duration, Instant};

use super::folder::folders;
use super::{Reply, Request, Role, View};

/// Longest wait for the answer to a request that moves nothing, and for the connection to a socket.
const ANSWERS: Duration = Duration::from_secs(2);
const CONNECTS: Duration = Duration::from_millis(500);

/// Returns the names of all running hubs of this user, sorted. Removes sockets that killed programs have left.
pub fn consoles() -> Vec<String> {
    let files = folders().into_iter().filter_map(|folder| fs::read_dir(folder).ok()).flatten();
    let sockets: Vec<(String, PathBuf)> = files
        .flatten()
        .filter_map(|file| {
            Some((file.file_name().to_str()?.strip_suffix(".sock")?.to_owned(), file.path()))
        })
        .collect();
    let alive = each(&sockets, CONNECTS, |(_, path)| is_alive(&path));
    // A program that stands still may not accept a connection.
    let mut names: Vec<String> = sockets
        .into_iter()
        .zip(alive)
        .filter_map(|((name, _), alive)| alive.unwrap_or(true).then_some(name))
        .collect();
    names.sort();
    names.dedup();
    names
}

/// Does work for each item in a thread of its own, so that none waits for another. Returns the results; `None` for work
/// that has not ended after `wait`.
fn each<I, T>(
    items: &[I],
    wait: Duration,
    work: impl Fn(I) -> T + Clone + Send + 'static,
) -> Vec<Option<T>>
where
    I: Clone + Send + 'static,
    T: Send + 'static,
{
    let end = Instant::now() + wait;
    let begin = |item: &I| {
        let (tell, told) = channel();
        let (item, work) = (item.clone(), work.clone());
        let begun = thread::Builder::new().spawn(move || {
            // Nobody listens after `wait`.
            let _ = tell.send(work(item));
        });
        begun.is_ok().then_some(told)
    };
    let begun: Vec<_> = items.iter().map(begin).collect();
    let left = || end.saturating_duration_since(Instant::now());
    begun.into_iter().map(|told| told?.recv_timeout(left()).ok()).collect()
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

/// Sends a request to a hub, and waits for the answer, which arrives after the command is executed. A request that
/// begins no motion is answered within 2 s.
///
/// # Errors
/// An I/O error if no hub has this name, it has ended, or it does not answer in time.
pub fn ask(name: &str, request: &Request) -> io::Result<Reply> {
    if matches!(request, Request::Home | Request::Jog { .. }) {
        return exchange(name, request, None);
    }
    ask_all(&[name.to_owned()], request).pop().unwrap_or_else(|| Err(ErrorKind::NotFound.into()))
}

/// Sends a request that begins no motion to several hubs at once, and returns their answers after at most 2 s. A hub
/// that does not answer delays no other hub.
pub fn ask_all(names: &[String], request: &Request) -> Vec<io::Result<Reply>> {
    let own = request.clone();
    let replies = each(names, ANSWERS, move |name: String| exchange(&name, &own, Some(ANSWERS)));
    let late = || {
        let text = format!("no answer within {} s: its program may stand still", ANSWERS.as_secs());
        Err(io::Error::new(ErrorKind::TimedOut, text))
    };
    replies.into_iter().map(|reply| reply.unwrap_or_else(late)).collect()
}

/// Returns the roles of hubs; `None` for a hub that does not answer.
pub fn roles(names: &[String]) -> Vec<Option<Role>> {
    let replies = ask_all(names, &Request::Who).into_iter();
    let role = |reply: Reply| {
        let all = [Role::Drives, Role::Watches, Role::Simulates];
        all.into_iter().find(|role| role.name() == reply.text)
    };
    replies.map(|reply| reply.ok().and_then(role)).collect()
}

/// Connects to a hub with a request after which both ends send more lines. Returns the connection after the reply.
///
/// # Errors
/// An I/O error if no hub has this name or it does not answer in time; with the hub's words if it refuses.
pub fn connect(name: &str, request: &Request) -> io::Result<BufReader<UnixStream>> {
    let stream = send(name, request)?;
    stream.set_read_timeout(Some(ANSWERS))?;
    let (mut reader, mut line) = (BufReader::new(stream), String::new());
    reader.read_line(&mut line)?;
    let reply: Reply = serde_json::from_str(&line).map_err(io::Error::other)?;
    if reply.ok { Ok(reader) } else { Err(io::Error::other(reply.text)) }
}

fn exchange(name: &str, request: &Request, wait: Option<Duration>) -> io::Result<Reply> {
    let mut line = String::new();
    let stream = send(name, request)?;
    // The thread of a hub that never answers ends, too.
    stream.set_read_timeout(wait.map(|wait| 2 * wait))?;
    BufReader::new(stream).read_line(&mut line)?;
    serde_json::from_str(&line).map_err(io::Error::other)
}

fn send(name: &str, request: &Request) -> io::Result<UnixStream> {
    let mut connected = Err(ErrorKind::NotFound.into());
    for folder in folders() {
        connected = UnixStream::connect(folder.join(format!("{name}.sock")));
        if connected.is_ok() {
            break;
        }
    }
    let mut stream = connected?;
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
