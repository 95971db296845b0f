//! Reads heads of HTTP requests, within limits of bytes and time, and decides which requests are accepted.

use std::io::{self, Read, Write};
use std::net::SocketAddr;
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use sha1::{Digest as _, Sha1};

use crate::page::FILES;
use crate::sounds::Sounds;

/// Maximum length of a request's head, bytes.
const HEAD_MAX: usize = 8192;
/// Maximum number of header fields.
const FIELDS_MAX: usize = 48;
/// Text that a server appends to a WebSocket key (RFC 6455).
const KEY_SUFFIX: &str = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";

/// An answer to a request.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// A file of the page: its index in `FILES`.
    File(usize),
    /// Bytes of a show's sound.
    Sound(Arc<[u8]>),
    /// The request is refused, with a status and the reason.
    Refused(&'static str, &'static str),
    /// The connection becomes a WebSocket. Contains the answer to the key of the request.
    Upgrade(String),
}

/// The parts of a request's head that the server uses.
#[derive(Debug, Default)]
struct Head {
    method: String,
    path: String,
    hosts: Vec<String>,
    origins: Vec<String>,
    upgrade: String,
    version: String,
    key: String,
}

/// Reads the head of a request. Returns the answer, the host in the request, and the bytes received after the head.
pub(crate) fn answer(
    stream: &mut impl Read,
    local: SocketAddr,
    sounds: &Sounds,
) -> io::Result<(Answer, String, Vec<u8>)> {
    let mut bytes = Vec::new();
    let mut chunk = [0; 1024];
    loop {
        let count = stream.read(&mut chunk)?;
        if count == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        bytes.extend_from_slice(&chunk[..count]);
        match parse(&bytes) {
            Err(refused) => return Ok((refused, String::new(), Vec::new())),
            Ok(Some((head, len))) => {
                let host = head.hosts.first().cloned().unwrap_or_default();
                return Ok((decide(&head, local, sounds), host, bytes.split_off(len)));
            }
            Ok(None) if bytes.len() > HEAD_MAX => {
                let refused = Answer::Refused("431 Request Header Fields Too Large", "too long");
                return Ok((refused, String::new(), Vec::new()));
            }
            Ok(None) => {}
        }
    }
}

/// Returns the head and its length, or `None` if it is not complete.
fn parse(bytes: &[u8]) -> Result<Option<(Head, usize)>, Answer> {
    let mut fields = [httparse::EMPTY_HEADER; FIELDS_MAX];
    let mut request = httparse::Request::new(&mut fields);
    let bad = || Answer::Refused("400 Bad Request", "not a request");
    let httparse::Status::Complete(len) = request.parse(bytes).map_err(|_| bad())? else {
        return Ok(None);
    };
    let mut head = Head {
        method: request.method.unwrap_or_default().to_owned(),
        path: request.path.unwrap_or_default().to_owned(),
        ..Head::default()
    };
    for field in request.headers.iter() {
        let value = String::from_utf8_lossy(field.value).trim().to_owned();
        match field.name.to_ascii_lowercase().as_str() {
            "host" => head.hosts.push(value),
            "origin" => head.origins.push(value),
            "upgrade" => head.upgrade = value,
            "sec-websocket-version" => head.version = value,
            "sec-websocket-key" => head.key = value,
            _ => {}
        }
    }
    Ok(Some((head, len)))
}

