//! The end of the socket of another command.

use std::fs;
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::os::unix::net::UnixStream;

use super::{Reply, Request, folder};

/// Returns the names of the consoles that run for this user.
pub fn consoles() -> Vec<String> {
    let files = fs::read_dir(folder()).into_iter().flatten().flatten();
    let mut names: Vec<String> = files
        .filter(|file| UnixStream::connect(file.path()).is_ok())
        .filter_map(|file| Some(file.file_name().to_str()?.strip_suffix(".sock")?.to_owned()))
        .collect();
    names.sort();
    names
}

/// Asks a console, and waits until the command is executed.
///
/// # Errors
/// An I/O error if no console has this name, or it has ended.
pub fn ask(name: &str, request: &Request) -> io::Result<Reply> {
    let mut stream = UnixStream::connect(folder().join(format!("{name}.sock")))?;
    let mut text = serde_json::to_string(request).map_err(io::Error::other)?;
    text.push('\n');
    stream.write_all(text.as_bytes())?;
    let mut line = String::new();
    BufReader::new(stream).read_line(&mut line)?;
    serde_json::from_str(&line).map_err(io::Error::other)
}