/// Returns the answer to a request. The host must be the address at which the request has arrived, also for files: a
/// page whose name leads to this address (DNS rebinding) gets nothing.
fn decide(head: &Head, local: SocketAddr, sounds: &Sounds) -> Answer {
    let is_own = |host: &String| is_own_host(host, local);
    let [host] = &head.hosts[..] else {
        return Answer::Refused("400 Bad Request", "a request names one host");
    };
    if !is_own(host) {
        return Answer::Refused("403 Forbidden", "the host is not this console's");
    }
    if head.method != "GET" {
        return Answer::Refused("405 Method Not Allowed", "files are read with GET");
    }
    if head.path == "/ws" {
        return upgrade(head, host);
    }
    if let Some(sound) = sounds.at(&head.path) {
        return Answer::Sound(sound);
    }
    let name = match head.path.strip_prefix('/') {
        Some("") => "index.html",
        Some(name) => name,
        None => return Answer::Refused("404 Not Found", "no such file"),
    };
    let file = FILES.iter().position(|(own, _, _)| *own == name);
    file.map_or(Answer::Refused("404 Not Found", "no such file"), Answer::File)
}

/// Returns whether a host is the address of this end of the connection as numbers, or `localhost` for a loopback
/// address.
fn is_own_host(host: &str, local: SocketAddr) -> bool {
    let local = SocketAddr::new(local.ip().to_canonical(), local.port());
    let is_loopback = local.ip().is_loopback() && host == format!("localhost:{}", local.port());
    // A browser leaves the port of HTTP out.
    let is_bare = local.port() == 80 && host == local.ip().to_string();
    host == local.to_string() || is_loopback || is_bare
}

/// Answers a request for a WebSocket. Only a page of this console may open one; a program that sends no origin may not.
fn upgrade(head: &Head, host: &str) -> Answer {
    if !matches!(&head.origins[..], [origin] if *origin == format!("http://{host}")) {
        return Answer::Refused("403 Forbidden", "the origin is not this console's page");
    }
    let is_key = STANDARD.decode(&head.key).is_ok_and(|key| key.len() == 16);
    if !head.upgrade.eq_ignore_ascii_case("websocket") || head.version != "13" || !is_key {
        return Answer::Refused("426 Upgrade Required", "a WebSocket of version 13 is expected");
    }
    let hash = Sha1::digest(format!("{}{KEY_SUFFIX}", head.key));
    Answer::Upgrade(STANDARD.encode(hash))
}

/// Writes the answer. `host`: the host in the request.
pub(crate) fn write(stream: &mut impl Write, answer: &Answer, host: &str) -> io::Result<()> {
    let (status, kind, body): (&str, &str, &[u8]) = match answer {
        Answer::Upgrade(key) => {
            return write!(
                stream,
                "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
                 Sec-WebSocket-Accept: {key}\r\n\r\n"
            );
        }
        Answer::Refused(status, why) => (*status, "text/plain; charset=utf-8", why.as_bytes()),
        Answer::File(index) => {
            let (_, kind, bytes) = FILES[*index];
            ("200 OK", kind, bytes)
        }
        Answer::Sound(bytes) => ("200 OK", "audio/wav", bytes),
    };
    let socket = match answer {
        Answer::File(_) => format!(" connect-src 'self' ws://{host};"),
        _ => String::new(),
    };
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\
         Content-Security-Policy: default-src 'self';{socket} frame-ancestors 'none'; base-uri 'none'; \
         form-action 'none'\r\nX-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY\r\n\
         Referrer-Policy: no-referrer\r\nCross-Origin-Opener-Policy: same-origin\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\nCache-Control: no-store\r\n\r\n",
        body.len()
    )?;
    stream.write_all(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sounds::OwnSound;

    const HERE: &str = "127.0.0.1:4000";

    fn asked(request: &str) -> Answer {
        answer(&mut request.as_bytes(), HERE.parse().unwrap(), &sounds()).unwrap().0
    }

    fn sounds() -> Sounds {
        let sounds = Sounds::default();
        sounds.add(&OwnSound {
            hash: "0a1b".to_owned(),
            name: "talk.wav".to_owned(),
            offset_s: 0.0,
            bytes: Arc::from(&b"RIFF"[..]),
        });
        sounds
    }

    fn status(request: &str) -> &'static str {
        match asked(request) {
            Answer::Refused(status, _) => &status[..3],
            Answer::File(_) | Answer::Sound(_) => "200",
            Answer::Upgrade(_) => "101",
        }
    }

    #[test]
    fn only_own_hosts_are_served() {
        for (host, expected) in [
            ("127.0.0.1:4000", "200"),
            ("localhost:4000", "200"),
            ("127.0.0.1", "403"),
            ("127.0.0.1:4001", "403"),
            ("evil.example:4000", "403"),
            ("localhost.evil.example:4000", "403"),
            ("[::1]:4000", "403"),
            ("", "403"),
        ] {
            assert_eq!(
                status(&format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n")),
                expected,
                "{host}"
            );
        }
        assert_eq!(status("GET / HTTP/1.1\r\n\r\n"), "400");
        assert_eq!(
            status("GET / HTTP/1.1\r\nHost: localhost:4000\r\nHost: 127.0.0.1:4000\r\n\r\n"),
            "400"
        );
        let of_other = |local: &str, host: &str| is_own_host(host, local.parse().unwrap());
        assert!(of_other("[::1]:4000", "[::1]:4000") && of_other("[::1]:4000", "localhost:4000"));
        assert!(of_other("192.168.1.5:80", "192.168.1.5"));
        assert!(of_other("[::ffff:10.0.0.1]:4000", "10.0.0.1:4000"));
        assert!(!of_other("192.168.1.5:4000", "localhost:4000"));
    }

    #[test]
    fn only_files_are_read_and_nothing_else() {
        for (line, expected) in [
            ("GET /", "200"),
            ("GET /index.html", "200"),
            ("GET /../Cargo.toml", "404"),
            ("GET http://127.0.0.1:4000/", "404"),
            ("GET /arm", "404"),
            ("GET /sound/0a1b", "200"),
            ("GET /sound/0a1c", "404"),
            ("GET /sound/", "404"),
            ("GET /sound/../sound/0a1b", "404"),
            ("POST /", "405"),
            ("POST /ws", "405"),
            ("OPTIONS /ws", "405"),
        ] {
            assert_eq!(
                status(&format!("{line} HTTP/1.1\r\nHost: {HERE}\r\n\r\n")),
                expected,
                "{line}"
            );
        }
        assert_eq!(status("\x16\x03\x01 tls?\r\n\r\n"), "400");
        assert_eq!(
            status(&format!("GET / HTTP/1.1\r\nHost: {HERE}\r\nA: {}", "b".repeat(9000))),
            "431"
        );
    }

    #[test]
    fn a_socket_needs_the_own_origin() {
        let with = |origin: &str| {
            let head = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
                        Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
            asked(&format!("GET /ws HTTP/1.1\r\nHost: {HERE}\r\n{head}{origin}\r\n"))
        };
        // The example of RFC 6455.
        let accepted = Answer::Upgrade("s3pPLMBiTxaQ9kYGzzhZRbK+xOo=".to_owned());
        assert_eq!(with("Origin: http://127.0.0.1:4000\r\n"), accepted);
        for origin in [
            "",
            "Origin: null\r\n",
            "Origin: http://evil.example\r\n",
            "Origin: https://127.0.0.1:4000\r\n",
            "Origin: http://localhost:4000\r\n",
            "Origin: http://127.0.0.1:4000\r\nOrigin: http://evil.example\r\n",
        ] {
            assert!(matches!(with(origin), Answer::Refused("403 Forbidden", _)), "{origin}");
        }
    }

    #[test]
    fn no_other_page_may_frame_the_console() {
        let mut out = Vec::new();
        write(&mut out, &Answer::File(0), HERE).unwrap();
        let text = String::from_utf8_lossy(&out);
        for field in
            ["frame-ancestors 'none'", "default-src 'self'", "nosniff", "ws://127.0.0.1:4000;"]
        {
            assert!(text.contains(field), "{field}");
        }
        assert!(!text.contains("Access-Control"));
    }
}
